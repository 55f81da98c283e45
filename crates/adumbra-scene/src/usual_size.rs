//! The size of a scene without outliers that are far away or unusually wide. Default lengths are fractions of
//! it.

use crate::Scene;

/// Maximum number of corners sampled, spread evenly over the triangles.
const MAX_CORNERS: u64 = 1 << 17;
/// Fraction of the corners, sorted along an axis, that is ignored at either end.
const OUTSIDE: f64 = 0.1;

impl Scene {
    /// The scene's usual diagonal, world units. Along each axis it takes the interval that holds the middle
    /// four fifths of the placed triangles' corners, and scales it so that an evenly filled scene gives its
    /// whole bounding box. Stray triangles, a sky dome or wide ground hardly change it. Cost: at most 131,072
    /// corners, sorted three times.
    pub fn usual_diagonal(&self) -> f64 {
        let step = (3 * self.instanced_triangles()).div_ceil(MAX_CORNERS).max(1);
        let mut along: [Vec<f64>; 3] = Default::default();
        let triangles = self.instances.iter().flat_map(|i| {
            let mesh = &self.meshes[i.mesh as usize];
            mesh.triangles.iter().map(move |t| (i, mesh, t))
        });
        for (instance, mesh, triangle) in triangles.step_by(usize::try_from(step).unwrap_or(usize::MAX)) {
            for p in triangle.map(|v| instance.to_world(mesh.positions[v as usize])) {
                along.iter_mut().zip(p).for_each(|(axis, c)| axis.push(c));
            }
        }
        let sides = along.map(|mut axis| {
            axis.sort_by(f64::total_cmp);
            let at = |share: f64| axis.get((share * axis.len().saturating_sub(1) as f64) as usize).copied();
            let [first, last] = [OUTSIDE, 1.0 - OUTSIDE].map(|share| at(share).unwrap_or_default());
            (last - first) / (1.0 - 2.0 * OUTSIDE)
        });
        sides.iter().map(|side| side * side).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GeneratedKind, Instance, generate};

    #[test]
    fn usual_diagonal_ignores_strays() {
        for kind in [GeneratedKind::City, GeneratedKind::Landscape, GeneratedKind::SphereGrid] {
            let mut scene = generate(kind, 1);
            let (usual, whole) = (scene.usual_diagonal(), scene.bounds().diagonal());
            assert!((0.5..1.3).contains(&(usual / whole)), "{kind:?}: {usual} {whole}");
            let far = |name: &str, place: f64| Instance {
                name: name.to_owned(),
                mesh: 0,
                world_from_mesh: [[1.0, 0.0, 0.0, place], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, place]],
                casts: true,
            };
            let first = scene.meshes[0].triangles[0];
            scene.meshes[0].triangles.truncate(1);
            scene.meshes[0].triangle_materials.truncate(1);
            assert_eq!(scene.meshes[0].triangles, [first]);
            let before = scene.usual_diagonal();
            scene.instances.push(far("stray", 1e6));
            assert!(scene.bounds().diagonal() > 1e6);
            let after = scene.usual_diagonal();
            assert!((after / before - 1.0).abs() < 0.02, "{kind:?}: {before} {after}");
        }
        assert_eq!(Scene::default().usual_diagonal(), 0.0);
    }
}
