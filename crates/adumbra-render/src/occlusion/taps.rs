//! The random texture of ambient occlusion: for each place of a 4 × 4 tile its own taps, the same on GPU and CPU.
//!
//! Numbers come from one sequence of points that fill the unit square evenly from any start on: multiples of 1/p and 1/p², p the plastic
//! number (M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018). Place k takes the k-th run of it, so that the
//! taps of a tile, which the filter averages, are as even as those of a texel.

use std::f64::consts::TAU;

use adumbra_shaders::constants::OCCLUSION_MAX_TAPS;
use adumbra_shaders::layout::{Array, OcclusionTaps};

use super::estimator::Estimator;
use super::settings::OcclusionSettings;

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
    for place in taps.chunks_exact_mut(MAX_TAPS) {
        match settings.estimator {
            Estimator::Issao => {
                let mut inside = sequence.by_ref().map(disc_tap).filter(|c| c[0].hypot(c[1]) < 1.0);
                for tap in place.iter_mut().take(samples) {
                    let c = inside.next().unwrap_or_default();
                    *tap = [c[0] as f32, c[1] as f32, 0.0, 0.0];
                }
            }
            _ => {}
        }
    }
    OcclusionTaps { taps: Array(taps) }
}

/// Equation 1 of Qiu et al. 2014 for a radius of 1. The relation of e1 and e2, lost in print, is that of consecutive points of the
/// sequence. What falls outside the disc, which counts nothing, is passed over when the texture is made.
fn disc_tap([e1, e2]: [f64; 2]) -> [f64; 2] {
    [e1 * libm::sin(TAU * e2), e2 * libm::cos(TAU * e1)]
}
