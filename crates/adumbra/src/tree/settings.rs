//! What a tree was asked for: written into its file, and shown by `info`.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::scene::Bounds;
use crate::settings::Bias;

/// The settings that decide what a tree answers. Nothing here varies between runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeSettings {
    /// Insides of closed components are free.
    pub closed_regions: bool,
    /// Alpha masks were ignored.
    pub ignore_alpha: bool,
    /// The box that fixed the space, if one was given.
    pub bounds: Option<Bounds>,
    /// How far the light's depths were moved away from the light (4-1), texels of the light's depth image.
    pub capture_bias: CaptureBias,
    /// The look-up bias, in voxels of the depth at the point.
    pub bias: Bias,
    /// What a lossy merge changed, if there was one.
    pub lossy: Option<LossyChange>,
    /// Triangles baked, instances counted.
    pub triangles: u64,
    /// Instances baked.
    pub instances: u64,
}

/// bias = slope factor · slope + constant (4-1), in texels of the light's depth image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaptureBias {
    /// Everywhere.
    pub constant_texels: f64,
    /// Times the slope: the tangent of the angle between normal and light.
    pub slope_texels: f64,
}

/// What a lossy merge was allowed and did: at most `max_share` times `leaf_voxels` voxels changed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LossyChange {
    /// Largest share of the leaf voxels that might change.
    pub max_share: f64,
    /// Leaf voxels of the tree before: cells of leaves of eight, at all the places where they stand, each counted once
    /// whatever its size.
    pub leaf_voxels: u64,
    /// Voxels of the finest level that changed: a bigger cell counts as all those in it.
    pub changed_voxels: u64,
}

impl Default for CaptureBias {
    /// Half a texel's diagonal along the slope: the farthest that a depth of the same plane lies from its texel's centre.
    fn default() -> Self {
        Self { constant_texels: 0.0, slope_texels: 0.75 }
    }
}

impl CaptureBias {
    /// Whether both terms are from 0 to 16 texels.
    ///
    /// # Errors
    /// [`Error::OptionRange`] with the first that is not.
    pub fn check(&self) -> Result<()> {
        for value in [self.constant_texels, self.slope_texels] {
            if !(0.0..=16.0).contains(&value) {
                let (value, range) = (value.to_string(), "from 0 to 16 texels");
                return Err(Error::OptionRange { option: "--capture-bias", value, range });
            }
        }
        Ok(())
    }
}
