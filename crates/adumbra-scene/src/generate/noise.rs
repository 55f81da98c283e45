//! Value noise based on the random numbers of [`crate::random`].

use crate::random::{finalize, to_unit};

/// Smooth noise from -1 to 1 with unit spacing: random values at integer points, smoothly interpolated.
pub(super) fn value_noise(seed: u64, x: f64, z: f64) -> f64 {
    let (x0, z0) = (x.floor(), z.floor());
    let (tx, tz) = (ease(x - x0), ease(z - z0));
    let at = |dx: i64, dz: i64| {
        let cell = finalize((x0 as i64 + dx) as u64 ^ finalize((z0 as i64 + dz) as u64 ^ finalize(seed)));
        to_unit(cell) * 2.0 - 1.0
    };
    let near = at(0, 0) * (1.0 - tx) + at(1, 0) * tx;
    let far = at(0, 1) * (1.0 - tx) + at(1, 1) * tx;
    near * (1.0 - tz) + far * tz
}

/// Noise of several octaves, each with half the amplitude and about twice the frequency of the one before;
/// about -1 to 1.
pub(super) fn fractal_noise(seed: u64, x: f64, z: f64, octaves: u64) -> f64 {
    let (mut sum, mut height, mut frequency, mut total) = (0.0, 1.0, 1.0, 0.0);
    for octave in 0..octaves {
        sum += height * value_noise(seed.wrapping_add(octave), x * frequency, z * frequency);
        total += height;
        height *= 0.5;
        frequency *= 2.03;
    }
    sum / total
}

/// 0 below `low`, 1 above `high`, smooth in between.
pub(super) fn smooth_step(low: f64, high: f64, x: f64) -> f64 {
    ease(((x - low) / (high - low)).clamp(0.0, 1.0))
}

fn ease(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}
