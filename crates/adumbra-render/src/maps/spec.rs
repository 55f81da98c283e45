//! From a technique's text to settings: `csm:cascades=4:size=2048:filter=5:split=practical:lambda=0.5:static=cached`.

use super::params::{
    CascadeSettings, DepthPrecision, MapBias, MapCasters, MapFilter, MapFit, MapSettings, MomentKind,
    MomentSettings, Split,
};
use super::told;
use crate::error::Result;
use crate::technique::{SpecReader, TechniqueSpec};

const SIZES: &[u32] = &[128, 256, 512, 1024, 2048, 4096, 8192, 16384];

impl MapSettings {
    /// The settings that a technique's text asks for; none where its name is not a shadow map's.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for a value out of range, or an unknown key.
    pub fn from_spec(spec: &TechniqueSpec) -> Result<Option<Self>> {
        let mut reader = spec.reader();
        let Some(settings) = Self::from_reader(&mut reader)? else { return Ok(None) };
        reader.finish()?;
        Ok(Some(settings))
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>) -> Result<Option<Self>> {
        let name = reader.spec().name();
        let fit = match name {
            "csm" | "csm-vsm" | "csm-evsm" => MapFit::Cascades(cascades(reader)?),
            _ => MapFit::Scene,
        };
        let filter = match name {
            "sm" => MapFilter::Nearest,
            "pcf" => comparisons(reader, &["5", "2", "3", "7", "poisson"])?,
            "csm" => comparisons(reader, &["5", "1", "2", "3", "7", "poisson"])?,
            "pcss" => MapFilter::Pcss {
                angle_degrees: reader.number("angle", told::SUN_ANGLE, 0.53, 0.01..=20.0)?,
                max_radius: reader.number("radius", told::PENUMBRA_RADIUS, 32.0, 1.0..=256.0)?,
            },
            "vsm" | "csm-vsm" => moments(reader, MomentKind::Variance)?,
            "evsm" | "csm-evsm" => moments(reader, MomentKind::ExponentialVariance)?,
            "msm" => moments(reader, MomentKind::FourMoments)?,
            _ => return Ok(None),
        };
        Ok(Some(Self {
            size: reader.integer("size", "of a layer, texels a side", 2048, SIZES)?,
            depth: DepthPrecision::from_reader(reader)?,
            fit,
            filter,
            bias: MapBias::from_reader(reader, &filter)?,
            cache_static: cache_static(reader)?,
            casters: MapCasters::All,
        }))
    }
}

/// `static`, which hybrid maps have too.
pub(crate) fn cache_static(reader: &mut SpecReader<'_>) -> Result<bool> {
    let what = "static casters: drawn anew in every frame, or kept until light or layer move";
    Ok(reader.choice("static", what, &["redrawn", "cached"])? == "cached")
}

impl DepthPrecision {
    pub(crate) fn from_reader(reader: &mut SpecReader<'_>) -> Result<Self> {
        Ok(match reader.choice("depth", "bits of a depth", &["32", "16"])? {
            "16" => Self::Bits16,
            _ => Self::Bits32,
        })
    }
}

impl MapBias {
    /// What is said of it, and the filter's usual bias for the rest.
    pub(crate) fn from_reader(reader: &mut SpecReader<'_>, filter: &MapFilter) -> Result<Self> {
        let usual = Self::of(filter);
        Ok(Self {
            constant_texels: reader.number("bias", told::BIAS, usual.constant_texels, 0.0..=16.0)?,
            slope_texels: reader.number("slope", told::SLOPE, usual.slope_texels, 0.0..=16.0)?,
            normal_offset_texels: reader.number(
                "normal",
                told::NORMAL,
                usual.normal_offset_texels,
                0.0..=16.0,
            )?,
            ..usual
        })
    }
}

fn cascades(reader: &mut SpecReader<'_>) -> Result<CascadeSettings> {
    let usual = CascadeSettings::default();
    let lambda = "of split=practical: its share of the logarithmic one";
    let far = "view depth where shadows end, world units; without it as far as the scene is in view, to the next power of two";
    Ok(CascadeSettings {
        cascades: reader.count("cascades", "layers", usual.cascades, 1..=8)?,
        split: match reader.choice("split", "of the view's depth", &["practical", "uniform", "log"])? {
            "uniform" => Split::Uniform,
            "log" => Split::Logarithmic,
            _ => Split::Practical { lambda: reader.number("lambda", lambda, 0.5, 0.0..=1.0)? },
        },
        far_world: reader.optional_number("far", far, 1e-3..=1e12)?,
        blend: reader.number(
            "blend",
            "share of a slice that blends into the next",
            usual.blend,
            0.0..=0.5,
        )?,
    })
}

fn comparisons(reader: &mut SpecReader<'_>, choices: &[&'static str]) -> Result<MapFilter> {
    let filter =
        reader.choice("filter", "texels a side that are compared; poisson: 16 of a disc", choices)?;
    Ok(match filter.parse() {
        Ok(1) => MapFilter::Nearest,
        Ok(width) => MapFilter::Pcf { width },
        Err(_) => {
            MapFilter::Poisson { radius: reader.number("radius", "of the disc, texels", 2.0, 0.5..=32.0)? }
        }
    })
}

fn moments(reader: &mut SpecReader<'_>, kind: MomentKind) -> Result<MapFilter> {
    let usual = MomentSettings::new(kind);
    let odd: Vec<u32> = (0..16).map(|i| 2 * i + 1).collect();
    let exponents = if kind == MomentKind::ExponentialVariance {
        [
            reader.number("positive", "exponent of the warp of depth", 40.0, 1.0..=42.0)?,
            reader.number("negative", "exponent of the warp of depth turned round", 5.0, 1.0..=42.0)?,
        ]
    } else {
        usual.exponents
    };
    let bleed = "share of the tail that counts as shadow: less light bleeds through, edges are harder";
    let deviation = "least standard deviation of depth, texels";
    Ok(MapFilter::Moments(MomentSettings {
        blur: reader.integer("blur", "width of the Gaussian over depth, texels, odd", usual.blur, &odd)?,
        bleed: reader.number("bleed", bleed, usual.bleed, 0.0..=0.9)?,
        least_deviation_texels: reader.number(
            "deviation",
            deviation,
            usual.least_deviation_texels,
            0.0..=16.0,
        )?,
        exponents,
        ..usual
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::TECHNIQUES;

    fn settings(text: &str) -> Result<Option<MapSettings>> {
        MapSettings::from_spec(&text.parse()?)
    }

    #[test]
    fn spec_gives_settings_for_every_name() {
        let known = TECHNIQUES.iter().filter_map(|(name, _)| Some((name, settings(name).unwrap()?)));
        let known: Vec<_> = known.collect();
        assert!(known.len() >= 9);
        for (name, found) in known {
            assert_eq!((found.size, found.cache_static), (2048, false), "{name}");
            assert_eq!(found.depth, DepthPrecision::Bits32, "{name}");
            let halved = settings(&format!("{name}:depth=16")).unwrap().unwrap();
            assert_eq!(halved, MapSettings { depth: DepthPrecision::Bits16, ..found });
            assert_eq!(found.layers(), if name.starts_with("csm") { 4 } else { 1 });
        }
        assert_eq!(settings("voxel").unwrap(), None);
    }

    #[test]
    fn spec_reads_every_key_of_cascades() {
        let text =
            "csm:cascades=3:size=1024:filter=7:split=log:far=90:blend=0.2:static=cached:bias=2:slope=0.25";
        let found = settings(text).unwrap().unwrap();
        let MapFit::Cascades(c) = found.fit else { panic!("{found:?}") };
        assert_eq!((c.cascades, c.split, c.far_world, c.blend), (3, Split::Logarithmic, Some(90.0), 0.2));
        assert_eq!(found.filter, MapFilter::Pcf { width: 7 });
        assert!(found.cache_static && found.size == 1024);
        assert_eq!((found.bias.constant_texels, found.bias.slope_texels), (2.0, 0.25));
    }

    #[test]
    fn spec_refuses_what_does_not_fit() {
        for text in [
            "sm:filter=3",
            "csm:cascades=9",
            "vsm:blur=4",
            "evsm:positive=43",
            "pcf:size=1000",
            "sm:depth=24",
            "pcf:filter=4",
            "csm:far=1e-300",
        ] {
            assert!(settings(text).is_err(), "{text}");
        }
    }
}
