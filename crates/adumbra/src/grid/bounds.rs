//! Axis-aligned boxes in world space.

/// An axis-aligned box in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bounds {
    /// Corner with the smallest coordinates, world units.
    pub min: [f64; 3],
    /// Corner with the largest coordinates, world units.
    pub max: [f64; 3],
}

impl Bounds {
    /// Returns the length of the diagonal, in world units.
    pub fn diagonal(&self) -> f64 {
        (0..3).map(|a| (self.max[a] - self.min[a]).powi(2)).sum::<f64>().sqrt()
    }
}
