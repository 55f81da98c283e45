//! Random choices that depend only on a seed.

use adumbra_scene::random::Random;

/// A source of random choices.
pub(crate) struct Dice {
    random: Random,
}

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self { random: Random::new(seed, 0) }
    }

    /// An index i with 0 <= i < count; `count` must not be 0.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.random.unit() * count as f64) as usize
    }

    pub(crate) fn pick<T: Clone>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())].clone()
    }

    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.random.unit() < probability
    }
}
