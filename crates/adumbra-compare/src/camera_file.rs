//! Cameras as JSON: saved by the viewer, read by `compare --camera`, and part of truth files.
//!
//! ```json
//! {"eye": [0, 2, 20], "target": [0, 2, 0], "fov_y": 60, "size": [1280, 720], "sun": [0.5, 0.8, 0.35]}
//! ```
//! `fov_y` is the vertical field of view in degrees; an orthographic camera has `height_world` instead. `sun`
//! is the direction towards the sun and may be absent.

use std::io::Write as _;
use std::path::Path;

use adumbra::Sun;
use adumbra_files::{TEXT_BYTES, read_whole, replace_file};
use adumbra_scene::{Camera, Projection};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// A camera, and the sun that it was saved with.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema)]
#[schemars(with = "CameraText")]
pub struct CameraFile {
    /// The camera.
    pub camera: Camera,
    /// The sun, if the file has one.
    pub sun: Option<Sun>,
}

/// A camera.
#[derive(Serialize, Deserialize, JsonSchema)]
pub(crate) struct CameraText {
    /// Where it is, world units.
    eye: [f64; 3],
    /// A point in the middle of the picture.
    target: [f64; 3],
    /// Vertical field of view in degrees, of a camera with perspective.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fov_y: Option<f64>,
    /// Height of the picture in world units, of an orthographic camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    height_world: Option<f64>,
    /// Width and height in pixels.
    size: [u32; 2],
    /// Direction towards the sun.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sun: Option<[f64; 3]>,
    /// Radius of the ambient occlusion in world units, in truth files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) ao_radius: Option<f64>,
}

impl CameraText {
    /// Returns the camera and its sun, or a message that says what is wrong.
    pub(crate) fn file(&self) -> Result<CameraFile, String> {
        let projection = match (self.fov_y, self.height_world) {
            (Some(fov_degrees), None) if fov_degrees > 0.0 && fov_degrees < 180.0 => {
                Projection::Perspective { fov_degrees }
            }
            (None, Some(height_world)) if height_world > 0.0 && height_world.is_finite() => {
                Projection::Orthographic { height_world }
            }
            _ => return Err("it needs fov_y between 0 and 180 degrees, or height_world above 0".to_owned()),
        };
        let [width, height] = self.size;
        if width.min(height) == 0 || width.max(height) > 16_384 {
            return Err(format!("its size is {width} x {height}; give 1 to 16384 pixels per side"));
        }
        if self.eye == self.target || !self.eye.iter().chain(&self.target).all(|c| c.is_finite()) {
            return Err("eye and target must be finite and differ".to_owned());
        }
        let sun = self.sun.map(Sun::from_direction).transpose().map_err(|e| e.to_string())?;
        let camera = Camera { eye: self.eye, target: self.target, projection, width, height };
        Ok(CameraFile { camera, sun })
    }
}

impl CameraFile {
    /// Reads a camera from a file.
    ///
    /// # Errors
    /// Returns [`Error::Program`] if the file cannot be read, and [`Error::CameraFile`] if it is not a
    /// camera.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = read_whole(path, TEXT_BYTES)?;
        Self::parse(&bytes).map_err(|what| Error::CameraFile { path: path.to_owned(), what })
    }

    /// Parses a camera from JSON.
    ///
    /// # Errors
    /// Returns a message for the user.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        serde_json::from_slice::<CameraText>(bytes).map_err(|e| e.to_string())?.file()
    }

    /// Returns the camera as JSON.
    pub fn text(&self) -> String {
        let c = &self.camera;
        let (fov_y, height_world) = match c.projection {
            Projection::Perspective { fov_degrees } => (Some(fov_degrees), None),
            Projection::Orthographic { height_world } => (None, Some(height_world)),
        };
        let sun = self.sun.map(|s| s.towards());
        let size = [c.width, c.height];
        let text =
            CameraText { eye: c.eye, target: c.target, fov_y, height_world, size, sun, ao_radius: None };
        serde_json::to_string(&text).unwrap_or_default()
    }

    /// Writes [`Self::text`] and a newline to a file.
    ///
    /// # Errors
    /// Returns [`Error::Program`] if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = self.text() + "\n";
        replace_file(path, |file| file.write_all(text.as_bytes()).map(|()| text.len() as u64))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camera_round_trips_through_json() {
        for projection in
            [Projection::Perspective { fov_degrees: 33.25 }, Projection::Orthographic { height_world: 12.5 }]
        {
            let camera =
                Camera { eye: [1.5, 2.0, -3.0], target: [0.1, 0.0, 7.0], projection, width: 64, height: 48 };
            for sun in [None, Some(Sun::from_angles(30.0, 12.0).unwrap())] {
                let file = CameraFile { camera, sun };
                let back = CameraFile::parse(file.text().as_bytes()).unwrap();
                assert_eq!(back.camera, camera);
                let apart = |a: Sun, b: Sun| (0..3).all(|i| (a.towards()[i] - b.towards()[i]).abs() < 1e-15);
                assert!(match (back.sun, sun) {
                    (Some(a), Some(b)) => apart(a, b),
                    (a, b) => a == b,
                });
            }
        }
    }

    #[test]
    fn rejects_invalid_cameras_naming_the_fault() {
        let base = r#""eye": [0, 0, 1], "target": [0, 0, 0]"#;
        for (rest, fault) in [
            (r#""fov_y": 200, "size": [4, 4]"#, "fov_y"),
            (r#""fov_y": 20, "height_world": 3, "size": [4, 4]"#, "height_world"),
            (r#""fov_y": 20, "size": [0, 4]"#, "0 x 4"),
            (r#""fov_y": 20, "size": [4, 4], "sun": [0, -1, 0]"#, "horizon"),
            (r#""fov_y": 20"#, "size"),
        ] {
            let what = CameraFile::parse(format!("{{{base}, {rest}}}").as_bytes()).unwrap_err();
            assert!(what.contains(fault), "{what}");
        }
        assert!(
            CameraFile::parse(br#"{"eye": [1,1,1], "target": [1,1,1], "fov_y": 20, "size": [4,4]}"#).is_err()
        );
    }
}
