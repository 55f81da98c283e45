//! Properties of shadow files.

use adumbra::{ShadowFile, Sun};

use crate::settings::Settings;

/// Whether a file fits the settings: it was baked for their sun.
pub(crate) fn serves(file: &ShadowFile, settings: &Settings) -> bool {
    is_same_sun(&file.sun(), &settings.sun)
}

/// Whether two suns are equal, up to rounding by file formats and conversion to angles.
pub(crate) fn is_same_sun(a: &Sun, b: &Sun) -> bool {
    (0..3).all(|i| (a.towards()[i] - b.towards()[i]).abs() < 1e-9)
}

/// Whether a world point is inside a file's space.
pub(crate) fn contains(file: &ShadowFile, p_world: [f64; 3]) -> bool {
    let p = file.grid.to_grid(p_world);
    (0..3).all(|a| (0.0..=f64::from(file.grid.size[a])).contains(&p[a]))
}

/// Describes the contents of a file in one line.
pub(crate) fn words(file: &ShadowFile) -> String {
    let megabytes = file.encoded_len() as f64 * 1e-6;
    format!("{} voxels of {:.3} m, {megabytes:.2} MB", file.settings.resolution, file.grid.voxel_size)
}
