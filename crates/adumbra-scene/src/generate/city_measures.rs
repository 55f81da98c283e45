//! Dimensions shared by the city, its buildings and its streets, in metres.

/// Half the side of a block including its pavement.
pub(crate) const BLOCK_HALF: f64 = 31.0;
/// Height of the pavement.
pub(crate) const PAVEMENT: f64 = 0.15;
