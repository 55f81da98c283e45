//! A file's words as a shader reads them: its sections, one after the other.

use std::borrow::Cow;

use crate::file::LightBody;

/// The 32-bit words of a file's voxels, in three consecutive parts.
///
/// | layout | parts |
/// |---|---|
/// | plain | top grid; nodes; leaf masks, the low half first |
/// | packed | top; units, two per word, the lower first; shared leaf masks, the low half first |
/// | depths | roots, two words each; wide entries, two words each; code, two half-words per word |
#[derive(Clone, Debug)]
pub struct Words<'f> {
    parts: [Cow<'f, [u32]>; 3],
}

impl<'f> Words<'f> {
    /// Returns the words of a file's voxels. Cost: a copy of the leaf masks and the packed units; the other parts are
    /// borrowed.
    pub fn new(body: &'f LightBody) -> Self {
        let halves = |masks: &[u64]| masks.iter().flat_map(|&m| [m as u32, (m >> 32) as u32]).collect();
        let parts = match body {
            LightBody::Plain(dag) => [
                Cow::Borrowed(&dag.top[..]),
                Cow::Borrowed(&dag.nodes[..]),
                Cow::Owned(halves(&dag.leaf_masks)),
            ],
            LightBody::Packed(packed) => {
                let two = |[low, high]: &[u16; 2]| u32::from(*low) | u32::from(*high) << 16;
                let units = packed.units.as_chunks().0.iter().map(two).collect();
                [Cow::Borrowed(&packed.top[..]), Cow::Owned(units), Cow::Owned(halves(&packed.leaf_masks))]
            }
            LightBody::Depths(depths) => [
                Cow::Borrowed(depths.top.as_flattened()),
                Cow::Borrowed(depths.wide.as_flattened()),
                Cow::Borrowed(&depths.code[..]),
            ],
        };
        Self { parts }
    }

    /// Returns the three parts, in order.
    pub fn parts(&self) -> [&[u32]; 3] {
        self.parts.each_ref().map(|part| &part[..])
    }

    /// Returns all words, one part after the other.
    pub fn iter(&self) -> impl Iterator<Item = u32> {
        self.parts.iter().flat_map(|part| part.iter().copied())
    }

    /// Returns the number of words.
    pub fn count(&self) -> u64 {
        self.parts.iter().map(|part| part.len() as u64).sum()
    }

    /// Returns the indices of the first words of the second and the third part.
    pub(super) fn offsets(body: &LightBody) -> [u32; 2] {
        let [first, second] = match body {
            LightBody::Plain(dag) => [dag.top.len(), dag.nodes.len()],
            LightBody::Packed(packed) => [packed.top.len(), packed.units.len() / 2],
            LightBody::Depths(depths) => [2 * depths.top.len(), 2 * depths.wide.len()],
        };
        [first as u32, (first + second) as u32]
    }
}
