//! Truth files: NumPy `.npz` archives with the images of another renderer.

use std::fs::File;
use std::path::Path;

use npyz::{Deserialize, NpyFile};
use zip::ZipArchive;

/// Returns an array of a truth file. Its element type is not converted.
///
/// # Panics
/// Panics if the file or the array is absent or unreadable.
pub fn npz_array<T: Deserialize>(path: &Path, name: &str) -> Vec<T> {
    let read = || -> Result<Vec<T>, Box<dyn std::error::Error>> {
        let mut archive = ZipArchive::new(File::open(path)?)?;
        Ok(NpyFile::new(archive.by_name(&format!("{name}.npy"))?)?.into_vec()?)
    };
    read().unwrap_or_else(|e| panic!("{}: {name}: {e}", path.display()))
}

/// Returns the camera of a truth file: `eye`, `target`, `fov_y`, `size`, `sun` and `ao_radius`.
///
/// # Panics
/// Panics if the file or its camera is absent or unreadable.
pub fn npz_camera(path: &Path) -> serde_json::Value {
    let text: Vec<String> = npz_array(path, "camera");
    serde_json::from_str(text[0].trim_end_matches('\0')).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
