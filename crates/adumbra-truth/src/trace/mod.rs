//! Ray tracing: the reference for every other answer of this crate.
//!
//! A [`Tracer`] holds a BVH of triangles for each mesh, stored once however often the mesh is placed, and a
//! BVH of instances over them. Origins, directions and t are `f64`; box tests are `f32` and conservative. The
//! triangle test is watertight (Woop, Benthin, Wald 2013): within one instance, no ray passes between
//! triangles that share an edge or a corner. Alpha masks are evaluated by [`Scene::is_opaque`], which the
//! bake uses too.

mod blas;
mod bvh;
mod fan;
mod sah;
mod sampling;
mod triangle;
mod visibility;
mod wedge;

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use adumbra::grid::vec3::{cross, dot};
use adumbra_scene::{AlphaMode, Mesh, Scene};
use blas::{Blas, TlasInstance, used_positions, world_box};
use bvh::{Bvh, Traversal};
pub use fan::{Cover, Fan};
use triangle::TriangleHit;

/// Lift relative to a position in a mesh: 2 to 4 units in the last place of `f32`, in which meshes are
/// stored. Surfaces drawn at the same place are no farther apart than that.
const LIFT_OF_PLACE: f64 = 4.0 / 16_777_216.0;
/// Lift relative to a world position and to the distance to it: at least 64 units in the last place of `f64`,
/// in which hits are computed. A hit's position is off by a few.
const LIFT_OF_POSITION: f64 = 64.0 * f64::EPSILON;

/// Up to this many instances are tested one after another; more get a BVH.
const MAX_LISTED_INSTANCES: usize = 2;

/// Options for building a [`Tracer`].
#[derive(Clone, Copy, Debug, Default)]
pub struct TraceOptions {
    /// Treat every material as opaque.
    pub ignore_alpha: bool,
}

/// A ray in world space. A ray with a NaN or a zero direction hits nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point at t = 0, world units.
    pub origin: [f64; 3],
    /// Direction of any nonzero length; t is in multiples of that length.
    pub direction: [f64; 3],
    /// Start of the range of valid hits, inclusive.
    pub t_min: f64,
    /// End of the range of valid hits, inclusive; may be infinite.
    pub t_max: f64,
}

/// The intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in lengths of its direction.
    pub t: f64,
    /// Index into [`Scene::instances`].
    pub instance: u32,
    /// Index into the triangles of the instance's mesh.
    pub triangle: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Barycentric weights of the triangle's three vertices; they sum to one.
    pub barycentric: [f64; 3],
    /// Texture coordinates at the hit; zero for a mesh that has none.
    pub uv: [f32; 2],
    /// Unit geometric normal in world space, on the counter-clockwise side of the triangle (the clockwise
    /// side if the instance is mirrored, as in glTF 2.0).
    pub normal: [f64; 3],
    /// True if the ray comes from the side that the normal points to.
    pub front: bool,
}

/// The properties of a material that rays need.
#[derive(Clone, Copy, Debug)]
struct Surface {
    casts: bool,
    masked: bool,
    transmissivity: f32,
}

/// A scene prepared for ray tracing. Queries take `&self` and may run on any number of threads.
#[derive(Debug)]
pub struct Tracer<'s> {
    scene: &'s Scene,
    surfaces: Vec<Surface>,
    blases: Vec<Blas>,
    instances: Vec<TlasInstance>,
    /// BVH over `instances`; empty if there are only a few.
    tlas: Bvh,
}

/// Bytes that a tracer holds for each stored triangle, and for each instance.
const TRIANGLE_BYTES: u64 = 64;
const INSTANCE_BYTES: u64 = 300;
/// Bytes that a triangle takes while the BVH of its mesh is built: corners, box, two nodes of the binary
/// tree, and the costs by which those are merged into wide nodes.
const WORKING_BYTES: u64 = 260;

/// A hit with the indices that the BVHs use.
struct Found<'h> {
    instance: &'h TlasInstance,
    triangle: u32,
    material: u32,
    hit: &'h TriangleHit,
}

impl<'s> Tracer<'s> {
    /// Prepares a scene for ray tracing. The scene must be valid, as [`adumbra_scene::load`] returns it. Runs
    /// on rayon's threads; the result does not depend on their number. Cost: about 2 µs per stored triangle,
    /// and one pass over the instanced vertices. Instances whose transform is not finite are skipped.
    pub fn build(scene: &'s Scene, options: TraceOptions) -> Self {
        let surfaces = scene.materials.iter().map(|m| Surface {
            casts: m.casts,
            masked: !options.ignore_alpha && m.alpha != AlphaMode::Opaque,
            transmissivity: m.transmissivity,
        });
        let (mut blases, used): (Vec<Blas>, Vec<Vec<[f32; 3]>>) =
            scene.meshes.par_iter().map(|mesh| (Blas::from_mesh(mesh), used_positions(mesh))).unzip();
        let boxes: Vec<_> =
            scene.instances.par_iter().map(|i| world_box(i, &used[i.mesh as usize])).collect();
        let (mut instances, mut placed_boxes) = (Vec::new(), Vec::new());
        for (number, (instance, world)) in scene.instances.iter().zip(boxes).enumerate() {
            if !world.iter().flatten().all(|c| c.is_finite()) {
                continue;
            }
            instances.push(TlasInstance::from_instance(number, instance).unwrap_or_else(|| {
                let (instance, blas) = TlasInstance::from_flat_instance(number, scene, blases.len());
                blases.push(blas);
                instance
            }));
            placed_boxes.push(world);
        }
        let few = instances.len() <= MAX_LISTED_INSTANCES;
        let tlas = if few { Bvh::default() } else { Bvh::build(placed_boxes.iter().copied()) };
        Self { scene, surfaces: surfaces.collect(), blases, instances, tlas }
    }

    /// Returns the approximate peak memory of [`Tracer::build`] in bytes, in addition to the scene. Meshes
    /// are prepared on all threads at the same time.
    pub fn building_bytes(scene: &Scene) -> u64 {
        let positions: u64 = scene.meshes.iter().map(|mesh| size_of_val(&*mesh.positions) as u64).sum();
        let mut sizes: Vec<u64> = scene.meshes.iter().map(|mesh| mesh.triangles.len() as u64).collect();
        sizes.sort_unstable();
        let at_work = sizes.iter().rev().take(rayon::current_num_threads()).sum::<u64>();
        Self::kept_bytes(scene) + positions + at_work * WORKING_BYTES
    }

    /// Returns the approximate maximum memory of a scene's tracer in bytes, in addition to the scene.
    pub(crate) fn kept_bytes(scene: &Scene) -> u64 {
        let triangles: u64 = scene.meshes.iter().map(|mesh| mesh.triangles.len() as u64).sum();
        triangles * TRIANGLE_BYTES + scene.instances.len() as u64 * INSTANCE_BYTES
    }

    /// The scene from which the tracer was built.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// Bytes held in addition to the scene: about 50 per stored triangle and 200 per instance.
    pub fn memory_bytes(&self) -> u64 {
        let flat = size_of_val(self.instances.as_slice()) + size_of_val(self.surfaces.as_slice());
        self.blases.iter().map(Blas::memory_bytes).sum::<u64>() + self.tlas.memory_bytes() + flat as u64
    }

    /// Whether the ray hits anything that casts a shadow. Cost: one traversal that ends at the first hit,
    /// about 1 µs.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.walk(ray, true, |_| Traversal::Stop)
    }

    /// Share of the light along the ray that passes through everything that casts a shadow: 1 if there is
    /// nothing, and else the smallest transmissivity of the materials there. So the faces of one crown, or
    /// crowns behind one another, count once, as in Lindberg and Grimmond 2011 (SOLWEIG). Cost: one traversal
    /// that ends at the first opaque hit.
    pub fn transmitted(&self, ray: &Ray) -> f32 {
        let mut share = 1.0_f32;
        self.walk(ray, true, |found| {
            share = share.min(self.surfaces[found.material as usize].transmissivity);
            if share > 0.0 { Traversal::On } else { Traversal::Stop }
        });
        share
    }

    /// The nearest opaque surface on the ray, whether it casts or not. If several are equally near, the
    /// lowest instance wins, then the lowest triangle. Cost: one traversal.
    pub fn nearest_surface(&self, ray: &Ray) -> Option<Hit> {
        self.nearest(ray, false)
    }

    /// The nearest opaque surface on the ray that casts a shadow. Ties and cost as for
    /// [`Tracer::nearest_surface`].
    pub fn nearest_blocker(&self, ray: &Ray) -> Option<Hit> {
        self.nearest(ray, true)
    }

    /// How far a secondary ray must start above a hit at `p_world`, world units, so that it hits neither the
    /// surface it leaves nor a coincident one. The distance follows the precision of the hit: of its position
    /// in its mesh, as scaled by the instance, and of `p_world` and `t`. The rest of the scene and its
    /// position in the world hardly matter.
    pub fn lift_world(&self, hit: &Hit, p_world: [f64; 3]) -> f64 {
        let largest = |v: [f64; 3]| v.into_iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let rows = &self.scene.instances[hit.instance as usize].world_from_mesh;
        let place = largest(std::array::from_fn(|a| p_world[a] - rows[a][3]));
        LIFT_OF_PLACE * place + LIFT_OF_POSITION * (largest(p_world) + hit.t.abs())
    }

    /// Calls `visit` with every opaque hit on the ray, whether it casts or not, in no particular order. A ray
    /// through a shared edge or corner hits each triangle there, and each one counts; a caller that counts
    /// windings should avoid aiming at edges. Cost: one traversal of everything that the ray's line meets.
    pub fn for_each_hit(&self, ray: &Ray, mut visit: impl FnMut(&Hit)) {
        self.walk(ray, false, |found| {
            visit(&self.complete(found));
            Traversal::On
        });
    }

    fn nearest(&self, ray: &Ray, casters_only: bool) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.walk(ray, casters_only, |found| {
            let key = (found.hit.t, found.instance.scene_instance, found.triangle);
            if best.as_ref().is_some_and(|b| (b.t, b.instance, b.triangle) <= key) {
                return Traversal::On;
            }
            best = Some(self.complete(found));
            Traversal::Until(found.hit.t)
        });
        best
    }

    /// Calls `visit` with each accepted hit. Returns whether the visitor stopped the traversal.
    fn walk(&self, ray: &Ray, casters_only: bool, mut visit: impl FnMut(&Found<'_>) -> Traversal) -> bool {
        let finite = ray.origin.iter().chain(&ray.direction).all(|c| c.is_finite());
        let in_order = ray.t_min <= ray.t_max;
        if !finite || !in_order {
            return false;
        }
        let mut until = ray.t_max;
        let mut enter = |instance: &TlasInstance| {
            if casters_only && !instance.casts {
                return Traversal::On;
            }
            let blas = &self.blases[instance.blas as usize];
            let before = until;
            let stopped = instance.walk(blas, ray, &mut until, |slot, hit| {
                self.accept(instance, blas.triangle(slot), hit, casters_only)
                    .map_or(Traversal::On, |f| visit(&f))
            });
            match stopped {
                true => Traversal::Stop,
                false if until < before => Traversal::Until(until),
                false => Traversal::On,
            }
        };
        if self.instances.len() <= MAX_LISTED_INSTANCES {
            return self.instances.iter().any(|instance| matches!(enter(instance), Traversal::Stop));
        }
        let range = (ray.t_min, ray.t_max);
        self.tlas.walk(ray.origin, ray.direction, range, |slot| {
            enter(&self.instances[self.tlas.order()[slot] as usize])
        })
    }

    /// Returns the hit if the surface there is opaque (and casts, if `casters_only`).
    fn accept<'h>(
        &self,
        instance: &'h TlasInstance,
        triangle: u32,
        hit: &'h TriangleHit,
        casters_only: bool,
    ) -> Option<Found<'h>> {
        let material = self.material(instance, triangle);
        let surface = self.surfaces[material as usize];
        let found = Found { instance, triangle, material, hit };
        let there = (surface.casts || !casters_only)
            && (!surface.masked || {
                let vertex_alpha = self.mesh(&found).alpha_at(triangle, hit.barycentric);
                self.scene.is_opaque(material, self.uv(&found), vertex_alpha)
            });
        there.then_some(found)
    }

    fn material(&self, instance: &TlasInstance, triangle: u32) -> u32 {
        let mesh = self.scene.instances[instance.scene_instance as usize].mesh as usize;
        self.scene.meshes[mesh].triangle_materials[triangle as usize]
    }

    fn surface(&self, instance: &TlasInstance, triangle: u32) -> Surface {
        self.surfaces[self.material(instance, triangle) as usize]
    }

    fn uv(&self, found: &Found<'_>) -> [f32; 2] {
        let weights = found.hit.barycentric;
        let [a, b, c] = self.mesh(found).corner_uvs(found.triangle).map(|uv| uv.map(f64::from));
        [0, 1].map(|k| (weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k]) as f32)
    }

    fn mesh(&self, found: &Found<'_>) -> &'s Mesh {
        &self.scene.meshes[self.scene.instances[found.instance.scene_instance as usize].mesh as usize]
    }

    fn complete(&self, found: &Found<'_>) -> Hit {
        let Found { instance, triangle, material, hit } = *found;
        let normal = self.normal(instance.scene_instance, triangle);
        let TriangleHit { t, barycentric, front } = *hit;
        let uv = self.uv(found);
        Hit { t, instance: instance.scene_instance, triangle, material, barycentric, uv, normal, front }
    }

    /// Unit geometric normal, or +Y for a triangle that its instance collapses to a line.
    fn normal(&self, instance: u32, triangle: u32) -> [f64; 3] {
        let instance = &self.scene.instances[instance as usize];
        let mesh = &self.scene.meshes[instance.mesh as usize];
        let [a, b, c] = mesh.triangles[triangle as usize].map(|i| mesh.positions[i as usize].map(f64::from));
        let turn = |d: [f64; 3]| instance.world_from_mesh.map(|row| dot([row[0], row[1], row[2]], d));
        let edge = |to: [f64; 3]| turn([to[0] - a[0], to[1] - a[1], to[2] - a[2]]);
        // Normalised by the largest component, so that squares of very small or large edges stay in range.
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
