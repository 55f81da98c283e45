//! The source of a light's shadows.

use std::fmt;

use bevy::ecs::prelude::*;
use bevy::reflect::prelude::*;
use bevy::reflect::{ReflectDeserialize, ReflectSerialize};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::BakedShadowError;

/// The source of the shadows of a [`BakedShadow`](crate::BakedShadow). The plugin keeps it up to date on the
/// light, and triggers [`BakedShadowChanged`] when it changes.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum BakedShadowStatus {
    /// No file is loaded yet. Shadows come from the light's cascades.
    #[default]
    Waiting,
    /// Files are in use.
    Active {
        /// How many of the light's files are.
        files: usize,
    },
    /// Files are in use, but others are missing, or a part of a streamed file could not be loaded. Static
    /// meshes outside of the files in use cast through the cascades.
    Incomplete {
        /// How many of the light's files are in use.
        files: usize,
        /// How many are not. Zero if only a part of a streamed file is missing; a coarser level answers
        /// there.
        missing: usize,
        /// Why the first of them is not in use, or which part is missing.
        fault: BakedShadowError,
    },
    /// The light points away from the sun of every loaded file. Shadows come from the light's cascades.
    Misaligned {
        /// Angle to the nearest of these suns.
        degrees: f32,
    },
    /// The light is followed, and points upwards as a sun does below the horizon. Shadows come from the
    /// light's cascades.
    Night,
    /// No file can be used. Shadows come from the light's cascades.
    Unusable(BakedShadowError),
}

impl BakedShadowStatus {
    /// Returns whether files are in use.
    pub fn is_active(&self) -> bool {
        matches!(self, Self::Active { .. } | Self::Incomplete { .. })
    }
}

impl BakedShadowStatus {
    /// Whether both are equal except for numbers that may change in every frame: an angle, or the scales of a
    /// root.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        use BakedShadowError::Root;
        match (self, other) {
            (Self::Misaligned { .. }, Self::Misaligned { .. })
            | (Self::Unusable(Root(_)), Self::Unusable(Root(_))) => true,
            (
                Self::Incomplete { files: a, missing: b, fault: Root(_) },
                Self::Incomplete { files: c, missing: d, fault: Root(_) },
            ) => (a, b) == (c, d),
            _ => self == other,
        }
    }
}

/// A saved world stores it as text.
impl Serialize for BakedShadowStatus {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Ignores the saved text: the plugin updates the status in a loaded world.
impl<'de> Deserialize<'de> for BakedShadowStatus {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(|_| Self::default())
    }
}

/// The text continues the sentence "the shadow is …", and says what to do if the shadow is not in use.
impl fmt::Display for BakedShadowStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting => f.write_str("loading"),
            Self::Active { files: 1 } => f.write_str("in use"),
            Self::Active { files } => write!(f, "in use, with {files} files"),
            Self::Incomplete { missing: 0, fault, .. } => {
                write!(f, "in use, but not complete: {fault}. A coarser level answers there")
            }
            Self::Incomplete { files, missing, fault } => {
                write!(f, "in use, but {missing} of {} files are missing: {fault}", files + missing)
            }
            Self::Misaligned { degrees } => write!(
                f,
                "not in use: the light is {degrees:.2} degrees off the file's sun; set BakedShadow::align, or turn the \
                 light"
            ),
            Self::Night => f.write_str("not in use: the sun is below the horizon"),
            Self::Unusable(error) => write!(f, "not in use: {error}"),
        }
    }
}

/// A light's [`BakedShadowStatus`] has changed.
#[derive(EntityEvent, Clone, Debug, Reflect)]
#[reflect(Event, Clone, Debug)]
pub struct BakedShadowChanged {
    /// The light.
    pub entity: Entity,
    /// Its new status.
    pub status: BakedShadowStatus,
}

#[cfg(test)]
mod tests {
    use adumbra::stream::{SourceError, StreamFault};

    use super::*;

    #[test]
    fn display_says_what_to_do() {
        let fault = StreamFault {
            part: "bundle 7 of level 0".to_owned(),
            error: SourceError::Changed.into(),
            retry_in: None,
        };
        let fault = BakedShadowError::Stream { file: "city.adumbra".to_owned(), fault: fault.into() };
        let rows = BakedShadowError::TooManyRows { rows: 9000, limit: 8192 };
        let ninth = BakedShadowError::TooManyFiles { limit: 8 };
        let all = [
            (BakedShadowStatus::Waiting, "loading"),
            (BakedShadowStatus::Active { files: 1 }, "in use"),
            (BakedShadowStatus::Active { files: 2 }, "2 files"),
            (
                BakedShadowStatus::Incomplete { files: 1, missing: 0, fault },
                "city.adumbra: the bundle 7 of level 0 is missing",
            ),
            (
                BakedShadowStatus::Incomplete { files: 8, missing: 4, fault: ninth },
                "4 of 12 files are missing: more than 8 files",
            ),
            (BakedShadowStatus::Misaligned { degrees: 1.234 }, "1.23 degrees"),
            (BakedShadowStatus::Misaligned { degrees: 1.0 }, "BakedShadow::align"),
            (BakedShadowStatus::Unusable(BakedShadowError::NoShadowMaps), "shadow_maps_enabled"),
            (BakedShadowStatus::Unusable(rows), "9000 rows of texels, and the device allows 8192"),
        ];
        for (status, words) in all {
            assert!(status.to_string().contains(words), "{status}");
        }
    }
}
