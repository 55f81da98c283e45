//! The texture of the forest's cards: a twig with leaves on a clear background.

use crate::random::Random;
use crate::{Pixels, Texture, Wrap};

/// Side of the image, texels.
const SIDE: u32 = 256;
/// Pairs of leaves along the twig.
const PAIRS: u32 = 8;
/// Half the width of the twig, as a share of the image's side.
const TWIG_HALF: f64 = 0.008;

/// A leaf: its foot and its direction in the image, whose side is 1, with y upwards.
struct Leaf {
    foot: [f64; 2],
    /// Of length 1.
    direction: [f64; 2],
    length: f64,
    /// Brightness of its green.
    shade: f64,
}

/// Returns a twig that grows from the middle of the lower edge to the upper.
pub(super) fn leaf_spray(seed: u64) -> Texture {
    let mut random = Random::new(seed, 59);
    let mut leaves = Vec::new();
    for pair in 0..PAIRS {
        for side in [-1.0, 1.0] {
            let up = (f64::from(pair) + random.range(0.2, 0.8)) / f64::from(PAIRS);
            let angle = random.range(0.6, 1.1);
            leaves.push(Leaf {
                foot: [0.5, 0.02 + 0.8 * up],
                direction: [side * libm::sin(angle), libm::cos(angle)],
                length: (0.5 - 0.22 * up) * random.range(0.8, 1.0),
                shade: random.range(0.7, 1.1),
            });
        }
    }
    let top = Leaf { foot: [0.5, 0.76], direction: [0.0, 1.0], length: 0.23, shade: 1.0 };
    leaves.push(top);
    let mut bytes = Vec::with_capacity((SIDE * SIDE * 4) as usize);
    for row in 0..SIDE {
        for column in 0..SIDE {
            let at =
                [(f64::from(column) + 0.5) / f64::from(SIDE), 1.0 - (f64::from(row) + 0.5) / f64::from(SIDE)];
            bytes.extend(texel(&leaves, at));
        }
    }
    Texture {
        name: "leaves".into(),
        width: SIDE,
        height: SIDE,
        pixels: Pixels::Rgba(bytes),
        wrap: [Wrap::Clamp; 2],
        nearest: false,
    }
}

/// Returns a texel's red, green, blue and alpha. Edges are one texel wide.
fn texel(leaves: &[Leaf], at: [f64; 2]) -> [u8; 4] {
    let twig = if at[1] < 0.8 { TWIG_HALF - (at[0] - 0.5).abs() } else { f64::NEG_INFINITY };
    let mut inside = twig;
    let mut color = [0x6B, 0x50, 0x3A].map(f64::from);
    for leaf in leaves {
        let depth = leaf.depth_at(at);
        if depth > inside {
            inside = depth;
            color = [0x5C, 0x8A, 0x3C].map(|c| f64::from(c) * leaf.shade);
        }
    }
    let alpha = (inside * f64::from(SIDE) + 0.5).clamp(0.0, 1.0);
    let byte = |value: f64| (value + 0.5) as u8;
    let [red, green, blue] = color.map(byte);
    [red, green, blue, byte(alpha * 255.0)]
}

impl Leaf {
    /// Returns how far inside the leaf a point is, negative outside. A leaf is a third as wide as long.
    fn depth_at(&self, at: [f64; 2]) -> f64 {
        let from_foot = [at[0] - self.foot[0], at[1] - self.foot[1]];
        let [x, y] = self.direction;
        let along = (from_foot[0] * x + from_foot[1] * y) / self.length;
        let across = (from_foot[1] * x - from_foot[0] * y).abs();
        if (0.0..=1.0).contains(&along) {
            self.length * along * (1.0 - along) * (2.0 / 3.0) - across
        } else {
            f64::NEG_INFINITY
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_cover_between_a_quarter_and_three_fifths_of_the_image() {
        for seed in 0..4 {
            let Pixels::Rgba(bytes) = leaf_spray(seed).pixels else { panic!("colours") };
            assert_eq!(bytes.len(), (SIDE * SIDE * 4) as usize);
            let opaque = bytes.chunks_exact(4).filter(|texel| texel[3] >= 128).count();
            let share = opaque as f64 / f64::from(SIDE * SIDE);
            assert!((0.25..0.6).contains(&share), "{share}");
        }
    }
}
