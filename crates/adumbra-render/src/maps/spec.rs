//! Parsing of settings from a technique's text:
//! `csm:cascades=4:size=2048:filter=5:split=practical:lambda=0.5:static=cached`.

use super::help;
use super::params::{
    CascadeSettings, DepthPrecision, MapBias, MapCasters, MapFilter, MapFit, MapSettings, MomentKind,
    MomentSettings, Split,
};
use crate::error::Result;
use crate::technique::{SpecReader, SpecText};

const SIZES: &[u32] = &[128, 256, 512, 1024, 2048, 4096, 8192, 16384];

/// A shadow-map technique: the placement of its layers and its kind of look-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapKind {
    cascades: bool,
    look_up: MapLookUp,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MapLookUp {
    Nearest,
    Comparisons,
    Penumbrae,
    Moments(MomentKind),
}

impl MapKind {
    pub(crate) const NEAREST: Self = Self::whole(MapLookUp::Nearest);
    pub(crate) const PCF: Self = Self::whole(MapLookUp::Comparisons);
    pub(crate) const PCSS: Self = Self::whole(MapLookUp::Penumbrae);
    pub(crate) const VSM: Self = Self::whole(MapLookUp::Moments(MomentKind::Variance));
    pub(crate) const EVSM: Self = Self::whole(MapLookUp::Moments(MomentKind::ExponentialVariance));
    pub(crate) const MSM: Self = Self::whole(MapLookUp::Moments(MomentKind::FourMoments));
    pub(crate) const CSM: Self = Self::cascades(MapLookUp::Comparisons);
    pub(crate) const CSM_VSM: Self = Self::cascades(MapLookUp::Moments(MomentKind::Variance));
    pub(crate) const CSM_EVSM: Self = Self::cascades(MapLookUp::Moments(MomentKind::ExponentialVariance));

    /// One layer over the whole scene.
    const fn whole(look_up: MapLookUp) -> Self {
        Self { cascades: false, look_up }
    }

    const fn cascades(look_up: MapLookUp) -> Self {
        Self { cascades: true, look_up }
    }
}

impl MapSettings {
    /// Parses the settings of a technique of this kind.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if a value is out of range or a key is unknown.
    pub(crate) fn from_spec(spec: &SpecText, kind: MapKind) -> Result<Self> {
        spec.read(|reader| Self::from_reader(reader, kind))
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>, kind: MapKind) -> Result<Self> {
        let fit = if kind.cascades { MapFit::Cascades(cascades(reader)?) } else { MapFit::Scene };
        let filter = match kind.look_up {
            MapLookUp::Nearest => MapFilter::Nearest,
            // Cascades offer the nearest texel as a filter. For a single map that is a technique of its own.
            MapLookUp::Comparisons if kind.cascades => {
                comparisons(reader, &["5", "1", "2", "3", "7", "poisson"])?
            }
            MapLookUp::Comparisons => comparisons(reader, &["5", "2", "3", "7", "poisson"])?,
            MapLookUp::Penumbrae => MapFilter::Pcss {
                sun_degrees: reader.number("sun-degrees", help::SUN_DEGREES, 0.53, 0.01..=20.0)?,
                max_radius: reader.number("radius", help::PENUMBRA_RADIUS, 32.0, 1.0..=256.0)?,
            },
            MapLookUp::Moments(kind) => moments(reader, kind)?,
        };
        Ok(Self {
            size: reader.integer("size", "texels per side of a layer", 2048, SIZES)?,
            depth: DepthPrecision::from_reader(reader)?,
            fit,
            filter,
            bias: MapBias::from_reader(reader, &filter)?,
            cache_static: cache_static(reader)?,
            casters: MapCasters::All,
        })
    }
}

/// Reads the key `static`, which hybrid maps have too.
pub(crate) fn cache_static(reader: &mut SpecReader<'_>) -> Result<bool> {
    let what = "static casters: redrawn every frame, or kept until the light or the layer moves";
    Ok(reader.choice("static", what, &["redrawn", "cached"])? == "cached")
}

impl DepthPrecision {
    pub(crate) fn from_reader(reader: &mut SpecReader<'_>) -> Result<Self> {
        Ok(match reader.choice("depth", "bits per depth", &["32", "16"])? {
            "16" => Self::Bits16,
            _ => Self::Bits32,
        })
    }
}

impl MapBias {
    /// Reads the bias. Keys that are not given take the filter's default.
    pub(crate) fn from_reader(reader: &mut SpecReader<'_>, filter: &MapFilter) -> Result<Self> {
        let usual = Self::for_filter(filter);
        Ok(Self {
            constant_texels: reader.number("bias", help::BIAS, usual.constant_texels, 0.0..=16.0)?,
            slope_texels: reader.number("slope", help::SLOPE, usual.slope_texels, 0.0..=16.0)?,
            normal_offset_texels: reader.number(
                "normal",
                help::NORMAL,
                usual.normal_offset_texels,
                0.0..=16.0,
            )?,
            ..usual
        })
    }
}

fn cascades(reader: &mut SpecReader<'_>) -> Result<CascadeSettings> {
    let usual = CascadeSettings::default();
    let lambda = "with split=practical: share of the logarithmic split";
    let far = "view depth where shadows end, world units; by default the farthest depth of the scene in view, rounded up to a power of two";
    Ok(CascadeSettings {
        cascades: reader.count("cascades", "number of layers", usual.cascades, 1..=8)?,
        split: match reader.choice(
            "split",
            "how cascades divide the view depth",
            &["practical", "uniform", "log"],
        )? {
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
        reader.choice("filter", "texels per side that are compared; poisson: 16 of a disc", choices)?;
    Ok(match filter.parse() {
        Ok(1) => MapFilter::Nearest,
        Ok(width) => MapFilter::Pcf { width },
        Err(_) => MapFilter::Poisson {
            radius: reader.number("radius", "radius of the disc, texels", 2.0, 0.5..=32.0)?,
        },
    })
}

fn moments(reader: &mut SpecReader<'_>, kind: MomentKind) -> Result<MapFilter> {
    let usual = MomentSettings::new(kind);
    let odd: Vec<u32> = (0..16).map(|i| 2 * i + 1).collect();
    let exponents = if kind == MomentKind::ExponentialVariance {
        [
            reader.number("positive", "exponent of the positive depth warp", 40.0, 1.0..=42.0)?,
            reader.number("negative", "exponent of the negative depth warp", 5.0, 1.0..=42.0)?,
        ]
    } else {
        usual.exponents
    };
    let bleed = "share of the tail that counts as shadow; more reduces light bleeding but hardens edges";
    let deviation = "minimum standard deviation of depth, texels";
    Ok(MapFilter::Moments(MomentSettings {
        blur: reader.integer(
            "blur",
            "width of the Gaussian blur of the map, texels, odd",
            usual.blur,
            &odd,
        )?,
        bleed: reader.number("bleed", bleed, usual.bleed, 0.0..=0.9)?,
        min_deviation_texels: reader.number(
            "deviation",
            deviation,
            usual.min_deviation_texels,
            0.0..=16.0,
        )?,
        exponents,
        ..usual
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(kind: MapKind, text: &str) -> Result<MapSettings> {
        MapSettings::from_spec(&text.parse()?, kind)
    }

    #[test]
    fn spec_gives_settings_for_every_kind() {
        let whole =
            [MapKind::NEAREST, MapKind::PCF, MapKind::PCSS, MapKind::VSM, MapKind::EVSM, MapKind::MSM];
        for kind in [&whole[..], &[MapKind::CSM, MapKind::CSM_VSM, MapKind::CSM_EVSM]].concat() {
            let found = settings(kind, "map").unwrap();
            assert_eq!((found.size, found.cache_static), (2048, false), "{kind:?}");
            assert_eq!(found.depth, DepthPrecision::Bits32, "{kind:?}");
            let halved = settings(kind, "map:depth=16").unwrap();
            assert_eq!(halved, MapSettings { depth: DepthPrecision::Bits16, ..found });
            assert_eq!(found.layers(), if whole.contains(&kind) { 1 } else { 4 });
        }
    }

    #[test]
    fn spec_reads_every_key_of_cascades() {
        let text =
            "csm:cascades=3:size=1024:filter=7:split=log:far=90:blend=0.2:static=cached:bias=2:slope=0.25";
        let found = settings(MapKind::CSM, text).unwrap();
        let MapFit::Cascades(c) = found.fit else { panic!("{found:?}") };
        assert_eq!((c.cascades, c.split, c.far_world, c.blend), (3, Split::Logarithmic, Some(90.0), 0.2));
        assert_eq!(found.filter, MapFilter::Pcf { width: 7 });
        assert!(found.cache_static && found.size == 1024);
        assert_eq!((found.bias.constant_texels, found.bias.slope_texels), (2.0, 0.25));
    }

    #[test]
    fn spec_rejects_invalid_values() {
        for (kind, text) in [
            (MapKind::NEAREST, "sm:filter=3"),
            (MapKind::CSM, "csm:cascades=9"),
            (MapKind::VSM, "vsm:blur=4"),
            (MapKind::EVSM, "evsm:positive=43"),
            (MapKind::PCF, "pcf:size=1000"),
            (MapKind::NEAREST, "sm:depth=24"),
            (MapKind::PCF, "pcf:filter=4"),
            (MapKind::CSM, "csm:far=1e-300"),
        ] {
            assert!(settings(kind, text).is_err(), "{text}");
        }
    }
}
