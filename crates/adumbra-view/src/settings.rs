//! The settings of a view, as plain data. Commands change them without a window or a device.

use adumbra::Sun;
use adumbra::stream::StreamOptions;
use adumbra_render::layers::Layer;
use adumbra_render::occlusion::{self, OCCLUSIONS};
use adumbra_render::{Reads, RenderError, SpecText, TECHNIQUES, TechniqueSpec};
use adumbra_scene::{Camera, Projection};

use crate::command::{Command, Side};
use crate::navigation;

/// Largest number of samples per pixel along each side.
const MAX_ANTIALIAS: u32 = 4;

/// How the two techniques are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shown {
    /// The first technique alone.
    Single,
    /// The first technique left of a divider at this fraction of the width, the second right of it.
    Split(f64),
    /// Red where the second technique is darker, blue where it is brighter, multiplied by this gain.
    Difference(f32),
}

/// The settings of a view.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The shadow techniques of both sides.
    pub shadows: [TechniqueSpec; 2],
    /// Ambient occlusion, used for both sides.
    pub ambient: SpecText,
    /// The layer of the frames to show.
    pub layer: Layer,
    /// How both sides are shown.
    pub shown: Shown,
    /// The sun.
    pub sun: Sun,
    /// The camera; its size is that of the picture, in pixels.
    pub camera: Camera,
    /// Whether there is a rolling ball.
    pub ball: bool,
    /// Seconds since all movements began.
    pub seconds: f64,
    /// Whether time runs.
    pub playing: bool,
    /// Whether the bounds of the shadow file's space are drawn as lines.
    pub show_box: bool,
    /// Whether the panel is shown.
    pub show_panel: bool,
    /// Whether the help is shown.
    pub show_help: bool,
    /// Samples per pixel along each side.
    pub antialias: u32,
    /// Whether frames are drawn continuously.
    pub continuous: bool,
    /// Resolution of bakes, in texels on the longest side.
    pub resolution: u64,
    /// Budget of shadow files in MiB: a file that needs more is streamed.
    pub budget_mib: u64,
    /// Number of frames over which pages of a streamed file fade in and out; 0 switches them at once.
    pub fade_frames: u32,
}

impl Settings {
    /// Returns how a shadow file is streamed.
    pub(crate) fn stream_options(&self) -> StreamOptions {
        StreamOptions {
            budget_bytes: self.budget_mib << 20,
            fade_frames: self.fade_frames,
            ..StreamOptions::default()
        }
    }

    /// Returns the technique of a side.
    pub fn shadow(&self, side: Side) -> &TechniqueSpec {
        &self.shadows[side as usize]
    }

    /// Whether both sides are visible.
    pub(crate) fn shows_both(&self) -> bool {
        self.shown != Shown::Single
    }

    /// Whether a visible technique is ray-traced.
    pub(crate) fn uses_traced(&self) -> bool {
        self.seen().iter().any(TechniqueSpec::is_traced)
    }

    /// Whether a visible technique reads a shadow file.
    pub(crate) fn uses_file(&self) -> bool {
        self.seen().iter().any(|s| s.reads() == Reads::LightFile)
    }

    /// Returns the visible techniques.
    pub(crate) fn seen(&self) -> &[TechniqueSpec] {
        if self.shows_both() { &self.shadows } else { &self.shadows[..1] }
    }

    /// Applies a command. Returns false if the command does not change a setting but does something else,
    /// such as a screenshot.
    ///
    /// # Errors
    /// Returns a message if the command is invalid. Then nothing has changed.
    pub fn apply(&mut self, command: &Command) -> Result<bool, String> {
        match command {
            Command::Shadow { side, technique } => {
                self.shadows[*side as usize] = shadow(technique)?;
            }
            Command::NextShadow { side, by } => {
                let names: Vec<&str> = shadow_names().collect();
                let next = further(&names, self.shadow(*side).name(), *by);
                self.shadows[*side as usize] = shadow(next)?;
            }
            Command::Ao(name) => self.ambient = ambient(name)?,
            Command::NextAo(by) => {
                let names: Vec<&str> = OCCLUSIONS.iter().map(|(name, _)| *name).collect();
                self.ambient = ambient(further(&names, self.ambient.name(), *by))?;
            }
            Command::Layer(name) => self.layer = layer(name)?,
            Command::NextLayer(by) => {
                let names = Layer::ALL.map(Layer::name);
                self.layer = layer(further(&names, self.layer.name(), *by))?;
            }
            Command::ChangeSides => self.shadows.swap(0, 1),
            Command::Single => self.shown = Shown::Single,
            Command::Split(at) => self.shown = Shown::Split(within("split", *at, 0.0, 1.0)?),
            Command::Difference(gain) => {
                self.shown = Shown::Difference(within("difference", f64::from(*gain), 1e-3, 1e3)? as f32);
            }
            Command::Sun { azimuth, elevation } => {
                self.sun = Sun::from_angles(*azimuth, *elevation).map_err(|e| e.to_string())?;
            }
            Command::TurnSun { azimuth, elevation } => {
                let by = [finite("sun", *azimuth)?, finite("sun", *elevation)?];
                self.sun = navigation::turn_sun(&self.sun, by);
            }
            Command::Camera { .. }
            | Command::Orbit(_)
            | Command::Look(_)
            | Command::Pan(_)
            | Command::Fly(_)
            | Command::Zoom(_) => self.move_camera(command)?,
            Command::Ball(on) => self.ball = *on,
            Command::Time(seconds) => self.seconds = finite("time", *seconds)?,
            Command::Play(on) => self.playing = *on,
            Command::Box(on) => self.show_box = *on,
            Command::Panel(on) => self.show_panel = *on,
            Command::Help(on) => self.show_help = *on,
            Command::Continuous(on) => self.continuous = *on,
            Command::Antialias(samples) => {
                if !(1..=MAX_ANTIALIAS).contains(samples) {
                    return Err(format!("antialias {samples}: give 1 to {MAX_ANTIALIAS}"));
                }
                self.antialias = *samples;
            }
            Command::Bake(resolution) => {
                if !resolution.is_power_of_two() || !(512..=1 << 18).contains(resolution) {
                    return Err(format!("bake {resolution}: give a power of two from 512 to 262144"));
                }
                self.resolution = *resolution;
            }
            Command::Budget(mib) => {
                if !(1..=8192).contains(mib) {
                    return Err(format!("budget {mib}: give 1 to 8192 MiB"));
                }
                self.budget_mib = *mib;
            }
            Command::LoadCamera(_)
            | Command::Hour(_)
            | Command::ResetCamera
            | Command::ResetSun
            | Command::ResetAll
            | Command::WatchBall
            | Command::CancelBake
            | Command::Drop(_)
            | Command::Resize(_)
            | Command::Screenshot(_)
            | Command::WindowShot(_)
            | Command::SaveCamera(_)
            | Command::Key(_)
            | Command::SayLine
            | Command::Quit => return Ok(false),
        }
        Ok(true)
    }

    fn move_camera(&mut self, command: &Command) -> Result<(), String> {
        let mut camera = self.camera;
        match command {
            Command::Camera { eye, target, fov } => {
                if eye == target {
                    return Err("camera: eye and target must differ".to_owned());
                }
                (camera.eye, camera.target) = (*eye, *target);
                if let Some(fov) = fov {
                    if !(*fov > 0.0 && *fov < 180.0) {
                        return Err(format!("camera: fov {fov}: give degrees between 0 and 180"));
                    }
                    camera.projection = Projection::Perspective { fov_degrees: *fov };
                }
            }
            Command::Orbit(degrees) => navigation::orbit(&mut camera, *degrees),
            Command::Look(degrees) => navigation::look(&mut camera, *degrees),
            Command::Pan(shares) => navigation::pan(&mut camera, *shares),
            Command::Fly(distances) => navigation::fly(&mut camera, *distances),
            Command::Zoom(factor) => navigation::zoom(&mut camera, within("zoom", *factor, 1e-3, 1e3)?),
            _ => return Ok(()),
        }
        if !camera.eye.iter().chain(&camera.target).all(|c| c.is_finite()) || camera.eye == camera.target {
            return Err("the camera's eye and target must be finite and differ".to_owned());
        }
        self.camera = camera;
        Ok(())
    }
}

/// Names of all shadow techniques that a side may show, ray tracing last.
pub(crate) fn shadow_names() -> impl Iterator<Item = &'static str> {
    TECHNIQUES.iter().map(|t| t.name)
}

fn further<'n>(names: &[&'n str], name: &str, by: i32) -> &'n str {
    let at = names.iter().position(|n| *n == name).unwrap_or(0) as i32;
    names[(at + by).rem_euclid(names.len() as i32) as usize]
}

fn shadow(text: &str) -> Result<TechniqueSpec, String> {
    text.parse().map_err(|e: RenderError| e.to_string())
}

fn ambient(text: &str) -> Result<SpecText, String> {
    let spec: SpecText = text.parse().map_err(|e| format!("{e}"))?;
    if !OCCLUSIONS.iter().any(|(name, _)| *name == spec.name()) {
        let names: Vec<&str> = OCCLUSIONS.iter().map(|(name, _)| *name).collect();
        return Err(format!("unknown ambient occlusion {text}; choose one of: {}", names.join(", ")));
    }
    occlusion::describe(&spec, 1.0).map_err(|e| e.to_string())?;
    Ok(spec)
}

fn layer(name: &str) -> Result<Layer, String> {
    let found = Layer::ALL.into_iter().find(|l| l.name() == name);
    found.ok_or_else(|| {
        format!("unknown layer {name}; choose one of: {}", Layer::ALL.map(Layer::name).join(", "))
    })
}

fn finite(what: &str, value: f64) -> Result<f64, String> {
    if value.is_finite() { Ok(value) } else { Err(format!("{what} {value}: give a number")) }
}

fn within(what: &str, value: f64, least: f64, most: f64) -> Result<f64, String> {
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{what} {value}: give a number from {least} to {most}"))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn settings() -> Settings {
        Settings {
            shadows: ["voxel", "csm:cascades=3"].map(|s| s.parse().unwrap()),
            ambient: "none".parse().unwrap(),
            layer: Layer::Color,
            shown: Shown::Single,
            sun: Sun::from_angles(30.0, 40.0).unwrap(),
            camera: Camera {
                eye: [0.0, 5.0, 10.0],
                target: [0.0; 3],
                projection: Projection::Perspective { fov_degrees: 45.0 },
                width: 320,
                height: 200,
            },
            ball: false,
            seconds: 0.0,
            playing: false,
            show_box: false,
            show_panel: true,
            show_help: false,
            antialias: 1,
            continuous: false,
            resolution: 8192,
            budget_mib: 64,
            fade_frames: 0,
        }
    }

    #[test]
    fn commands_change_their_settings() {
        let mut s = settings();
        let csm = Command::Shadow { side: Side::Second, technique: "vsm:blur=5".to_owned() };
        for command in [
            csm,
            Command::Ao("issao:radius=2".to_owned()),
            Command::Layer("hrsm-levels".to_owned()),
            Command::Split(0.25),
            Command::Sun { azimuth: 90.0, elevation: 10.0 },
            Command::Antialias(2),
            Command::Bake(1024),
            Command::Box(true),
        ] {
            assert_eq!(s.apply(&command), Ok(true), "{command:?}");
        }
        assert_eq!(s.shadow(Side::Second).to_string(), "vsm:blur=5");
        assert_eq!((s.ambient.name(), s.layer, s.shown), ("issao", Layer::HybridLevels, Shown::Split(0.25)));
        assert!((s.sun.elevation_degrees() - 10.0).abs() < 1e-9 && s.sun.towards()[0] > 0.9);
        assert_eq!((s.antialias, s.resolution, s.show_box), (2, 1024, true));
        assert_eq!((s.uses_file(), s.uses_traced()), (true, false));
        s.shadows = ["csm", "blur:base=voxel/filter=3"].map(|text| text.parse().unwrap());
        assert!(s.uses_file());
        s.shadows = ["csm", "truth"].map(|text| text.parse().unwrap());
        assert_eq!((s.uses_file(), s.uses_traced()), (false, true));
        s.shown = Shown::Single;
        assert!(!s.uses_traced());
    }

    #[test]
    fn wrong_commands_change_nothing() {
        let shadow = |text: &str| Command::Shadow { side: Side::First, technique: text.to_owned() };
        for command in [
            shadow("smm"),
            shadow("voxel:filtr=9"),
            shadow("csm:cascades=9"),
            Command::Ao("blurry".to_owned()),
            Command::Ao("issao:radius=no".to_owned()),
            Command::Layer("x-ray".to_owned()),
            Command::Split(1.5),
            Command::Difference(f32::NAN),
            Command::Sun { azimuth: 0.0, elevation: -5.0 },
            Command::Camera { eye: [1.0; 3], target: [1.0; 3], fov: None },
            Command::Camera { eye: [1.0; 3], target: [2.0; 3], fov: Some(190.0) },
            Command::Fly([f64::NAN; 3]),
            Command::Zoom(0.0),
            Command::Antialias(9),
            Command::Bake(1000),
            Command::Budget(0),
            Command::Time(f64::INFINITY),
        ] {
            let mut s = settings();
            assert!(s.apply(&command).is_err(), "{command:?}");
            assert_eq!(s, settings(), "{command:?}");
        }
    }

    #[test]
    fn next_cycles_through_all_choices() {
        let mut s = settings();
        let count = shadow_names().count();
        let mut seen = Vec::new();
        for _ in 0..count {
            assert_eq!(s.apply(&Command::NextShadow { side: Side::First, by: 1 }), Ok(true));
            seen.push(s.shadow(Side::First).name().to_owned());
        }
        assert_eq!(seen.last().map(String::as_str), Some("voxel"));
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), count);
        s.apply(&Command::NextAo(-1)).unwrap();
        assert_eq!(s.ambient.name(), "truth");
        s.apply(&Command::NextLayer(-1)).unwrap();
        assert_eq!(s.layer, Layer::ALL[Layer::ALL.len() - 1]);
    }

    #[test]
    fn apply_returns_false_for_other_commands() {
        for command in [Command::Quit, Command::ResetCamera, Command::Screenshot("a.png".into())] {
            assert_eq!(settings().apply(&command), Ok(false));
        }
    }
}
