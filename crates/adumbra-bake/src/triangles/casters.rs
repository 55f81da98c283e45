//! The scene in the form that the bake traverses: clusters of nearby triangles, and for every square of the
//! light's plane the clusters that may touch it.

use std::sync::Arc;

use crate::triangles::adjacency::adjacent_vertices;
use crate::triangles::cluster::ClusterTriangle;
use crate::triangles::opacity::OpacityTables;
use adumbra::grid::LightGrid;
use adumbra_scene::topology::Topology;
use adumbra_scene::{Instance, Mesh, Scene, topology};
use rayon::prelude::*;

/// Largest number of triangles in a cluster.
const CLUSTER_TRIANGLES: usize = 128;

/// The parts of a scene that are the same in every grid.
pub(crate) struct SceneClusters {
    /// One for each mesh.
    meshes: Vec<MeshClusters>,
    /// Empty if outlines are not requested.
    pub(crate) opacity: OpacityTables,
}

/// Triangles of one mesh, sorted so that nearby ones are adjacent.
pub(crate) struct MeshClusters {
    /// Triangles, cluster by cluster.
    pub(crate) triangles: Vec<ClusterTriangle>,
    /// [`adjacent_vertices`] of each triangle; empty if outlines are not requested.
    pub(crate) adjacent_vertices: Vec<[u32; 3]>,
    clusters: Vec<Cluster>,
}

struct Cluster {
    end: u32,
    min: [f32; 3],
    max: [f32; 3],
}

/// One cluster of one instance.
#[derive(Clone, Copy)]
pub(crate) struct Placed {
    pub(crate) instance: u32,
    pub(crate) cluster: u32,
}

/// The casters of a scene, sorted into bins.
pub(crate) struct Casters<'s> {
    pub(crate) scene: &'s Scene,
    pub(crate) clusters: Arc<SceneClusters>,
    pub(crate) bins: Arc<Bins>,
}

/// The placed clusters that may touch each bin.
pub(crate) struct Bins {
    bin_start: Vec<u32>,
    placed: Vec<Placed>,
}

/// The options that decide which triangles are casters, and which of them bound solids.
#[derive(Clone, Copy)]
pub(crate) struct CasterOptions {
    pub(crate) closed_regions: bool,
    pub(crate) ignore_alpha: bool,
    /// Whether to compute what the fast builder needs: connected components, adjacent vertices and opacity.
    pub(crate) outlines: bool,
    /// Most bytes that the bake may take, the scene's included, if they are limited.
    pub(crate) limit_bytes: Option<u64>,
}

/// Returns the bytes that [`SceneClusters::new`] holds while it works, apart from the scene and the opacity
/// of its materials. It sorts one mesh after another.
pub(crate) fn sorting_bytes(scene: &Scene, options: CasterOptions) -> u64 {
    let kept = size_of::<ClusterTriangle>() + if options.outlines { size_of::<[u32; 3]>() } else { 0 };
    let mut most = 0;
    let mut all = 0;
    for mesh in &scene.meshes {
        // Finding adjacent triangles takes no more than finding solids.
        most = most.max(topology::working_bytes(mesh));
        all += (mesh.triangles.len() * kept) as u64;
    }
    all + most
}

impl Cluster {
    /// Returns the least and the largest coordinates of the cluster's box in a grid.
    fn extent_in(&self, grid: &LightGrid, instance: &Instance) -> [[f64; 3]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in 0..8_usize {
            let pick = |a: usize| if corner >> a & 1 == 0 { self.min[a] } else { self.max[a] };
            let p = grid.to_grid(instance.to_world([pick(0), pick(1), pick(2)]));
            for a in 0..3 {
                low[a] = low[a].min(p[a]);
                high[a] = high[a].max(p[a]);
            }
        }
        [low, high]
    }
}

impl SceneClusters {
    /// Clusters every mesh of the scene.
    pub(crate) fn new(scene: &Scene, options: CasterOptions) -> Arc<Self> {
        let meshes = scene.meshes.iter().map(|mesh| cluster_mesh(scene, mesh, options)).collect();
        let has_holes = options.outlines && !options.ignore_alpha;
        let opacity = if has_holes {
            // Half of the remaining memory. Without tables, samples are equally exact but slower.
            let others = scene.memory_bytes() + sorting_bytes(scene, options);
            let room = options.limit_bytes.map_or(u64::MAX, |limit| limit.saturating_sub(others) / 2);
            OpacityTables::new(scene, room)
        } else {
            OpacityTables::default()
        };
        Arc::new(Self { meshes, opacity })
    }

    /// Calls `f` with each placed cluster of casting instances: the least and the largest coordinates of its
    /// box in a grid, and its number of triangles.
    pub(crate) fn for_each_extent(
        &self,
        scene: &Scene,
        grid: &LightGrid,
        mut f: impl FnMut([[f64; 3]; 2], u64),
    ) {
        for instance in scene.instances.iter().filter(|instance| instance.casts) {
            let mut start = 0;
            for cluster in &self.meshes[instance.mesh as usize].clusters {
                f(cluster.extent_in(grid, instance), u64::from(cluster.end - start));
                start = cluster.end;
            }
        }
    }
}

impl Bins {
    fn new(
        scene: &Scene,
        clusters: &SceneClusters,
        grid: &LightGrid,
        bin_side: u32,
        bins: [u32; 2],
        reach_texels: f64,
    ) -> Self {
        let side = f64::from(bin_side);
        // The bins that each placed cluster may touch, in order: from the first to before the last, along x
        // and y.
        let touched: Vec<(Placed, [[u32; 2]; 2])> = scene
            .instances
            .par_iter()
            .enumerate()
            .flat_map_iter(|(i, instance)| {
                let own = &clusters.meshes[instance.mesh as usize].clusters;
                (0_u32..).zip(own).filter_map(move |(c, cluster)| {
                    let [low, high] = cluster.extent_in(grid, instance);
                    let first = [0, 1].map(|a| ((low[a] - reach_texels) / side).floor().max(0.0) as u32);
                    let end = [0, 1].map(|a| {
                        (((high[a] + reach_texels) / side).floor() + 1.0).clamp(0.0, f64::from(bins[a]))
                            as u32
                    });
                    let is_in_grid = first[0] < end[0] && first[1] < end[1];
                    is_in_grid.then_some((Placed { instance: i as u32, cluster: c }, [first, end]))
                })
            })
            .collect();
        let in_bins = |[first, end]: [[u32; 2]; 2]| {
            (first[1]..end[1]).flat_map(move |y| (first[0]..end[0]).map(move |x| (y * bins[0] + x) as usize))
        };
        let mut bin_start = vec![0_u32; (bins[0] * bins[1]) as usize + 1];
        for bin in touched.iter().flat_map(|&(_, range)| in_bins(range)) {
            bin_start[bin] += 1;
        }
        let mut sum = 0;
        for start in &mut bin_start {
            sum += std::mem::replace(start, sum);
        }
        let mut placed = vec![Placed { instance: 0, cluster: 0 }; sum as usize];
        for (cluster, range) in touched {
            for bin in in_bins(range) {
                placed[bin_start[bin] as usize] = cluster;
                bin_start[bin] += 1;
            }
        }
        // After filling, each start has moved to the end of its bin.
        bin_start.rotate_right(1);
        bin_start[0] = 0;
        Self { bin_start, placed }
    }
}

impl<'s> Casters<'s> {
    /// Sorts every placed cluster of the scene into bins of `bin_side` texels; `bins` is their number across
    /// and down. `reach_texels` is how far outside its outline a triangle still matters.
    pub(crate) fn new(
        scene: &'s Scene,
        clusters: Arc<SceneClusters>,
        grid: &LightGrid,
        bin_side: u32,
        bins: [u32; 2],
        reach_texels: f64,
    ) -> Self {
        let bins = Arc::new(Bins::new(scene, &clusters, grid, bin_side, bins, reach_texels));
        Self { scene, clusters, bins }
    }

    /// Returns the placed clusters that may touch `bin`.
    pub(crate) fn in_bin(&self, bin: usize) -> &[Placed] {
        let Bins { bin_start, placed } = &*self.bins;
        &placed[bin_start[bin] as usize..bin_start[bin + 1] as usize]
    }

    /// Returns the triangles of a placed cluster.
    pub(crate) fn triangles(&self, placed: Placed) -> &[ClusterTriangle] {
        &self.mesh_of(placed).triangles[self.places(placed)]
    }

    /// Returns the adjacent vertices of each triangle of a placed cluster. Requires outlines.
    pub(crate) fn adjacent_vertices(&self, placed: Placed) -> &[[u32; 3]] {
        &self.mesh_of(placed).adjacent_vertices[self.places(placed)]
    }

    fn mesh_of(&self, placed: Placed) -> &MeshClusters {
        &self.clusters.meshes[self.scene.instances[placed.instance as usize].mesh as usize]
    }

    fn places(&self, placed: Placed) -> std::ops::Range<usize> {
        let clusters = &self.mesh_of(placed).clusters;
        let c = placed.cluster as usize;
        let start = if c == 0 { 0 } else { clusters[c - 1].end };
        start as usize..clusters[c].end as usize
    }

    /// Returns the number of casting triangles, counted once per instance.
    pub(crate) fn instanced_triangles(&self) -> u64 {
        let casting = self.scene.instances.iter().filter(|i| i.casts);
        casting
            .map(|i| {
                self.clusters.meshes[i.mesh as usize].triangles.iter().filter(|t| t.casts).count() as u64
            })
            .sum()
    }

    /// Bytes held by this structure.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let meshes: usize = self
            .clusters
            .meshes
            .iter()
            .map(|m| {
                m.triangles.capacity() * size_of::<ClusterTriangle>()
                    + m.clusters.capacity() * size_of::<Cluster>()
                    + m.adjacent_vertices.capacity() * size_of::<[u32; 3]>()
            })
            .sum();
        self.clusters.opacity.memory_bytes()
            + (meshes
                + self.bins.placed.capacity() * size_of::<Placed>()
                + self.bins.bin_start.capacity() * 4) as u64
    }
}

/// Sorts the triangles by position alone, so that no file depends on their order in the mesh, nor on which
/// corner comes first. Mesh encoders that are lossless in all other respects change both. The order has an
/// effect, because bounds on how freely a column may switch start from the first surface of a group.
fn cluster_mesh(scene: &Scene, mesh: &Mesh, options: CasterOptions) -> MeshClusters {
    let topology: Option<Topology> =
        (options.closed_regions || options.outlines).then(|| topology::analyse(mesh, &scene.materials));
    let mut order: Vec<(u64, u32)> = Vec::with_capacity(mesh.triangles.len());
    let (min, max) = bounds(mesh.positions.iter());
    let scale: [f32; 3] = std::array::from_fn(|a| 1023.0 / (max[a] - min[a]).max(f32::MIN_POSITIVE));
    for (t, &triangle) in mesh.triangles.iter().enumerate() {
        let corners = triangle.map(|v| mesh.positions[v as usize]);
        let cell: [u64; 3] = std::array::from_fn(|a| {
            let low = corners.iter().fold(f32::INFINITY, |low, p| low.min(p[a]));
            ((low - min[a]) * scale[a]) as u64
        });
        order.push((spread(cell[0]) << 2 | spread(cell[1]) << 1 | spread(cell[2]), t as u32));
    }
    order.sort_unstable_by(|&(cell, t), &(other_cell, other)| {
        let key = |t: u32| (leading_corner_first(mesh, t), mesh.triangle_materials[t as usize], t);
        cell.cmp(&other_cell).then_with(|| key(t).cmp(&key(other)))
    });
    // Components are numbered as they are met.
    let mut numbers = vec![None; topology.as_ref().map_or(0, |t| t.components.len())];
    let mut met = 0;
    let triangles: Vec<_> = order
        .iter()
        .map(|&(_, t)| {
            let material = &scene.materials[mesh.triangle_materials[t as usize] as usize];
            let masked = !options.ignore_alpha && material.alpha != adumbra_scene::AlphaMode::Opaque;
            let solid = options.closed_regions && topology.as_ref().is_some_and(|s| s.is_solid(t as usize));
            let component = topology.as_ref().map_or(0, |s| {
                let number = &mut numbers[s.component_of_triangle[t as usize] as usize];
                *number.get_or_insert_with(|| {
                    met += 1;
                    met - 1
                })
            });
            ClusterTriangle { triangle: t, casts: material.casts, solid, masked, component }
        })
        .collect();
    // Free these first: adjacency needs as much memory again.
    drop((order, topology, numbers));
    let clusters = triangles
        .chunks(CLUSTER_TRIANGLES)
        .enumerate()
        .map(|(i, chunk)| {
            let corners = chunk.iter().flat_map(|c| mesh.triangles[c.triangle as usize]);
            let (min, max) = bounds(corners.map(|v| &mesh.positions[v as usize]));
            Cluster { end: (i * CLUSTER_TRIANGLES + chunk.len()) as u32, min, max }
        })
        .collect();
    let adjacent_vertices = if options.outlines { adjacent_vertices(mesh, &triangles) } else { Vec::new() };
    MeshClusters { triangles, adjacent_vertices, clusters }
}

/// Returns the coordinates of a triangle's corners, as words, from the least one on: the same whichever
/// corner comes first in the mesh.
fn leading_corner_first(mesh: &Mesh, triangle: u32) -> [[u32; 3]; 3] {
    let mut corners = mesh.triangles[triangle as usize].map(|v| mesh.positions[v as usize].map(f32::to_bits));
    let least = (0..3).min_by_key(|&c| corners[c]).unwrap_or_default();
    corners.rotate_left(least);
    corners
}

fn bounds<'a>(points: impl Iterator<Item = &'a [f32; 3]>) -> ([f32; 3], [f32; 3]) {
    let mut min = [f32::INFINITY; 3];
    let mut max = [f32::NEG_INFINITY; 3];
    for p in points {
        for a in 0..3 {
            min[a] = min[a].min(p[a]);
            max[a] = max[a].max(p[a]);
        }
    }
    (min, max)
}

/// Spreads ten bits, with two zero bits after each.
fn spread(v: u64) -> u64 {
    (0..10).fold(0, |out, bit| out | (v >> bit & 1) << (3 * bit))
}
