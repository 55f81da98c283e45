//! The direction in which most of a scene's horizontal edges run, for the oblique frame: geometry that is
//! aligned with the grid takes the fewest bytes.

use std::f64::consts::FRAC_PI_2;

use adumbra_scene::{Instance, Mesh, Scene};
use rayon::prelude::*;

/// Number of directions in a quarter of a turn. A step moves the end of an edge of 100 m by 2.4 mm.
const DIRECTIONS: usize = 1 << 16;
/// Directions on either side that count for a peak: 0.04°.
const NEAR: usize = 32;
/// An edge that rises by less than this share of its length is horizontal.
const LEVEL: f64 = 1.0 / 64.0;
/// Units in the longest edge that the scene has room for. Sums of whole numbers do not depend on their order.
const UNITS: f64 = (1_u64 << 32) as f64;

/// Returns the yaw of [`adumbra::Frame::Oblique`], from 0 to a quarter of a turn.
///
/// Cost: one pass over the triangles of all instances.
pub(crate) fn dominant_yaw_radians(scene: &Scene) -> f64 {
    let diagonal = scene.bounds().diagonal();
    let units_per_world = UNITS / diagonal.max(f64::MIN_POSITIVE);
    let casting: Vec<&Instance> = scene.instances.iter().filter(|i| i.casts).collect();
    let lengths = casting
        .par_iter()
        .fold(
            || vec![0_u64; DIRECTIONS],
            |mut lengths, instance| {
                add_edges(&mut lengths, instance, &scene.meshes[instance.mesh as usize], units_per_world);
                lengths
            },
        )
        .reduce(
            || vec![0_u64; DIRECTIONS],
            |mut sum, lengths| {
                sum.iter_mut().zip(lengths).for_each(|(sum, length)| *sum = sum.saturating_add(length));
                sum
            },
        );
    peak(&lengths) as f64 / DIRECTIONS as f64 * FRAC_PI_2
}

fn add_edges(lengths: &mut [u64], instance: &Instance, mesh: &Mesh, units_per_world: f64) {
    for triangle in &mesh.triangles {
        let corners = triangle.map(|v| instance.to_world(mesh.positions[v as usize]));
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let [x, y, z] = std::array::from_fn(|i| corners[b][i] - corners[a][i]);
            let flat = (x * x + z * z).sqrt();
            if !(flat > 0.0 && y.abs() <= LEVEL * flat) {
                continue;
            }
            let quarters = libm::atan2(z, x) / FRAC_PI_2;
            let direction = ((quarters - quarters.floor()) * DIRECTIONS as f64).round() as usize;
            let units = &mut lengths[direction % DIRECTIONS];
            *units = units.saturating_add((flat * units_per_world) as u64);
        }
    }
}

/// Returns the most frequent direction within the neighbourhood that has most length; the first of equals.
fn peak(lengths: &[u64]) -> usize {
    let at = |direction: usize| lengths[direction % DIRECTIONS];
    // The window's centre is `start + NEAR`.
    let mut window: u128 = (0..=2 * NEAR).map(|i| u128::from(at(i))).sum();
    let mut best = (window, 0);
    for start in 1..DIRECTIONS {
        window += u128::from(at(start + 2 * NEAR));
        window -= u128::from(at(start - 1));
        if window > best.0 {
            best = (window, start);
        }
    }
    let mut most = (0, 0);
    for direction in best.1..=best.1 + 2 * NEAR {
        if at(direction) > most.0 {
            most = (at(direction), direction % DIRECTIONS);
        }
    }
    most.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use adumbra_testing::{cuboid, scene_of};

    #[test]
    fn yaw_is_that_of_the_longest_edges_whatever_their_order() {
        let turned = |degrees: f64| {
            let mut scene = scene_of(vec![cuboid([0.0; 3], [8.0, 3.0, 5.0])]);
            let (sin, cos) = degrees.to_radians().sin_cos();
            scene.instances[0].world_from_mesh =
                [[cos, 0.0, -sin, 7.0], [0.0, 1.0, 0.0, 0.0], [sin, 0.0, cos, -2.0]];
            scene
        };
        assert_eq!(dominant_yaw_radians(&turned(0.0)), 0.0);
        assert_eq!(dominant_yaw_radians(&turned(90.0)), 0.0);
        for degrees in [0.3_f64, 27.0, 89.9, -30.0] {
            let mut scene = turned(degrees);
            let yaw = dominant_yaw_radians(&scene);
            let expected = degrees.rem_euclid(90.0);
            assert!((yaw.to_degrees() - expected).abs() < 0.001, "{degrees}: {}", yaw.to_degrees());
            scene.meshes[0].triangles.reverse();
            assert_eq!(dominant_yaw_radians(&scene), yaw);
        }
    }
}
