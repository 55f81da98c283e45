//! Edges of the true shadow in a picture: between neighbouring pixels of which rays find one lit and the
//! other shadowed.
//!
//! [`crate::truth::EdgeProbe`] traces rays around a point from its tangent plane. It takes the folds of a
//! bumpy surface for edges, because points of that plane are below the surface there. Here an edge is one
//! that the picture shows, so folds that cast no shadow are not edges. However, edges that the camera does
//! not see are missed. If pixels are larger than the radius, so are shadows that fall between them.

use std::collections::HashMap;

use crate::metrics::is_lit;
use crate::report::ClearErrors;
use crate::truth::Surfaces;
use crate::vector::{cross, dot, normalize};

/// Returns for each pixel whether it is within `radius_world`, in the light's plane, of a pixel at an edge of
/// the hard shadow `truth`. Pixels without a surface are not.
///
/// Cost: one pass over the picture, plus a search of the edges near each pixel.
pub fn near_edges(surfaces: &Surfaces, truth: &[f32], towards_sun: [f64; 3], radius_world: f64) -> Vec<bool> {
    let other = if towards_sun[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
    let x = normalize(cross(other, towards_sun));
    let y = cross(towards_sun, x);
    let flat = |i: usize| [dot(x, surfaces.position[i]), dot(y, surfaces.position[i])];
    let cell = |p: [f64; 2]| p.map(|c| (c / radius_world).floor() as i64);
    let apart = |a: [f64; 2], b: [f64; 2]| libm::hypot(a[0] - b[0], a[1] - b[1]);
    let width = surfaces.width as usize;
    let neighbours = |i: usize| {
        let beside = [(!i.is_multiple_of(width)).then(|| i - 1), (i % width + 1 < width).then_some(i + 1)];
        let above = [i.checked_sub(width), Some(i + width).filter(|&j| j < surfaces.pixels())];
        beside.into_iter().chain(above).flatten().filter(|&j| surfaces.is_valid(j))
    };
    // Size of a pixel in the light's plane: the distance to the nearest of its neighbours.
    let spacing = |i: usize| neighbours(i).map(|j| apart(flat(i), flat(j))).fold(f64::INFINITY, f64::min);
    let mut edges: HashMap<[i64; 2], Vec<[f64; 2]>> = HashMap::new();
    for i in (0..surfaces.pixels()).filter(|&i| surfaces.is_valid(i)) {
        for j in neighbours(i).filter(|&j| is_lit(truth[i]) != is_lit(truth[j])) {
            // Neighbours that are far apart in the world are on both sides of a silhouette, not of a shadow
            // edge.
            if apart(flat(i), flat(j)) <= radius_world.max(3.0 * spacing(i).min(spacing(j))) {
                edges.entry(cell(flat(i))).or_default().push(flat(i));
                break;
            }
        }
    }
    let near = |i: usize| {
        let p = flat(i);
        let [column, row] = cell(p);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [column + dx, row + dy]));
        around.filter_map(|c| edges.get(&c)).flatten().any(|&edge| apart(p, edge) <= radius_world)
    };
    (0..surfaces.pixels()).map(|i| surfaces.is_valid(i) && near(i)).collect()
}

/// Returns the errors of `factors` at the compared pixels that are not `near` an edge: acne and leaks.
/// Returns `None` if there is no such pixel.
pub fn errors_off_edges(
    factors: &[f32],
    truth: &[f32],
    is_compared: impl Fn(usize) -> bool,
    near: &[bool],
) -> Option<ClearErrors> {
    let (mut all, mut clear, mut wrong) = (0_u64, 0_u64, [0_u64; 2]);
    for i in (0..factors.len()).filter(|&i| is_compared(i)) {
        all += 1;
        if near[i] {
            continue;
        }
        clear += 1;
        if is_lit(factors[i]) != is_lit(truth[i]) {
            wrong[usize::from(is_lit(truth[i]))] += 1;
        }
    }
    let of = |part: u64, whole: u64| part as f64 / whole as f64;
    (clear > 0).then(|| ClearErrors {
        pixels: of(clear, all),
        wrong_lit: of(wrong[0], clear),
        wrong_shadowed: of(wrong[1], clear),
    })
}

#[cfg(test)]
mod tests {
    use adumbra_scene::{Camera, GeneratedKind, Projection, generate};

    use super::*;
    use crate::truth::{SunShape, TruthTracer};

    /// A dimpled ball on the ground, seen across the light: many folds, and a single shadow.
    fn ball(radius_world: f64) -> (Surfaces, Vec<f32>, Vec<bool>) {
        let mut scene = generate(GeneratedKind::Ball, 1);
        scene.stand_on_ground(4.0).unwrap();
        let truth = TruthTracer::build(&scene, false);
        let projection = Projection::Perspective { fov_degrees: 45.0 };
        let camera =
            Camera { eye: [-4.0, 5.0, 4.0], target: [-0.5, 0.0, 0.0], projection, width: 160, height: 120 };
        let surfaces = truth.surfaces(&camera);
        let towards_sun = normalize([0.5, 0.8, 0.35]);
        let factors = truth.factors(&surfaces, towards_sun, SunShape::Hard);
        let near = near_edges(&surfaces, &factors, towards_sun, radius_world);
        (surfaces, factors, near)
    }

    #[test]
    fn folds_without_a_shadow_are_not_edges() {
        let (surfaces, factors, near) = ball(0.04);
        // The top of the ball, where the sun is high above every dimple.
        let top = (0..surfaces.pixels()).filter(|&i| surfaces.is_valid(i) && surfaces.position[i][1] > 1.9);
        let top: Vec<usize> = top.collect();
        assert!(top.len() > 30, "{}", top.len());
        let lit = top.iter().filter(|&&i| factors[i] > 0.5).count();
        let off = top.iter().filter(|&&i| near[i]).count();
        assert!(lit == top.len() && off == 0, "{lit} lit, {off} near edges, of {}", top.len());
        assert!(near.iter().any(|n| *n), "the ball's shadow has an outline");
    }

    #[test]
    fn near_edges_has_both_sides_and_grows_with_the_radius() {
        let count = |radius| {
            let (_, factors, near) = ball(radius);
            let sides = [true, false]
                .map(|lit| (0..near.len()).filter(|&i| near[i] && is_lit(factors[i]) == lit).count());
            assert!(sides[0] > 20 && sides[1] > 20, "{sides:?}");
            sides[0] + sides[1]
        };
        assert!(count(0.05) < count(0.2));
    }

    #[test]
    fn errors_off_edges_of_known_values() {
        let truth = [0.0, 0.0, 1.0, 1.0, 1.0, 0.0];
        let factors = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
        let near = [false, false, false, false, true, false];
        let e = errors_off_edges(&factors, &truth, |i| i != 5, &near).unwrap();
        assert_eq!((e.pixels, e.wrong_lit, e.wrong_shadowed), (0.8, 0.25, 0.25));
        assert_eq!(errors_off_edges(&factors, &truth, |i| i == 4, &near), None);
    }
}
