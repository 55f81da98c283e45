//! Buffer views compressed with meshoptimizer: the glTF extensions `EXT_meshopt_compression` and
//! `KHR_meshopt_compression`. Their streams are decoded by a port of meshoptimizer's own decoder, behind the
//! feature `meshopt`.
//!
//! Departures: both extension names accept everything that either of them defines, including version 1 of the
//! vertex codec and the filter `COLOR`, because files with these under the older name exist. A view's stated
//! length may differ from its decoded length; its accessors are checked against the decoded bytes.

#[cfg(feature = "meshopt")]
mod compressed;

#[cfg(feature = "meshopt")]
pub(super) use compressed::Compressed;

use serde_json::{Map, Value};

use crate::gltf::numbers::index_of;

/// The names of the extensions. If a view has both, the newer one is used.
const EXTENSIONS: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// The extension of a buffer view, if it is compressed.
pub(super) fn extension(extensions: &Map<String, Value>) -> Option<(&'static str, &Value)> {
    EXTENSIONS.iter().find_map(|&name| Some((name, extensions.get(name)?)))
}

/// The buffer that holds the compressed bytes of a buffer view with these extensions.
pub(super) fn buffer(extensions: &Map<String, Value>) -> Option<usize> {
    index_of(extension(extensions)?.1.get("buffer")?)
}

/// Whether a buffer with these extensions is only a fallback for compressed data.
pub(super) fn is_fallback(extensions: &Map<String, Value>) -> bool {
    extension(extensions).and_then(|(_, json)| json.get("fallback")?.as_bool()) == Some(true)
}
