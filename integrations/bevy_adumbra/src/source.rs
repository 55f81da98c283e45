//! Where a streamed file is read from.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use adumbra::stream::ShadowSource;
use bevy::asset::AssetPath;
use bevy::reflect::prelude::*;
use bevy::reflect::{ReflectDeserialize, ReflectSerialize};
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Where a streamed file is read from.
#[derive(Clone, Reflect)]
#[reflect(opaque)]
#[reflect(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum StreamSource {
    /// An asset, by its path. It is opened once, and ranges of it are read if its reader can seek. Otherwise
    /// it is read whole, once, and streamed from memory, as are assets of Bevy's `http` and `https` sources.
    /// Bevy's reader of files may read up to 8 MiB more than requested; [`StreamSource::Disk`] does not.
    Asset(AssetPath<'static>),
    /// A file on a disk, by its path in the file system.
    Disk(PathBuf),
    /// A custom source, such as an HTTP client that requests ranges. It is called on threads that may block.
    Ranges(Arc<dyn ShadowSource>),
}

impl StreamSource {
    /// A custom source. Its clones are the same source, so lights that share a source share its bytes.
    pub fn ranges(source: impl ShadowSource + 'static) -> Self {
        Self::Ranges(Arc::new(source))
    }
}

/// The form in which a saved world stores a source.
#[derive(Serialize, Deserialize)]
enum Saved {
    Asset(AssetPath<'static>),
    Disk(PathBuf),
}

/// A custom source cannot be saved.
impl Serialize for StreamSource {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let saved = match self {
            Self::Asset(path) => Saved::Asset(path.clone()),
            Self::Disk(path) => Saved::Disk(path.clone()),
            Self::Ranges(_) => {
                let what = "StreamSource::Ranges cannot be saved; leave its component out, and insert it once the world is loaded";
                return Err(S::Error::custom(what));
            }
        };
        saved.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for StreamSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match Saved::deserialize(deserializer)? {
            Saved::Asset(path) => Self::Asset(path),
            Saved::Disk(path) => Self::Disk(path),
        })
    }
}

/// Two custom sources are equal if they are clones of one source.
impl PartialEq for StreamSource {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Asset(a), Self::Asset(b)) => a == b,
            (Self::Disk(a), Self::Disk(b)) => a == b,
            (Self::Ranges(a), Self::Ranges(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl fmt::Display for StreamSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asset(path) => path.fmt(f),
            Self::Disk(path) => path.display().fmt(f),
            Self::Ranges(_) => f.write_str("a source of ranges"),
        }
    }
}

impl fmt::Debug for StreamSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "StreamSource({self})")
    }
}

/// The path of an asset.
impl From<&'static str> for StreamSource {
    fn from(path: &'static str) -> Self {
        Self::Asset(path.into())
    }
}

/// The path of an asset.
impl From<String> for StreamSource {
    fn from(path: String) -> Self {
        Self::Asset(path.into())
    }
}

impl From<AssetPath<'static>> for StreamSource {
    fn from(path: AssetPath<'static>) -> Self {
        Self::Asset(path)
    }
}

/// A path in the file system.
impl From<PathBuf> for StreamSource {
    fn from(path: PathBuf) -> Self {
        Self::Disk(path)
    }
}

/// A path in the file system.
impl From<&Path> for StreamSource {
    fn from(path: &Path) -> Self {
        Self::Disk(path.to_owned())
    }
}

impl From<Arc<dyn ShadowSource>> for StreamSource {
    fn from(source: Arc<dyn ShadowSource>) -> Self {
        Self::Ranges(source)
    }
}

#[cfg(test)]
mod tests {
    use adumbra::stream::BytesSource;

    use super::*;

    #[test]
    fn sources_are_the_same_by_path_or_by_identity() {
        assert_eq!(StreamSource::from("city.adumbra"), StreamSource::from("city.adumbra".to_owned()));
        assert_ne!(StreamSource::from("city.adumbra"), StreamSource::from(Path::new("city.adumbra")));
        let own = StreamSource::ranges(BytesSource(Vec::new()));
        assert_eq!(own, own.clone());
        assert_ne!(own, StreamSource::ranges(BytesSource(Vec::new())));
        assert_eq!(StreamSource::from("a/city.adumbra").to_string(), "a/city.adumbra");
    }
}
