//! How the scene of a shadow file was loaded. A program that compares a scene with its shadow file, or draws
//! them together, loads the scene in the same way.

use std::path::Path;

use adumbra::FileSettings;

use crate::{LoadOptions, UpAxis, is_gltf};

/// How the scene of a shadow file was loaded, as far as the shadow file records it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoadedAs {
    /// Whether masked and blended materials were taken as opaque.
    pub ignore_alpha: bool,
    /// The axis that points up in the scene's file, if the shadow file records it.
    pub up: Option<UpAxis>,
}

impl From<&FileSettings> for LoadedAs {
    fn from(settings: &FileSettings) -> Self {
        let up = if settings.scene_is_z_up { UpAxis::Z } else { UpAxis::Y };
        Self { ignore_alpha: settings.ignore_alpha, up: Some(up) }
    }
}

impl LoadOptions {
    /// Adopts the settings that a shadow file records, unless an option overrides them. `scene` is the path
    /// of the scene: a glTF file is Y up even if the baked scene had another format.
    pub fn follow(&mut self, baked: LoadedAs, scene: &Path) {
        self.ignore_alpha |= baked.ignore_alpha;
        if self.up.is_none() && !is_gltf(scene) {
            self.up = baked.up;
        }
    }
}
