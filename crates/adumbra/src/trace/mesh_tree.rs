//! The two levels under the tracer: a tree of triangles for each mesh, stored once, and the placing of each instance.
//!
//! Rays are carried into the mesh's space by the inverse of the instance's map with t unchanged. An instance whose map
//! has no usable inverse (flattened to a plane, say) gets a mesh of its own, its triangles already placed.

use super::box_tree::{Box3, BoxTree, Step, union};
use super::triangle::{ShearedRay, TriangleHit};
use super::{Ray, Scene};
use crate::light::{cross, dot};
use crate::scene::{Instance, Mesh};

/// Below this share of the largest determinant that its columns could have, a map counts as flat.
const FLAT: f64 = 1e-9;

/// Triangles in the order of their tree's leaves.
#[derive(Debug, Default)]
pub(super) struct MeshTree {
    tree: BoxTree,
    corners: Vec<[[f32; 3]; 3]>,
}

impl MeshTree {
    /// The tree over the triangles of a mesh, in its own space.
    pub(super) fn of_mesh(mesh: &Mesh) -> Self {
        Self::build(&mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect::<Vec<_>>())
    }

    fn build(triangles: &[[[f32; 3]; 3]]) -> Self {
        let tree = BoxTree::build(triangles.iter().map(|t| {
            let p = t.map(|v| v.map(f64::from));
            p.map(|v| [v, v]).into_iter().fold([p[0], p[0]], union)
        }));
        let corners = tree.order().iter().map(|&i| triangles[i as usize]).collect();
        Self { tree, corners }
    }

    /// The number of the triangle in its mesh.
    pub(super) fn triangle(&self, slot: usize) -> u32 {
        self.tree.order()[slot]
    }

    /// Bytes on the heap.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.tree.memory_bytes() + size_of_val(self.corners.as_slice()) as u64
    }
}

/// Where an instance stands, as rays need it.
#[derive(Debug)]
pub(super) struct Placing {
    /// Index into the scene's instances.
    pub(super) instance: u32,
    /// Index into the tracer's trees.
    pub(super) tree: u32,
    /// The instance casts.
    pub(super) casts: bool,
    mesh_from_world: [[f64; 4]; 3],
}

impl Placing {
    /// The placing of an instance whose map can be inverted.
    pub(super) fn of_instance(number: usize, instance: &Instance) -> Option<Self> {
        let mesh_from_world = invert(&instance.world_from_mesh)?;
        Some(Self { instance: number as u32, tree: instance.mesh, casts: instance.casts, mesh_from_world })
    }

    /// The placing of an instance that is flat, as tree number `tree`, and that tree.
    pub(super) fn of_flat_instance(number: usize, scene: &Scene, tree: usize) -> (Self, MeshTree) {
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
        let tree_here = MeshTree::build(&world.iter().map(|t| t.map(place)).collect::<Vec<_>>());
        let mut mesh_from_world = [[0.0; 4]; 3];
        for (a, row) in mesh_from_world.iter_mut().enumerate() {
            (row[a], row[3]) = (scale, -center[a] * scale);
        }
        let placing =
            Self { instance: number as u32, tree: tree as u32, casts: instance.casts, mesh_from_world };
        (placing, tree_here)
    }

    /// Calls `visit` with each triangle that the ray hits, and its slot in `tree`. Returns whether the visitor stopped
    /// it; `until` is the end of the ray and is drawn in as the visitor says.
    #[inline]
    pub(super) fn walk(
        &self,
        tree: &MeshTree,
        ray: &Ray,
        until: &mut f64,
        mut visit: impl FnMut(usize, &TriangleHit) -> Step,
    ) -> bool {
        let (origin, direction) = self.to_mesh(ray);
        let mut sheared = ShearedRay::new(origin, direction, ray.t_min, *until);
        tree.tree.walk(origin, direction, (ray.t_min, *until), |slot| {
            let Some(hit) = sheared.intersect(&tree.corners[slot]) else { return Step::On };
            let step = visit(slot, &hit);
            if let Step::Until(t) = step {
                sheared.shorten(t);
                *until = t;
            }
            step
        })
    }

    /// The ray's origin and direction in the space of its tree.
    fn to_mesh(&self, ray: &Ray) -> ([f64; 3], [f64; 3]) {
        let (m, o, d) = (&self.mesh_from_world, ray.origin, ray.direction);
        let origin = m.map(|r| r[0] * o[0] + r[1] * o[1] + r[2] * o[2] + r[3]);
        (origin, m.map(|r| r[0] * d[0] + r[1] * d[1] + r[2] * d[2]))
    }

    /// The hit with one triangle given in the mesh's space, without a tree.
    #[cfg(test)]
    pub(super) fn try_one(&self, ray: &Ray, corners: &[[f32; 3]; 3]) -> Option<TriangleHit> {
        let (origin, direction) = self.to_mesh(ray);
        ShearedRay::new(origin, direction, ray.t_min, ray.t_max).intersect(corners)
    }
}

/// The box of each instance in the world; not finite where the instance has no triangles.
pub(super) fn world_box(instance: &Instance, used: &[[f32; 3]]) -> Box3 {
    let none = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    used.iter().map(|&p| instance.to_world(p)).fold(none, |b, p| union(b, [p, p]))
}

/// The positions that triangles of the mesh use, each once.
pub(super) fn used_positions(mesh: &Mesh) -> Vec<[f32; 3]> {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    mesh.positions.iter().zip(used).filter_map(|(&p, used)| used.then_some(p)).collect()
}

/// The inverse of an affine map, none where it is (nearly) flat.
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
    fn mesh_tree_inverts_maps_and_refuses_flat_ones() {
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
