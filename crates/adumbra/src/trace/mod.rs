//! Rays: the truth that every other answer of this crate is judged by.
//!
//! A [`Tracer`] holds a tree of triangles for each mesh, stored once however often it is placed, and a tree of
//! instances over them. Origins, directions and t are `f64`; box tests are `f32` and conservative; the triangle test is
//! watertight (Woop, Benthin, Wald 2013): within one instance no ray passes between triangles that share an edge or a
//! corner. Alpha masks decide what is there, by [`Scene::is_opaque`], the function that the bake uses too.

mod box_tree;
mod mesh_tree;
mod sah;
mod sampling;
mod triangle;
mod visibility;

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::light::{cross, dot};
use crate::scene::{AlphaMode, Mesh, Scene};
use box_tree::{BoxTree, Step};
use mesh_tree::{MeshTree, Placing, used_positions, world_box};
use triangle::TriangleHit;

/// Of a place in a mesh: four units in the last place of the floats that meshes are stored in. Surfaces that are drawn in one place are no
/// farther apart than that.
const LIFT_OF_PLACE: f64 = 4.0 / 16_777_216.0;
/// Of a world position and of the way to it: 64 units in the last place of the doubles that hits are computed in, of which a hit's place is
/// off by a few.
const LIFT_OF_POSITION: f64 = 64.0 * f64::EPSILON;

/// So many instances are tried one after the other; more get a tree.
const FEW_PLACINGS: usize = 2;

/// How to read the scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct TraceOptions {
    /// Take every material as opaque.
    pub ignore_alpha: bool,
}

/// A ray in world space. One with a NaN, or with no direction, hits nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where t = 0, world units.
    pub origin: [f64; 3],
    /// Any length but zero; t counts in lengths of it.
    pub direction: [f64; 3],
    /// Hits count from here, inclusive.
    pub t_min: f64,
    /// Hits count up to here, inclusive; may be infinite.
    pub t_max: f64,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where along the ray, in lengths of its direction.
    pub t: f64,
    /// Index into [`Scene::instances`].
    pub instance: u32,
    /// Index into the triangles of the instance's mesh.
    pub triangle: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Weights of the triangle's three vertices; they sum to one.
    pub barycentric: [f64; 3],
    /// Texture coordinates there; zero for a mesh that has none.
    pub uv: [f32; 2],
    /// Unit geometric normal in world space on the counter-clockwise side of the triangle (the clockwise one where the
    /// instance is mirrored, as glTF 2.0 has it).
    pub normal: [f64; 3],
    /// The ray comes from the side that the normal points to.
    pub front: bool,
}

/// What rays need to know of a material.
#[derive(Clone, Copy, Debug)]
struct Surface {
    casts: bool,
    masked: bool,
}

/// A scene made ready for rays. Answers take `&self` and may be asked from any number of threads.
#[derive(Debug)]
pub struct Tracer<'s> {
    scene: &'s Scene,
    surfaces: Vec<Surface>,
    trees: Vec<MeshTree>,
    placings: Vec<Placing>,
    /// Over `placings`; empty where they are few.
    top: BoxTree,
}

/// A hit with the numbers that the trees use.
struct Found<'h> {
    placing: &'h Placing,
    triangle: u32,
    material: u32,
    hit: &'h TriangleHit,
}

impl<'s> Tracer<'s> {
    /// Makes a scene, valid as [`crate::scene::load`] leaves it, ready for rays; on rayon's threads, with the same result
    /// for any number of them. Cost: about 2 µs a stored triangle, and one pass over the instanced vertices. Instances
    /// whose place is not finite are left out.
    pub fn build(scene: &'s Scene, options: TraceOptions) -> Self {
        let surfaces = scene.materials.iter().map(|m| Surface {
            casts: m.casts,
            masked: !options.ignore_alpha && m.alpha != AlphaMode::Opaque,
        });
        let (mut trees, used): (Vec<MeshTree>, Vec<Vec<[f32; 3]>>) =
            scene.meshes.par_iter().map(|mesh| (MeshTree::of_mesh(mesh), used_positions(mesh))).unzip();
        let boxes: Vec<_> =
            scene.instances.par_iter().map(|i| world_box(i, &used[i.mesh as usize])).collect();
        let (mut placings, mut placed_boxes) = (Vec::new(), Vec::new());
        for (number, (instance, world)) in scene.instances.iter().zip(boxes).enumerate() {
            if !world.iter().flatten().all(|c| c.is_finite()) {
                continue;
            }
            placings.push(Placing::of_instance(number, instance).unwrap_or_else(|| {
                let (placing, tree) = Placing::of_flat_instance(number, scene, trees.len());
                trees.push(tree);
                placing
            }));
            placed_boxes.push(world);
        }
        let few = placings.len() <= FEW_PLACINGS;
        let top = if few { BoxTree::default() } else { BoxTree::build(placed_boxes.iter().copied()) };
        Self { scene, surfaces: surfaces.collect(), trees, placings, top }
    }

    /// The scene that it was built from.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// Bytes held besides the scene: about 50 a stored triangle and 200 an instance.
    pub fn memory_bytes(&self) -> u64 {
        let flat = size_of_val(self.placings.as_slice()) + size_of_val(self.surfaces.as_slice());
        self.trees.iter().map(MeshTree::memory_bytes).sum::<u64>() + self.top.memory_bytes() + flat as u64
    }

    /// Whether the ray meets anything that casts a shadow. Cost: one walk that ends at the first hit, 1 µs or so.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.walk(ray, true, |_| Step::Stop)
    }

    /// The first opaque surface on the ray, casting or not; the lowest instance, then triangle where several are equally
    /// near. Cost: one walk.
    pub fn nearest_surface(&self, ray: &Ray) -> Option<Hit> {
        self.nearest(ray, false)
    }

    /// As [`Tracer::nearest_surface`], of what casts a shadow.
    pub fn nearest_blocker(&self, ray: &Ray) -> Option<Hit> {
        self.nearest(ray, true)
    }

    /// How far above a hit at `p_world` a further ray starts, world units, so that it meets neither the surface that it leaves nor another in
    /// the same place. It follows the precision of the hit: of its place in its mesh, as the instance scales it, and of `p_world` and `t`.
    /// What else the scene holds, and where in the world it stands, hardly matters.
    pub fn lift_world(&self, hit: &Hit, p_world: [f64; 3]) -> f64 {
        let largest = |v: [f64; 3]| v.into_iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let rows = &self.scene.instances[hit.instance as usize].world_from_mesh;
        let place = largest(std::array::from_fn(|a| p_world[a] - rows[a][3]));
        LIFT_OF_PLACE * place + LIFT_OF_POSITION * (largest(p_world) + hit.t.abs())
    }

    /// Calls `visit` with every opaque hit on the ray, casting or not, in no order. A ray through a shared edge or
    /// corner meets each triangle there, and each counts: whoever counts windings should aim beside them. Cost: one
    /// walk through everything that the ray's line meets.
    pub fn for_each_hit(&self, ray: &Ray, mut visit: impl FnMut(&Hit)) {
        self.walk(ray, false, |found| {
            visit(&self.complete(found));
            Step::On
        });
    }

    fn nearest(&self, ray: &Ray, casters_only: bool) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.walk(ray, casters_only, |found| {
            let key = (found.hit.t, found.placing.instance, found.triangle);
            if best.as_ref().is_some_and(|b| (b.t, b.instance, b.triangle) <= key) {
                return Step::On;
            }
            best = Some(self.complete(found));
            Step::Until(found.hit.t)
        });
        best
    }

    /// Calls `visit` with each hit that is there; returns whether the visitor stopped it.
    fn walk(&self, ray: &Ray, casters_only: bool, mut visit: impl FnMut(&Found<'_>) -> Step) -> bool {
        let finite = ray.origin.iter().chain(&ray.direction).all(|c| c.is_finite());
        let in_order = ray.t_min <= ray.t_max;
        if !finite || !in_order {
            return false;
        }
        let mut until = ray.t_max;
        let mut enter = |placing: &Placing| {
            if casters_only && !placing.casts {
                return Step::On;
            }
            let tree = &self.trees[placing.tree as usize];
            let before = until;
            let stopped = placing.walk(tree, ray, &mut until, |slot, hit| {
                self.judge(placing, tree.triangle(slot), hit, casters_only).map_or(Step::On, |f| visit(&f))
            });
            match stopped {
                true => Step::Stop,
                false if until < before => Step::Until(until),
                false => Step::On,
            }
        };
        if self.placings.len() <= FEW_PLACINGS {
            return self.placings.iter().any(|placing| matches!(enter(placing), Step::Stop));
        }
        let range = (ray.t_min, ray.t_max);
        self.top.walk(ray.origin, ray.direction, range, |slot| {
            enter(&self.placings[self.top.order()[slot] as usize])
        })
    }

    /// The hit, if there is something opaque (and casting) at it.
    fn judge<'h>(
        &self,
        placing: &'h Placing,
        triangle: u32,
        hit: &'h TriangleHit,
        casters_only: bool,
    ) -> Option<Found<'h>> {
        let mesh = self.scene.instances[placing.instance as usize].mesh as usize;
        let material = self.scene.meshes[mesh].triangle_materials[triangle as usize];
        let surface = self.surfaces[material as usize];
        let found = Found { placing, triangle, material, hit };
        let there = (surface.casts || !casters_only)
            && (!surface.masked || {
                let vertex_alpha = self.mesh(&found).alpha_at(triangle, hit.barycentric);
                self.scene.is_opaque(material, self.uv(&found), vertex_alpha)
            });
        there.then_some(found)
    }

    fn uv(&self, found: &Found<'_>) -> [f32; 2] {
        let weights = found.hit.barycentric;
        let [a, b, c] = self.mesh(found).corner_uvs(found.triangle).map(|uv| uv.map(f64::from));
        [0, 1].map(|k| (weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k]) as f32)
    }

    fn mesh(&self, found: &Found<'_>) -> &'s Mesh {
        &self.scene.meshes[self.scene.instances[found.placing.instance as usize].mesh as usize]
    }

    fn complete(&self, found: &Found<'_>) -> Hit {
        let Found { placing, triangle, material, hit } = *found;
        let normal = self.normal(placing.instance, triangle);
        let TriangleHit { t, barycentric, front } = *hit;
        let uv = self.uv(found);
        Hit { t, instance: placing.instance, triangle, material, barycentric, uv, normal, front }
    }

    /// Unit geometric normal; +Y for a triangle that its instance flattens to a line.
    fn normal(&self, instance: u32, triangle: u32) -> [f64; 3] {
        let instance = &self.scene.instances[instance as usize];
        let mesh = &self.scene.meshes[instance.mesh as usize];
        let [a, b, c] = mesh.triangles[triangle as usize].map(|i| mesh.positions[i as usize].map(f64::from));
        let turn = |d: [f64; 3]| instance.world_from_mesh.map(|row| dot([row[0], row[1], row[2]], d));
        let edge = |to: [f64; 3]| turn([to[0] - a[0], to[1] - a[1], to[2] - a[2]]);
        // Scaled, so that squares of very small or large edges stay in range.
        let scaled = |v: [f64; 3]| {
            let largest = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            v.map(|x| x / largest)
        };
        let n = scaled(cross(scaled(edge(b)), scaled(edge(c))));
        let length = dot(n, n).sqrt();
        let side = if instance.determinant() < 0.0 { -1.0 } else { 1.0 };
        if length > 0.0 { n.map(|x| side * x / length) } else { [0.0, 1.0, 0.0] }
    }
}
