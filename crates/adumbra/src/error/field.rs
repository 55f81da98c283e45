//! The fields and parameters that have a range.

use std::fmt;

/// A field or parameter that has a range. The list is complete, so that a program that tells its users which
/// option sets a field does not compile until a new one has its option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangeField {
    /// Elevation of the sun.
    SunElevation,
    /// Thickness of open surfaces.
    Thickness,
    /// How far behind a surface a column may switch.
    SwitchLimit,
    /// Number of levels of detail.
    Levels,
    /// The bounds of a bake.
    Bounds,
    /// Texels, or voxels, along the longest side.
    Resolution,
    /// Edge of a voxel.
    VoxelSize,
    /// Texels a side of a region.
    RegionTexels,
    /// Texels along a side of a filter.
    FilterWidth,
    /// A term of the look-up bias.
    BiasTerm,
    /// Turn of the grid about the sun's direction.
    Yaw,
    /// Words of a file that a texture is to hold.
    TextureWords,
    /// Voxels along the longest side of a grid.
    LongestSide,
    /// The largest radius of a penumbra.
    PenumbraRadius,
    /// Number of normals or results of a list of points.
    PointCount,
    /// Size of the ground that is added to a scene.
    GroundSize,
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
            Self::Thickness => "the thickness",
            Self::SwitchLimit => "the switch limit",
            Self::Levels => "the number of levels",
            Self::Bounds => "the bounds",
            Self::Resolution => "the resolution",
            Self::VoxelSize => "the voxel size",
            Self::RegionTexels => "the side of a region",
            Self::FilterWidth => "the filter's width",
            Self::BiasTerm => "a term of the bias",
            Self::Yaw => "the yaw",
            Self::TextureWords => "the file's size in words",
            Self::LongestSide => "the grid's longest side",
            Self::PenumbraRadius => "the largest radius",
            Self::PointCount => "the number of normals or results",
            Self::GroundSize => "the size of the ground",
            Self::SunDegrees => "the sun's angular diameter",
            Self::Placement => "the placement",
        })
    }
}
