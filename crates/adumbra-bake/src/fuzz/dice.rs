//! Random numbers in the forms that scene generation needs.

use std::ops::Range;

use adumbra_scene::random::Random;

/// A stream of random choices determined by its seed.
pub(crate) struct Dice(Random);

impl Dice {
    /// Creates a stream. Streams of the same seed with different numbers are independent.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        Self(Random::new(seed, stream))
    }

    /// Returns a number uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    /// Returns a number uniform in a range.
    pub(crate) fn within(&mut self, range: Range<f64>) -> f64 {
        range.start + (range.end - range.start) * self.unit()
    }

    /// Returns a number uniform on a logarithmic scale, in a range of positive numbers.
    pub(crate) fn scale(&mut self, range: Range<f64>) -> f64 {
        self.within(range.start.ln()..range.end.ln()).exp()
    }

    /// Returns an integer from 0 to `n` - 1.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// Returns an integer in a range.
    pub(crate) fn count(&mut self, range: Range<usize>) -> usize {
        range.start + self.below(range.len())
    }

    /// Returns true with this probability.
    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Returns one of the choices.
    pub(crate) fn pick<T: Clone>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())].clone()
    }

    /// Returns a point in the cube of this half side around `center`.
    pub(crate) fn near(&mut self, center: [f64; 3], half: f64) -> [f64; 3] {
        center.map(|c| c + self.within(-half..half))
    }
}
