//! The settings of a tree, as written into its file and shown by `info`.

use crate::tree::error::{OptionError, TreeOption};
use serde::{Deserialize, Serialize};

use crate::tree::error::Result;
use adumbra::Bias;
use adumbra::grid::Bounds;

/// The settings that determine the answers of a tree. Nothing here varies between runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeSettings {
    /// Whether the insides of closed components are free.
    pub closed_regions: bool,
    /// Whether alpha masks were ignored.
    pub ignore_alpha: bool,
    /// The box that determined the cube, if one was given.
    pub bounds: Option<Bounds>,
    /// The distance that depths were moved away from the light (4-1), in texels of the light's depth image.
    pub capture_bias: CaptureBias,
    /// The look-up bias, in voxels of the depth at the point.
    pub bias: Bias,
    /// The change made by a lossy merge, if there was one.
    pub lossy: Option<LossyChange>,
    /// Number of triangles baked, counted once per instance.
    pub triangles: u64,
    /// Number of instances baked.
    pub instances: u64,
}

/// bias = slope factor · slope + constant (4-1), in texels of the light's depth image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaptureBias {
    /// The constant term.
    pub constant_texels: f64,
    /// Factor of the slope, which is the tangent of the angle between normal and light.
    pub slope_texels: f64,
}

/// The change allowed and made by a lossy merge: at most `max_share` times `leaf_voxels` voxels changed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LossyChange {
    /// Maximum share of the leaf voxels that was allowed to change.
    pub max_share: f64,
    /// Number of leaf voxels of the tree before the merge: the cells of the leaves of eight in the expanded
    /// tree, each counted once regardless of its size.
    pub leaf_voxels: u64,
    /// Number of voxels of the finest level that changed; a larger cell counts as all the voxels in it.
    pub changed_voxels: u64,
}

impl Default for CaptureBias {
    /// Half a texel's diagonal along the slope: a depth on the same plane is at most this far from the centre
    /// of its texel.
    fn default() -> Self {
        Self { constant_texels: 0.0, slope_texels: 0.75 }
    }
}

impl CaptureBias {
    /// Checks that both terms are from 0 to 16 texels.
    ///
    /// # Errors
    /// Returns [`Error::Option`](crate::tree::Error::Option) for the first term that is not.
    pub fn check(&self) -> Result<()> {
        for value in [self.constant_texels, self.slope_texels] {
            if !(0.0..=16.0).contains(&value) {
                return Err(
                    OptionError::new(TreeOption::CaptureBiasTerm, value, "from 0 to 16 texels").into()
                );
            }
        }
        Ok(())
    }
}
