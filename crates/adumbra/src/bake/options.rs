//! What a bake can be asked for, with defaults, ranges and presets.

use std::path::PathBuf;

use crate::error::{Error, Result};
use crate::light::Sun;
use crate::scene::Bounds;
use crate::settings::{Bias, Receivers};

/// Smallest resolution, texels on the longest side of the light's plane.
pub const MIN_RESOLUTION: u32 = 8;
/// Largest resolution, likewise.
pub const MAX_RESOLUTION: u32 = 1 << 18;
/// Voxels behind its first surface within which a column switches, where nothing is asked for: a 9 × 9 filter's reach
/// and the steepest of the usual slopes.
pub const DEFAULT_SWITCH_WITHIN: u32 = 8;
/// Most voxels that [`Options::switch_within_voxels`] may be.
pub const MAX_SWITCH_WITHIN: u32 = 65_535;

/// How fine the grid is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// Texels on the longest side of the scene in the light's plane; a power of two.
    Resolution(u64),
    /// Edge of a voxel in world units.
    VoxelSize(f64),
}

/// How the columns are found. Both answer every point that must be answered alike; files differ in voxels that nobody sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Builder {
    /// Block descent: cost follows the silhouettes.
    #[default]
    Fast,
    /// Every texel is drawn: cost follows the area. The judge of the other.
    Plain,
}

/// Options of [`super::bake`].
#[derive(Clone, Debug)]
pub struct Options {
    /// The sun.
    pub sun: Sun,
    /// How fine the grid is.
    pub size: Size,
    /// How far below an open surface a shadow may begin, world units, at least 0; the bias at the slope if that is more.
    pub thickness_world: f64,
    /// No static surface lies behind the last one of a column, so its shadow may begin anywhere there.
    pub assume_ground: bool,
    /// Insides of closed components are free.
    pub closed_regions: bool,
    /// Take masked materials as opaque.
    pub ignore_alpha: bool,
    /// Which points must be answered.
    pub receivers: Receivers,
    /// The space to cover, in place of the scene's own extent; casters outside it but sunward still cast into it.
    pub bounds: Option<Bounds>,
    /// The look-up bias that the bake makes room for.
    pub bias: Bias,
    /// Bytes that the bake may hold; none = no limit. What is built and has no room is kept in temporary files.
    pub max_memory_bytes: Option<u64>,
    /// Folder of those files, which have no names; none = the system's.
    pub spill_folder: Option<PathBuf>,
    /// How far behind its first surface a column may switch to shadow, voxels, at most [`MAX_SWITCH_WITHIN`]; 0: anywhere
    /// inside the solid. In a block that no contour crosses the deepest first surface counts for all its columns. Less: bigger files, and filters that find shadow close to a wall's foot.
    pub switch_within_voxels: u32,
    /// How the columns are found.
    pub builder: Builder,
}

impl Options {
    /// Defaults for a sun and a size: ground assumed, closed regions used, every point answered.
    pub fn new(sun: Sun, size: Size) -> Self {
        Self {
            sun,
            size,
            thickness_world: 0.0,
            assume_ground: true,
            closed_regions: true,
            ignore_alpha: false,
            receivers: Receivers::All,
            bounds: None,
            bias: Bias::default(),
            max_memory_bytes: None,
            spill_folder: None,
            switch_within_voxels: DEFAULT_SWITCH_WITHIN,
            builder: Builder::Fast,
        }
    }

    pub(super) fn check(&self) -> Result<()> {
        if !self.thickness_world.is_finite() || self.thickness_world < 0.0 {
            let (value, range) = (self.thickness_world.to_string(), "a finite number of metres, 0 or more");
            return Err(Error::OptionRange { option: "--thickness", value, range });
        }
        if self.switch_within_voxels > MAX_SWITCH_WITHIN {
            let (value, range) = (self.switch_within_voxels.to_string(), "a number of voxels up to 65535");
            return Err(Error::OptionRange { option: "--switch-within", value, range });
        }
        self.bias.check()?;
        self.bounds.as_ref().map_or(Ok(()), check_bounds)
    }
}

/// Whether a box given as `--bounds` is one.
pub(crate) fn check_bounds(b: &Bounds) -> Result<()> {
    for a in 0..3 {
        if !(b.min[a].is_finite() && b.max[a].is_finite() && b.min[a] < b.max[a]) {
            let value = format!("{:?} to {:?}", b.min, b.max);
            let range = "six finite numbers, each minimum below its maximum";
            return Err(Error::OptionRange { option: "--bounds", value, range });
        }
    }
    Ok(())
}

impl Size {
    /// Resolution and voxel size for a space of this longest side.
    pub(crate) fn resolve(self, longest_side: f64) -> Result<(u32, f64)> {
        match self {
            Self::Resolution(resolution) => {
                let nearest =
                    resolution.clamp(MIN_RESOLUTION.into(), MAX_RESOLUTION.into()).next_power_of_two();
                if nearest != resolution {
                    return Err(Error::Resolution {
                        resolution,
                        min: MIN_RESOLUTION,
                        max: MAX_RESOLUTION,
                        suggestion: nearest as u32,
                    });
                }
                Ok((nearest as u32, longest_side / nearest as f64))
            }
            Self::VoxelSize(size) => {
                let refuse = |value, range| Err(Error::OptionRange { option: "--voxel-size", value, range });
                if !(size.is_finite() && size > 0.0) {
                    return refuse(size.to_string(), "a finite number of metres above 0");
                }
                let texels = (longest_side / size).ceil();
                if texels > f64::from(MAX_RESOLUTION) {
                    let value = format!("{size} ({texels} texels across)");
                    return refuse(value, "coarse enough for at most 262144 texels across the scene");
                }
                Ok(((texels as u32).next_power_of_two().max(MIN_RESOLUTION), size))
            }
        }
    }
}

/// Ready-made sizes; an explicit resolution or voxel size wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// 2048: a look at the result within seconds.
    Draft,
    /// 4096.
    Low,
    /// 8192.
    Medium,
    /// 16384.
    High,
    /// 32768.
    Ultra,
}

impl Preset {
    /// Texels on the longest side.
    pub fn resolution(self) -> u32 {
        match self {
            Self::Draft => 2048,
            Self::Low => 4096,
            Self::Medium => 8192,
            Self::High => 16384,
            Self::Ultra => 32768,
        }
    }
}
