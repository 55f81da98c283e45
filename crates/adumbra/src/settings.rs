//! What a bake was asked for: written into the file, and shown by `info`.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::scene::Bounds;

/// How far a look-up moves its point towards the light before it reads the grid. All in texels of the light's plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// Along the light, everywhere.
    pub constant_texels: f64,
    /// Along the light, times the slope: the tangent of the angle between normal and light, at most [`MAX_SLOPE`].
    pub slope_texels: f64,
    /// Along the normal.
    pub normal_offset_texels: f64,
}

/// The bias counts steeper slopes as this one: n·l = 0.1.
pub const MAX_SLOPE: f64 = 9.95;

/// Steepest plane of a receiver that look-ups follow from texel to texel: level ground under a sun 0.5° high. Steeper surfaces
/// are taken to rise by this much. It keeps all of a look-up within 32 bits, see [`crate::query::FixedReceiver`].
pub const MAX_PLANE_SLOPE: f64 = 120.0;

impl Default for Bias {
    fn default() -> Self {
        Self { constant_texels: 1.0, slope_texels: 0.5, normal_offset_texels: 0.0 }
    }
}

impl Bias {
    /// Whether every term is from 0 to 16 texels.
    ///
    /// # Errors
    /// [`Error::OptionRange`] with the first that is not.
    pub fn check(&self) -> Result<()> {
        for value in [self.constant_texels, self.slope_texels, self.normal_offset_texels] {
            if !(0.0..=16.0).contains(&value) {
                let (value, range) = (value.to_string(), "from 0 to 16 texels");
                return Err(Error::OptionRange { option: "bias", value, range });
            }
        }
        Ok(())
    }

    /// Bias along the light at a surface of this slope, in texels; the normal offset is not in it.
    pub fn along_light(&self, slope: f64) -> f64 {
        self.constant_texels + self.slope_texels * slope.min(MAX_SLOPE)
    }
}

/// Which points the file must answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Receivers {
    /// Every point in space.
    #[default]
    All,
    /// Only points on static surfaces, with a margin for filter and bias.
    Static,
}

/// The settings that decide what the file answers. Nothing here varies between runs of the same bake.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Texels on the longest side of the scene in the light's plane; with a voxel size, the power of two that holds them.
    pub resolution: u32,
    /// How far below an open surface a shadow may begin, world units; 0 = the bias at its slope.
    pub thickness_world: f64,
    /// No static surface lies behind the last one of a column.
    pub assume_ground: bool,
    /// Insides of closed components are free.
    pub closed_regions: bool,
    /// Alpha masks were ignored.
    pub ignore_alpha: bool,
    /// Which points are answered.
    pub receivers: Receivers,
    /// How far behind its first surface, or the deepest of a block that no contour crosses, a column may switch, voxels; 0 = anywhere inside
    /// the solid.
    pub switch_within_voxels: u32,
    /// The box that fixed the space, if one was given.
    pub bounds: Option<Bounds>,
    /// The look-up bias that the bake was made for.
    pub bias: Bias,
    /// Triangles baked, instances counted.
    pub triangles: u64,
    /// Instances baked.
    pub instances: u64,
}
