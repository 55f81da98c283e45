//! What a shadow file says of itself, of either kind.

use adumbra::format::{AnyFile, LightBody};
use adumbra::light::Sun;

use crate::settings::Settings;

/// Whether a file has what is asked for: this sun, and penumbrae where they are to be seen.
pub(crate) fn serves(file: &AnyFile, settings: &Settings) -> bool {
    is_same_sun(&sun_of(file), &settings.sun) && (!settings.uses_penumbrae() || !lacks_penumbrae(file))
}

/// Whether a file is light-aligned and has no penumbrae.
pub(crate) fn lacks_penumbrae(file: &AnyFile) -> bool {
    matches!(file, AnyFile::Light(file) if !matches!(file.body, LightBody::Hierarchy(_)))
}

/// The sun that a file was baked for.
pub(crate) fn sun_of(file: &AnyFile) -> Sun {
    match file {
        AnyFile::Light(file) => file.grid.sun,
        AnyFile::Tree(file) => file.sun,
    }
}

/// Whether a bake took masked materials as opaque.
pub(crate) fn ignored_alpha(file: &AnyFile) -> bool {
    match file {
        AnyFile::Light(file) => file.settings.ignore_alpha,
        AnyFile::Tree(file) => file.settings.ignore_alpha,
    }
}

/// Whether two suns are one, but for the rounding of their ways through files and angles.
pub(crate) fn is_same_sun(a: &Sun, b: &Sun) -> bool {
    (0..3).all(|i| (a.towards()[i] - b.towards()[i]).abs() < 1e-9)
}

/// What a file holds, in a line.
pub(crate) fn words(file: &AnyFile) -> String {
    let (voxels, voxel_size) = match file {
        AnyFile::Light(file) => (file.settings.resolution, file.grid.voxel_size),
        AnyFile::Tree(file) => (file.space.side_voxels(), file.space.voxel_size),
    };
    format!("{voxels} voxels of {voxel_size:.3} m, {:.2} MB", file.encoded_len() as f64 * 1e-6)
}
