//! The range of view depths at which a camera sees a box: the box clipped by the planes of the view, in `f64`
//! relative to the eye.
//!
//! The box's corners alone would not be enough. In a wide scene most of them are outside the view, and
//! lengths derived from them would change with every stray triangle.

use adumbra::Bounds;
use adumbra_scene::View;

/// Returns the least and greatest view depth of the part of a box inside a view, world units, or `None` if
/// they do not intersect. Every view starts at the eye, whether perspective or orthographic.
pub(crate) fn depths_in_view(view: &View, bounds: &Bounds) -> Option<[f64; 2]> {
    let relative = |v: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|a| v[a] - view.eye[a]) };
    let [low, high] = [relative(&bounds.min), relative(&bounds.max)];
    if (0..3).any(|a| !(low[a] <= high[a] && low[a].is_finite() && high[a].is_finite())) {
        return None;
    }
    let planes = planes(view);
    let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in faces(low, high).into_iter().flat_map(|face| cut(face.to_vec(), &planes)) {
        let depth = dot(view.forward, p).max(0.0);
        (nearest, farthest) = (nearest.min(depth), farthest.max(depth));
    }
    // If the eye is inside the box, the view starts at the eye, and the box's faces are farther away.
    if (0..3).all(|a| low[a] <= 0.0 && high[a] >= 0.0) {
        nearest = 0.0;
    }
    (nearest <= farthest).then_some([nearest, farthest])
}

/// Returns the planes of a camera's view volume, without a far plane: `xyz · p + w >= 0` for points inside,
/// relative to the eye.
pub(super) fn planes(view: &View) -> [[f64; 4]; 5] {
    let [fx, fy, fz] = view.forward;
    let side = |axis: [f64; 3], half: f64| {
        if view.orthographic {
            [axis[0], axis[1], axis[2], half]
        } else {
            [axis[0] + half * fx, axis[1] + half * fy, axis[2] + half * fz, 0.0]
        }
    };
    let back = |v: [f64; 3]| v.map(|c| -c);
    let [half_x, half_y] = view.half;
    [
        [fx, fy, fz, 0.0],
        side(view.right, half_x),
        side(back(view.right), half_x),
        side(view.up, half_y),
        side(back(view.up), half_y),
    ]
}

/// Returns the six faces of a box, each as its corners in order around the face.
fn faces(low: [f64; 3], high: [f64; 3]) -> [[[f64; 3]; 4]; 6] {
    std::array::from_fn(|face| {
        let (axis, end) = (face / 2, if face % 2 == 0 { low } else { high });
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        [[low, low], [high, low], [high, high], [low, high]].map(|[at_u, at_v]| {
            let mut p = [0.0; 3];
            (p[axis], p[u], p[v]) = (end[axis], at_u[u], at_v[v]);
            p
        })
    })
}

/// Clips a convex polygon against planes and returns the part inside all of them.
fn cut(mut polygon: Vec<[f64; 3]>, planes: &[[f64; 4]]) -> Vec<[f64; 3]> {
    for plane in planes {
        let inside = |p: [f64; 3]| dot([plane[0], plane[1], plane[2]], p) + plane[3];
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, &p) in polygon.iter().enumerate() {
            let q = polygon[(i + 1) % polygon.len()];
            let (at_p, at_q) = (inside(p), inside(q));
            if at_p >= 0.0 {
                kept.push(p);
            }
            if (at_p >= 0.0) != (at_q >= 0.0) {
                let t = at_p / (at_p - at_q);
                kept.push(std::array::from_fn(|a| p[a] + t * (q[a] - p[a])));
            }
        }
        polygon = kept;
    }
    polygon
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use adumbra_scene::{Camera, Projection};

    use super::*;

    const WIDE: Projection = Projection::Perspective { fov_degrees: 90.0 };

    fn view(eye: [f64; 3], target: [f64; 3], projection: Projection) -> View {
        Camera { eye, target, projection, width: 100, height: 100 }.view()
    }

    fn near(found: Option<[f64; 2]>, expected: [f64; 2]) {
        let found = found.expect("something is in view");
        assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-6), "{found:?} {expected:?}");
    }

    #[test]
    fn depths_end_where_the_view_leaves_the_box() {
        let cube = Bounds { min: [-10.0; 3], max: [10.0; 3] };
        near(depths_in_view(&view([0.0; 3], [0.0, 0.0, -1.0], WIDE), &cube), [0.0, 10.0]);
        near(depths_in_view(&view([0.0, 0.0, 50.0], [0.0; 3], WIDE), &cube), [40.0, 60.0]);
        assert_eq!(depths_in_view(&view([0.0, 0.0, 50.0], [0.0, 0.0, 60.0], WIDE), &cube), None);
        // Looking down on a floor that fills the whole view: every visible point, the farthest corner
        // included, has the same view depth.
        let floor = Bounds { min: [-1e6, 0.0, -1e6], max: [1e6, 0.0, 1e6] };
        near(depths_in_view(&view([0.0, 7.0, 0.0], [0.0; 3], WIDE), &floor), [7.0, 7.0]);
        let flat = Projection::Orthographic { height_world: 4.0 };
        near(depths_in_view(&view([0.0, 3.0, 20.0], [0.0, 3.0, 0.0], flat), &cube), [10.0, 30.0]);
        assert_eq!(depths_in_view(&view([0.0, 13.0, 20.0], [0.0, 13.0, 0.0], flat), &cube), None);
    }

    #[test]
    fn a_stray_triangle_beside_the_view_changes_nothing() {
        let town = Bounds { min: [-20.0, 0.0, -20.0], max: [20.0, 2.0, 20.0] };
        let strayed = Bounds { max: [1e6, 2.0, 1e6], ..town };
        let street = view([0.0, 1.5, 6.0], [0.0, 1.0, 0.0], Projection::Perspective { fov_degrees: 45.0 });
        let (alone, with) = (depths_in_view(&street, &town), depths_in_view(&street, &strayed));
        near(with, alone.unwrap());
    }

    #[test]
    fn empty_and_nan_bounds_are_not_in_view() {
        let nothing = Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
        let ahead = view([0.0; 3], [0.0, 0.0, -1.0], WIDE);
        assert_eq!(depths_in_view(&ahead, &nothing), None);
        let unbounded = Bounds { min: [f64::NAN, 0.0, 0.0], max: [1.0; 3] };
        assert_eq!(depths_in_view(&ahead, &unbounded), None);
    }
}
