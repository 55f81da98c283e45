//! The asset: a parsed `.adumbra` file and its look-up texture.

use std::sync::Arc;

use adumbra::gpu::{LookUp, LookUpTexture};
use adumbra::{Error, FormatError, LightGrid, RangeError, Receivers, ShadowFile};
use bevy::asset::io::Reader;
use bevy::asset::{Asset, AssetLoader, LoadContext};
use bevy::math::Vec3;
use bevy::reflect::TypePath;
use bevy::reflect::prelude::*;
use serde::{Deserialize, Serialize};

use crate::DeviceLimits;

/// A baked shadow file: the asset of `.adumbra` files.
#[derive(Asset, Clone, Debug, Reflect)]
#[reflect(opaque)]
#[reflect(Clone)]
pub struct BakedShadowFile {
    file: Arc<ShadowFile>,
    texture: Result<Arc<LookUpTexture>, RangeError>,
}

impl BakedShadowFile {
    /// Makes the asset of a file that was read or baked. A file that needs a larger texture than the device
    /// allows is an asset all the same, but casts no shadows. Cost: one copy of the file's words.
    ///
    /// # Errors
    /// Returns the errors of [`LookUpTexture::new`], except the error of the size.
    pub fn new(file: ShadowFile, limits: DeviceLimits) -> Result<Self, Error> {
        let max_side = limits.max_texture_side;
        let texture = match LookUpTexture::new(&file, &LookUp::default(), max_side) {
            Ok(texture) => Ok(Arc::new(texture)),
            Err(Error::Range(error)) => Err(error),
            Err(error) => return Err(error),
        };
        Ok(Self { file: Arc::new(file), texture })
    }

    /// Returns the file, for look-ups on the CPU with [`ShadowFile::sampler`].
    pub fn file(&self) -> &Arc<ShadowFile> {
        &self.file
    }

    /// Returns the unit vector towards the sun.
    pub fn towards_sun(&self) -> Vec3 {
        Vec3::from_array(self.file.sun().towards().map(|c| c as f32))
    }

    /// Returns the voxel grid in the world.
    pub fn grid(&self) -> &LightGrid {
        &self.file.grid
    }

    /// Returns which receivers the file answers for.
    pub(crate) fn receivers(&self) -> Receivers {
        self.file.settings.receivers
    }

    /// Returns the texture, or the reason why it cannot be made.
    pub(crate) fn texture(&self) -> Result<&Arc<LookUpTexture>, &RangeError> {
        self.texture.as_ref()
    }
}

/// Settings of [`ShadowFileLoader`].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct ShadowFileSettings {}

/// Loads `.adumbra` files. Checksums and structure are verified.
#[derive(TypePath, Clone, Debug)]
pub struct ShadowFileLoader {
    limits: DeviceLimits,
}

impl ShadowFileLoader {
    pub(crate) const EXTENSIONS: [&str; 1] = ["adumbra"];

    pub(crate) fn new(limits: DeviceLimits) -> Self {
        Self { limits }
    }
}

/// An error of loading a `.adumbra` file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowFileError {
    /// The bytes could not be read.
    #[error("the shadow file could not be read: {0}")]
    Io(#[from] std::io::Error),
    /// The bytes are not a valid file.
    #[error("not a valid shadow file: {0}; bake it again with this version of adumbra")]
    Invalid(#[from] FormatError),
    /// A setting in the file is out of range.
    #[error("not a usable shadow file: {0}; bake it again with this version of adumbra")]
    Unusable(#[from] Error),
}

impl AssetLoader for ShadowFileLoader {
    type Asset = BakedShadowFile;
    type Settings = ShadowFileSettings;
    type Error = ShadowFileError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &ShadowFileSettings,
        _load_context: &mut LoadContext<'_>,
    ) -> Result<BakedShadowFile, ShadowFileError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let file = ShadowFile::from_bytes(&bytes)?;
        Ok(BakedShadowFile::new(file, self.limits)?)
    }

    fn extensions(&self) -> &[&str] {
        &Self::EXTENSIONS
    }
}
