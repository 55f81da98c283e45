//! Reproducible random numbers: SplitMix64 (Steele, Lea, Flood, *Fast Splittable Pseudorandom Number
//! Generators*, 2014).

/// A stream of random numbers.
pub struct Random {
    state: u64,
}

impl Random {
    /// Creates the generator for `seed`; different values of `stream` give independent sequences.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self { state: finalize(seed ^ finalize(stream)) }
    }

    /// Creates the generator for one batch of samples; batches can be drawn on many threads.
    pub fn for_batch(seed: u64, batch: u64) -> Self {
        let mut random = Self { state: seed ^ batch.wrapping_mul(0xd134_2543_de82_ef95) };
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        let bits = mix(self.state);
        self.state = self.state.wrapping_add(STEP);
        bits
    }

    /// A number x with 0 <= x < 1.
    pub fn unit(&mut self) -> f64 {
        to_unit(self.next())
    }

    /// A number x with low <= x < high.
    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// An index i with 0 <= i < count; `count` must not be 0.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// A random element of `items`.
    pub(crate) fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    /// True with this probability.
    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// An angle from 0 to 2π, radians.
    pub(crate) fn angle(&mut self) -> f64 {
        self.range(0.0, std::f64::consts::TAU)
    }
}

/// Maps 64 random bits to x with 0 <= x < 1.
pub(crate) fn to_unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// The increment of the state.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// A 64-bit hash: the random number that follows the state `v`.
pub fn mix(v: u64) -> u64 {
    finalize(v.wrapping_add(STEP))
}

/// The finalizer of SplitMix64: Stafford's thirteenth variant of MurmurHash3's.
pub(crate) fn finalize(z: u64) -> u64 {
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
