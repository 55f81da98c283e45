//! The cap on the radius in texels on the screen: a larger radius shrinks to the cap as a whole and is not
//! cut off.

use adumbra_render::{Renderer, SceneOptions};
use adumbra_scene::{Camera, Projection};

use crate::kit;
use crate::kit::ambient::{GBuffer, largest, settings};
use crate::kit::boxes::boxes;

const SIZE: [u32; 2] = [160, 120];
/// Height of an orthographic picture, world units. One texel is 1/64 of a world unit.
const HEIGHT_WORLD: f64 = 120.0 / 64.0;
const CAP: f64 = 32.0;
/// Every estimator with fixed parameters, independent of tuned defaults.
const ESTIMATORS: [&str; 5] = [
    "ssao:strength=1:power=1:bias=0.05:range=1",
    "hbao:strength=1:power=1:bias=0.1:falloff=2",
    "alchemy:sigma=0.5:k=1:beta=0.0001:epsilon=0.001",
    "issao",
    "gtao:falloff=0.385:thin=0:distribution=2:power=2.2",
];

/// An inside corner, so near that a radius of one unit covers a large part of the picture.
fn corner(projection: Projection) -> GBuffer {
    let scene = boxes(&[([-9.0, -1.0, -9.0], [9.0, 0.0, 9.0]), ([-10.0, -1.0, -9.0], [0.0, 9.0, 9.0])]);
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    let camera =
        Camera { eye: [2.1, 1.7, 0.9], target: [0.0; 3], projection, width: SIZE[0], height: SIZE[1] };
    GBuffer::drawn(&mut renderer, camera, 0)
}

fn visibility(seen: &GBuffer, estimator: &str, radius_world: f64, cap: f64) -> Vec<f32> {
    // `levels=off`, because `issao` otherwise reduces its taps in steps if the radius is only a few texels.
    seen.on_cpu(&settings(&format!("{estimator}:filter=none:levels=off:cap={cap}"), radius_world))
}

fn mean(values: impl ExactSizeIterator<Item = f32>) -> f64 {
    let count = values.len() as f64;
    values.map(f64::from).sum::<f64>() / count
}

#[test]
fn capped_radius_gives_the_result_of_the_smaller_radius() {
    let seen = corner(Projection::Orthographic { height_world: HEIGHT_WORLD });
    for estimator in ESTIMATORS {
        let small = visibility(&seen, estimator, CAP / 64.0, 4096.0);
        for radius_world in [0.51, 0.75, 2.0, 100.0] {
            let capped = visibility(&seen, estimator, radius_world, CAP);
            // Rounding may move a tap to the next texel.
            let moved = capped.iter().zip(&small).filter(|(a, b)| (*a - *b).abs() > 1e-4).count();
            let whole = visibility(&seen, estimator, radius_world, 4096.0);
            println!(
                "{estimator} {radius_world}: {moved} texels from the smaller radius, {:.3} from its own without a cap",
                largest(&capped, &whole)
            );
            assert!(moved * 1000 <= small.len(), "{estimator} {radius_world}: {moved}");
        }
        // The corner must still be visible. If the region were cut off at the cap, a large radius would leave
        // almost nothing of it.
        let darkest = small.iter().copied().fold(1.0, f32::min);
        assert!(darkest < 0.7, "{estimator}: {darkest}");
        let whole = visibility(&seen, estimator, 2.0, 4096.0);
        assert!(largest(&small, &whole) > 0.1, "{estimator}: the cap has an effect");
    }
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn result_is_continuous_where_the_radius_passes_the_cap() {
    // From well below the cap everywhere to well above it.
    let perspective = Projection::Perspective { fov_degrees: 40.0 };
    for projection in [Projection::Orthographic { height_world: HEIGHT_WORLD }, perspective] {
        result_goes_on_while_the_radius_grows(projection, 0.4, 48);
    }
}

#[test]
fn result_is_continuous_just_below_and_above_the_cap() {
    // The cap is a radius of half a unit.
    let projection = Projection::Orthographic { height_world: HEIGHT_WORLD };
    result_goes_on_while_the_radius_grows(projection, 0.48, 7);
}

/// Grows the radius by a factor of 1.02 per step, to beyond the cap.
fn result_goes_on_while_the_radius_grows(projection: Projection, from_world: f64, radii: u32) {
    let seen = corner(projection);
    for estimator in ESTIMATORS {
        let (mut steps, mut last) = (Vec::new(), None::<Vec<f32>>);
        for step in 0..radii {
            let now = visibility(&seen, estimator, from_world * libm::pow(1.02, f64::from(step)), CAP);
            if let Some(last) = &last {
                steps.push(mean(now.iter().zip(last).map(|(a, b)| (a - b).abs())));
            }
            last = Some(now);
        }
        let (first, most) = (steps[0], steps.iter().copied().fold(0.0, f64::max));
        let last = steps[steps.len() - 1];
        println!(
            "{estimator} {projection:?}: mean step {first:.4} at first, {most:.4} at most, {last:.5} at last"
        );
        // Rounding moves taps at every step. Reaching the cap causes no further change, and beyond the cap
        // nothing changes.
        assert!(most < 0.02 && most < 2.0 * first, "{estimator} {projection:?}: {steps:?}");
        assert!(last < 1e-3, "{estimator} {projection:?}: {steps:?}");
    }
}
