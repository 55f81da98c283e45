//! Filters of shadow maps: moments and their blur, light bleeding and its reduction, and soft shadows against
//! a ray-traced sun disc.

use adumbra_render::maps::gaussian;
use adumbra_render::maps::twin::MapTwin;
use adumbra_render::{Answer, Prepared, Renderer, SceneOptions, Shot, SurfacePoint, TechniqueFiles, build};
use adumbra_scene::{Camera, Projection};

use crate::kit;
use crate::kit::boxes::boxes;
use crate::kit::penumbra::Penumbra;

fn prepare(renderer: &Renderer, name: &str) -> Prepared {
    let technique = build(renderer.gpu(), &name.parse().unwrap(), TechniqueFiles::default()).unwrap();
    renderer.prepare(technique).unwrap()
}

/// Computes blurred moments of a few texels, and of the mip level above, directly and compares them with what
/// the passes stored.
#[test]
fn moments_are_blurred_per_layer_and_reduced_to_mips() {
    let mut renderer = Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap();
    let shot = Shot { camera: kit::camera(32, 18), towards_sun: kit::sun(), number: 0 };
    for name in ["csm-vsm:size=128:cascades=2:blur=7", "csm-evsm:size=128:cascades=2:blur=3", "msm:size=128"]
    {
        let mut technique = prepare(&renderer, name);
        renderer.draw(&shot, &mut technique, Answer::Visibility).unwrap();
        let map = technique.technique().map().unwrap();
        let twin = MapTwin::read(renderer.gpu(), map).unwrap();
        let weights = gaussian(map.params().filter_width);
        let layers = map.settings().layers() as usize;
        let radius = weights.len() as i64 - 1;
        let expected = |layer: usize, x: u32, y: u32| {
            let mut sum = [0.0_f64; 4];
            for dy in -radius..=radius {
                for dx in -radius..=radius {
                    let at = |c: u32, d: i64| (i64::from(c) + d).clamp(0, 127) as u32;
                    let m = twin.moments_of_depth(layer, at(x, dx), at(y, dy)).unwrap();
                    let weight = weights[dx.unsigned_abs() as usize] * weights[dy.unsigned_abs() as usize];
                    (0..4).for_each(|c| sum[c] += f64::from(weight) * f64::from(m[c]));
                }
            }
            sum
        };
        let near = |a: [f64; 4], b: [f32; 4]| {
            (0..4).all(|c| (a[c] - f64::from(b[c])).abs() <= 2e-5 * a[c].abs().max(1e-3))
        };
        for layer in 0..layers {
            for (x, y) in [(0, 0), (127, 64), (37, 90), (64, 64), (101, 3)] {
                let (a, b) = (expected(layer, x, y), twin.moments_stored(layer, 0, x, y).unwrap());
                assert!(near(a, b), "{name} layer {layer} at {x}, {y}: {a:?}, not {b:?}");
                let mut mean = [0.0; 4];
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let m = twin.moments_stored(layer, 0, x / 2 * 2 + dx, y / 2 * 2 + dy).unwrap();
                    (0..4).for_each(|c| mean[c] += 0.25 * f64::from(m[c]));
                }
                assert!(near(mean, twin.moments_stored(layer, 1, x / 2, y / 2).unwrap()), "{name} {x} {y}");
            }
        }
    }
}

/// Uses ground at height 0, a low plate over the whole middle, and above it a high plate that ends at x = 0.
/// Below the low plate everything is dark, but in a variance map the high plate's edge shows through it.
#[test]
fn light_bleeds_through_overlapping_casters_until_the_tail_is_cut() {
    let scene = boxes(&[
        ([-20.0, -1.0, -20.0], [20.0, 0.0, 20.0]),
        ([-8.0, 1.0, -8.0], [8.0, 1.1, 8.0]),
        ([-8.0, 10.0, -8.0], [0.0, 10.1, 8.0]),
    ]);
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    let projection = Projection::Perspective { fov_degrees: 60.0 };
    let camera = Camera { eye: [0.0, 30.0, 30.0], target: [0.0; 3], projection, width: 1280, height: 720 };
    let shot = Shot { camera, towards_sun: [0.0, 1.0, 0.0], number: 0 };
    let points: Vec<_> = (-200..=200)
        .map(|i| SurfacePoint { p_world: [0.01 * f64::from(i), 0.0, 0.3], normal: [0.0, 1.0, 0.0] })
        .collect();
    let mut brightest = |name: &str| {
        let mut technique = prepare(&renderer, name);
        let factors = renderer.answer(&shot, &mut technique, &points).unwrap();
        factors.into_iter().fold(0.0, f32::max)
    };
    // A share q of the filter is the low plate, 1 above the ground; the rest is 9 nearer the sun. Chebyshev's
    // bound is 81 q (1 - q) / (81 q (1 - q) + (10 - 9 q)²), at most 0.67, at q = 10/11. With the tail cut at
    // 0.2 that is 0.59.
    let plain = brightest("vsm:size=512:blur=9:bleed=0");
    let usual = brightest("vsm:size=512:blur=9:bleed=0.2");
    let strong = brightest("vsm:size=512:blur=9:bleed=0.9");
    let (exponential, four) = (brightest("evsm:size=512:blur=9"), brightest("msm:size=512:blur=9"));
    println!(
        "bleeding: vsm {plain:.3}, cut at 0.2 {usual:.3}, at 0.9 {strong:.3}, evsm {exponential:.3}, msm {four:.3}"
    );
    assert_eq!(brightest("sm:size=512"), 0.0);
    assert_eq!(brightest("pcf:size=512"), 0.0);
    assert!((0.6..0.68).contains(&plain), "{plain}");
    assert!((0.5..0.6).contains(&usual), "{usual}");
    assert!(strong < 0.02, "{strong}");
    assert!(exponential < 0.1 * plain && four < 0.1 * plain, "{exponential} {four}");
}

/// Uses a raised plate over flat ground, under a sun whose penumbra is about as wide as the widest filter.
/// The mean of several comparisons has a smaller error than one comparison, and penumbrae that follow their
/// casters have the smallest.
#[test]
fn filters_are_nearer_to_a_sun_disc_than_one_comparison() {
    let angle: f64 = 2.0;
    let mut penumbra = Penumbra::new(angle);
    let mut error = |name: &str| {
        let technique = prepare(&penumbra.renderer, name);
        penumbra.error(technique)
    };
    let names = ["sm", "pcf:filter=3", "pcf", "pcf:filter=poisson", "vsm", "pcss:sun-degrees=2"];
    let [one, three, five, poisson, variance, soft] = names.map(|name| error(&format!("{name}:size=1024")));
    println!(
        "RMSE against a disc of {angle}°: sm {one:.4}, pcf 3×3 {three:.4}, 5×5 {five:.4}, Poisson {poisson:.4}, vsm {variance:.4}, \
         pcss {soft:.4}"
    );
    assert!(three < one && five < one && poisson < one && variance < one);
    assert!(soft < five);
}
