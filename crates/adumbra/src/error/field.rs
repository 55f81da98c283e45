//! The fields and parameters that have a range.

use std::fmt;

/// A field or parameter that has a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RangeField {
    /// Elevation of the sun.
    SunElevation,
    /// Texels a side of a region.
    RegionTexels,
    /// Texels along a side of a filter.
    FilterWidth,
    /// A term of the look-up bias.
    BiasTerm,
    /// Words of a file that a texture is to hold.
    TextureWords,
    /// Voxels along the longest side of a grid.
    LongestSide,
    /// The largest radius of a penumbra.
    PenumbraRadius,
    /// Number of normals or results of a list of points.
    PointCount,
    /// Angular diameter of the sun's disc.
    SunDegrees,
    /// Where an app has a file's world.
    Placement,
}

/// The name in messages.
impl fmt::Display for RangeField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SunElevation => "the sun's elevation",
            Self::RegionTexels => "the side of a region",
            Self::FilterWidth => "the filter's width",
            Self::BiasTerm => "a term of the bias",
            Self::TextureWords => "the file's size in words",
            Self::LongestSide => "the grid's longest side",
            Self::PenumbraRadius => "the largest radius",
            Self::PointCount => "the number of normals or results",
            Self::SunDegrees => "the sun's angular diameter",
            Self::Placement => "the placement",
        })
    }
}
