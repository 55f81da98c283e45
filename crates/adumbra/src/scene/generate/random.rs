//! Random numbers that are the same everywhere: SplitMix64 (Steele, Lea, Flood, *Fast Splittable Pseudorandom Number
//! Generators*, 2014), and value noise on it.

/// A stream of random numbers.
pub(super) struct Random {
    state: u64,
}

impl Random {
    /// The stream of `seed`; another `stream` is independent of it.
    pub(super) fn new(seed: u64, stream: u64) -> Self {
        Self { state: mix(seed ^ mix(stream)) }
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        mix(self.state)
    }

    /// 0 <= x < 1.
    pub(super) fn unit(&mut self) -> f64 {
        to_unit(self.next())
    }

    /// low <= x < high.
    pub(super) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// 0 <= i < count; `count` is not 0.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// One of `items`.
    pub(super) fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    /// True with this probability.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// An angle in radians.
    pub(super) fn angle(&mut self) -> f64 {
        self.range(0.0, std::f64::consts::TAU)
    }
}

/// Smooth noise from -1 to 1 at unit spacing: random values at whole points, smoothly blended.
pub(super) fn value_noise(seed: u64, x: f64, z: f64) -> f64 {
    let (x0, z0) = (x.floor(), z.floor());
    let (tx, tz) = (ease(x - x0), ease(z - z0));
    let at = |dx: i64, dz: i64| {
        let cell = mix((x0 as i64 + dx) as u64 ^ mix((z0 as i64 + dz) as u64 ^ mix(seed)));
        to_unit(cell) * 2.0 - 1.0
    };
    let near = at(0, 0) * (1.0 - tx) + at(1, 0) * tx;
    let far = at(0, 1) * (1.0 - tx) + at(1, 1) * tx;
    near * (1.0 - tz) + far * tz
}

/// Noise of several octaves, each half as high and twice as fine; about -1 to 1.
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

/// 0 below `low`, 1 above `high`, smooth between.
pub(super) fn smooth_step(low: f64, high: f64, x: f64) -> f64 {
    ease(((x - low) / (high - low)).clamp(0.0, 1.0))
}

fn ease(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

fn to_unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ z >> 31
}
