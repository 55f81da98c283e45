//! Tests whether the box of `--bounds` contains any part of the scene.

use std::array::from_fn;
use std::path::Path;

use adumbra::Bounds;
use adumbra_scene::Scene;

/// Whether bounds contain no part of a scene, which was loaded from `path`. If so, prints a warning on
/// stderr. Bounds that are not a box are left to the bake, which refuses them with the allowed range.
pub fn warn_if_empty(bounds: Option<&Bounds>, scene: &Scene, path: &Path) -> bool {
    let is_empty = bounds.is_some_and(|b| is_box(b) && !hold_geometry(b, scene));
    if is_empty {
        let Bounds { min, max } = scene.bounds();
        crate::note!(
            "warning: --bounds contain no part of {}, which extends from {min:?} to {max:?}; check the box's position and unit",
            path.display()
        );
    }
    is_empty
}

fn is_box(bounds: &Bounds) -> bool {
    let Bounds { min, max } = bounds;
    (0..3).all(|a| min[a].is_finite() && max[a].is_finite() && min[a] < max[a])
}

/// Whether any triangle, of a caster or a receiver, intersects these bounds.
fn hold_geometry(bounds: &Bounds, scene: &Scene) -> bool {
    scene.instances.iter().any(|instance| {
        let Some(mesh) = scene.meshes.get(instance.mesh as usize) else { return false };
        let world = |corner: u32| instance.to_world(mesh.positions[corner as usize]);
        mesh.triangles.iter().any(|triangle| meets(bounds, triangle.map(world)))
    })
}

/// Whether a triangle and a box have a point in common, by the separating-axis theorem. The axes are those of
/// the box, the triangle's normal, and the cross products of a box axis and a triangle edge.
fn meets(bounds: &Bounds, triangle: [[f64; 3]; 3]) -> bool {
    let half: [f64; 3] = from_fn(|a| (bounds.max[a] - bounds.min[a]) / 2.0);
    // Relative to the centre of the box.
    let corners = triangle.map(|corner| from_fn(|a| corner[a] - bounds.min[a] - half[a]));
    let separates = |axis: [f64; 3]| {
        let along = corners.map(|corner| dot(axis, corner));
        let low = along.into_iter().fold(f64::INFINITY, f64::min);
        let high = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let reach = dot(axis.map(f64::abs), half);
        low > reach || high < -reach
    };
    let own: [[f64; 3]; 3] = from_fn(|a| from_fn(|b| f64::from(u8::from(a == b))));
    // The box's own axes first: they are cheap and separate most.
    if own.into_iter().any(separates) {
        return false;
    }
    let edges: [[f64; 3]; 3] = from_fn(|i| from_fn(|a| corners[(i + 1) % 3][a] - corners[i][a]));
    let across = own.into_iter().flat_map(|axis| edges.map(|edge| cross(axis, edge)));
    !across.chain([cross(edges[0], edges[1])]).any(separates)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_and_boxes_meet_only_where_they_share_points() {
        let triangle = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 100.0, 100.0]];
        for (min, max, expected) in [
            // Inside the triangle's bounding box: past its long edge, off its plane, past its long edge
            // again, and on it.
            ([90.0, 80.0, 90.0], [95.0, 95.0, 95.0], false),
            ([20.0, 10.0, 40.0], [30.0, 30.0, 60.0], false),
            ([60.0, 58.0, 58.0], [70.0, 62.0, 62.0], false),
            ([30.0, 30.0, 30.0], [31.0, 31.0, 31.0], true),
            // The triangle passes through a box that contains none of its corners, has a corner inside one,
            // is inside one, touches one, and just misses one.
            ([40.0, -10.0, -10.0], [45.0, 90.0, 90.0], true),
            ([-5.0, -5.0, -5.0], [1.0, 1.0, 1.0], true),
            ([-1e3; 3], [1e3; 3], true),
            ([-5.0, -5.0, -5.0], [0.0, 0.0, 0.0], true),
            ([-5.0, -5.0, -5.0], [-0.1, 0.0, 0.0], false),
            // Past its long edge, where only an axis perpendicular to that edge and to an edge of the box
            // separates.
            ([52.0, 50.0, 40.0], [60.0, 60.0, 60.0], false),
        ] {
            assert_eq!(meets(&Bounds { min, max }, triangle), expected, "{min:?} {max:?}");
        }
        // A degenerate triangle is a line.
        let line = [[0.0; 3], [10.0; 3], [5.0; 3]];
        assert!(meets(&Bounds { min: [4.0; 3], max: [6.0; 3] }, line));
        assert!(!meets(&Bounds { min: [4.0, 6.5, 4.0], max: [6.0, 8.0, 6.0] }, line));
    }
}
