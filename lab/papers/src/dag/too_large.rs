//! Limits of conversions between layouts. A file of a few bytes may represent a grid that does not fit into
//! any memory in another layout.

use crate::dag::roots::top_dims;

/// Largest number of root cubes of a graph that a conversion makes. Bakes have some thousands.
pub const MAX_CONVERTED_ROOTS: u64 = 1 << 24;
/// Largest number of voxels along the light of a grid that is converted.
pub const MAX_CONVERTED_DEPTH: u64 = 1 << 31;

/// The conversion of a file to another layout was refused, because the result could be too large. Look-ups in
/// the file do not need the conversion.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "its conversion would produce {count} {what}, but at most {limit} are allowed; look up in the file as it is, or bake it at a lower resolution"
)]
pub struct TooLarge {
    /// The name of the counted items, in the plural.
    pub what: &'static str,
    /// A lower bound of the count in the result.
    pub count: u128,
    /// The largest allowed count.
    pub limit: u64,
}

impl TooLarge {
    /// Checks that `count` is at most `limit`.
    ///
    /// # Errors
    /// Returns [`TooLarge`] if it is larger.
    pub fn check(what: &'static str, count: u128, limit: u64) -> Result<(), Self> {
        if count > u128::from(limit) { Err(Self { what, count, limit }) } else { Ok(()) }
    }

    /// Checks that the plain top grid of a grid of `size` voxels can be made.
    ///
    /// # Errors
    /// Returns [`TooLarge`] if it has more than [`MAX_CONVERTED_ROOTS`] roots, or more than
    /// [`MAX_CONVERTED_DEPTH`] voxels along the light.
    pub fn check_roots(size: [u32; 3], root_level: u32) -> Result<(), Self> {
        Self::check("voxels along the light", size[2].into(), MAX_CONVERTED_DEPTH)?;
        let roots = top_dims(size, root_level).iter().map(|&n| u128::from(n)).product();
        Self::check("root cubes", roots, MAX_CONVERTED_ROOTS)
    }

    /// Returns the error for a graph with more words than its pointers can address.
    pub fn words() -> Self {
        let limit = 1 << 31;
        Self { what: "words of nodes", count: limit + 1, limit: limit as u64 }
    }
}
