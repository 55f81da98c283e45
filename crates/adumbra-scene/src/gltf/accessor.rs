//! Reads accessors one element at a time, after checking all bounds: float or integer, normalised or not
//! (KHR_mesh_quantization), strided, sparse. Only the list of sparse elements is allocated.

use std::path::Path;

use ::gltf::json::Root;
use ::gltf::json::accessor::{Accessor as Json, ComponentType, Type};
use ::gltf::json::validation::Checked;
use hashbrown::HashMap;

use crate::error::Result;
use crate::gltf::container::Buffers;
use crate::gltf::draco::{Attribute, Decoded};
use crate::gltf::faults::bad;

/// An accessor whose bounds have been checked.
pub(super) struct Accessor<'a> {
    /// Number of elements.
    pub(super) count: usize,
    /// Number of components per element.
    pub(super) components: usize,
    kind: ComponentType,
    normalized: bool,
    /// Bytes from the first element on; `None` if all elements are initialised to zero.
    base: Option<&'a [u8]>,
    stride: usize,
    sparse: HashMap<u32, &'a [u8]>,
}

/// Number of elements by which an accessor without bytes may exceed the total buffer size in bytes.
const ZEROS_ALLOWED: u64 = 4096;

impl<'a> Accessor<'a> {
    /// Opens an accessor and checks that every element is within its buffer view.
    pub(super) fn open(path: &Path, root: &'a Root, buffers: &'a Buffers<'_>, index: usize) -> Result<Self> {
        let broken = |what: &str| bad(path, format!("accessor {index} {what}"));
        let json: &Json = root.accessors.get(index).ok_or_else(|| broken("does not exist"))?;
        buffers.faults.check(path, "accessor", index)?;
        let (Checked::Valid(kind), Checked::Valid(shape)) = (&json.component_type, &json.type_) else {
            return Err(broken("has an unknown type"));
        };
        let (kind, components) = (kind.0, component_count(*shape));
        let size = components * kind_size(kind);
        let count = usize::try_from(json.count.0).ok().filter(|&n| u32::try_from(n).is_ok());
        let count = count.ok_or_else(|| broken("has too many elements"))?;
        let mut stride = size;
        let base = match json.buffer_view {
            Some(view) => {
                let (bytes, view) = buffers.view(root, view.value())?;
                stride = view.byte_stride.map_or(size, |s| if s.0 == 0 { size } else { s.0 });
                if stride < size {
                    return Err(broken("has a stride smaller than its elements"));
                }
                let bytes = slice_from(bytes, json.byte_offset.map_or(0, |o| o.0));
                let bytes = bytes.ok_or_else(|| broken("begins past its buffer view"))?;
                let needed =
                    count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size));
                if needed.is_none_or(|n| n > bytes.len()) {
                    return Err(broken("reaches past its buffer view"));
                }
                Some(bytes)
            }
            None if count as u64 > buffers.total() + ZEROS_ALLOWED => {
                return Err(broken("has more elements than the file could describe"));
            }
            None => None,
        };
        let mut accessor = Self {
            count,
            components,
            kind,
            normalized: json.normalized,
            base,
            stride,
            sparse: HashMap::new(),
        };
        if let Some(sparse) = &json.sparse {
            let Checked::Valid(index_kind) = sparse.indices.component_type else {
                return Err(broken("has sparse indices of an unknown type"));
            };
            let part = |view: usize, offset: u64, size: usize| -> Result<&'a [u8]> {
                let (bytes, _) = buffers.view(root, view)?;
                let n = usize::try_from(sparse.count.0).ok().and_then(|n| n.checked_mul(size));
                let bytes = slice_from(bytes, offset).zip(n).and_then(|(b, n)| b.get(..n));
                bytes.ok_or_else(|| broken("has sparse elements past their buffer view"))
            };
            // Each opened accessor has its own list, even if several share the same bytes.
            if sparse.count.0 > count as u64 {
                return Err(broken("replaces more elements than it has"));
            }
            let bytes = sparse.count.0.saturating_mul(2 * size_of::<(u32, &[u8])>() as u64);
            buffers.sources.budget.charge(bytes, || format!("the sparse elements of accessor {index}"))?;
            let index_size = kind_size(index_kind.0);
            let at = part(sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0, index_size)?;
            let to = part(sparse.values.buffer_view.value(), sparse.values.byte_offset.0, size)?;
            for (at, to) in at.chunks_exact(index_size).zip(to.chunks_exact(size)) {
                let at = number(index_kind.0, false, at) as u32;
                if at as usize >= count {
                    return Err(broken("replaces an element that it does not have"));
                }
                accessor.sparse.insert(at, to);
            }
        }
        Ok(accessor)
    }

    /// An accessor whose elements come from a Draco stream.
    pub(super) fn decoded(
        path: &Path,
        root: &Root,
        stream: &Decoded,
        attribute: &'a Attribute,
        index: usize,
    ) -> Result<Self> {
        let broken = |what: &str| bad(path, format!("accessor {index} {what}"));
        let json: &Json = root.accessors.get(index).ok_or_else(|| broken("does not exist"))?;
        if !matches!(json.type_, Checked::Valid(shape) if component_count(shape) == attribute.components) {
            return Err(broken("has not as many components as its Draco data"));
        }
        let normalized = json.normalized;
        Ok(Self {
            normalized,
            ..Self::packed(attribute.kind, attribute.components, stream.points, &attribute.bytes)
        })
    }

    /// The corners of a Draco stream's triangles.
    pub(super) fn corners(stream: &'a Decoded) -> Self {
        Self::packed(ComponentType::U32, 1, stream.corner_count(), &stream.corners)
    }

    fn packed(kind: ComponentType, components: usize, count: usize, bytes: &'a [u8]) -> Self {
        let stride = components * kind_size(kind);
        let (base, sparse) = (Some(bytes), HashMap::new());
        Self { count, components, kind, normalized: false, base, stride, sparse }
    }

    /// Element `index` as floats, or `None` if it does not exist. Missing components are 0.
    pub(super) fn floats<const N: usize>(&self, index: usize) -> Option<[f32; N]> {
        self.components(index, self.normalized, |component| component as f32)
    }

    /// Element `index` as unsigned integers (indices, joints), or `None` if it does not exist.
    pub(super) fn integers<const N: usize>(&self, index: usize) -> Option<[u32; N]> {
        self.components(index, false, |component| component as u32)
    }

    fn components<T: Copy + Default, const N: usize>(
        &self,
        index: usize,
        normalized: bool,
        convert: impl Fn(f64) -> T,
    ) -> Option<[T; N]> {
        let mut out = [T::default(); N];
        for (value, bytes) in out.iter_mut().zip(self.element(index)?.chunks_exact(kind_size(self.kind))) {
            *value = convert(number(self.kind, normalized, bytes));
        }
        Some(out)
    }

    /// Whether the components are unsigned integers.
    pub(super) fn is_unsigned(&self) -> bool {
        matches!(self.kind, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
    }

    fn element(&self, index: usize) -> Option<&'a [u8]> {
        if index >= self.count {
            return None;
        }
        if !self.sparse.is_empty()
            && let Some(bytes) = self.sparse.get(&(index as u32))
        {
            return Some(bytes);
        }
        let size = self.components * kind_size(self.kind);
        match self.base {
            Some(bytes) => bytes.get(index * self.stride..)?.get(..size),
            None => Some(&[]),
        }
    }
}

fn slice_from(bytes: &[u8], offset: u64) -> Option<&[u8]> {
    bytes.get(usize::try_from(offset).ok()?..)
}

fn component_count(shape: Type) -> usize {
    match shape {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 | Type::Mat2 => 4,
        Type::Mat3 => 9,
        Type::Mat4 => 16,
    }
}

fn kind_size(kind: ComponentType) -> usize {
    match kind {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

/// Decodes one component; missing bytes give 0. Normalisation follows glTF 2.0, section 3.11.
fn number(kind: ComponentType, normalized: bool, bytes: &[u8]) -> f64 {
    let two = || bytes.first_chunk().copied().unwrap_or_default();
    let four = || bytes.first_chunk().copied().unwrap_or_default();
    let one = bytes.first().copied().unwrap_or_default();
    let (value, full) = match kind {
        ComponentType::I8 => (f64::from(one as i8), 127.0),
        ComponentType::U8 => (f64::from(one), 255.0),
        ComponentType::I16 => (f64::from(i16::from_le_bytes(two())), 32767.0),
        ComponentType::U16 => (f64::from(u16::from_le_bytes(two())), 65535.0),
        ComponentType::U32 => (f64::from(u32::from_le_bytes(four())), 4_294_967_295.0),
        ComponentType::F32 => return f64::from(f32::from_le_bytes(four())),
    };
    if normalized { (value / full).max(-1.0) } else { value }
}
