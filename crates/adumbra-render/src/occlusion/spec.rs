//! Parsing of ambient-occlusion settings from text: `issao:radius=4:half=on`.

use adumbra_shaders::constants::{OCCLUSION_MAX_SIDE, OCCLUSION_MAX_TAPS};

use super::estimator::Estimator;
use super::settings::{Filter, Normals, OcclusionSettings};
use crate::error::Result;
use crate::technique::{Parameter, SpecReader, SpecText, changed};

/// Largest number of rays per pixel of `truth`.
const MAX_RAYS: u32 = 65_536;

impl OcclusionSettings {
    /// Parses `NAME[:key=value…]`. `default_radius_world` applies if there is no `radius`.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if a name, a parameter or a value does not exist.
    pub fn from_spec(spec: &SpecText, default_radius_world: f64) -> Result<Self> {
        spec.read(|reader| Self::from_reader(reader, default_radius_world))
    }

    fn from_reader(r: &mut SpecReader<'_>, default_radius_world: f64) -> Result<Self> {
        let spec = r.spec();
        let Some(estimator) = Estimator::ALL.into_iter().find(|e| e.name() == spec.name()) else {
            let names: Vec<&str> = Estimator::ALL.iter().map(|e| e.name()).collect();
            let names = names.join(", ");
            return Err(spec.wrong(format!("unknown ambient occlusion; choose one of: {names}, truth, none")));
        };
        let mut s = Self::new(estimator, default_radius_world);
        s.radius_world = radius(r, s.radius_world)?;
        s.samples = r.count("samples", "taps per pixel", s.samples, 1..=OCCLUSION_MAX_TAPS)?;
        s.cap_texels = r.number("cap", "largest radius on the screen, texels", s.cap_texels, 1.0..=4096.0)?;
        let what = "fewer taps where the radius covers few pixels (issao)";
        s.levels = r.choice("levels", what, &["on", "off"])? == "on";
        let what = "normals of the G-buffer, or computed from depth";
        s.normals = match r.choice("normals", what, &["gbuffer", "depth"])? {
            "gbuffer" => Normals::GBuffer,
            _ => Normals::Depth,
        };
        let what = "two passes that respect depth, the square, two passes that ignore depth, or none";
        s.filter = match r.choice("filter", what, &["bilateral", "square", "gauss", "none"])? {
            "bilateral" => Filter::Bilateral,
            "square" => Filter::BilateralSquare,
            "gauss" => Filter::Gauss,
            _ => Filter::None,
        };
        let what = "neighbours on either side that the filter reads";
        s.filter_side = r.count("side", what, s.filter_side, 1..=OCCLUSION_MAX_SIDE)?;
        s.sigma_texels =
            r.number("blur", "the filter's standard deviation, texels", s.sigma_texels, 0.1..=16.0)?;
        s.sigma_depth = r.number(
            "sharpness",
            "the filter's standard deviation of view depth, radii",
            s.sigma_depth,
            1e-4..=100.0,
        )?;
        let what = "what the filter compares depth with: the pixel's surface, extrapolated, or its depth";
        s.planes = r.choice("depth", what, &["plane", "plain"])? == "plane";
        s.edge_test = r.choice("edges", "skip pixels that need no filter", &["off", "on"])? == "on";
        s.half = r.choice("half", "estimate at half the width and height", &["off", "on"])? == "on";
        let what = "reuse what is still valid of earlier frames";
        s.reuse = r.choice("reuse", what, &["off", "on"])? == "on";
        s.frames =
            r.count("frames", "with reuse=on: largest number of frames in the mean", s.frames, 1..=64)?;
        let preset = if estimator == Estimator::Issao { preset(r)? } else { &[] };
        for (value, p) in s.shape.iter_mut().zip(estimator.parameters()) {
            let default = preset.iter().find(|(name, _)| *name == p.name).map_or(p.default, |(_, v)| *v);
            *value = if p.words.is_empty() {
                r.number(p.name, p.what, default, p.range[0]..=p.range[1])?
            } else {
                r.place(p.name, p.what, default as usize, p.words)? as f64
            };
        }
        Ok(s)
    }
}

/// Settings of ray-traced ambient visibility: `truth`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedSettings {
    /// Distance beyond which nothing occludes, world units.
    pub radius_world: f64,
    /// Rays per pixel, 1 to 65,536.
    pub rays: u32,
}

impl TracedSettings {
    /// Parses `truth[:radius=R][:rays=N]`. `default_radius_world` applies if there is no `radius`.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if a parameter or a value does not exist.
    pub fn from_spec(spec: &SpecText, default_radius_world: f64) -> Result<Self> {
        spec.read(|reader| Self::from_reader(reader, default_radius_world))
    }

    fn from_reader(r: &mut SpecReader<'_>, default_radius_world: f64) -> Result<Self> {
        let radius_world = radius(r, default_radius_world)?;
        Ok(Self { radius_world, rays: r.count("rays", "rays per pixel", 256, 1..=MAX_RAYS)? })
    }
}

/// Settings of ambient occlusion, for any name of [`super::OCCLUSIONS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AmbientSettings {
    /// `none`: open sky.
    Open,
    /// `truth`: rays on the CPU.
    Traced(TracedSettings),
    /// A screen-space estimator.
    Estimated(OcclusionSettings),
}

impl AmbientSettings {
    /// Parses `NAME[:key=value…]`. `default_radius_world` applies if there is no `radius`.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if a name, a parameter or a value does not exist.
    pub fn from_spec(spec: &SpecText, default_radius_world: f64) -> Result<Self> {
        spec.read(|reader| Self::from_reader(reader, default_radius_world))
    }

    fn from_reader(reader: &mut SpecReader<'_>, default_radius_world: f64) -> Result<Self> {
        Ok(match reader.spec().name() {
            "none" => Self::Open,
            "truth" => Self::Traced(TracedSettings::from_reader(reader, default_radius_world)?),
            _ => Self::Estimated(OcclusionSettings::from_reader(reader, default_radius_world)?),
        })
    }
}

fn radius(r: &mut SpecReader<'_>, default_world: f64) -> Result<f64> {
    r.number("radius", "nothing farther away than this occludes, world units", default_world, 0.0..=1e9)
}

/// Returns the parameters of an ambient occlusion of [`super::OCCLUSIONS`] with their values in `spec`.
/// `default_radius_world` is as in [`OcclusionSettings::from_spec`].
///
/// # Errors
/// Returns [`crate::RenderError::Technique`] if a name, a parameter or a value does not exist.
pub fn describe(spec: &SpecText, default_radius_world: f64) -> Result<Vec<Parameter>> {
    let mut reader = spec.reader();
    read(&mut reader, default_radius_world)?;
    reader.finish()
}

/// [`crate::TechniqueSpec::change`] for ambient occlusion.
///
/// # Errors
/// Returns the errors of [`describe`].
pub fn change(spec: &SpecText, default_radius_world: f64, key: &str, value: &str) -> Result<SpecText> {
    changed(spec, key, value, |reader| read(reader, default_radius_world))
}

fn read(reader: &mut SpecReader<'_>, default_radius_world: f64) -> Result<()> {
    AmbientSettings::from_reader(reader, default_radius_world).map(drop)
}

/// The settings that the paper published for its figures 3, 4 and 5, converted to radii. With v = R w its
/// equation takes λ / R and σ / R², while φ and ψ are unchanged. The radius itself is not preset, because the
/// paper's R is in the units of unpublished scenes.
fn preset(r: &mut SpecReader<'_>) -> Result<&'static [(&'static str, f64)]> {
    Ok(
        match r.choice(
            "preset",
            "the settings published with these figures",
            &["none", "fig3", "fig4", "fig5"],
        )? {
            "fig3" => &const { published(1.75, 0.40, 0.022, 1.06, 0.000_16) },
            "fig4" => &const { published(1.05, 0.43, 0.014, 1.00, 0.000_19) },
            "fig5" => &const { published(2.20, 0.55, 0.018, 1.00, 0.000_15) },
            _ => &[],
        },
    )
}

const fn published(radius: f64, phi: f64, psi: f64, lambda: f64, sigma: f64) -> [(&'static str, f64); 5] {
    [
        ("lambda", lambda / radius),
        ("phi", phi),
        ("psi", psi),
        ("sigma", sigma / (radius * radius)),
        ("reading", 1.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occlusion::OCCLUSIONS;
    use crate::technique::parameter::tests::holds;

    #[test]
    fn accepts_defaults_and_range_ends_but_nothing_beyond() {
        for text in OCCLUSIONS.iter().map(|(name, _)| *name).chain(["issao:preset=fig4", "gtao:power=2"]) {
            holds(&text.parse().unwrap(), |spec| describe(spec, 0.7));
        }
        assert!(describe(&"none:radius=1".parse().unwrap(), 1.0).is_err());
        assert!(describe(&"unknown".parse().unwrap(), 1.0).is_err());
    }

    #[test]
    fn describe_matches_the_settings() {
        let spec: SpecText = "issao:preset=fig4:radius=2:before=nothing".parse().unwrap();
        let settings = OcclusionSettings::from_spec(&spec, 1.0).unwrap();
        let described = describe(&spec, 1.0).unwrap();
        for p in settings.estimator.parameters() {
            let value = &described.iter().find(|t| t.key == p.name).unwrap().value;
            let place = p.words.iter().position(|w| w == value).map(|i| i as f64);
            assert_eq!(place.or_else(|| value.parse().ok()), Some(settings.parameter(p.name)), "{}", p.name);
        }
        let changed_keys: Vec<&str> = described.iter().filter(|p| !p.is_default()).map(|p| p.key).collect();
        assert_eq!(changed_keys, ["radius", "preset", "before"]);
    }

    #[test]
    fn change_writes_the_shortest_text() {
        for (text, key, value, expected) in [
            ("issao:radius=2", "radius", "1", "issao"),
            ("issao", "half", "on", "issao:half=on"),
            ("issao:lambda=0.5", "preset", "fig3", "issao:lambda=0.5:preset=fig3"),
            ("truth", "rays", "64", "truth:rays=64"),
        ] {
            assert_eq!(change(&text.parse().unwrap(), 1.0, key, value).unwrap().to_string(), expected);
        }
        assert!(change(&"ssao".parse().unwrap(), 1.0, "preset", "fig3").is_err());
    }
}
