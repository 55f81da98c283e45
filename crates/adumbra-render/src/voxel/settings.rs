//! Parsing of a light-aligned file's look-up settings from a technique's text. Without a file, the bias is the default
//! of a bake.

use adumbra::gpu::{PENUMBRA_ANGLES_DEGREES, PENUMBRA_RADII_TEXELS};
use adumbra::query::FILTER_WIDTHS;
use adumbra::{Bias, LightBody, ShadowFile};

use super::filter::VoxelFilter;
use crate::error::Result;
use crate::maps::help;
use crate::technique::{SpecReader, SpecText};

/// Settings of a light-aligned file's look-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelSettings {
    /// The mean over texels, or penumbrae, which only the layout `depths` supports.
    pub filter: VoxelFilter,
    /// Bias, in texels.
    pub bias: Bias,
}

impl VoxelSettings {
    /// Settings for the mean over `width` × `width` texels.
    pub fn taps(width: u32, bias: Bias) -> Self {
        Self { filter: VoxelFilter::Taps(width), bias }
    }

    /// Parses `voxel[:filter=K]` or `voxel:soft[:angle=DEGREES][:radius=TEXELS]`, each with
    /// `[:bias=…][:slope=…][:normal=…]`. Defaults: K = 5, a sun of 0.53°, 32 texels, and the file's bias.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if a parameter is unknown or out of range, or if penumbrae are
    /// requested of a file in a layout other than `depths`.
    pub fn from_spec(spec: &SpecText, file: Option<&ShadowFile>) -> Result<Self> {
        spec.read(|reader| Self::from_reader(reader, file))
    }

    /// Whether a technique's text requests the penumbrae of the sun's disc.
    pub(crate) fn has_penumbrae(spec: &SpecText) -> bool {
        spec.value("shade") == Some("soft")
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>, file: Option<&ShadowFile>) -> Result<Self> {
        let has_soft = file.is_none_or(|f| matches!(f.body, LightBody::Depths(_)));
        let spec = reader.spec();
        if !has_soft && Self::has_penumbrae(spec) {
            return Err(spec.wrong("penumbrae need a file with layout depths".to_owned()));
        }
        let what = "soft: penumbrae of the sun's disc, from files with layout depths";
        let shadows = &["hard", "soft"][..if has_soft { 2 } else { 1 }];
        let filter = if reader.choice("shade", what, shadows)? == "soft" {
            VoxelFilter::Soft {
                angle_degrees: reader.number("angle", help::SUN_ANGLE, 0.53, PENUMBRA_ANGLES_DEGREES)?,
                max_radius_texels: reader.number(
                    "radius",
                    help::PENUMBRA_RADIUS,
                    32.0,
                    PENUMBRA_RADII_TEXELS,
                )?,
            }
        } else {
            VoxelFilter::Taps(read_width(reader)?)
        };
        let bias = file.map_or_else(Bias::default, |f| f.settings.bias);
        Ok(Self { filter, bias: read_bias(reader, bias)? })
    }
}

/// Reads the key `filter` of a light-aligned file.
pub(crate) fn read_width(reader: &mut SpecReader<'_>) -> Result<u32> {
    reader.integer("filter", "texels per side", 5, &FILTER_WIDTHS)
}

/// Reads the keys `bias`, `slope` and `normal`, in texels. The file's bias is the default.
pub(super) fn read_bias(reader: &mut SpecReader<'_>, file: Bias) -> Result<Bias> {
    Ok(Bias {
        constant_texels: reader.number("bias", help::FILE_BIAS, file.constant_texels, 0.0..=16.0)?,
        slope_texels: reader.number("slope", help::SLOPE, file.slope_texels, 0.0..=16.0)?,
        normal_offset_texels: reader.number("normal", help::NORMAL, file.normal_offset_texels, 0.0..=16.0)?,
    })
}
