//! The parameter block of a look-up: the placement of the grid, the location of the file's words, and the
//! bias and filter.

use std::ops::RangeInclusive;

use super::grid::GridParameters;
use crate::error::{RangeError, RangeField, Result};
use crate::file::ShadowFile;
use crate::grid::{LightGrid, Placement};
use crate::query::Filter;
use crate::settings::Bias;

/// Penumbrae of a sun's disc in place of a filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penumbra {
    /// The sun's full angle, in [`Penumbra::ANGLES_DEGREES`].
    pub sun_degrees: f64,
    /// The largest radius of a penumbra, from its middle to its edge, in [`Penumbra::RADII_TEXELS`].
    pub max_radius_texels: f64,
}

impl Default for Penumbra {
    /// The sun as seen from the Earth, and penumbrae of up to 32 texels.
    fn default() -> Self {
        Self { sun_degrees: 0.53, max_radius_texels: 32.0 }
    }
}

impl Penumbra {
    /// Full angles of a sun whose penumbrae can be looked up, degrees.
    pub const ANGLES_DEGREES: RangeInclusive<f64> = 0.01..=20.0;
    /// Largest radii of penumbrae that can be looked up, texels. With larger ones, depths on the receiver's
    /// plane would overflow 32 bits.
    pub const RADII_TEXELS: RangeInclusive<f64> = 1.0..=64.0;

    fn check(&self) -> Result<(), RangeError> {
        let Self { sun_degrees, max_radius_texels } = *self;
        if !Self::ANGLES_DEGREES.contains(&sun_degrees) {
            return Err(RangeError::new(RangeField::SunDegrees, sun_degrees, "from 0.01 to 20 degrees"));
        }
        if !Self::RADII_TEXELS.contains(&max_radius_texels) {
            return Err(RangeError::new(
                RangeField::PenumbraRadius,
                max_radius_texels,
                "from 1 to 64 texels",
            ));
        }
        Ok(())
    }
}

/// How a shader looks up a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LookUp {
    /// The filter.
    pub filter: Filter,
    /// The bias; `None`: the bias that the file was baked for.
    pub bias: Option<Bias>,
    /// Penumbrae in place of the filter, for `core/depths_soft.wgsl`.
    pub penumbra: Option<Penumbra>,
    /// Placement of the file's world in the app's.
    pub placement: Placement,
}

/// The WGSL structure `AdumbraVoxelParams`.
///
/// | offset | bytes | field |
/// |---|---|---|
/// | 0 | 272 | grid |
/// | 272 | 12 | root count |
/// | 284 | 4 | root level |
/// | 288 | 16 | bias: constant, slope, normal offset in texels; factor 1 |
/// | 304 | 4 | first word of the table of blocks |
/// | 308 | 4 | number of coarser levels that follow |
/// | 312 | 4 | 1 if pages may be absent, 2 if their weights also follow the table, else 0 |
/// | 316 | 4 | first word of code |
/// | 320 | 4 | filter width, texels |
/// | 324 | 4 | texels by which the sun's cone widens per voxel of depth; 0 without penumbrae |
/// | 328 | 4 | largest radius of a penumbra, texels; 0 without penumbrae |
/// | 332 | 4 | zero |
/// | 336 | 16 | the penumbra's ellipse, see [`Parameters::penumbra`] |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Transform from world to grid.
    pub grid: GridParameters,
    /// Number of blocks at which look-ups begin along x and y, and 1.
    pub root_count: [u32; 3],
    /// Such a block spans 2^root_level voxels along each side.
    pub root_level: u32,
    /// Look-up bias.
    pub bias: Bias,
    /// Index of the first word of the table of blocks among the words. 0 unless the file is streamed.
    pub table_offset: u32,
    /// Number of coarser levels that can answer where pages are absent. 0 unless the file is streamed.
    pub coarser_levels: u32,
    /// Whether pages may be absent, so that look-ups have to check. `false` unless the file is streamed.
    pub may_lack_pages: bool,
    /// Whether a weight per page follows the table of blocks. `false` unless a streamed file fades its
    /// levels.
    pub pages_fade: bool,
    /// Index of the first word of code among the words.
    pub code_offset: u32,
    /// Width of the filter, texels.
    pub filter_width: u32,
    /// Texels by which the sun's cone widens per voxel of depth; 0 without penumbrae.
    pub sun_cone: f32,
    /// Largest radius of a penumbra, texels; 0 without penumbrae. In the oblique frame this is its short
    /// radius.
    pub max_radius_texels: f32,
    /// Rows of the map from the unit circle across the light to the ellipse that is its outline in grid x and
    /// y, see [`LightGrid::circle_across_light`].
    pub penumbra: [[f32; 2]; 2],
}

/// Where the words of a quadtree are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WordPlaces {
    pub(crate) block_level: u32,
    pub(crate) block_dims: [u32; 2],
    /// First word of the table of blocks.
    pub(crate) table_offset: u32,
    /// First word of the code.
    pub(crate) code_offset: u32,
}

impl WordPlaces {
    /// Returns the places of a file's words, when they are on their own.
    pub(crate) fn of(file: &ShadowFile) -> Self {
        Self {
            block_level: file.tree.root_level(),
            block_dims: file.tree.top_dims(),
            table_offset: 0,
            code_offset: 2 * file.tree.top().len() as u32,
        }
    }
}

impl Parameters {
    /// Size of the structure in bytes.
    pub const BYTES: usize = 352;

    /// Creates the parameters of a look-up in a file. Positions in the shader are relative to `anchor_world`.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::Error::Range) if the bias or the penumbrae are out of range, or the
    /// grid is too large for look-ups on a GPU.
    pub fn new(file: &ShadowFile, look_up: &LookUp, anchor_world: [f64; 3]) -> Result<Self> {
        Self::of_grid(&file.grid, file.settings.bias, WordPlaces::of(file), look_up, anchor_world)
    }

    /// Creates the parameters of a look-up in words at these places. The bias is the file's unless `look_up`
    /// has one.
    pub(crate) fn of_grid(
        grid: &LightGrid,
        bias: Bias,
        words: WordPlaces,
        look_up: &LookUp,
        anchor_world: [f64; 3],
    ) -> Result<Self> {
        let bias = look_up.bias.unwrap_or(bias);
        bias.check()?;
        let [nx, ny] = words.block_dims;
        let mut parameters = Self {
            grid: GridParameters::new(&grid.placed(&look_up.placement), anchor_world)?,
            root_count: [nx, ny, 1],
            root_level: words.block_level,
            bias,
            table_offset: words.table_offset,
            coarser_levels: 0,
            may_lack_pages: false,
            pages_fade: false,
            code_offset: words.code_offset,
            filter_width: look_up.filter.width(),
            sun_cone: 0.0,
            max_radius_texels: 0.0,
            penumbra: grid.circle_across_light().map(|row| row.map(|c| c as f32)),
        };
        if let Some(penumbra) = look_up.penumbra {
            penumbra.check()?;
            parameters.filter_width = 1;
            parameters.sun_cone = grid.cone_texels_per_voxel(penumbra.sun_degrees) as f32;
            parameters.max_radius_texels = penumbra.max_radius_texels as f32;
        }
        Ok(parameters)
    }

    /// Sets the world position that positions in the shader are relative to. `grid` is the file's grid with
    /// the app's placement ([`LightGrid::placed`]).
    ///
    /// # Errors
    /// Returns [`RangeError`] only if the grid itself is too large.
    pub fn set_anchor(&mut self, grid: &LightGrid, anchor_world: [f64; 3]) -> Result<(), RangeError> {
        self.grid = GridParameters::new(grid, anchor_world)?;
        Ok(())
    }

    /// Returns the structure's bytes, little-endian, as a uniform buffer holds them.
    pub fn to_bytes(self) -> [u8; Self::BYTES] {
        let mut out = Vec::with_capacity(Self::BYTES);
        self.grid.put(&mut out);
        let Bias { constant_texels, slope_texels, normal_offset_texels } = self.bias;
        let bias = [constant_texels as f32, slope_texels as f32, normal_offset_texels as f32, 1.0];
        let [nx, ny, nz] = self.root_count;
        let residency = if self.pages_fade { 2 } else { u32::from(self.may_lack_pages) };
        let words = [nx, ny, nz, self.root_level]
            .into_iter()
            .chain(bias.map(f32::to_bits))
            .chain([self.table_offset, self.coarser_levels, residency, self.code_offset])
            .chain([self.filter_width, self.sun_cone.to_bits(), self.max_radius_texels.to_bits(), 0])
            .chain(self.penumbra.as_flattened().iter().map(|c| c.to_bits()));
        words.for_each(|word| out.extend(word.to_le_bytes()));
        std::array::from_fn(|i| out[i])
    }
}
