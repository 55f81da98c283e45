//! Truth files: the truth of another renderer, with its camera, as NumPy `.npz`.
//!
//! The arrays are pos and normal (H, W, 3), ndotl, sun and ao (H, W), all `f32`, valid (H, W, bool), and
//! camera. The latter is JSON text with `eye`, `target`, `fov_y` (degrees), `size` (width, height), `sun`
//! (direction towards it) and `ao_radius` (world units).

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use adumbra::Sun;
use adumbra_scene::Camera;
use npyz::{Deserialize as NpyDeserialize, NpyFile};
use zip::ZipArchive;
use zip::result::ZipError;

use crate::camera_file::{CameraFile, CameraText};
use crate::error::{Error, Result};

/// The contents of a truth file: one view, with one value per pixel and row 0 at the top.
#[derive(Clone, Debug)]
pub struct TruthView {
    /// The camera.
    pub camera: Camera,
    /// The sun.
    pub sun: Sun,
    /// World-space position of the nearest surface.
    pub position: Vec<[f32; 3]>,
    /// Unit geometric normal of that surface in world space, facing the viewer.
    pub normal: Vec<[f32; 3]>,
    /// Cosine between normal and sun, -1 to 1.
    pub n_dot_l: Vec<f32>,
    /// Visibility of the sun's centre, 0 or 1.
    pub visibility: Vec<f32>,
    /// Cosine-weighted ambient visibility within [`Self::ambient_radius_world`], 1 = open.
    pub ambient: Vec<f32>,
    /// Largest distance of occluders for the ambient visibility, in world units.
    pub ambient_radius_world: f64,
    /// Whether there is a surface.
    pub valid: Vec<bool>,
}

/// Reads camera and sun of a truth file, without its arrays.
///
/// # Errors
/// Returns [`Error::TruthFile`] if the file is absent or has no camera with a sun above the horizon.
pub fn truth_camera(path: &Path) -> Result<(Camera, Sun)> {
    let text = camera_text(path)?;
    camera_and_sun(path, &text)
}

fn camera_and_sun(path: &Path, text: &CameraText) -> Result<(Camera, Sun)> {
    let CameraFile { camera, sun } =
        text.file().map_err(|what| refuse(path, format!("its camera is invalid: {what}")))?;
    Ok((camera, sun.ok_or_else(|| refuse(path, "its camera has no sun".to_owned()))?))
}

fn camera_text(path: &Path) -> Result<CameraText> {
    let text: Vec<String> = array(path, "camera")?;
    let text = text.first().map_or("", |t| t.trim_end_matches('\0'));
    serde_json::from_str(text).map_err(|e| refuse(path, format!("its camera is invalid: {e}")))
}

impl TruthView {
    /// Reads a truth file.
    ///
    /// # Errors
    /// Returns [`Error::TruthFile`] if the file is absent, has no camera with a sun above the horizon, or has
    /// no `ao_radius`, and if an array is absent, of another type, or not of the camera's size.
    pub fn read(path: &Path) -> Result<Self> {
        let text = camera_text(path)?;
        let (camera, sun) = camera_and_sun(path, &text)?;
        let no_radius = || refuse(path, "its camera has no ao_radius".to_owned());
        let pixels = camera.width as usize * camera.height as usize;
        let of_size = |name: &str, length: usize, wanted: usize| {
            let what = format!("array {name:?} has {length} values instead of {wanted}");
            if length == wanted { Ok(()) } else { Err(refuse(path, what)) }
        };
        let singles = |name: &str, channels: usize| {
            let values: Vec<f32> = array(path, name)?;
            of_size(name, values.len(), pixels * channels).map(|()| values)
        };
        let triples = |name: &str| singles(name, 3).map(|v| v.as_chunks::<3>().0.to_vec());
        let valid: Vec<bool> = array(path, "valid")?;
        of_size("valid", valid.len(), pixels)?;
        Ok(Self {
            camera,
            sun,
            position: triples("pos")?,
            normal: triples("normal")?,
            n_dot_l: singles("ndotl", 1)?,
            visibility: singles("sun", 1)?,
            ambient: singles("ao", 1)?,
            ambient_radius_world: text.ao_radius.ok_or_else(no_radius)?,
            valid,
        })
    }
}

fn refuse(path: &Path, what: String) -> Error {
    Error::TruthFile { path: path.to_owned(), what }
}

fn array<T: NpyDeserialize>(path: &Path, name: &str) -> Result<Vec<T>> {
    let read = || -> std::io::Result<Option<Vec<T>>> {
        let mut archive = ZipArchive::new(BufReader::new(File::open(path)?))?;
        match archive.by_name(&format!("{name}.npy")) {
            Ok(array) => NpyFile::new(array)?.into_vec().map(Some),
            Err(ZipError::FileNotFound) => Ok(None),
            Err(e) => Err(e.into()),
        }
    };
    match read() {
        Ok(Some(values)) => Ok(values),
        Ok(None) => Err(refuse(path, format!("it has no array {name:?}"))),
        Err(e) => Err(refuse(path, format!("{name:?}: {e}"))),
    }
}
