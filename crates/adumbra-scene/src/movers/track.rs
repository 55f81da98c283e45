//! Keys of one property over time, and the values between them (Khronos, *glTF 2.0 Specification*, 2021,
//! appendix C).

/// How values between keys are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Interpolation {
    /// The value of the previous key.
    Step,
    /// Linear interpolation; spherical for rotations.
    Linear,
    /// A cubic Hermite spline; each key has an incoming tangent, a value and an outgoing tangent.
    Cubic,
}

/// An animated property of `N` numbers; four numbers are a rotation. Before the first key it has the first
/// key's value, and after the last key the last one's.
#[derive(Clone, Debug)]
pub(crate) struct Track<const N: usize> {
    /// Times of the keys, seconds, finite and not decreasing.
    times: Vec<f32>,
    /// One per key; three per key for cubic splines.
    values: Vec<[f32; N]>,
    interpolation: Interpolation,
}

impl<const N: usize> Track<N> {
    /// Returns `None` unless there is at least one key, times are finite and do not decrease, and there are
    /// as many finite values as the interpolation needs.
    pub(crate) fn new(times: Vec<f32>, values: Vec<[f32; N]>, interpolation: Interpolation) -> Option<Self> {
        let each = if interpolation == Interpolation::Cubic { 3 } else { 1 };
        let sound = !times.is_empty()
            && values.len() == each * times.len()
            && times.iter().all(|t| t.is_finite())
            && times.is_sorted()
            && values.iter().flatten().all(|v| v.is_finite());
        sound.then_some(Self { times, values, interpolation })
    }

    /// Time of the last key, seconds.
    pub(crate) fn end_seconds(&self) -> f64 {
        self.times.last().map_or(0.0, |&t| t.into())
    }

    /// The times of the keys, and a third, a half and two thirds of the way from each key to the next, in
    /// seconds.
    pub(crate) fn moments(&self) -> impl Iterator<Item = f64> {
        let times = || self.times.iter().map(|&t| f64::from(t));
        let between = times().zip(times().skip(1)).flat_map(|(from, to)| {
            let third = (to - from) / 3.0;
            [from + third, f64::midpoint(from, to), to - third]
        });
        times().chain(between)
    }

    /// The value at a time. Cost: a binary search.
    pub(crate) fn at(&self, seconds: f64) -> [f64; N] {
        let after = self.times.partition_point(|&t| f64::from(t) <= seconds);
        if after == 0 {
            return self.key(0, 1);
        }
        let before = after - 1;
        if after == self.times.len() || self.interpolation == Interpolation::Step {
            return self.key(before, 1);
        }
        let (from, to) = (f64::from(self.times[before]), f64::from(self.times[after]));
        let (span, t) = (to - from, (seconds - from) / (to - from));
        let (a, b) = (self.key(before, 1), self.key(after, 1));
        if self.interpolation == Interpolation::Linear {
            return if N == 4 {
                along_arc(a, b, t)
            } else {
                std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
            };
        }
        let (leaving, arriving) = (self.key(before, 2), self.key(after, 0));
        let (t2, t3) = (t * t, t * t * t);
        std::array::from_fn(|i| {
            (2.0 * t3 - 3.0 * t2 + 1.0) * a[i]
                + span * (t3 - 2.0 * t2 + t) * leaving[i]
                + (3.0 * t2 - 2.0 * t3) * b[i]
                + span * (t3 - t2) * arriving[i]
        })
    }

    /// Value (`part` 1), incoming tangent (0) or outgoing tangent (2) of a key. Tracks without tangents
    /// return the value for every `part`.
    fn key(&self, index: usize, part: usize) -> [f64; N] {
        let at = if self.interpolation == Interpolation::Cubic { 3 * index + part } else { index };
        self.values[at].map(f64::from)
    }
}

/// Spherical interpolation between two rotations along the shorter arc. The result need not be normalised.
fn along_arc<const N: usize>(a: [f64; N], b: [f64; N], t: f64) -> [f64; N] {
    let dot: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    let angle = libm::acos((dot * sign).min(1.0));
    let sine = libm::sin(angle);
    // For nearly equal rotations, linear interpolation is accurate.
    let (wa, wb) = if sine < 1e-6 {
        (1.0 - t, t)
    } else {
        (libm::sin((1.0 - t) * angle) / sine, libm::sin(t * angle) / sine)
    };
    std::array::from_fn(|i| wa * a[i] + sign * wb * b[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_holds_and_linear_interpolates() {
        let track = |kind| Track::new(vec![1.0, 3.0], vec![[0.0], [4.0]], kind).unwrap();
        let (step, line) = (track(Interpolation::Step), track(Interpolation::Linear));
        assert_eq!([0.0, 1.0, 2.9, 3.0, 9.0].map(|t| step.at(t)[0]), [0.0, 0.0, 0.0, 4.0, 4.0]);
        assert_eq!([0.0, 1.0, 1.5, 2.0, 9.0].map(|t| line.at(t)[0]), [0.0, 0.0, 1.0, 2.0, 4.0]);
        assert_eq!(line.end_seconds(), 3.0);
    }

    #[test]
    fn spline_matches_values_and_tangents_at_its_keys() {
        let values = vec![[0.0], [1.0], [2.0], [-1.0], [5.0], [0.0]];
        let track = Track::new(vec![0.0, 2.0], values, Interpolation::Cubic).unwrap();
        let slope = |t: f64| (track.at(t + 1e-6)[0] - track.at(t - 1e-6)[0]) / 2e-6;
        assert_eq!((track.at(0.0)[0], track.at(2.0)[0]), (1.0, 5.0));
        assert!((slope(1e-5) - 2.0).abs() < 1e-3 && (slope(2.0 - 1e-5) + 1.0).abs() < 1e-3);
    }

    #[test]
    fn rotations_take_the_shorter_arc() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // The same quarter turn about y, once with the quaternion negated.
        for sign in [1.0, -1.0] {
            let end = [0.0, sign * half, 0.0, sign * half];
            let track =
                Track::new(vec![0.0, 1.0], vec![[0.0, 0.0, 0.0, 1.0], end], Interpolation::Linear).unwrap();
            let eighth = std::f64::consts::FRAC_PI_8;
            let [_, y, _, w] = track.at(0.5);
            assert!((y - eighth.sin()).abs() < 1e-7 && (w - eighth.cos()).abs() < 1e-7, "{sign}: {y} {w}");
        }
    }

    #[test]
    fn rejects_invalid_keys() {
        let make = |times: &[f32], values: &[f32], kind| {
            Track::new(times.to_vec(), values.iter().map(|&v| [v]).collect(), kind).is_some()
        };
        assert!(make(&[0.0, 0.0, 1.0], &[1.0, 2.0, 3.0], Interpolation::Linear));
        assert!(!make(&[], &[], Interpolation::Linear));
        assert!(!make(&[1.0, 0.0], &[1.0, 2.0], Interpolation::Step));
        assert!(!make(&[0.0, f32::NAN], &[1.0, 2.0], Interpolation::Linear));
        assert!(!make(&[0.0], &[f32::INFINITY], Interpolation::Linear));
        assert!(!make(&[0.0, 1.0], &[1.0, 2.0], Interpolation::Cubic));
    }
}
