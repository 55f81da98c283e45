//! FLIP compared with its authors' implementation.

use adumbra_compare::metrics::flip;
use adumbra_compare::metrics::flip::{PIXELS_PER_DEGREE, flip_map};
use adumbra_scene::random::Random;
use adumbra_truth::picture::Picture;
use nv_flip::FlipImageRgb8;

/// Largest difference at any pixel. The other implementation takes a square root in single precision.
const MAX_DIFFERENCE: f32 = 1e-3;

fn picture(width: u32, height: u32, color: impl Fn(u32, u32) -> [u8; 3]) -> Picture {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Picture { width, height, rgb: pixels.flat_map(|(x, y)| color(x, y)).collect(), difference_share: None }
}

fn noise(width: u32, height: u32, seed: u64) -> Picture {
    let mut random = Random::for_batch(seed, 0);
    let rgb = (0..width * height * 3).map(|_| (random.unit() * 256.0) as u8).collect();
    Picture { width, height, rgb, difference_share: None }
}

fn shade(width: u32, height: u32, edge: u32) -> Picture {
    picture(width, height, |x, y| {
        let light = if x + y / 2 < edge { 0.35 } else { 1.0 };
        [220.0, 190.0, 150.0].map(|c| (c * light - f64::from(y % 7)) as u8)
    })
}

#[track_caller]
fn check(name: &str, reference: &Picture, test: &Picture) -> f64 {
    let image = |p: &Picture| FlipImageRgb8::with_data(p.width, p.height, &p.rgb);
    let theirs = nv_flip::flip(image(reference), image(test), PIXELS_PER_DEGREE as f32).to_vec();
    let ours = flip_map(reference, test, PIXELS_PER_DEGREE).unwrap();
    let largest = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let mean = flip(reference, test).unwrap();
    let their_mean = theirs.iter().map(|e| f64::from(*e)).sum::<f64>() / theirs.len() as f64;
    eprintln!("{name}: mean {mean:.6}, theirs {their_mean:.6}, largest difference {largest:.2e}");
    assert!(largest <= MAX_DIFFERENCE, "{name}: {largest}");
    assert!((mean - their_mean).abs() <= 1e-4, "{name}");
    mean
}

#[test]
fn flip_matches_its_authors_on_shadow_edges() {
    assert!(check("edge moved by 3", &shade(96, 64, 50), &shade(96, 64, 53)) > 0.0);
    assert!(check("odd size", &shade(61, 37, 30), &shade(61, 37, 22)) > 0.0);
}

#[test]
fn flip_matches_its_authors_on_noise_and_tiny_pictures() {
    check("noise", &noise(48, 33, 1), &noise(48, 33, 2));
    check("one pixel", &noise(1, 1, 3), &noise(1, 1, 4));
    check("one row", &noise(40, 1, 5), &noise(40, 1, 6));
    check("smaller than the filter", &noise(5, 7, 7), &noise(5, 7, 8));
}

#[test]
fn flip_matches_its_authors_on_plain_colors() {
    let plain = |c: [u8; 3]| picture(24, 24, |_, _| c);
    assert_eq!(check("equal", &plain([10, 200, 30]), &plain([10, 200, 30])), 0.0);
    check("black and white", &plain([0; 3]), &plain([255; 3]));
    check("green and blue", &plain([0, 255, 0]), &plain([0, 0, 255]));
    let dot = |x: u32, y: u32| if (x, y) == (12, 12) { [255; 3] } else { [40; 3] };
    check("a point", &plain([40; 3]), &picture(24, 24, dot));
}
