//! Geometry compressed with Draco, as in the glTF extension KHR_draco_mesh_compression (Khronos, ratified).
//!
//! A primitive names a buffer view with a Draco stream, and gives for each of its attributes the id that the
//! attribute has in the stream. The stream's content replaces the accessors' data: its triangles replace the
//! indices, whatever the primitive's mode, and its counts and component types replace those of the accessors.
//! An accessor says only whether its values are normalised. Attributes that are not in the stream are read as
//! usual.
//!
//! A primitive may have uncompressed data as well, for programs that do not know the extension. Where all of
//! its accessors have data and the file does not require the extension, that data is read: it has not been
//! quantised, and gives the same scene whether this crate is built with the feature `draco` or not.

#[cfg(feature = "draco")]
mod header;
#[cfg(feature = "draco")]
mod stream;

use std::path::Path;

use ::gltf::json::Root;
use ::gltf::json::accessor::ComponentType;
use ::gltf::json::mesh::{Primitive, Semantic};
use ::gltf::json::validation::Checked;
use hashbrown::HashMap;
use serde_json::{Map, Value};

use crate::Result;
use crate::gltf::container::Buffers;
use crate::gltf::faults::bad;
use crate::gltf::numbers::{index_of, whole};

/// The extension's name.
pub(super) const EXTENSION: &str = "KHR_draco_mesh_compression";

/// The decoded streams of a scene.
#[derive(Default)]
pub(super) struct Streams {
    of_view: HashMap<usize, Decoded>,
}

/// A primitive's decoded stream.
#[derive(Clone, Copy)]
pub(super) struct Compressed<'s, 'p> {
    /// The buffer view with the stream.
    pub(super) view: usize,
    /// The content of the stream.
    pub(super) decoded: &'s Decoded,
    ids: &'p Map<String, Value>,
}

/// The content of a stream.
pub(super) struct Decoded {
    /// Number of points: elements of each attribute.
    pub(super) points: usize,
    /// The corners of the triangles, as little-endian 32-bit words.
    pub(super) corners: Vec<u8>,
    attributes: Vec<Attribute>,
}

/// An attribute of a stream.
pub(super) struct Attribute {
    /// The number by which a primitive names it.
    id: u32,
    pub(super) kind: ComponentType,
    pub(super) components: usize,
    /// One value per point, packed and little-endian.
    pub(super) bytes: Vec<u8>,
}

/// What a primitive's accessors state about the content of its stream.
#[derive(Clone, Copy)]
#[cfg_attr(not(feature = "draco"), expect(dead_code, reason = "only the decoder reads them"))]
struct Stated {
    /// Number of triangles, if the primitive has indices.
    triangles: Option<u64>,
    /// Number of points.
    points: u64,
    /// Total size of a point's attributes, bytes.
    point_bytes: u64,
}

impl Decoded {
    /// Number of corners: three per triangle.
    pub(super) fn corner_count(&self) -> usize {
        self.corners.len() / size_of::<u32>()
    }
}

impl<'s> Compressed<'s, '_> {
    /// The stream's attribute that replaces an accessor's data, if there is one.
    pub(super) fn attribute(&self, semantic: &str) -> Option<&'s Attribute> {
        let id = whole(self.ids.get(semantic)?)?;
        self.decoded.attributes.iter().find(|a| u64::from(a.id) == id)
    }
}

impl Streams {
    /// Decodes the streams of a mesh's primitives, each stream once. The primitives come with their indices.
    ///
    /// # Errors
    /// [`Error::SceneParse`](crate::Error::SceneParse) naming the mesh and the primitive,
    /// [`Error::SceneMemory`](crate::Error::SceneMemory), and
    /// [`Error::MissingFeature`](crate::Error::MissingFeature) if this crate was built without the feature
    /// `draco` and there is no uncompressed data.
    pub(super) fn decode<'p>(
        &mut self,
        path: &Path,
        root: &Root,
        buffers: &Buffers<'_>,
        mesh: &str,
        primitives: impl Iterator<Item = (u32, &'p Primitive)>,
    ) -> Result<()> {
        for (number, primitive) in primitives {
            let Some(extension) = extension(primitive) else { continue };
            if has_fallback(root, primitive) {
                continue;
            }
            let place = format!("primitive {number} of mesh {mesh:?}");
            let broken = |what: &str| bad(path, format!("the Draco data of {place} {what}"));
            let Some((view, ids)) = view_and_ids(extension) else {
                return Err(broken("has no buffer view or no attributes"));
            };
            if !self.of_view.contains_key(&view) {
                let (bytes, _) = buffers.view(root, view)?;
                let stated = stated(root, primitive, ids);
                let decoded = decode_stream(buffers, bytes, stated, &place, &broken)?;
                self.of_view.insert(view, decoded);
            }
            let Some(stream) = self.of(primitive) else { continue };
            for (semantic, accessor) in &primitive.attributes {
                let semantic = semantic.to_string();
                if ids.contains_key(&semantic) && stream.attribute(&semantic).is_none() {
                    return Err(broken(&format!("lacks its attribute {semantic}")));
                }
                let is_sparse = root.accessors.get(accessor.value()).is_some_and(|a| a.sparse.is_some());
                if ids.contains_key(&semantic) && is_sparse {
                    return Err(broken(&format!("has its attribute {semantic} in a sparse accessor too")));
                }
            }
        }
        Ok(())
    }

    /// The decoded stream of a primitive, if it has one.
    pub(super) fn of<'s, 'p>(&'s self, primitive: &'p Primitive) -> Option<Compressed<'s, 'p>> {
        let (view, ids) = view_and_ids(extension(primitive)?)?;
        self.of_view.get(&view).map(|decoded| Compressed { view, decoded, ids })
    }
}

fn extension(primitive: &Primitive) -> Option<&Value> {
    primitive.extensions.as_ref()?.others.get(EXTENSION)
}

fn view_and_ids(extension: &Value) -> Option<(usize, &Map<String, Value>)> {
    let view = index_of(extension.get("bufferView")?)?;
    Some((view, extension.get("attributes")?.as_object()?))
}

/// Whether all accessors of a primitive have uncompressed data, and the file does not require the extension.
fn has_fallback(root: &Root, primitive: &Primitive) -> bool {
    let mut accessors = primitive.attributes.values().chain(&primitive.indices);
    let has_data = |index: usize| root.accessors.get(index).is_some_and(|a| a.buffer_view.is_some());
    !root.extensions_required.iter().any(|name| name == EXTENSION) && accessors.all(|a| has_data(a.value()))
}

/// What a primitive's accessors state.
fn stated(root: &Root, primitive: &Primitive, ids: &Map<String, Value>) -> Stated {
    let count = |index: usize| root.accessors.get(index).map_or(0, |a| a.count.0);
    let points = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
    let size = |index: usize| {
        let json = root.accessors.get(index)?;
        let (Checked::Valid(kind), Checked::Valid(shape)) = (json.component_type, json.type_) else {
            return None;
        };
        Some((kind.0.size() * shape.multiplicity()) as u64)
    };
    let compressed = primitive.attributes.iter().filter(|(s, _)| ids.contains_key(&s.to_string()));
    Stated {
        // A strip of n indices has n - 2 triangles; some writers state a list's count for it.
        triangles: primitive.indices.map(|i| match primitive.mode {
            Checked::Valid(::gltf::json::mesh::Mode::Triangles) => count(i.value()) / 3,
            _ => count(i.value()),
        }),
        points: points.map_or(0, |p| count(p.value())),
        point_bytes: compressed.filter_map(|(_, a)| size(a.value())).sum(),
    }
}

#[cfg(feature = "draco")]
fn decode_stream(
    buffers: &Buffers<'_>,
    bytes: &[u8],
    stated: Stated,
    place: &str,
    broken: &dyn Fn(&str) -> crate::Error,
) -> Result<Decoded> {
    stream::decode(bytes, stated, &buffers.sources.budget, place).map_err(|fault| match fault {
        stream::Fault::Broken(what) => broken(&what),
        stream::Fault::Memory(error) => error,
    })
}

#[cfg(not(feature = "draco"))]
fn decode_stream(
    buffers: &Buffers<'_>,
    _: &[u8],
    _: Stated,
    _: &str,
    _: &dyn Fn(&str) -> crate::Error,
) -> Result<Decoded> {
    Err(crate::Error::MissingFeature {
        path: buffers.sources.scene.to_owned(),
        what: EXTENSION,
        feature: "draco",
    })
}
