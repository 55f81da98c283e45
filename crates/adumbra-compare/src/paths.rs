//! Camera paths: keyframes from a JSON file, or a path generated for a scene.
//!
//! ```json
//! {"frames": 120, "interpolation": "catmull-rom", "keyframes": [
//!   {"eye": [0, 2, 20], "target": [0, 2, 0], "fov": 60}, {"eye": [10, 2, 0], "target": [0, 2, 0]}]}
//! ```
//! Frames are spread evenly over the segments between keyframes. `fov` is the vertical field of view in
//! degrees. If it is absent, that of the previous keyframe applies, 45 for the first. The spline is the
//! uniform one of Catmull, Rom, *A Class of Local Interpolating Splines*, 1974. The first and last keyframes
//! are their own neighbours beyond the ends.

use std::path::Path;

use adumbra::Bounds;
use adumbra_files::{TEXT_BYTES, read_whole};
use adumbra_scene::{Camera, Projection};
use serde::Deserialize;

use crate::error::{Error, Result};

/// Largest number of frames of a path.
const MAX_FRAMES: u32 = 100_000;
const DEFAULT_FOV_DEGREES: f64 = 45.0;

/// A camera path.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    keyframes: Vec<Keyframe>,
    interpolation: Interpolation,
    frames: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Keyframe {
    eye: [f64; 3],
    target: [f64; 3],
    fov_degrees: f64,
}

/// The interpolation between keyframes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// A smooth curve through every keyframe.
    #[default]
    CatmullRom,
    /// Straight lines.
    Linear,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PathText {
    frames: u32,
    #[serde(default)]
    interpolation: Interpolation,
    keyframes: Vec<KeyframeText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyframeText {
    eye: [f64; 3],
    target: [f64; 3],
    fov: Option<f64>,
}

impl CameraPath {
    /// Reads a path from a file.
    ///
    /// # Errors
    /// Returns [`Error::Program`] if the file cannot be read, and [`Error::CameraPath`] if it is not a path.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = read_whole(path, TEXT_BYTES)?;
        Self::parse(&bytes).map_err(|what| Error::CameraPath { path: path.to_owned(), what })
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let text: PathText = serde_json::from_slice(bytes).map_err(|e| e.to_string())?;
        if !(1..=MAX_FRAMES).contains(&text.frames) {
            return Err(format!("{} frames; give 1 to {MAX_FRAMES}", text.frames));
        }
        if text.keyframes.is_empty() {
            return Err("it has no keyframes".to_owned());
        }
        let mut fov = DEFAULT_FOV_DEGREES;
        let mut keyframes = Vec::new();
        for (number, k) in text.keyframes.iter().enumerate() {
            fov = k.fov.unwrap_or(fov);
            if !(fov > 0.0 && fov < 180.0) {
                return Err(format!(
                    "keyframe {number} has a fov of {fov}; give an angle between 0 and 180 degrees"
                ));
            }
            if k.eye == k.target || !k.eye.iter().chain(&k.target).all(|c| c.is_finite()) {
                return Err(format!("keyframe {number}: eye and target must be finite and differ"));
            }
            keyframes.push(Keyframe { eye: k.eye, target: k.target, fov_degrees: fov });
        }
        Ok(Self { keyframes, interpolation: text.interpolation, frames: text.frames })
    }

    /// Returns a path once around a scene, looking from outside and above at a point over the middle of its
    /// footprint, a fifth of the way up. The path loops: the first frame is the one after the last.
    pub fn orbit(bounds: &Bounds, frames: u32) -> Self {
        const KEYFRAMES: u32 = 24;
        let frames = frames.clamp(1, MAX_FRAMES);
        let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * (bounds.min[a] + bounds.max[a]));
        let target = [middle[0], 0.8 * bounds.min[1] + 0.2 * bounds.max[1], middle[2]];
        let radius = 0.6 * bounds.diagonal();
        // The last frame is one step short of the full circle, so that a loop has even steps.
        let turns = 1.0 - 1.0 / f64::from(frames);
        let keyframe = |i: u32| {
            let angle = std::f64::consts::TAU * turns * f64::from(i) / f64::from(KEYFRAMES);
            let (sin, cos) = libm::sincos(angle);
            let eye = [target[0] + radius * cos, target[1] + 0.5 * radius, target[2] + radius * sin];
            Keyframe { eye, target, fov_degrees: DEFAULT_FOV_DEGREES }
        };
        Self {
            keyframes: (0..=KEYFRAMES).map(keyframe).collect(),
            interpolation: Interpolation::CatmullRom,
            frames,
        }
    }

    /// Returns a path that moves from a camera by `walk_world` along its horizontal direction, then by
    /// `rise_world` straight up. While it rises, the camera keeps looking ahead and increasingly down, so
    /// that one path has both near and far shadows.
    pub fn fly(from: &Camera, walk_world: f64, rise_world: f64, frames: u32) -> Self {
        let view = from.view();
        let flat = (view.forward[0].powi(2) + view.forward[2].powi(2)).sqrt().max(1e-9);
        let ahead = [view.forward[0] / flat, 0.0, view.forward[2] / flat];
        let fov_degrees = match from.projection {
            Projection::Perspective { fov_degrees } => fov_degrees,
            Projection::Orthographic { .. } => DEFAULT_FOV_DEGREES,
        };
        let keyframe = |walk: f64, rise: f64, down: f64| {
            let up = [0.0, 1.0, 0.0];
            let eye: [f64; 3] = std::array::from_fn(|a| {
                from.eye[a] + walk * walk_world * ahead[a] + rise * rise_world * up[a]
            });
            let reach = walk_world.max(rise_world);
            let target = std::array::from_fn(|a| eye[a] + reach * (ahead[a] - down * up[a]));
            Keyframe { eye, target, fov_degrees }
        };
        Self {
            keyframes: vec![
                keyframe(0.0, 0.0, 0.0),
                keyframe(0.5, 0.0, 0.0),
                keyframe(1.0, 0.0, 0.0),
                keyframe(1.0, 0.4, 0.3),
                keyframe(1.0, 1.0, 0.7),
            ],
            interpolation: Interpolation::CatmullRom,
            frames: frames.clamp(1, MAX_FRAMES),
        }
    }

    /// Returns the number of frames.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// Returns the path with another number of frames, clamped to 1 to 100,000.
    #[must_use]
    pub fn with_frames(self, frames: u32) -> Self {
        Self { frames: frames.clamp(1, MAX_FRAMES), ..self }
    }

    /// Returns the camera of a frame, 0 to [`CameraPath::frames`] - 1.
    pub fn camera(&self, frame: u32, width: u32, height: u32) -> Camera {
        let segments = (self.keyframes.len() - 1) as f64;
        let along = f64::from(frame) / f64::from(self.frames.max(2) - 1) * segments;
        let segment = (along.floor() as usize).min(self.keyframes.len().saturating_sub(2));
        let t = along - segment as f64;
        let key = |offset: i64| {
            let last = self.keyframes.len() as i64 - 1;
            &self.keyframes[(segment as i64 + offset).clamp(0, last) as usize]
        };
        let blend = |of: &dyn Fn(&Keyframe) -> f64| {
            let [a, b, c, d] = [-1, 0, 1, 2].map(|o| of(key(o)));
            match self.interpolation {
                Interpolation::Linear => b + t * (c - b),
                Interpolation::CatmullRom => {
                    let slope = 0.5 * (c - a);
                    let bend = a - 2.5 * b + 2.0 * c - 0.5 * d;
                    let twist = 0.5 * (d - a) + 1.5 * (b - c);
                    b + t * (slope + t * (bend + t * twist))
                }
            }
        };
        let fov_degrees = blend(&|k| k.fov_degrees).clamp(1.0, 179.0);
        Camera {
            eye: std::array::from_fn(|a| blend(&|k| k.eye[a])),
            target: std::array::from_fn(|a| blend(&|k| k.target[a])),
            projection: Projection::Perspective { fov_degrees },
            width,
            height,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const THREE: &[u8] = br#"{"frames": 5, "keyframes": [{"eye": [0, 0, 0], "target": [0, 0, -1], "fov": 30},
        {"eye": [2, 0, 0], "target": [2, 0, -1]}, {"eye": [4, 4, 0], "target": [4, 0, -1], "fov": 60}]}"#;

    #[test]
    fn path_passes_its_keyframes() {
        let path = CameraPath::parse(THREE).unwrap();
        let at = |frame: u32| path.camera(frame, 8, 4);
        assert_eq!((at(0).eye, at(2).eye, at(4).eye), ([0.0; 3], [2.0, 0.0, 0.0], [4.0, 4.0, 0.0]));
        assert_eq!(at(0).projection, Projection::Perspective { fov_degrees: 30.0 });
        assert_eq!(at(4).projection, Projection::Perspective { fov_degrees: 60.0 });
        // The curve is smooth: it dips before it rises.
        assert!(at(1).eye[1] < 0.0);
    }

    #[test]
    fn path_of_lines_is_straight() {
        let text =
            String::from_utf8_lossy(THREE).replace("\"frames\"", "\"interpolation\": \"linear\", \"frames\"");
        let path = CameraPath::parse(text.as_bytes()).unwrap();
        assert_eq!(path.camera(1, 8, 4).eye, [1.0, 0.0, 0.0]);
        assert_eq!(path.camera(3, 8, 4).eye, [3.0, 2.0, 0.0]);
        assert_eq!(path.with_frames(1).camera(0, 8, 4).eye, [0.0; 3]);
    }

    #[test]
    fn path_of_one_keyframe_does_not_move() {
        let path =
            CameraPath::parse(br#"{"frames": 3, "keyframes": [{"eye": [1, 2, 3], "target": [0, 0, 0]}]}"#)
                .unwrap();
        assert!((0..3).all(|f| path.camera(f, 4, 4).eye == [1.0, 2.0, 3.0]));
    }

    #[test]
    fn rejects_invalid_paths_naming_the_fault() {
        for (text, fault) in [
            ("{\"frames\": 0, \"keyframes\": []}", "0 frames"),
            ("{\"frames\": 2, \"keyframes\": []}", "no keyframes"),
            ("{\"frames\": 2, \"keyframes\": [{\"eye\": [0,0,0], \"target\": [0,0,0]}]}", "keyframe 0"),
            (
                "{\"frames\": 2, \"keyframes\": [{\"eye\": [0,0,0], \"target\": [1,0,0], \"fov\": 180}]}",
                "180",
            ),
            ("{\"frames\": 2, \"key\": []}", "key"),
            ("[", "EOF"),
        ] {
            let error = CameraPath::parse(text.as_bytes()).unwrap_err();
            assert!(error.contains(fault), "{error}");
        }
    }

    #[test]
    fn fly_walks_then_rises() {
        let projection = Projection::Perspective { fov_degrees: 60.0 };
        let from = Camera { eye: [1.0, 2.0, 3.0], target: [1.0, 2.0, -7.0], projection, width: 8, height: 8 };
        let path = CameraPath::fly(&from, 10.0, 20.0, 9);
        assert_eq!(path.camera(0, 8, 8).eye, [1.0, 2.0, 3.0]);
        assert_eq!(path.camera(4, 8, 8).eye, [1.0, 2.0, -7.0]);
        let last = path.camera(8, 8, 8);
        assert_eq!(last.eye, [1.0, 22.0, -7.0]);
        assert!(last.view().forward[1] < -0.5 && last.view().forward[2] < -0.5);
        assert_eq!(last.projection, projection);
    }

    #[test]
    fn orbit_goes_around_at_an_even_pace() {
        let bounds = Bounds { min: [-10.0, 0.0, -10.0], max: [10.0, 5.0, 10.0] };
        let path = CameraPath::orbit(&bounds, 12);
        let eyes: Vec<[f64; 3]> = (0..12).map(|f| path.camera(f, 4, 4).eye).collect();
        let step = |a: [f64; 3], b: [f64; 3]| ((a[0] - b[0]).powi(2) + (a[2] - b[2]).powi(2)).sqrt();
        let first = step(eyes[0], eyes[1]);
        for i in 0..12 {
            let next = step(eyes[i], eyes[(i + 1) % 12]);
            assert!((next / first - 1.0).abs() < 0.05, "{i}: {next} {first}");
        }
    }
}
