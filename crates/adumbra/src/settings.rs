//! The settings of a bake. They are written into the file and shown by `info`.

use crate::error::{RangeError, RangeField, Result};
use crate::grid::{Bounds, Region};

/// How far a look-up moves its point before it reads the grid. All terms are in texels of the light's plane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bias {
    /// Distance towards the sun, on every surface.
    pub constant_texels: f64,
    /// Distance towards the sun, multiplied by the slope: the tangent of the angle between normal and light,
    /// at most [`MAX_SLOPE`].
    pub slope_texels: f64,
    /// Distance along the normal.
    pub normal_offset_texels: f64,
}

/// The largest slope that the bias uses; steeper slopes are clamped to it. It corresponds to n·l = 0.1.
pub const MAX_SLOPE: f64 = 9.95;

/// The steepest receiver plane that look-ups follow from texel to texel: level ground under a sun 0.5° high.
/// Steeper planes are clamped to this slope. The limit keeps all arithmetic of a look-up within 32 bits, see
/// [`crate::query::FixedReceiver`].
pub const MAX_PLANE_SLOPE: f64 = 120.0;

impl Default for Bias {
    fn default() -> Self {
        Self { constant_texels: 1.0, slope_texels: 0.5, normal_offset_texels: 0.0 }
    }
}

impl Bias {
    /// Checks that every term is from 0 to 16 texels.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::Error::Range) with the first term that is not.
    pub fn check(&self) -> Result<()> {
        for value in [self.constant_texels, self.slope_texels, self.normal_offset_texels] {
            if !(0.0..=16.0).contains(&value) {
                return Err(RangeError::new(RangeField::BiasTerm, value, "from 0 to 16 texels").into());
            }
        }
        Ok(())
    }

    /// Returns the bias along the light at a surface of this slope, in texels, without the normal offset.
    pub fn along_light(&self, slope: f64) -> f64 {
        self.constant_texels + self.slope_texels * slope.min(MAX_SLOPE)
    }
}

/// How the voxels of a file are stored. A reader accepts either, and both hold the same voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Encoding {
    /// As they are in memory, so that a page can be used without decoding it.
    Raw,
    /// Coded: about a third of the bytes.
    #[default]
    Coded,
}

/// The points at which a file must be correct.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Receivers {
    /// All points in space.
    #[default]
    All,
    /// Only points on static surfaces, with a margin for filter and bias.
    Static,
}

/// The settings that determine what a file returns. Nothing here varies between runs of the same bake.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FileSettings {
    /// Number of texels on the longest side of the scene in the light's plane. If a voxel size was given, the
    /// smallest power of two that is at least that number.
    pub resolution: u32,
    /// How far below an open surface its shadow may begin, in world units; 0 = the bias at the surface's
    /// slope.
    pub thickness_world: f64,
    /// Whether the bake assumed that no static surface is behind the last one of a column.
    pub assume_ground: bool,
    /// Whether the insides of closed connected components are free, that is, may be lit or shadowed.
    pub closed_regions: bool,
    /// Whether alpha masks were ignored.
    pub ignore_alpha: bool,
    /// Whether Z points up in the scene's own file. The shadow file is of the world, in which Y does: (x, y,
    /// z) of the scene's file is (x, z, −y) here.
    pub scene_is_z_up: bool,
    /// The points at which the file is correct.
    pub receivers: Receivers,
    /// How far behind its first surface a column may switch from lit to shadowed, in voxels. In a block that
    /// no contour crosses, the distance is measured from the block's deepest first surface. 0 = anywhere that
    /// no look-up from a surface reads.
    pub switch_within_voxels: u32,
    /// For marches to another sun: a ray that is hidden from both keys for this many voxels from its start
    /// counts as blocked. 0 = never.
    pub dark_after_voxels: u32,
    /// The box that fixed the extent of the grid, if one was given.
    pub bounds: Option<Bounds>,
    /// The region that the file covers, if the world was cut into regions. Positions are then relative to the
    /// region's origin.
    pub region: Option<Region>,
    /// The look-up bias that the bake was made for.
    pub bias: Bias,
    /// Number of baked triangles, with those of every instance counted.
    pub triangles: u64,
    /// Number of baked instances.
    pub instances: u64,
}
