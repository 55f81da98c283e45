//! Why no file of a light is in use.

use std::error::Error;
use std::ops::Deref;
use std::sync::Arc;

use adumbra::RangeError;
use adumbra::stream::StreamFault;
use bevy::asset::AssetLoadError;
use bevy::reflect::prelude::*;

/// Why no file of a light is in use. The message says what to do.
// Error types of the lower crates do not implement reflection.
#[derive(Clone, Debug, PartialEq, Reflect, thiserror::Error)]
#[reflect(opaque)]
#[reflect(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BakedShadowError {
    /// The light casts no shadows.
    #[error("the light has no shadows; set DirectionalLight::shadow_maps_enabled")]
    NoShadowMaps,
    /// The light's lists of files are empty.
    #[error("BakedShadow::files and BakedShadow::streams are empty; give it a file")]
    NoFiles,
    /// Nothing bakes the keys of a light that is to be followed.
    #[error(
        "BakedShadow::follow needs keys, and nothing bakes them; put a RuntimeBake on the light (feature `bake`)"
    )]
    NothingFollows,
    /// A light that is followed has penumbrae.
    #[error("BakedShadow::sun_degrees is not possible with BakedShadow::follow; set one of them alone")]
    SoftFollow,
    /// There is no light to shadow.
    #[error("BakedShadow is on an entity without a DirectionalLight; put it on the sun")]
    NoLight,
    /// A file could not be loaded.
    #[error(transparent)]
    NotLoaded(SharedError<AssetLoadError>),
    /// A part of a streamed file could not be loaded.
    #[error("{file}: {fault}")]
    Stream {
        /// Where the file is read from.
        file: String,
        /// The missing part, the reason, and the time of the next request.
        #[source]
        fault: SharedError<StreamFault>,
    },
    /// A file is too large for look-ups on this device.
    #[error(transparent)]
    File(RangeError),
    /// A file's root is mirrored, or scaled by more than one number.
    #[error("a file cannot follow its FileRoot: {0}")]
    Root(RangeError),
    /// A setting of the light is out of range.
    #[error("BakedShadow: {0}")]
    Setting(#[source] SharedError<adumbra::Error>),
    /// All files of the app together are too many.
    #[error("more than {limit} files are in use; load fewer at a time")]
    TooManyFiles {
        /// How many may be in use at once.
        limit: usize,
    },
    /// All files of the app together are too large for the device.
    #[error(
        "the files need {rows} rows of texels, and the device allows {limit}; bake at a lower resolution, load \
         fewer at a time, or stream them with less StreamBudget::bytes"
    )]
    TooManyRows {
        /// Rows of a texture that they need.
        rows: u32,
        /// Rows of a texture that the device allows.
        limit: u32,
    },
    /// One of Bevy's shaders is not as expected. No shader is changed.
    #[error(
        "{shader} has {text:?} {found} times where bevy_adumbra {} expects it once; use the bevy_adumbra of this \
         version of Bevy, and no other plugin that changes this shader",
        env!("CARGO_PKG_VERSION")
    )]
    ShaderText {
        /// Path of the shader's asset.
        shader: &'static str,
        /// The text that should occur once.
        text: &'static str,
        /// How often the text occurs.
        found: usize,
    },
    /// One of Bevy's shaders is no longer WGSL. No shader is changed.
    #[error(
        "{shader} is not WGSL; use the bevy_adumbra of this version of Bevy, and no other plugin that changes this \
         shader"
    )]
    ShaderLanguage {
        /// Path of the shader's asset.
        shader: &'static str,
    },
}

/// A shared error: clones refer to the same error. Two are equal if their messages are equal.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct SharedError<E: Error + 'static>(Arc<E>);

impl<E: Error> From<E> for SharedError<E> {
    fn from(error: E) -> Self {
        Self(Arc::new(error))
    }
}

impl<E: Error> From<Arc<E>> for SharedError<E> {
    fn from(error: Arc<E>) -> Self {
        Self(error)
    }
}

impl<E: Error> Clone for SharedError<E> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<E: Error> PartialEq for SharedError<E> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.to_string() == other.0.to_string()
    }
}

impl<E: Error> Deref for SharedError<E> {
    type Target = E;

    fn deref(&self) -> &E {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_with_equal_messages_are_equal() {
        let error = |text: &str| SharedError::from(std::io::Error::other(text.to_owned()));
        assert_eq!(error("one"), error("one"));
        assert_ne!(error("one"), error("two"));
        assert_eq!(error("one").to_string(), "one");
    }
}
