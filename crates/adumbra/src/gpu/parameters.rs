//! The parameter block of a look-up: the placement of the grid, the location of the file's words, and the bias and
//! filter.

use std::ops::RangeInclusive;

use super::grid::GridParameters;
use crate::error::{RangeError, RangeField, Result};
use crate::file::ShadowFile;
use crate::grid::LightGrid;
use crate::query::Filter;
use crate::settings::Bias;

/// Full angles of a sun whose penumbrae can be looked up, degrees.
pub const PENUMBRA_ANGLES_DEGREES: RangeInclusive<f64> = 0.01..=20.0;
/// Largest radii of penumbrae that can be looked up, texels. With larger ones, depths on the receiver's plane would
/// overflow 32 bits.
pub const PENUMBRA_RADII_TEXELS: RangeInclusive<f64> = 1.0..=64.0;

/// Penumbrae of a sun's disc in place of a filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penumbra {
    /// The sun's full angle, in [`PENUMBRA_ANGLES_DEGREES`].
    pub sun_degrees: f64,
    /// The largest radius of a penumbra, from its middle to its edge, in [`PENUMBRA_RADII_TEXELS`].
    pub max_radius_texels: f64,
}

impl Default for Penumbra {
    /// The sun as seen from the Earth, and penumbrae of up to 32 texels.
    fn default() -> Self {
        Self { sun_degrees: 0.53, max_radius_texels: 32.0 }
    }
}

impl Penumbra {
    fn check(&self) -> Result<(), RangeError> {
        let Self { sun_degrees, max_radius_texels } = *self;
        if !PENUMBRA_ANGLES_DEGREES.contains(&sun_degrees) {
            return Err(RangeError::new(RangeField::SunAngle, sun_degrees, "from 0.01 to 20 degrees"));
        }
        if !PENUMBRA_RADII_TEXELS.contains(&max_radius_texels) {
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
}

/// The WGSL structure `AdumbraVoxelParams`.
///
/// | offset | bytes | field |
/// |---|---|---|
/// | 0 | 272 | grid |
/// | 272 | 12 | root count |
/// | 284 | 4 | root level |
/// | 288 | 16 | bias: constant, slope, normal offset in texels; factor 1 |
/// | 304 | 12 | zero |
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
    /// Index of the first word of code among the words.
    pub code_offset: u32,
    /// Width of the filter, texels.
    pub filter_width: u32,
    /// Texels by which the sun's cone widens per voxel of depth; 0 without penumbrae.
    pub sun_cone: f32,
    /// Largest radius of a penumbra, texels; 0 without penumbrae. In the oblique frame this is its short radius.
    pub max_radius_texels: f32,
    /// Rows of the map from the unit circle across the light to the ellipse that is its outline in grid x and y, see
    /// [`LightGrid::circle_across_light`].
    pub penumbra: [[f32; 2]; 2],
}

impl Parameters {
    /// Size of the structure in bytes.
    pub const BYTES: usize = 352;

    /// Creates the parameters of a look-up in a file. Positions in the shader are relative to `anchor_world`.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::Error::Range) if the bias or the penumbrae are out of range, or the grid is too
    /// large for look-ups on a GPU.
    pub fn new(file: &ShadowFile, look_up: &LookUp, anchor_world: [f64; 3]) -> Result<Self> {
        let (grid, tree) = (&file.grid, &*file.tree);
        let bias = look_up.bias.unwrap_or(file.settings.bias);
        bias.check()?;
        let [nx, ny] = tree.top_dims();
        let mut parameters = Self {
            grid: GridParameters::new(grid, anchor_world)?,
            root_count: [nx, ny, 1],
            root_level: tree.root_level(),
            bias,
            code_offset: 2 * tree.top().len() as u32,
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

    /// Sets the world position that positions in the shader are relative to.
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
        let words = [nx, ny, nz, self.root_level]
            .into_iter()
            .chain(bias.map(f32::to_bits))
            .chain([0, 0, 0, self.code_offset])
            .chain([self.filter_width, self.sun_cone.to_bits(), self.max_radius_texels.to_bits(), 0])
            .chain(self.penumbra.as_flattened().iter().map(|c| c.to_bits()));
        words.for_each(|word| out.extend(word.to_le_bytes()));
        std::array::from_fn(|i| out[i])
    }
}
