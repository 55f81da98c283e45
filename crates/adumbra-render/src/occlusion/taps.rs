//! The noise of ambient occlusion: a separate set of taps for each texel of a 4 × 4 tile, the same on GPU and
//! CPU.
//!
//! Values come from one sequence of points that fills the unit square evenly from any start: multiples of 1/p
//! and 1/p², where p is the plastic number (M. Roberts, *The Unreasonable Effectiveness of Quasirandom
//! Sequences*, 2018). Texel k of the tile takes the k-th run of the sequence, so that the taps of a whole
//! tile, which the filter averages, are as even as those of a texel. Marches instead rotate from texel to
//! texel by a 16th of the angle between two directions, and their start offsets are multiples of the golden
//! ratio.

use std::f64::consts::TAU;

use adumbra_shaders::constants::OCCLUSION_MAX_TAPS;
use adumbra_shaders::layout::{Array, OcclusionTaps};

use super::estimator::Estimator;
use super::settings::{OcclusionSettings, march};

const GOLDEN: f64 = 1.618_033_988_749_895;
const PLASTIC: f64 = 1.324_717_957_244_746;
/// Texels of the tile.
const PLACES: usize = 16;
const MAX_TAPS: usize = OCCLUSION_MAX_TAPS as usize;

/// Returns the taps of an estimator.
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
                for (tap, e) in place.iter_mut().take(samples).zip(sequence.by_ref()) {
                    let r = e[0].sqrt();
                    *tap = [r * libm::cos(TAU * e[1]), r * libm::sin(TAU * e[1]), 0.0, 0.0].map(|v| v as f32);
                }
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

/// [`disc_tap`] with e1 = e2, on the assumption that this is the relation that was lost in print. It gives a
/// spiral of one turn whose density falls with the distance from the middle and which ends at the rim.
/// Independent e1 and e2 reach a distance of 1.255, and points beyond 1 are skipped. Each texel of the tile
/// rotates its spiral by a further 16th of a circle.
fn spiral_tap(e: f64, place: usize) -> [f32; 4] {
    let [x, y] = disc_tap([e, e]);
    let (sin, cos) = libm::sincos(TAU * place as f64 / PLACES as f64);
    [cos * x - sin * y, sin * x + cos * y, 0.0, 0.0].map(|v| v as f32)
}

/// Offset of a tile texel within each interval that taps divide a range into, 0 to 1.
fn within_tile(place: usize) -> f64 {
    (place as f64 + 0.5) / PLACES as f64
}

/// A point in the unit ball, denser towards the middle. `at` is the tap's position from the first to the
/// last, 0 to 1; its distance is lerp(0.1, 1, at²).
fn ball_tap([e1, e2]: [f64; 2], at: f64) -> [f32; 4] {
    let (z, length) = (1.0 - 2.0 * e1, 0.1 + 0.9 * at * at);
    let r = (1.0 - z * z).sqrt();
    [r * libm::cos(TAU * e2), r * libm::sin(TAU * e2), z, 0.0].map(|v| (v * length) as f32)
}

/// Writes the taps of a march, by direction, then by step. With `paired`, only the first half of the
/// directions is written, because the others are their opposites. x and y are the direction, y up. z is the
/// distance of the step as a share of the radius, and w that of the opposite direction. Over the tile,
/// directions rotate by the angle between two of them, and each direction's steps shift by one step.
fn march_taps(
    place: &mut [[f32; 4]],
    number: usize,
    [directions, steps]: [u32; 2],
    paired: bool,
    power: f64,
) {
    let (slices, turns) = if paired && directions > 1 { (directions / 2, 0.5) } else { (directions, 1.0) };
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

#[cfg(test)]
mod tests {
    use super::*;

    fn taps_for(estimator: Estimator, samples: u32) -> Vec<[f32; 4]> {
        let settings = OcclusionSettings { samples, ..OcclusionSettings::new(estimator, 1.0) };
        taps(&settings).taps.0.chunks_exact(MAX_TAPS).flat_map(|p| p[..samples as usize].to_vec()).collect()
    }

    fn mean(taps: &[[f32; 4]], of: impl Fn(&[f32; 4]) -> f32) -> f32 {
        taps.iter().map(of).sum::<f32>() / taps.len() as f32
    }

    #[test]
    fn disc_taps_are_evenly_spread() {
        let taps = taps_for(Estimator::Alchemy, 12);
        assert!(taps.iter().all(|t| t[0].hypot(t[1]) < 1.0));
        assert!((mean(&taps, |t| t[0] * t[0] + t[1] * t[1]) - 0.5).abs() < 0.02);
        assert!(mean(&taps, |t| t[0]).hypot(mean(&taps, |t| t[1])) < 0.02);
    }

    #[test]
    fn taps_of_a_ball_are_even_in_direction_and_denser_inside() {
        let length = |t: &[f32; 4]| (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
        let taps = taps_for(Estimator::Ssao, 12);
        assert!(taps.iter().all(|t| (0.1..1.0).contains(&length(t))));
        // The mean of 0.1 + 0.9 t² over uniform t is 0.4.
        assert!((mean(&taps, length) - 0.4).abs() < 0.01);
        for axis in 0..3 {
            assert!((mean(&taps, |t| (t[axis] / length(t)).powi(2)) - 1.0 / 3.0).abs() < 0.02, "{axis}");
        }
    }

    #[test]
    fn march_taps_are_unit_directions_with_outward_steps() {
        for samples in 1..=64 {
            let [directions, steps] = march(samples);
            for (estimator, slices) in
                [(Estimator::Hbao, directions), (Estimator::Gtao, directions.div_ceil(2))]
            {
                let taps = taps_for(estimator, samples);
                for place in taps.chunks_exact(samples as usize) {
                    let (used, rest) = place.split_at((slices * steps) as usize);
                    assert!(used.iter().all(|t| (t[0].hypot(t[1]) - 1.0).abs() < 1e-6));
                    assert!(used.iter().flat_map(|t| &t[2..]).all(|far| (0.0..1.0).contains(far)));
                    assert!(rest.iter().all(|t| *t == [0.0; 4]), "{estimator} {samples}");
                    let outwards = |d: &[[f32; 4]]| d.is_sorted_by(|a, b| a[2] < b[2] && a[3] < b[3]);
                    assert!(used.chunks_exact(steps as usize).all(outwards));
                }
            }
            // HBAO directions cover a whole turn. GTAO directions cover half a turn, because each also
            // represents its opposite.
            let turns = |estimator| {
                mean(&taps_for(estimator, samples), |t| t[0])
                    .hypot(mean(&taps_for(estimator, samples), |t| t[1]))
            };
            assert!(turns(Estimator::Hbao) < 1e-3, "{samples}");
        }
        assert!(taps_for(Estimator::Gtao, 12).iter().take(6).all(|t| t[1] >= 0.0));
    }
}
