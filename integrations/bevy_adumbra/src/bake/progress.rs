//! How far a bake is, and why it failed.

use std::{fmt, io};

use bevy::ecs::prelude::*;
use bevy::mesh::MeshAccessError;
use bevy::reflect::prelude::*;
use bevy::reflect::{ReflectDeserialize, ReflectSerialize};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::SharedError;

/// How far the bake of a [`RuntimeBake`](crate::RuntimeBake) is. The plugin keeps it on the light.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum BakeProgress {
    /// Nothing has begun: there are no meshes yet, or they still change.
    #[default]
    Waiting,
    /// A bake is under way.
    Baking {
        /// Resolution of the file that is being made.
        resolution: u32,
        /// Share of it that is done.
        share: f32,
    },
    /// The last file is in use.
    Done {
        /// How long it was baked.
        seconds: f64,
        /// Number of its triangles.
        triangles: u64,
    },
    /// The light is followed, and keys answer.
    Following {
        /// Whether another key is being baked.
        is_baking: bool,
        /// How many times coarser than requested the keys that answer are: 1 or 8.
        coarser: u32,
    },
    /// The bake failed. It begins again when something changes.
    Failed(BakeError),
}

/// A saved world stores it as text.
impl Serialize for BakeProgress {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Ignores the saved text: a loaded world is baked again.
impl<'de> Deserialize<'de> for BakeProgress {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(|_| Self::default())
    }
}

impl fmt::Display for BakeProgress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting => f.write_str("waiting for meshes that stand still"),
            Self::Baking { resolution, share } => {
                write!(f, "{:.0} % of resolution {resolution}", 100.0 * share)
            }
            Self::Done { seconds, triangles } => write!(f, "{triangles} triangles in {seconds:.2} s"),
            Self::Following { coarser: 1, .. } => f.write_str("following the sun"),
            Self::Following { coarser, .. } => write!(f, "following the sun, {coarser} times coarser so far"),
            Self::Failed(error) => write!(f, "failed: {error}"),
        }
    }
}

/// Why a bake failed. The message says what to do where something can be done.
// Error types of the lower crates do not implement reflection.
#[derive(Clone, Debug, PartialEq, Reflect, thiserror::Error)]
#[reflect(opaque)]
#[reflect(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BakeError {
    /// There is nothing to bake.
    #[error("no mesh below a ShadowStatic has triangles")]
    NoTriangles,
    /// A mesh is not in the main world.
    #[error(
        "a mesh below a ShadowStatic cannot be read ({0}); load it with RenderAssetUsages::MAIN_WORLD too"
    )]
    Unreadable(#[source] SharedError<MeshAccessError>),
    /// A vertex is not finite.
    #[error("a mesh below a ShadowStatic has a vertex that is not finite")]
    NotFinite,
    /// The threads of the bake could not be started.
    #[error("no thread could be started: {0}")]
    Threads(#[source] SharedError<io::Error>),
    /// The light is not a sun: it shines from below.
    #[error(transparent)]
    Sun(SharedError<adumbra::Error>),
    /// The scene could not be baked.
    #[error(transparent)]
    Bake(SharedError<adumbra_bake::Error>),
    /// A key of a light that is followed could not be baked.
    #[error(transparent)]
    Follow(SharedError<adumbra_path::Error>),
    /// The file that was baked cannot be looked up.
    #[error(transparent)]
    File(SharedError<adumbra::Error>),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn display_describes_progress() {
        let all = [
            (BakeProgress::Baking { resolution: 2048, share: 0.254 }, "25 % of resolution 2048"),
            (BakeProgress::Done { seconds: 1.234, triangles: 12 }, "12 triangles in 1.23 s"),
            (BakeProgress::Failed(BakeError::NoTriangles), "failed: no mesh below a ShadowStatic"),
        ];
        for (progress, words) in all {
            assert!(progress.to_string().contains(words), "{progress}");
        }
    }
}
