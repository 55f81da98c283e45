//! The bottom level of the tracer: one BVH per mesh, stored once, and the instances that place them.
//!
//! Rays are transformed to mesh space by the inverse of the instance's transform, with t unchanged. An
//! instance whose transform has no usable inverse (flattened to a plane, for example) gets its own BVH over
//! its transformed triangles.

use crate::trace::bvh::{Box3, Bvh, Traversal, union};
use crate::trace::triangle::{ShearedRay, TriangleHit};
use crate::trace::{Ray, Scene};
use adumbra::grid::vec3::{cross, dot};
use adumbra_scene::{Instance, Mesh};

/// A transform counts as flat if its determinant is below this fraction of the product of its columns'
/// lengths.
const FLAT: f64 = 1e-9;

/// A BVH and its triangles, in the order of its leaves.
#[derive(Debug, Default)]
pub(super) struct Blas {
    bvh: Bvh,
    corners: Vec<[[f32; 3]; 3]>,
}

impl Blas {
    /// Builds the BVH over the triangles of a mesh, in mesh space.
    pub(super) fn from_mesh(mesh: &Mesh) -> Self {
        Self::build(&mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect::<Vec<_>>())
    }

    fn build(triangles: &[[[f32; 3]; 3]]) -> Self {
        let bvh = Bvh::build(triangles.iter().map(|t| {
            let p = t.map(|v| v.map(f64::from));
            p.map(|v| [v, v]).into_iter().fold([p[0], p[0]], union)
        }));
        let corners = bvh.order().iter().map(|&i| triangles[i as usize]).collect();
        Self { bvh, corners }
    }

    /// The index of the triangle in its mesh.
    pub(super) fn triangle(&self, slot: usize) -> u32 {
        self.bvh.order()[slot]
    }

    /// The tree over the triangles.
    pub(super) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The corners of the triangle in a slot, in the tree's space.
    pub(super) fn corners(&self, slot: usize) -> &[[f32; 3]; 3] {
        &self.corners[slot]
    }

    /// Heap memory, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.bvh.memory_bytes() + size_of_val(self.corners.as_slice()) as u64
    }
}

/// An instance with the transform for rays.
#[derive(Debug)]
pub(super) struct TlasInstance {
    /// Index into the scene's instances.
    pub(super) scene_instance: u32,
    /// Index into the tracer's BVHs.
    pub(super) blas: u32,
    /// Whether the instance casts.
    pub(super) casts: bool,
    mesh_from_world: [[f64; 4]; 3],
}

impl TlasInstance {
    /// Prepares an instance; `None` if its transform cannot be inverted.
    pub(super) fn from_instance(number: usize, instance: &Instance) -> Option<Self> {
        let mesh_from_world = invert(&instance.world_from_mesh)?;
        Some(Self {
            scene_instance: number as u32,
            blas: instance.mesh,
            casts: instance.casts,
            mesh_from_world,
        })
    }

    /// Prepares a flat instance, and builds its own BVH, which gets index `blas`.
    pub(super) fn from_flat_instance(number: usize, scene: &Scene, blas: usize) -> (Self, Blas) {
        let instance = &scene.instances[number];
        let mesh = &scene.meshes[instance.mesh as usize];
        let world: Vec<[[f64; 3]; 3]> =
            mesh.triangles.iter().map(|t| t.map(|i| instance.to_world(mesh.positions[i as usize]))).collect();
        let none = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let whole = world.iter().flatten().fold(none, |b, &p| union(b, [p, p]));
        let center: [f64; 3] = std::array::from_fn(|a| 0.5 * whole[0][a] + 0.5 * whole[1][a]);
        let size = (0..3).map(|a| whole[1][a] - whole[0][a]).fold(0.0, f64::max);
        let scale = if size > 0.0 { 1.0 / size } else { 1.0 };
        let place = |p: [f64; 3]| std::array::from_fn(|a| ((p[a] - center[a]) * scale) as f32);
        let flat_blas = Blas::build(&world.iter().map(|t| t.map(place)).collect::<Vec<_>>());
        let mut mesh_from_world = [[0.0; 4]; 3];
        for (a, row) in mesh_from_world.iter_mut().enumerate() {
            (row[a], row[3]) = (scale, -center[a] * scale);
        }
        let instance =
            Self { scene_instance: number as u32, blas: blas as u32, casts: instance.casts, mesh_from_world };
        (instance, flat_blas)
    }

    /// Calls `visit` with each triangle that the ray hits, and its slot in `blas`. Returns whether the
    /// visitor stopped the traversal. `until` is the end of the ray and is updated when the visitor shortens
    /// it.
    #[inline]
    pub(super) fn walk(
        &self,
        blas: &Blas,
        ray: &Ray,
        until: &mut f64,
        mut visit: impl FnMut(usize, &TriangleHit) -> Traversal,
    ) -> bool {
        let (origin, direction) = self.to_mesh(ray);
        let mut sheared = ShearedRay::new(origin, direction, ray.t_min, *until);
        blas.bvh.walk(origin, direction, (ray.t_min, *until), |slot| {
            let Some(hit) = sheared.intersect(&blas.corners[slot]) else { return Traversal::On };
            let step = visit(slot, &hit);
            if let Traversal::Until(t) = step {
                sheared.shorten(t);
                *until = t;
            }
            step
        })
    }

    /// The ray's origin and direction in the space of the BVH.
    fn to_mesh(&self, ray: &Ray) -> ([f64; 3], [f64; 3]) {
        let (m, o, d) = (&self.mesh_from_world, ray.origin, ray.direction);
        let origin = m.map(|r| r[0] * o[0] + r[1] * o[1] + r[2] * o[2] + r[3]);
        (origin, m.map(|r| r[0] * d[0] + r[1] * d[1] + r[2] * d[2]))
    }

    /// The map from the world to the space of the BVH.
    pub(super) fn mesh_from_world(&self) -> &[[f64; 4]; 3] {
        &self.mesh_from_world
    }

    /// Intersects one triangle given in mesh space, without the BVH.
    #[cfg(test)]
    pub(super) fn try_one(&self, ray: &Ray, corners: &[[f32; 3]; 3]) -> Option<TriangleHit> {
        let (origin, direction) = self.to_mesh(ray);
        ShearedRay::new(origin, direction, ray.t_min, ray.t_max).intersect(corners)
    }
}

/// The world-space bounding box of an instance; not finite if its mesh has no triangles.
pub(super) fn world_box(instance: &Instance, used: &[[f32; 3]]) -> Box3 {
    let none = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    used.iter().map(|&p| instance.to_world(p)).fold(none, |b, p| union(b, [p, p]))
}

/// The positions that the mesh's triangles use, each once.
pub(super) fn used_positions(mesh: &Mesh) -> Vec<[f32; 3]> {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    mesh.positions.iter().zip(used).filter_map(|(&p, used)| used.then_some(p)).collect()
}

/// The inverse of an affine map, or `None` if it is (nearly) flat.
fn invert(m: &[[f64; 4]; 3]) -> Option<[[f64; 4]; 3]> {
    let column = |a: usize| [m[0][a], m[1][a], m[2][a]];
    let [x, y, z, origin] = [0, 1, 2, 3].map(column);
    let rows = [cross(y, z), cross(z, x), cross(x, y)];
    let det = dot(x, rows[0]);
    let largest = dot(x, x).sqrt() * dot(y, y).sqrt() * dot(z, z).sqrt();
    let inverse = rows.map(|r| {
        let r = r.map(|c| c / det);
        [r[0], r[1], r[2], -dot(r, origin)]
    });
    let usable = det.abs() > FLAT * largest && inverse.iter().flatten().all(|c| c.is_finite());
    usable.then_some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mesh_tree_inverts_maps_except_flat_ones() {
        let m = [[0.0, -2.0, 0.0, 5.0], [3.0, 0.0, 0.5, -7.0], [0.0, 0.0, 1e-7, 2.0]];
        let inverse = invert(&m).unwrap();
        let p = [0.3, -0.4, 0.6];
        let apply = |m: &[[f64; 4]; 3], p: [f64; 3]| m.map(|r| dot([r[0], r[1], r[2]], p) + r[3]);
        let back = apply(&inverse, apply(&m, p));
        assert!((0..3).all(|a| (back[a] - p[a]).abs() < 1e-8), "{back:?}");
        assert!(invert(&[[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).is_none());
        assert!(invert(&[[1.0, 1.0, 0.0, 0.0], [0.0, 1e-12, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).is_none());
        assert!(invert(&[[0.0; 4]; 3]).is_none());
    }
}
