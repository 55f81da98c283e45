//! The options of a bake, with defaults and ranges.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use adumbra::file::{LEVEL_STEP, MAX_LEVELS};
use adumbra::{Bias, Bounds, Encoding, RangeError, Receivers, Region, Sun};
use adumbra_files::target_folder;

use crate::error::{BakeField, Error, Result};

/// The resolution of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// Texels on the longest side of the scene as the sun sees it: a power of two from
    /// [`Size::MIN_RESOLUTION`] to [`Size::MAX_RESOLUTION`]. Voxels have the same size in either frame.
    Resolution(u64),
    /// Edge length of a voxel in world units, in either frame.
    VoxelSize(f64),
}

/// How the grid lies in the world, see [`adumbra::Frame`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FrameChoice {
    /// Perpendicular to the light.
    Light,
    /// Upright, aligned with most of the scene's horizontal edges.
    Oblique,
    /// Upright, with the grid's x axis at this angle from the world's +X towards +Z, in radians. Bakes of
    /// parts of a world share their voxels only if they share the angle.
    ObliqueAt(f64),
    /// Light, if the sun is below 5°. Otherwise the frame in which the file is smaller in a forecast from a
    /// few blocks; oblique if the forecast finds no difference.
    #[default]
    Auto,
}

/// Elevation of the sun in degrees below which [`FrameChoice::Auto`] does not consider the oblique frame: a
/// shadow would be more than eleven times as long as its caster is high, and the grid would be as long.
pub(crate) const LOWEST_OBLIQUE_DEGREES: f64 = 5.0;

/// Whether shadows below the last surface of a column are left out, because they would fall on nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AssumeGround {
    /// Left out if the scene has a ground of its own: a floor that fills its outline and catches its shadows.
    #[default]
    Auto,
    /// Left out.
    Yes,
    /// Kept: for a ground that only the app draws, and for what moves below bridges with nothing under them.
    No,
}

impl From<bool> for AssumeGround {
    fn from(assume: bool) -> Self {
        if assume { Self::Yes } else { Self::No }
    }
}

/// The method that finds the columns. Both give the same answer at every point that must be answered. Their
/// files differ in voxels that cannot be seen.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColumnBuilder {
    /// Block descent: cost grows with the silhouettes.
    #[default]
    Fast,
    /// Every texel is drawn: cost grows with the area. The reference for [`ColumnBuilder::Fast`].
    Plain,
}

/// The options of a bake. [`BakeOptions::new`] creates default ones, and [`BakeOptions::with`] changes them.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BakeOptions {
    /// The sun.
    pub sun: Sun,
    /// How the grid lies in the world.
    pub frame: FrameChoice,
    /// The resolution of the grid.
    pub size: Size,
    /// How far below an open surface a shadow may begin, in world units along the light, at least 0. The bias
    /// at the surface's slope applies instead if it is larger.
    pub thickness_world: f64,
    /// Whether to assume that nothing is below the last surface of a column, so that its shadow may begin
    /// anywhere there.
    pub assume_ground: AssumeGround,
    /// Whether voxels inside closed components may be either lit or shadowed.
    pub closed_regions: bool,
    /// Whether to treat masked materials as opaque.
    pub ignore_alpha: bool,
    /// Which points must be answered.
    pub receivers: Receivers,
    /// The region to cover instead of the scene's own extent. Casters outside it on the sunward side still
    /// cast into it.
    pub bounds: Option<Bounds>,
    /// The look-up bias that the bake allows for.
    pub bias: Bias,
    /// Largest number of bytes that the bake may hold; `None` = no limit. What does not fit is kept in
    /// temporary files.
    pub max_memory_bytes: Option<u64>,
    /// Folder for the temporary files, which have no names; `None` = the system's folder.
    pub spill_folder: Option<PathBuf>,
    /// How far behind its first surface a column may switch to shadow, in voxels, at most
    /// [`BakeOptions::MAX_SWITCH_WITHIN`]; 0 = anywhere that neither receivers nor the filters around them
    /// read. In a block that no contour crosses, the distance counts from the block's deepest first surface
    /// for all of its columns. A limit makes files larger. It serves filters around points that are not part
    /// of the scene, such as movers beside a wall.
    pub switch_within_voxels: u32,
    /// Number of levels of detail, from 1 to [`MAX_LEVELS`](adumbra::file::MAX_LEVELS). Each has voxels four
    /// times as large as the one before it. Levels of fewer than 256 texels are left out.
    pub levels: u32,
    /// How the voxels are stored in a file that is written.
    pub encoding: Encoding,
    /// The region of the world to cover instead of the scene's own extent. Set by
    /// [`RegionPlan::options`](crate::RegionPlan::options), with a frame and a voxel size that all regions
    /// share.
    #[doc(hidden)]
    pub region: Option<Region>,
    /// The method that finds the columns.
    #[doc(hidden)]
    pub builder: ColumnBuilder,
}

/// Texels on the longest side of the scene below which a bake has no coarser level: its few root blocks would
/// each have nearly all triangles.
pub(crate) const LEAST_LEVEL_TEXELS: u32 = 256;

impl BakeOptions {
    /// Levels of detail of a bake, unless another number is asked for.
    pub const DEFAULT_LEVELS: u32 = 3;
    /// Largest value of [`BakeOptions::switch_within_voxels`].
    pub const MAX_SWITCH_WITHIN: u32 = 65_535;

    /// Creates default options for a sun and a size: a ground assumed where the scene has one, closed regions
    /// used, every point answered.
    pub fn new(sun: Sun, size: Size) -> Self {
        Self {
            sun,
            frame: FrameChoice::default(),
            size,
            thickness_world: 0.0,
            assume_ground: AssumeGround::default(),
            closed_regions: true,
            ignore_alpha: false,
            receivers: Receivers::All,
            bounds: None,
            bias: Bias::default(),
            max_memory_bytes: None,
            spill_folder: None,
            switch_within_voxels: 0,
            levels: Self::DEFAULT_LEVELS,
            encoding: Encoding::default(),
            region: None,
            builder: ColumnBuilder::Fast,
        }
    }

    /// Returns the options with some of them changed.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// Returns the options with the folder of `path` for temporary files, unless they name another folder.
    pub(crate) fn spilling_beside(&self, path: &Path) -> Self {
        let spill_folder = self.spill_folder.clone().unwrap_or_else(|| target_folder(path));
        Self { spill_folder: Some(spill_folder), ..self.clone() }
    }

    /// Returns the number of levels of a bake at this resolution.
    pub(crate) fn level_count(&self, resolution: u32) -> u32 {
        let is_fine = |level: &u32| resolution / LEVEL_STEP.pow(*level) >= LEAST_LEVEL_TEXELS;
        1 + (1..self.levels).take_while(is_fine).count() as u32
    }

    pub(crate) fn check(&self) -> Result<()> {
        if !self.thickness_world.is_finite() || self.thickness_world < 0.0 {
            let range = "a finite length in world units, 0 or more";
            return Err(RangeError::new(BakeField::Thickness, self.thickness_world, range).into());
        }
        if self.switch_within_voxels > Self::MAX_SWITCH_WITHIN {
            let range = "a number of voxels up to 65535";
            return Err(RangeError::new(BakeField::SwitchLimit, self.switch_within_voxels, range).into());
        }
        if !(1..=MAX_LEVELS).contains(&self.levels) {
            return Err(RangeError::new(BakeField::Levels, self.levels, "from 1 to 8").into());
        }
        if let FrameChoice::ObliqueAt(yaw_radians) = self.frame
            && !(-PI..=PI).contains(&yaw_radians)
        {
            let value = format!("{yaw_radians} radians ({}°)", yaw_radians.to_degrees());
            return Err(
                RangeError::new(BakeField::Yaw, value, "from -pi to pi radians (-180° to 180°)").into()
            );
        }
        self.bias.check()?;
        self.bounds.as_ref().map_or(Ok(()), check_bounds)
    }
}

/// Checks that the bounds of a bake are a valid box.
///
/// # Errors
/// Returns [`Error::Range`] if the box has no extent or is not finite.
pub fn check_bounds(b: &Bounds) -> Result<()> {
    for a in 0..3 {
        if !(b.min[a].is_finite() && b.max[a].is_finite() && b.min[a] < b.max[a]) {
            let value = format!("{:?} to {:?}", b.min, b.max);
            let range = "six finite numbers, each minimum below its maximum";
            return Err(RangeError::new(BakeField::Bounds, value, range).into());
        }
    }
    Ok(())
}

impl Default for Size {
    /// 8192 texels on the longest side.
    fn default() -> Self {
        Self::Resolution(8192)
    }
}

impl Size {
    /// Smallest resolution, texels on the longest side.
    pub const MIN_RESOLUTION: u32 = 8;
    /// Largest resolution, texels on the longest side.
    pub const MAX_RESOLUTION: u32 = 1 << 18;

    /// Returns the edge of a voxel for a space whose longest side is `longest_side`, without the limits of
    /// one grid.
    ///
    /// # Errors
    /// Returns [`Error::Range`] if the size is not above 0, and [`Error::Resolution`] for a resolution that
    /// no file has.
    pub(crate) fn voxel_size(self, longest_side: f64) -> Result<f64> {
        match self {
            Self::VoxelSize(size) if size.is_finite() && size > 0.0 => Ok(size),
            _ => Ok(self.resolve(longest_side)?.1),
        }
    }

    /// Returns resolution and voxel size for a space whose longest side is `longest_side`.
    ///
    /// # Errors
    /// Returns [`Error::Resolution`] or [`Error::Range`] if the size is out of range.
    pub fn resolve(self, longest_side: f64) -> Result<(u32, f64)> {
        match self {
            Self::Resolution(resolution) => {
                let nearest = resolution
                    .clamp(Self::MIN_RESOLUTION.into(), Self::MAX_RESOLUTION.into())
                    .next_power_of_two();
                if nearest != resolution {
                    return Err(Error::Resolution {
                        resolution,
                        min: Self::MIN_RESOLUTION,
                        max: Self::MAX_RESOLUTION,
                        suggestion: nearest as u32,
                    });
                }
                Ok((nearest as u32, longest_side / nearest as f64))
            }
            Self::VoxelSize(size) => {
                let refuse =
                    |value: String, range| Err(RangeError::new(BakeField::VoxelSize, value, range).into());
                if !(size.is_finite() && size > 0.0) {
                    return refuse(size.to_string(), "a finite length in world units above 0");
                }
                let texels = (longest_side / size).ceil();
                if texels > f64::from(Self::MAX_RESOLUTION) {
                    let value = format!("{size} ({texels} texels across)");
                    return refuse(value, "coarse enough for at most 262144 texels across the scene");
                }
                Ok(((texels as u32).next_power_of_two().max(Self::MIN_RESOLUTION), size))
            }
        }
    }
}
