//! Properties of shadow files of either kind.

use adumbra::{LightBody, Sun};
use adumbra_tree::AnyFile;

use crate::settings::Settings;

/// Whether a file fits the settings: it was baked for their sun, and has penumbrae if they are needed.
pub(crate) fn serves(file: &AnyFile, settings: &Settings) -> bool {
    is_same_sun(&sun_of(file), &settings.sun) && (!settings.uses_penumbrae() || !lacks_penumbrae(file))
}

/// Whether a file is light-aligned and has no penumbrae.
pub(crate) fn lacks_penumbrae(file: &AnyFile) -> bool {
    matches!(file, AnyFile::Light(file) if !matches!(file.body, LightBody::Depths(_)))
}

/// The sun that a file was baked for.
pub(crate) fn sun_of(file: &AnyFile) -> Sun {
    match file {
        AnyFile::Light(file) => file.grid.sun,
        AnyFile::Tree(file) => file.sun,
    }
}

/// Whether the bake treated masked materials as opaque.
pub(crate) fn ignored_alpha(file: &AnyFile) -> bool {
    match file {
        AnyFile::Light(file) => file.settings.ignore_alpha,
        AnyFile::Tree(file) => file.settings.ignore_alpha,
    }
}

/// Whether two suns are equal, up to rounding by file formats and conversion to angles.
pub(crate) fn is_same_sun(a: &Sun, b: &Sun) -> bool {
    (0..3).all(|i| (a.towards()[i] - b.towards()[i]).abs() < 1e-9)
}

/// Whether a world point is inside a file's space.
pub(crate) fn contains(file: &AnyFile, p_world: [f64; 3]) -> bool {
    match file {
        AnyFile::Light(file) => {
            let p = file.grid.to_grid(p_world);
            (0..3).all(|a| (0.0..=f64::from(file.grid.size[a])).contains(&p[a]))
        }
        AnyFile::Tree(file) => {
            let side = f64::from(file.space.side_voxels());
            file.space.to_tree(p_world).iter().all(|p| (0.0..=side).contains(p))
        }
    }
}

/// Describes the contents of a file in one line.
pub(crate) fn words(file: &AnyFile) -> String {
    let (voxels, voxel_size) = match file {
        AnyFile::Light(file) => (file.settings.resolution, file.grid.voxel_size),
        AnyFile::Tree(file) => (file.space.side_voxels(), file.space.voxel_size),
    };
    format!("{voxels} voxels of {voxel_size:.3} m, {:.2} MB", file.encoded_len() as f64 * 1e-6)
}
