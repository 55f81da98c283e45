//! What the shadows of a light come from.

use std::fmt;

use bevy::ecs::prelude::*;
use bevy::reflect::prelude::*;

use crate::error::BakedShadowError;

/// What the shadows of a [`BakedShadow`](crate::BakedShadow) come from. It is kept up to date on the light, and
/// [`BakedShadowChanged`] is triggered when it changes.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
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
    /// The light points away from the sun of every loaded file. Shadows come from the light's cascades.
    Misaligned {
        /// Angle to the nearest of these suns.
        degrees: f32,
    },
    /// Nothing can be used. Shadows come from the light's cascades.
    Unusable(BakedShadowError),
}

impl BakedShadowStatus {
    /// Returns whether files are in use.
    pub fn is_active(&self) -> bool {
        matches!(self, Self::Active { .. })
    }
}

/// Continues the sentence "the shadow is …", and says what to do if it is not in use.
impl fmt::Display for BakedShadowStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting => f.write_str("loading"),
            Self::Active { files: 1 } => f.write_str("in use"),
            Self::Active { files } => write!(f, "in use, with {files} files"),
            Self::Misaligned { degrees } => write!(
                f,
                "not in use: the light is {degrees:.2} degrees off the file's sun; set BakedShadow::align, or turn the \
                 light"
            ),
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
    use super::*;

    #[test]
    fn a_status_is_said_with_what_to_do() {
        let rows = BakedShadowError::TooManyRows { rows: 9000, limit: 8192 };
        let all = [
            (BakedShadowStatus::Waiting, "loading"),
            (BakedShadowStatus::Active { files: 1 }, "in use"),
            (BakedShadowStatus::Active { files: 2 }, "2 files"),
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
