//! The random texture of ambient occlusion: for each place of a 4 × 4 tile its own taps, the same on GPU and CPU.
//!
//! Numbers come from one sequence of points that fill the unit square evenly from any start on: multiples of 1/p and 1/p², p the plastic
//! number (M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018). Place k takes the k-th run of it, so that the
//! taps of a tile, which the filter averages, are as even as those of a texel.

use std::f64::consts::TAU;

use adumbra_shaders::constants::OCCLUSION_MAX_TAPS;
use adumbra_shaders::layout::{Array, OcclusionTaps};

use super::estimator::Estimator;
use super::settings::{OcclusionSettings, march};

const GOLDEN: f64 = 1.618_033_988_749_895;
const PLASTIC: f64 = 1.324_717_957_244_746;
/// Places of the tile.
const PLACES: usize = 16;
const MAX_TAPS: usize = OCCLUSION_MAX_TAPS as usize;

/// The taps of an estimator.
pub fn taps(settings: &OcclusionSettings) -> OcclusionTaps {
    let mut taps = [[0.0_f32; 4]; PLACES * MAX_TAPS];
    let samples = settings.samples as usize;
    let mut sequence = (1_u32..)
        .map(|i| [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)].map(|step| (0.5 + f64::from(i) * step).fract()));
    for (number, place) in taps.chunks_exact_mut(MAX_TAPS).enumerate() {
        match settings.estimator {
            Estimator::Issao if settings.parameter("relation") > 0.5 => {
                for (i, tap) in place.iter_mut().enumerate().take(samples) {
                    *tap = spiral_tap((i as f64 + within_tile(number)) / samples as f64, number);
                }
            }
            Estimator::Issao => {
                let mut inside = sequence.by_ref().map(disc_tap).filter(|c| c[0].hypot(c[1]) < 1.0);
                for tap in place.iter_mut().take(samples) {
                    let c = inside.next().unwrap_or_default();
                    *tap = [c[0] as f32, c[1] as f32, 0.0, 0.0];
                }
            }
            Estimator::Alchemy => {
                place.iter_mut().zip(sequence.by_ref()).take(samples).for_each(|(tap, e)| {
                    let r = e[0].sqrt();
                    *tap = [r * libm::cos(TAU * e[1]), r * libm::sin(TAU * e[1]), 0.0, 0.0].map(|v| v as f32);
                })
            }
            Estimator::Ssao => {
                for ((i, tap), e) in place.iter_mut().enumerate().take(samples).zip(sequence.by_ref()) {
                    *tap = ball_tap(e, (i as f64 + within_tile(number)) / samples as f64);
                }
            }
            Estimator::Hbao => march_taps(place, number, march(settings.samples), false, 1.0),
            Estimator::Gtao => {
                march_taps(place, number, march(settings.samples), true, settings.parameter("distribution"));
            }
        }
    }
    OcclusionTaps { taps: Array(taps) }
}

/// C(e1, e2) of Qiu et al. 2014, equation 1, for a radius of 1.
fn disc_tap([e1, e2]: [f64; 2]) -> [f64; 2] {
    [e1 * libm::sin(TAU * e2), e2 * libm::cos(TAU * e1)]
}

/// The same where the relation of e1 and e2, lost in print, is that they are equal: a spiral of one turn, whose density falls with the distance from the
/// middle, and which ends at the rim (free of each other they reach 1.255, and what is beyond 1 is passed over). Each place turns its
/// spiral by a 16th of a circle more.
fn spiral_tap(e: f64, place: usize) -> [f32; 4] {
    let [x, y] = disc_tap([e, e]);
    let (sin, cos) = libm::sincos(TAU * place as f64 / PLACES as f64);
    [cos * x - sin * y, sin * x + cos * y, 0.0, 0.0].map(|v| v as f32)
}

/// Where a place of the tile falls in each of the parts that taps divide something into.
fn within_tile(place: usize) -> f64 {
    (place as f64 + 0.5) / PLACES as f64
}

/// A point in the unit ball, denser towards the middle: the share `at` of the way from the first tap to the last, at lerp(0.1, 1, at²).
fn ball_tap([e1, e2]: [f64; 2], at: f64) -> [f32; 4] {
    let (z, length) = (1.0 - 2.0 * e1, 0.1 + 0.9 * at * at);
    let r = (1.0 - z * z).sqrt();
    [r * libm::cos(TAU * e2), r * libm::sin(TAU * e2), z, 0.0].map(|v| (v * length) as f32)
}

/// Taps of a march: by direction, then by step; of `paired` directions only the first half, which the others are opposite to. x and y are
/// the direction, y up; z how far the step is, of the radius, and w the same of the opposite direction. The tile turns directions by
/// what lies between two of them, and moves the steps of each by one.
fn march_taps(
    place: &mut [[f32; 4]],
    number: usize,
    [directions, steps]: [u32; 2],
    paired: bool,
    power: f64,
) {
    let slices = if paired { directions.div_ceil(2) } else { directions };
    let turns = if paired { 0.5 } else { 1.0 };
    let mut next = place.iter_mut();
    for slice in 0..slices {
        let angle = TAU * turns * (f64::from(slice) + within_tile(number)) / f64::from(slices);
        let start = |side: u32| {
            let i = (2 * slice + side) as usize * PLACES + number;
            (0.5 + i as f64 * (GOLDEN - 1.0)).fract()
        };
        for step in 0..steps {
            let far = |side| libm::pow((f64::from(step) + start(side)) / f64::from(steps), power);
            if let Some(tap) = next.next() {
                *tap = [libm::cos(angle), libm::sin(angle), far(0), far(1)].map(|v| v as f32);
            }
        }
    }
}
