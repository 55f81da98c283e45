//! Limits of conversions between layouts: a file of a few bytes may stand for a grid whose other form no memory holds.

use super::Dag;

/// Most root cubes of a graph that is made by a conversion. Bakes have some thousands.
pub const MAX_CONVERTED_ROOTS: u64 = 1 << 24;
/// Most voxels along the light of what is converted.
pub(crate) const MAX_CONVERTED_DEPTH: u64 = 1 << 31;

/// A file is not converted to another layout, because the result could be too large. Look-ups in the file as it is need no conversion.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "its conversion would make {count} {what}, but at most {limit} are made; look up in the file as it is, or bake it at a lower resolution"
)]
pub struct TooLarge {
    /// What is counted.
    pub what: &'static str,
    /// How many there would be, at least.
    pub count: u128,
    /// How many there may be.
    pub limit: u64,
}

impl TooLarge {
    /// That there are no more of something than `limit`.
    pub(crate) fn check(what: &'static str, count: u128, limit: u64) -> Result<(), Self> {
        if count > u128::from(limit) { Err(Self { what, count, limit }) } else { Ok(()) }
    }

    /// That a grid of this size has a top grid of plain roots that can be made.
    pub(crate) fn check_roots(size: [u32; 3], root_level: u32) -> Result<(), Self> {
        Self::check("voxels along the light", size[2].into(), MAX_CONVERTED_DEPTH)?;
        let roots = Dag::top_dims_covering(size, root_level).iter().map(|&n| u128::from(n)).product();
        Self::check("root cubes", roots, MAX_CONVERTED_ROOTS)
    }

    /// For a graph that has more words than its pointers can name.
    pub(crate) fn words() -> Self {
        let limit = 1 << 31;
        Self { what: "words of nodes", count: limit + 1, limit: limit as u64 }
    }
}
