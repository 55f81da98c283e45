//! Parsing of a light-aligned file's look-up settings from a technique's text. Without a file, the bias is
//! the default of a bake.

use adumbra::gpu::{LookUp, Penumbra};
use adumbra::{Bias, Filter};

use super::LightFile;

use crate::error::Result;
use crate::maps::help;
use crate::technique::{SpecReader, SpecText};

/// Settings of a light-aligned file's look-up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VoxelSettings {
    /// Filter or penumbrae, and bias. Without a bias, the file's bias applies.
    pub look_up: LookUp,
    /// For a sun path: whether rays are marched only where the answers of the two keys differ, as
    /// [`PathSampler::quick`](adumbra::PathSampler::quick) does.
    pub quick: bool,
}

impl VoxelSettings {
    /// Settings for a filter.
    pub fn taps(filter: Filter, bias: Bias) -> Self {
        Self { look_up: LookUp { filter, bias: Some(bias), ..LookUp::default() }, quick: false }
    }

    /// Parses `voxel[:filter=K]`, `voxel:path[:filter=K]` or
    /// `voxel:soft[:sun-degrees=DEGREES][:radius=TEXELS]`, each with `[:bias=…][:slope=…][:normal=…]`.
    /// Defaults: K = 5, a sun of 0.53°, 32 texels, and the file's bias. Between the keys of a sun path, a
    /// filter may have `:march=quick`, and penumbrae have no largest radius.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if a parameter is unknown or out of range.
    pub fn from_spec(spec: &SpecText, file: Option<LightFile<'_>>) -> Result<Self> {
        spec.read(|reader| Self::from_reader(reader, file))
    }

    /// Whether a technique's text requests the penumbrae of the sun's disc.
    pub(crate) fn has_penumbrae(spec: &SpecText) -> bool {
        spec.value("shade") == Some("soft")
    }

    /// Whether a technique's text requires a sun path.
    pub(crate) fn needs_path(spec: &SpecText) -> bool {
        spec.value("shade") == Some("path")
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>, file: Option<LightFile<'_>>) -> Result<Self> {
        let usual = Penumbra::default();
        let what = "soft: penumbrae of the sun's disc; path: a moment of a sun path";
        // Offer `path` if there is no file yet or the file is a sun path.
        let has_path = file.is_none_or(LightFile::is_path) || Self::needs_path(reader.spec());
        let shades: &[&str] = if has_path { &["hard", "soft", "path"] } else { &["hard", "soft"] };
        let mut look_up = LookUp::default();
        let mut quick = false;
        if reader.choice("shade", what, shades)? == "soft" {
            look_up.penumbra = Some(Penumbra {
                sun_degrees: reader.number(
                    "sun-degrees",
                    help::SUN_DEGREES,
                    usual.sun_degrees,
                    Penumbra::ANGLES_DEGREES,
                )?,
                max_radius_texels: reader.number(
                    "radius",
                    help::PENUMBRA_RADIUS,
                    usual.max_radius_texels,
                    Penumbra::RADII_TEXELS,
                )?,
            });
        } else {
            look_up.filter = read_filter(reader)?;
            if has_path {
                let march = "between keys of a sun path; quick: only where their own answers differ";
                quick = reader.choice("march", march, &["full", "quick"])? == "quick";
            }
        }
        let bias = file.map_or_else(Bias::default, LightFile::bias);
        look_up.bias = Some(read_bias(reader, bias)?);
        Ok(Self { look_up, quick })
    }
}

/// Reads the key `filter` of a light-aligned file.
///
/// # Errors
/// Returns [`crate::RenderError::Technique`] for a width that does not exist.
pub fn read_filter(reader: &mut SpecReader<'_>) -> Result<Filter> {
    let widths = Filter::ALL.map(Filter::width);
    let width = reader.integer("filter", "texels per side", Filter::default().width(), &widths)?;
    Ok(Filter::try_from(width)?)
}

/// Reads the keys `bias`, `slope` and `normal`, in texels. The file's bias is the default.
///
/// # Errors
/// Returns [`crate::RenderError::Technique`] for a value that is out of range.
pub fn read_bias(reader: &mut SpecReader<'_>, file: Bias) -> Result<Bias> {
    Ok(Bias {
        constant_texels: reader.number("bias", help::FILE_BIAS, file.constant_texels, 0.0..=16.0)?,
        slope_texels: reader.number("slope", help::SLOPE, file.slope_texels, 0.0..=16.0)?,
        normal_offset_texels: reader.number("normal", help::NORMAL, file.normal_offset_texels, 0.0..=16.0)?,
    })
}
