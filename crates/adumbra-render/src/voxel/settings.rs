//! From a technique's text to how baked files are looked up in; what comes from the file is that of a bake's defaults where there is none.

use adumbra::format::{LightBody, ShadowFile, TreeFile};
use adumbra::query::{FILTER_WIDTHS, KERNEL_SIDES, TapLayers, Weights};
use adumbra::settings::Bias;

use super::hierarchy::{ANGLES_DEGREES, RADII_TEXELS};
use super::{CubesOptions, CubesStore, HierarchyFilter};
use crate::error::Result;
use crate::maps::told;
use crate::technique::{SpecReader, TechniqueSpec};

/// How a light-aligned file is looked up in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelSettings {
    /// Texels, or penumbrae, which only a hierarchy has.
    pub filter: HierarchyFilter,
    /// Of the filter's taps; penumbrae have none.
    pub layers: TapLayers,
    /// In texels.
    pub bias: Bias,
}

impl VoxelSettings {
    /// `voxel[:filter=K][:layers=tap|block]` or `voxel:soft[:angle=DEGREES][:radius=TEXELS]`, each with `[:bias=…][:slope=…][:normal=…]`;
    /// K = 9, a tap's own layer, a sun of 0.53°, 32 texels and the file's bias by default.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for other parameters, and for penumbrae of a file that is no hierarchy.
    pub fn from_spec(spec: &TechniqueSpec, file: Option<&ShadowFile>) -> Result<Self> {
        let mut reader = spec.reader();
        let settings = Self::from_reader(&mut reader, file)?;
        reader.finish()?;
        Ok(settings)
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>, file: Option<&ShadowFile>) -> Result<Self> {
        let has_soft = file.is_none_or(|f| matches!(f.body, LightBody::Hierarchy(_)));
        let spec = reader.spec();
        if !has_soft && spec.value("shade") == Some("soft") {
            return Err(spec.wrong("penumbrae need a file that was baked with --layout hierarchy".to_owned()));
        }
        let what = "soft: the penumbrae of a sun, of files baked with --layout hierarchy";
        let shades = &["hard", "soft"][..if has_soft { 2 } else { 1 }];
        let mut layers = TapLayers::default();
        let filter = if reader.choice("shade", what, shades)? == "soft" {
            HierarchyFilter::Soft {
                angle_degrees: reader.number("angle", told::SUN_ANGLE, 0.53, ANGLES_DEGREES)?,
                max_radius_texels: reader.number("radius", told::PENUMBRA_RADIUS, 32.0, RADII_TEXELS)?,
            }
        } else {
            let width = read_width(reader)?;
            layers = read_layers(reader)?;
            HierarchyFilter::Taps(width)
        };
        let bias = file.map_or_else(Bias::default, |f| f.settings.bias);
        Ok(Self { filter, layers, bias: read_bias(reader, bias)? })
    }
}

/// `filter` of a light-aligned file.
pub(crate) fn read_width(reader: &mut SpecReader<'_>) -> Result<u32> {
    reader.integer("filter", "texels a side", 9, &FILTER_WIDTHS)
}

/// `layers` of a light-aligned file.
pub(crate) fn read_layers(reader: &mut SpecReader<'_>) -> Result<TapLayers> {
    let what = "of voxels: a tap's own; block: one for 8 × 8 texels, cheaper, light leaks on slopes";
    let is_block = reader.choice("layers", what, &["tap", "block"])? == "block";
    Ok(if is_block { TapLayers::Block } else { TapLayers::Tap })
}

impl CubesOptions {
    /// `voxel-cubes[:filter=1|3|5][:weights=mean|poisson][:taps=front|all][:bias=…][:slope=…][:normal=…]`, or `voxel-texture`, which also
    /// takes `read=texels|buffer`. By default 3³, mean, and the file's bias.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for other parameters.
    pub fn from_spec(spec: &TechniqueSpec, file: Option<&TreeFile>) -> Result<Self> {
        let mut reader = spec.reader();
        let options = Self::from_reader(&mut reader, file)?;
        reader.finish()?;
        Ok(options)
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>, file: Option<&TreeFile>) -> Result<Self> {
        let filter = reader.integer("filter", "voxels a side of a cube", 3, &KERNEL_SIDES)?;
        let weights = match reader.choice("weights", "of the filter's voxels", &["mean", "poisson"])? {
            "poisson" => Weights::Poisson,
            _ => Weights::Mean,
        };
        let taps = "which voxels count: those before the receiver's plane, or all";
        let all_taps = reader.choice("taps", taps, &["front", "all"])? == "all";
        let bias = read_bias(reader, file.map_or_else(Bias::default, |f| f.settings.bias))?;
        let read = "from texels, or from a buffer that they are decoded into at load";
        let store = if reader.spec().name() == "voxel-cubes" {
            CubesStore::Words
        } else if reader.choice("read", read, &["texels", "buffer"])? == "buffer" {
            CubesStore::Decoded
        } else {
            CubesStore::Texels
        };
        Ok(Self { bias, filter, weights, all_taps, store })
    }
}

/// The file's bias, or what was asked for: `bias`, `slope` and `normal` in texels.
fn read_bias(reader: &mut SpecReader<'_>, file: Bias) -> Result<Bias> {
    Ok(Bias {
        constant_texels: reader.number("bias", told::FILE_BIAS, file.constant_texels, 0.0..=16.0)?,
        slope_texels: reader.number("slope", told::SLOPE, file.slope_texels, 0.0..=16.0)?,
        normal_offset_texels: reader.number("normal", told::NORMAL, file.normal_offset_texels, 0.0..=16.0)?,
    })
}
