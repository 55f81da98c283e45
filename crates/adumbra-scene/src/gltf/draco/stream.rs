//! Decodes a Draco stream with the crate `draco-core`, within a memory budget.
//!
//! Memory is charged before decoding, from the counts in the stream's header and the counts that the
//! accessors state. The decoder is limited to the same numbers. The constants below are upper bounds on its
//! peak memory; `docs/decoders.md` has the measurements.

use ::gltf::json::accessor::ComponentType;
use draco_core::{
    DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute, PointIndex,
};

use super::header::Header;
use super::{Attribute, Decoded, Stated};
use crate::Error;
use crate::budget::Budget;

/// Memory that decoding takes whatever the counts: tables of the entropy coder, bytes.
const TABLE_BYTES: u64 = 8 << 20;
/// Memory per triangle while it is decoded, bytes.
const TRIANGLE_BYTES: u64 = 64;
/// Memory per triangle and attribute with separate connectivity, bytes.
const SEAMED_TRIANGLE_BYTES: u64 = 32;
/// Memory per point while it is decoded, without its attributes, bytes.
const POINT_BYTES: u64 = 32;
/// Memory per byte of a point's attributes: a value of one byte is decoded in two steps of four bytes each.
const ATTRIBUTE_FACTOR: u64 = 9;
/// A stream may have this many more bytes of attributes per point than the primitive's accessors state.
const UNSTATED_POINT_BYTES: u64 = 16;

/// Why a stream could not be decoded.
pub(super) enum Fault {
    /// What is wrong with the stream.
    Broken(String),
    /// The stream does not fit the memory budget.
    Memory(Error),
}

/// Decodes a stream; `place` describes the primitive it belongs to. The result stays charged to the budget.
pub(super) fn decode(
    bytes: &[u8],
    stated: Stated,
    budget: &Budget<'_>,
    place: &str,
) -> Result<Decoded, Fault> {
    let header = Header::read(bytes).map_err(Fault::Broken)?;
    check(&header, stated)?;
    let most = header.points.unwrap_or(header.triangles.saturating_mul(3));
    // The accessors should state the number of points in the stream, but some writers state that of the mesh
    // before it was cut along its seams.
    let first = stated.points.min(most);
    match decode_points(bytes, &header, first, stated, budget, place) {
        Err(Attempt::TooMany) if first < most => decode_points(bytes, &header, most, stated, budget, place),
        other => other,
    }
    .map_err(|attempt| match attempt {
        Attempt::TooMany => Fault::Broken("has more attributes than its accessors state".to_owned()),
        Attempt::Failed(fault) => fault,
    })
}

/// Refuses counts that the accessors contradict, before any memory is charged for them.
fn check(header: &Header, stated: Stated) -> Result<(), Fault> {
    let &Header { triangles, points, .. } = header;
    if let Some(most) = stated.triangles
        && triangles > most
    {
        let what = format!("has {triangles} triangles, but its accessors state {most}");
        return Err(Fault::Broken(what));
    }
    match points {
        Some(points) if points > stated.points.max(triangles.saturating_mul(3)) => {
            let most = stated.points;
            Err(Fault::Broken(format!("has {points} points, but its accessors state {most}")))
        }
        _ => Ok(()),
    }
}

/// Why one attempt failed.
enum Attempt {
    /// The stream has more points than were allowed.
    TooMany,
    Failed(Fault),
}

impl From<Error> for Attempt {
    fn from(error: Error) -> Self {
        Self::Failed(Fault::Memory(error))
    }
}

fn decode_points(
    bytes: &[u8],
    header: &Header,
    points: u64,
    stated: Stated,
    budget: &Budget<'_>,
    place: &str,
) -> Result<Decoded, Attempt> {
    let point_bytes = stated.point_bytes.saturating_add(UNSTATED_POINT_BYTES);
    let attribute_bytes = points.saturating_mul(point_bytes);
    let triangle_bytes = TRIANGLE_BYTES + header.seamed * SEAMED_TRIANGLE_BYTES;
    let passing = [
        TABLE_BYTES,
        header.triangles.saturating_mul(triangle_bytes),
        points.saturating_mul(POINT_BYTES),
        attribute_bytes.saturating_mul(ATTRIBUTE_FACTOR),
    ];
    let passing = passing.into_iter().fold(0, u64::saturating_add);
    let what = || format!("the Draco data of {place} with {} triangles", header.triangles);
    budget.charge(passing, what)?;
    budget.charge_decoding(header.triangles.saturating_mul(12).saturating_add(attribute_bytes), what)?;
    let limits = DecodeLimits::default()
        .with_max_points(points)
        .with_max_faces(header.triangles)
        .with_max_decoded_bytes(attribute_bytes);
    let mut mesh = Mesh::new();
    let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
    let decoded = match MeshDecoder::new().decode(&mut buffer, &mut mesh) {
        Ok(()) => unpack(&mesh, budget, &what),
        Err(error) if error.kind() == ErrorKind::LimitExceeded => Err(Attempt::TooMany),
        Err(error) => Err(Attempt::Failed(Fault::Broken(what_is_wrong(error.kind()).to_owned()))),
    };
    drop(mesh);
    budget.release(passing);
    decoded
}

fn what_is_wrong(kind: ErrorKind) -> &'static str {
    match kind {
        // For integer normals, Google's encoder uses the prediction of octahedral normals, so that its
        // decoder returns other values.
        ErrorKind::InvalidParameter => {
            "is damaged, or has integer normals, which encoders damage at low speeds; encode normals as floats, or at speed 4 or more"
        }
        _ => "is damaged",
    }
}

/// Copies a decoded mesh into the form that accessors read: packed values, one per point.
fn unpack(mesh: &Mesh, budget: &Budget<'_>, what: &dyn Fn() -> String) -> Result<Decoded, Attempt> {
    let points = mesh.num_points();
    let attributes = || (0..mesh.num_attributes()).filter_map(|i| mesh.try_attribute(i).ok());
    let sizes = attributes().map(|a| (a.num_components() as usize * a.data_type().byte_length()) as u64);
    let bytes = sizes.fold(0, u64::saturating_add).saturating_mul(points as u64);
    budget.charge(bytes.saturating_add(mesh.num_faces() as u64 * 12), what)?;
    let mut corners = Vec::with_capacity(mesh.num_faces() * 12);
    for corner in mesh.faces().iter().flatten() {
        corners.extend_from_slice(&corner.0.to_le_bytes());
    }
    let mut list = Vec::new();
    for attribute in attributes() {
        list.push(values(attribute, points).map_err(|what| Attempt::Failed(Fault::Broken(what)))?);
    }
    Ok(Decoded { points, corners, attributes: list })
}

fn values(attribute: &PointAttribute, points: usize) -> Result<Attribute, String> {
    let kind = match attribute.data_type() {
        DataType::Int8 => ComponentType::I8,
        DataType::Uint8 | DataType::Bool => ComponentType::U8,
        DataType::Int16 => ComponentType::I16,
        DataType::Uint16 => ComponentType::U16,
        DataType::Uint32 => ComponentType::U32,
        DataType::Float32 => ComponentType::F32,
        other => return Err(format!("has an attribute of type {other:?}, which glTF does not have")),
    };
    let components = attribute.num_components() as usize;
    let size = components * kind.size();
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(size);
    let stored = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(points * size);
    for point in 0..points as u32 {
        let from = (attribute.mapped_index(PointIndex(point)).0 as usize).checked_mul(stride);
        let value = from.and_then(|from| stored.get(from..)?.get(..size));
        bytes.extend_from_slice(value.ok_or("has an attribute with too few values")?);
    }
    Ok(Attribute { id: attribute.unique_id(), kind, components, bytes })
}
