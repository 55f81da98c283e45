//! The most texels that a radius takes on the screen: a larger one shrinks to it as a whole, it is not cut off.

mod kit;

use adumbra::camera::{Camera, Projection};
use adumbra_render::{Renderer, SceneOptions};
use kit::ambient::{Seen, largest, settings};
use kit::boxes::boxes;

const SIZE: [u32; 2] = [160, 120];
/// World units that an orthographic picture is high: a texel is a 64th of one.
const HEIGHT_WORLD: f64 = 120.0 / 64.0;
const CAP: f64 = 32.0;
/// With numbers that no tuning moves.
const ESTIMATORS: [&str; 5] = [
    "ssao:strength=1:power=1:bias=0.05:range=1",
    "hbao:strength=1:power=1:bias=0.1:falloff=2",
    "alchemy:sigma=0.5:k=1:beta=0.0001:epsilon=0.001",
    "issao",
    "gtao:falloff=0.385:thin=0:distribution=2:power=2.2",
];

/// An inside corner, from so near that a radius of a unit covers a large part of the picture.
fn corner(projection: Projection) -> Seen {
    let scene = boxes(&[([-9.0, -1.0, -9.0], [9.0, 0.0, 9.0]), ([-10.0, -1.0, -9.0], [0.0, 9.0, 9.0])]);
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    let camera =
        Camera { eye: [2.1, 1.7, 0.9], target: [0.0; 3], projection, width: SIZE[0], height: SIZE[1] };
    Seen::drawn(&mut renderer, camera, 0)
}

fn visibility(seen: &Seen, estimator: &str, radius_world: f64, cap: f64) -> Vec<f32> {
    // At few texels `issao` takes fewer taps by steps of its own.
    seen.on_cpu(&settings(&format!("{estimator}:filter=none:levels=off:cap={cap}"), radius_world))
}

fn mean(values: impl ExactSizeIterator<Item = f32>) -> f64 {
    let count = values.len() as f64;
    values.map(f64::from).sum::<f64>() / count
}

#[test]
fn capped_radius_is_the_smaller_radius_as_a_whole() {
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
        // And the corner is seen in it: were the region cut to the cap, a large radius would leave next to nothing of it.
        let darkest = small.iter().copied().fold(1.0, f32::min);
        assert!(darkest < 0.7, "{estimator}: {darkest}");
        let whole = visibility(&seen, estimator, 2.0, 4096.0);
        assert!(largest(&small, &whole) > 0.1, "{estimator}: the cap tells");
    }
}

#[test]
fn result_goes_on_where_the_radius_passes_the_cap() {
    for projection in [
        Projection::Orthographic { height_world: HEIGHT_WORLD },
        Projection::Perspective { fov_degrees: 40.0 },
    ] {
        let seen = corner(projection);
        for estimator in ESTIMATORS {
            let (mut steps, mut last) = (Vec::new(), None::<Vec<f32>>);
            // By factors of 1.02, from well below the cap to well above it everywhere.
            for step in 0..48 {
                let now = visibility(&seen, estimator, 0.4 * libm::pow(1.02, f64::from(step)), CAP);
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
            // Rounding moves taps at every step; passing the cap adds none of its own, and beyond it nothing changes.
            assert!(most < 0.02 && most < 2.0 * first, "{estimator} {projection:?}: {steps:?}");
            assert!(last < 1e-3, "{estimator} {projection:?}: {steps:?}");
        }
    }
}
