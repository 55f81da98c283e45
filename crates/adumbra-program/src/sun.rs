//! The sun of a run, and where it comes from: the options, a file that determines it, the scene's own lights,
//! or the default.

use std::fmt;
use std::path::Path;

use adumbra::Sun;
use adumbra_scene::Scene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Direction towards the sun where nothing else gives one.
pub const DEFAULT_SUN: [f64; 3] = [0.5, 0.8, 0.35];

/// A direction with a component from this size on is shown with length 1.
const LONG: f64 = 1e6;

/// Where the direction of a sun comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SunSource {
    /// From `--sun`, or from `--azimuth` and `--elevation`.
    Option,
    /// From the shadow file.
    ShadowFile,
    /// From the file of the camera or of the truth.
    CameraFile,
    /// From the middle of the day that the sun is moved across.
    SunSweep,
    /// From a directional light of the scene.
    Light,
    /// From nothing: it is the default.
    Default,
}

/// Where the direction of a sun comes from, with the light's name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct SunOrigin {
    /// What gave the direction.
    pub source: SunSource,
    /// The name of the scene's light. Null unless the source is `light`.
    pub light: Option<String>,
}

impl From<SunSource> for SunOrigin {
    fn from(source: SunSource) -> Self {
        Self { source, light: None }
    }
}

impl fmt::Display for SunOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.source, &self.light) {
            (SunSource::Option, _) => f.write_str("--sun"),
            (SunSource::ShadowFile, _) => f.write_str("of the shadow file"),
            (SunSource::CameraFile, _) => f.write_str("of the camera's file"),
            (SunSource::SunSweep, _) => f.write_str("of the middle of the sweep"),
            (SunSource::Light, Some(name)) => write!(f, "light {name:?} of the scene"),
            (SunSource::Light, None) => f.write_str("light of the scene"),
            (SunSource::Default, _) => f.write_str("default"),
        }
    }
}

/// The sun of a run.
#[derive(Clone, Debug)]
pub struct ChosenSun {
    /// The sun.
    pub sun: Sun,
    /// Where it comes from.
    pub origin: SunOrigin,
    /// The direction as it was given, of any length.
    towards: [f64; 3],
}

impl ChosenSun {
    /// Returns a sun that does not come from the scene.
    pub fn from_source(sun: Sun, source: SunSource) -> Self {
        Self { sun, origin: source.into(), towards: sun.towards() }
    }

    /// Returns a sun in a direction of any length.
    pub(crate) fn from_direction(towards: [f64; 3], origin: SunOrigin) -> Result<Self, adumbra::Error> {
        Ok(Self { sun: Sun::from_direction(towards)?, origin, towards })
    }
}

impl fmt::Display for ChosenSun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_long = self.towards.iter().any(|c| c.abs() >= LONG);
        let towards = if is_long { self.sun.towards() } else { self.towards };
        // Adding 0 turns -0 into 0.
        let [x, y, z] = towards.map(|c| (c * 1e4).round() / 1e4 + 0.0);
        write!(f, "sun {x},{y},{z} ({})", self.origin)
    }
}

/// Returns the sun of a scene if nothing else determines it: its first directional light that shines and is
/// above the horizon, or the default. Also returns one message for each earlier light that cannot be the sun.
///
/// # Errors
///
/// Returns no error in practice, because the default sun is above the horizon.
pub fn sun_of_scene(scene: &Scene) -> Result<(ChosenSun, Vec<String>), adumbra::Error> {
    let mut messages = Vec::new();
    for light in &scene.suns {
        let origin = SunOrigin { source: SunSource::Light, light: Some(light.name.clone()) };
        match Sun::from_direction(light.towards) {
            Ok(sun) => return Ok((ChosenSun { sun, origin, towards: sun.towards() }, messages)),
            Err(error) => messages.push(format!("the light {:?} cannot be the sun: {error}", light.name)),
        }
    }
    Ok((ChosenSun::from_direction(DEFAULT_SUN, SunSource::Default.into())?, messages))
}

/// Like [`sun_of_scene`], but prints the messages on stderr. `path` is the scene's.
///
/// # Errors
///
/// Returns the errors of [`sun_of_scene`].
pub fn sun_of_scene_with_warnings(scene: &Scene, path: &Path) -> Result<ChosenSun, adumbra::Error> {
    let (sun, messages) = sun_of_scene(scene)?;
    for message in messages {
        crate::note!("warning: {}: {message}", path.display());
    }
    Ok(sun)
}

/// Elevation below which level ground comes close to the steepest plane that look-ups follow, degrees.
const LOWEST_SUN_DEGREES: f64 = 1.0;

/// Warns on stderr of a sun under which look-ups on level ground are inexact.
pub fn warn_of_low_sun(sun: &Sun) {
    if sun.elevation_degrees() < LOWEST_SUN_DEGREES {
        crate::note!(
            "warning: the sun is {:.2}° above the horizon; below {LOWEST_SUN_DEGREES}° level ground is too steep relative to the light for exact look-ups; check the file with verify",
            sun.elevation_degrees()
        );
    }
}

#[cfg(test)]
mod tests {
    use adumbra_scene::FileSun;

    use super::*;

    fn lit_by(lights: &[(&str, [f64; 3])]) -> Scene {
        let suns = lights.iter().map(|&(name, towards)| FileSun { name: name.to_owned(), towards });
        Scene { suns: suns.collect(), ..Scene::default() }
    }

    #[test]
    fn first_light_above_the_horizon_is_the_sun() {
        let default = Sun::from_direction(DEFAULT_SUN).unwrap();
        for (lights, towards, said, refused) in [
            (&[][..], default.towards(), "sun 0.5,0.8,0.35 (default)", 0),
            (&[("Sun", [0.0, 1.0, 0.0])], [0.0, 1.0, 0.0], "sun 0,1,0 (light \"Sun\" of the scene)", 0),
            (
                &[("a", [0.6, 0.8, 0.0]), ("b", [0.0, 1.0, 0.0])],
                [0.6, 0.8, 0.0],
                "sun 0.6,0.8,0 (light \"a\" of the scene)",
                0,
            ),
            (
                &[("up", [0.0, -1.0, 0.0]), ("b", [0.0, 1.0, 0.0])],
                [0.0, 1.0, 0.0],
                "sun 0,1,0 (light \"b\" of the scene)",
                1,
            ),
            (
                &[("level", [1.0, 0.0, 0.0]), ("nan", [f64::NAN; 3])],
                default.towards(),
                "sun 0.5,0.8,0.35 (default)",
                2,
            ),
        ] {
            let (chosen, messages) = sun_of_scene(&lit_by(lights)).unwrap();
            let off =
                chosen.sun.towards().iter().zip(towards).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{lights:?}: {:?}", chosen.sun.towards());
            assert_eq!(chosen.to_string(), said);
            assert_eq!(messages.len(), refused, "{messages:?}");
            let named = lights.iter().zip(&messages).all(|((name, _), message)| message.contains(name));
            assert!(named, "{messages:?}");
        }
    }
}
