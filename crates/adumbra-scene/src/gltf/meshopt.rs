//! Buffer views compressed with meshoptimizer: the glTF extensions `EXT_meshopt_compression` and
//! `KHR_meshopt_compression`. Their streams are decoded by a port of meshoptimizer's own decoder, behind the feature
//! `meshopt`.
//!
//! Departures: both names take all that either of them defines, that is, version 1 of the vertex codec and the filter
//! `COLOR` too, as files with these under the older name exist. A view may be shorter or longer than what it decodes
//! to; its accessors are checked against the decoded bytes.

#[cfg(feature = "meshopt")]
mod compressed;

#[cfg(feature = "meshopt")]
pub(super) use compressed::Compressed;

use serde_json::{Map, Value};

use crate::gltf::numbers::index_of;

/// The extensions' names; the newer goes first where a view has both.
const EXTENSIONS: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// The extension of a buffer view, if it is compressed.
pub(super) fn extension(extensions: &Map<String, Value>) -> Option<(&'static str, &Value)> {
    EXTENSIONS.iter().find_map(|&name| Some((name, extensions.get(name)?)))
}

/// The buffer that holds the compressed bytes of a buffer view with these extensions.
pub(super) fn buffer(extensions: &Map<String, Value>) -> Option<usize> {
    index_of(extension(extensions)?.1.get("buffer")?)
}

/// Whether a buffer with these extensions only stands in for compressed data.
pub(super) fn is_fallback(extensions: &Map<String, Value>) -> bool {
    extension(extensions).and_then(|(_, json)| json.get("fallback")?.as_bool()) == Some(true)
}
