//! One compressed buffer view: its description, read from the extension's JSON, and its decoding.

use meshoptimizer_rs::{Error, Limits, Workspace, codec};
use serde_json::Value;

use crate::gltf::numbers::whole;

/// A compressed buffer view, as its extension describes it.
pub(in crate::gltf) struct Compressed {
    /// The name of the extension.
    pub(in crate::gltf) extension: &'static str,
    /// The buffer with the compressed bytes.
    pub(in crate::gltf) buffer: usize,
    /// Offset of the compressed bytes in the buffer.
    pub(in crate::gltf) byte_offset: u64,
    /// Number of compressed bytes.
    pub(in crate::gltf) byte_length: u64,
    /// Bytes per decoded element.
    stride: u64,
    /// Number of decoded elements.
    count: u64,
    mode: Mode,
    filter: Filter,
}

/// The content of a compressed buffer view.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// Elements of any kind.
    Attributes,
    /// Corners of triangles, three per triangle.
    Triangles,
    /// Indices of any kind.
    Indices,
}

/// How decoded elements are turned into the accessor's numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Compressed {
    /// Reads a buffer view's extension. `byte_stride` is that of the view itself. The error is a clause about
    /// the view.
    pub(in crate::gltf) fn read(
        extension: &'static str,
        json: &Value,
        byte_stride: Option<u64>,
    ) -> Result<Self, String> {
        let number = |key: &str| json.get(key).and_then(whole);
        let needed = |key: &str| number(key).ok_or_else(|| format!("its {extension} has no {key}"));
        let word = |key: &str| json.get(key).and_then(Value::as_str);
        let unknown = |key: &str| format!("its {extension} has an unknown {key}");
        let mode = match word("mode") {
            Some("ATTRIBUTES") => Mode::Attributes,
            Some("TRIANGLES") => Mode::Triangles,
            Some("INDICES") => Mode::Indices,
            _ => return Err(unknown("mode")),
        };
        let filter = match (json.get("filter"), word("filter")) {
            (None, _) | (_, Some("NONE")) => Filter::None,
            (_, Some("OCTAHEDRAL")) => Filter::Octahedral,
            (_, Some("QUATERNION")) => Filter::Quaternion,
            (_, Some("EXPONENTIAL")) => Filter::Exponential,
            (_, Some("COLOR")) => Filter::Color,
            _ => return Err(unknown("filter")),
        };
        let (stride, count) = (needed("byteStride")?, needed("count")?);
        let fits = match (mode, filter) {
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => stride == 4 || stride == 8,
            (Mode::Attributes, Filter::Quaternion) => stride == 8,
            (Mode::Attributes, _) => stride > 0 && stride <= 256 && stride.is_multiple_of(4),
            (_, Filter::None) => stride == 2 || stride == 4,
            _ => return Err(format!("its {extension} has a filter on indices")),
        };
        if !fits || byte_stride.is_some_and(|own| own != stride) {
            return Err(format!("its {extension} has a byteStride of {stride}, which does not fit"));
        }
        if mode == Mode::Triangles && !count.is_multiple_of(3) {
            return Err(format!("its {extension} has {count} corners, which make no triangles"));
        }
        Ok(Self {
            extension,
            buffer: usize::try_from(needed("buffer")?).unwrap_or(usize::MAX),
            byte_offset: number("byteOffset").unwrap_or(0),
            byte_length: needed("byteLength")?,
            stride,
            count,
            mode,
            filter,
        })
    }

    /// The size of the decoded view, bytes.
    pub(in crate::gltf) fn decoded_bytes(&self) -> u64 {
        self.stride.saturating_mul(self.count)
    }

    /// Decodes the view into [`Self::decoded_bytes`] bytes. The error is a clause about the view.
    pub(in crate::gltf) fn decode(&self, compressed: &[u8]) -> Result<Vec<u8>, String> {
        let too_large = || format!("its {} has {} elements, which is too many", self.extension, self.count);
        let stride = usize::try_from(self.stride).map_err(|_| too_large())?;
        let count = usize::try_from(self.count).map_err(|_| too_large())?;
        let mut workspace = Workspace::new(Limits { max_bytes: usize::MAX, max_work: u64::MAX });
        let work = &mut workspace;
        let decoded = match self.mode {
            _ if count == 0 => return Ok(Vec::new()),
            Mode::Attributes => codec::decode_vertex_buffer(count, stride, compressed, work),
            Mode::Triangles => codec::decode_index_buffer(count, stride, compressed, work),
            Mode::Indices => codec::decode_index_sequence(count, stride, compressed, work),
        };
        let filtered = decoded.and_then(|mut bytes| {
            match self.filter {
                Filter::None => Ok(()),
                Filter::Octahedral => codec::decode_filter_oct(&mut bytes, count, stride, work),
                Filter::Quaternion => codec::decode_filter_quat(&mut bytes, count, stride, work),
                Filter::Exponential => codec::decode_filter_exp(&mut bytes, count, stride, work),
                Filter::Color => codec::decode_filter_color(&mut bytes, count, stride, work),
            }?;
            Ok(bytes)
        });
        filtered.map_err(|error| match error {
            Error::UnsupportedVersion => {
                format!("its {} has an unknown version of the codec", self.extension)
            }
            Error::AllocationFailed | Error::LimitExceeded | Error::SizeOverflow => too_large(),
            _ => format!("its {} has broken data", self.extension),
        })
    }
}
