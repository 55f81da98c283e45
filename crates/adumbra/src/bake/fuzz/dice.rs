//! Random numbers in the forms that scene generation needs.

use std::ops::Range;

use crate::verify::Random;

/// A stream of random choices that is fixed by its seed.
pub(super) struct Dice(Random);

impl Dice {
    /// Streams of the same seed with different numbers are independent.
    pub(super) fn new(seed: u64, stream: u64) -> Self {
        Self(Random::new(seed, stream))
    }

    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    /// Uniform in a range of real numbers.
    pub(super) fn within(&mut self, range: Range<f64>) -> f64 {
        range.start + (range.end - range.start) * self.unit()
    }

    /// Uniform on a logarithmic scale, in a range of positive numbers.
    pub(super) fn scale(&mut self, range: Range<f64>) -> f64 {
        self.within(range.start.ln()..range.end.ln()).exp()
    }

    /// A whole number below `n`.
    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// A whole number in a range.
    pub(super) fn count(&mut self, range: Range<usize>) -> usize {
        range.start + self.below(range.len())
    }

    /// True with this probability.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// One of the choices.
    pub(super) fn pick<T: Clone>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())].clone()
    }

    /// A point in the cube of this half side around `center`.
    pub(super) fn near(&mut self, center: [f64; 3], half: f64) -> [f64; 3] {
        center.map(|c| c + self.within(-half..half))
    }
}
