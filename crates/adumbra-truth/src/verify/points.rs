//! Random points on surfaces and in space.

use super::answers::Below;
use adumbra::grid::LightGrid;
use adumbra::grid::vec3::{cross, dot};
use adumbra_scene::random::Random;
use adumbra_scene::{Instance, Mesh, Scene, topology};

/// A point to compare.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// World position.
    pub p_world: [f64; 3],
    /// Unit geometric normal, turned towards the sun unless the triangle bounds a solid; `None` for points in
    /// space.
    pub normal: Option<[f64; 3]>,
}

/// The triangles that bound solids.
pub struct Solids {
    /// The mesh of each instance; `None` for an instance that casts no shadow.
    mesh_of_instance: Vec<Option<u32>>,
    /// Indexed by mesh, then triangle.
    solid: Vec<Vec<bool>>,
}

impl Solids {
    /// Analyses every mesh of `scene` as the bake does.
    pub fn of(scene: &Scene) -> Self {
        let solid = scene
            .meshes
            .iter()
            .map(|mesh| {
                let topology = topology::analyse(mesh, &scene.materials);
                (0..mesh.triangles.len()).map(|t| topology.is_solid(t)).collect()
            })
            .collect();
        Self { mesh_of_instance: scene.instances.iter().map(|i| i.casts.then_some(i.mesh)).collect(), solid }
    }

    /// Whether this triangle of this instance bounds a solid.
    pub fn contains(&self, instance: u32, triangle: u32) -> bool {
        self.mesh_of_instance[instance as usize]
            .is_some_and(|mesh| self.solid[mesh as usize][triangle as usize])
    }
}

/// Draws points on the scene's opaque surfaces, uniformly by area in world space. A two-sided surface is
/// sampled on the side that faces the sun.
pub struct SurfaceSampler<'s> {
    scene: &'s Scene,
    ignore_alpha: bool,
    towards_sun: [f64; 3],
    /// Running sum of the instances' areas.
    instance_sums: Vec<f64>,
    /// For each instance, the index into `triangle_sums`.
    sums_of_instance: Vec<u32>,
    /// Running sums of triangle areas: first of each mesh in its own space, then of each non-uniformly scaled
    /// instance in world space.
    triangle_sums: Vec<Vec<f64>>,
    solids: &'s Solids,
}

/// Number of draws after which a point in a hole of a masked surface is accepted.
const MASK_TRIES: u32 = 64;
/// Scales that differ by less than this fraction are treated as equal.
const SAME_SCALE: f64 = 1e-6;

impl<'s> SurfaceSampler<'s> {
    /// Computes the running sums. Cost: one pass over the triangles of every mesh and of every non-uniformly
    /// scaled instance. Memory: 8 bytes for each of those triangles.
    pub fn new(scene: &'s Scene, solids: &'s Solids, towards_sun: [f64; 3], ignore_alpha: bool) -> Self {
        let corners = |mesh: &Mesh, t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
        let mesh_sums = scene.meshes.iter().map(|mesh| {
            running_sum(mesh.triangles.iter().map(|t| area(corners(mesh, t).map(|p| p.map(f64::from)))))
        });
        let mut triangle_sums: Vec<Vec<f64>> = mesh_sums.collect();
        let mut sums_of_instance = Vec::with_capacity(scene.instances.len());
        let instance_sums = running_sum(scene.instances.iter().map(|instance| {
            let total = |sums: &[f64]| sums.last().copied().unwrap_or_default();
            if let Some(scale) = even_scale(instance) {
                sums_of_instance.push(instance.mesh);
                return total(&triangle_sums[instance.mesh as usize]) * scale * scale;
            }
            let mesh = &scene.meshes[instance.mesh as usize];
            let sums = running_sum(
                mesh.triangles.iter().map(|t| area(corners(mesh, t).map(|p| instance.to_world(p)))),
            );
            sums_of_instance.push(triangle_sums.len() as u32);
            triangle_sums.push(sums);
            triangle_sums.last().map_or(0.0, |sums| total(sums))
        }));
        Self { scene, ignore_alpha, towards_sun, instance_sums, sums_of_instance, triangle_sums, solids }
    }

    /// Draws the next point.
    pub fn sample(&self, random: &mut Random) -> Sample {
        let mut tries = 0;
        loop {
            let (sample, opaque) = self.try_sample(random);
            tries += 1;
            if opaque || tries == MASK_TRIES {
                return sample;
            }
        }
    }

    fn try_sample(&self, random: &mut Random) -> (Sample, bool) {
        let instance_index = pick(&self.instance_sums, random.unit());
        let instance = &self.scene.instances[instance_index];
        let mesh_index = instance.mesh as usize;
        let mesh = &self.scene.meshes[mesh_index];
        let sums = &self.triangle_sums[self.sums_of_instance[instance_index] as usize];
        let triangle = pick(sums, random.unit());
        let (mut u, mut v) = (random.unit(), random.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let weights = [1.0 - u - v, u, v];
        let corners = mesh.triangles[triangle];
        let p = corners.map(|c| instance.to_world(mesh.positions[c as usize]));
        let p_world =
            std::array::from_fn(|a| p[0][a] * weights[0] + p[1][a] * weights[1] + p[2][a] * weights[2]);
        let mut normal = cross(sub(p[1], p[0]), sub(p[2], p[0]));
        let length = dot(normal, normal).sqrt();
        let mut sign = if instance.determinant() < 0.0 { -1.0 } else { 1.0 };
        let solid = self.solids.contains(instance_index as u32, triangle as u32);
        if !solid && sign * dot(normal, self.towards_sun) < 0.0 {
            sign = -sign;
        }
        normal = normal.map(|c| c * sign / length);
        let material = mesh.triangle_materials[triangle];
        let opaque = self.ignore_alpha || {
            let at = |values: [f32; 3]| (0..3).map(|c| values[c] * weights[c] as f32).sum();
            let uv = mesh.corner_uvs(triangle as u32);
            let vertex_alpha = mesh.alpha_at(triangle as u32, weights);
            self.scene.is_opaque(material, [0, 1].map(|a| at(uv.map(|c| c[a]))), vertex_alpha)
        };
        (Sample { p_world, normal: Some(normal) }, opaque)
    }
}

/// Draws points in a box, uniformly by volume.
pub struct VolumeSampler {
    corner: [f64; 3],
    edges: [[f64; 3]; 3],
}

impl VolumeSampler {
    /// Samples the volume of `grid`.
    pub fn new(grid: &LightGrid) -> Self {
        let edges =
            std::array::from_fn(|a| grid.edges[a].map(|c| c * grid.voxel_size * f64::from(grid.size[a])));
        Self { corner: grid.origin(), edges }
    }

    /// Samples the cube with the lowest corner `p_min` and the edge `side_world`.
    pub fn in_cube(p_min: [f64; 3], side_world: f64) -> Self {
        let edges = std::array::from_fn(|a| std::array::from_fn(|b| if a == b { side_world } else { 0.0 }));
        Self { corner: p_min, edges }
    }

    /// Draws the next point.
    pub fn sample(&self, random: &mut Random) -> Sample {
        let mut p_world = self.corner;
        for edge in &self.edges {
            let t = random.unit();
            for (p, c) in p_world.iter_mut().zip(edge) {
                *p += c * t;
            }
        }
        Sample { p_world, normal: None }
    }
}

/// Draws points on level ground just below the scene, uniformly over the grid's columns.
pub struct GroundSampler {
    below: Below,
    height_world: f64,
}

impl GroundSampler {
    /// Samples ground one voxel below the lowest point of `scene`, where an app may draw it.
    pub fn new(scene: &Scene, below: Below) -> Self {
        Self { below, height_world: scene.bounds().min[1] - below.grid.voxel_size }
    }

    /// How far below an open surface its shadow may begin, voxels along the light.
    pub(super) fn thickness_voxels(&self) -> f64 {
        self.below.thickness_voxels
    }

    /// Draws the next point.
    pub fn sample(&self, random: &mut Random) -> Sample {
        let grid = &self.below.grid;
        let [x, y] = [0, 1].map(|axis| random.unit() * f64::from(grid.size[axis]));
        let on_column = grid.to_world([x, y, 0.0]);
        let towards = grid.sun.towards();
        let t = (self.height_world - on_column[1]) / towards[1];
        Sample {
            p_world: std::array::from_fn(|a| on_column[a] + t * towards[a]),
            normal: Some([0.0, 1.0, 0.0]),
        }
    }
}

/// The scale of an instance that is only rotated and uniformly scaled; `None` for any other.
fn even_scale(instance: &Instance) -> Option<f64> {
    let column = |a: usize| [0, 1, 2].map(|row| instance.world_from_mesh[row][a]);
    let columns = [column(0), column(1), column(2)];
    let squared = dot(columns[0], columns[0]);
    let is_even = (0..3).all(|a| {
        (0..3).all(|b| {
            let expected = if a == b { squared } else { 0.0 };
            (dot(columns[a], columns[b]) - expected).abs() <= SAME_SCALE * squared
        })
    });
    (is_even && squared > 0.0).then(|| squared.sqrt())
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn area(p: [[f64; 3]; 3]) -> f64 {
    let n = cross(sub(p[1], p[0]), sub(p[2], p[0]));
    0.5 * dot(n, n).sqrt()
}

fn running_sum(terms: impl Iterator<Item = f64>) -> Vec<f64> {
    terms
        .scan(0.0, |sum, term| {
            *sum += term;
            Some(*sum)
        })
        .collect()
}

/// The index of the interval of the running sum that contains the fraction `unit`.
fn pick(sums: &[f64], unit: f64) -> usize {
    let target = unit * sums.last().copied().unwrap_or_default();
    sums.partition_point(|s| *s <= target).min(sums.len() - 1)
}
