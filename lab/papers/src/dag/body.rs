//! A graph, by layout. Each function here has one arm per layout: its header number, the
//! elements of its sections, and how they are read, written and validated.

use crate::dag::composition::Composition;
use adumbra::file::sections::u32_words;

use crate::dag::LeafMasks;
use crate::dag::file_error::DagFileError;
use crate::dag::header::{DAG_HEADER_BYTES, Header};
use crate::dag::layout::DagLayout;
use crate::dag::packed::PackedDag;
use crate::dag::plain::Dag;
use crate::sections::{CHUNK_BYTES, lay_out, u32_chunks};

/// The voxels of a graph file.
#[derive(Clone, Debug, PartialEq)]
pub enum DagBody {
    /// The plain layout: the graph as a bake builds it.
    Plain(Dag),
    /// The packed layout: the same graph in about a third of the bytes.
    Packed(PackedDag),
}

impl DagBody {
    /// Returns the layout.
    pub fn layout(&self) -> DagLayout {
        match self {
            Self::Plain(_) => DagLayout::Plain,
            Self::Packed(_) => DagLayout::Packed,
        }
    }

    /// Returns the voxels for look-ups.
    pub fn leaf_masks(&self) -> &dyn LeafMasks {
        match self {
            Self::Plain(dag) => dag,
            Self::Packed(packed) => packed,
        }
    }

    /// Returns the breakdown of the bytes.
    ///
    /// # Errors
    /// Returns [`DagFileError::Packed`] if a packed graph is not valid.
    pub fn composition(&self) -> Result<Composition, DagFileError> {
        Ok(match self {
            Self::Plain(dag) => dag.composition(),
            Self::Packed(packed) => packed.composition()?,
        })
    }

    pub(super) fn validate(&self) -> Result<(), DagFileError> {
        match self {
            Self::Plain(dag) => dag.validate()?,
            Self::Packed(packed) => packed.validate()?,
        }
        Ok(())
    }

    /// Returns the root level: a root cube spans 2^root_level voxels along each side.
    pub fn root_level(&self) -> u32 {
        self.space().1
    }

    /// Returns the number of root cubes along x, y, z.
    pub fn top_dims(&self) -> [u32; 3] {
        self.space().2
    }

    /// Returns the size in voxels, the root level, and the number of roots along each axis.
    pub fn space(&self) -> ([u32; 3], u32, [u32; 3]) {
        match self {
            Self::Plain(dag) => (dag.size, dag.root_level, dag.top_dims),
            Self::Packed(packed) => (packed.size, packed.root_level, packed.top_dims),
        }
    }

    /// Returns the size in bytes of a file with these voxels.
    pub fn encoded_len(&self) -> u64 {
        lay_out(DAG_HEADER_BYTES, self.section_lengths())[2].end()
    }

    /// Returns the sizes of the sections in bytes: top, nodes, leaf masks.
    pub fn section_lengths(&self) -> [u64; 3] {
        let [top, nodes, leaf_masks] = match self {
            Self::Plain(dag) => [dag.top.len() * 4, dag.nodes.len() * 4, dag.leaf_masks.len() * 8],
            Self::Packed(packed) => {
                [packed.top.len() * 4, packed.units.len() * 2, packed.leaf_masks.len() * 8]
            }
        };
        [top as u64, nodes as u64, leaf_masks as u64]
    }

    /// Returns the bytes of a section, in pieces of some 64 KiB.
    pub(super) fn chunks(&self, section: usize) -> Box<dyn Iterator<Item = Vec<u8>> + '_> {
        match (self, section) {
            (Self::Plain(dag), 0) => Box::new(u32_chunks(&dag.top)),
            (Self::Plain(dag), 1) => Box::new(u32_chunks(&dag.nodes)),
            (Self::Plain(dag), _) => Box::new(u64_chunks(&dag.leaf_masks)),
            (Self::Packed(packed), 0) => Box::new(u32_chunks(&packed.top)),
            (Self::Packed(packed), 1) => Box::new(u16_chunks(&packed.units)),
            (Self::Packed(packed), _) => Box::new(u64_chunks(&packed.leaf_masks)),
        }
    }

    /// Decodes the sections without validating them.
    pub(super) fn parse(header: &Header, [top, nodes, leaf_masks]: [&[u8]; 3]) -> Self {
        let (size, root_level, top_dims) = (header.grid.size, header.root_level, header.top_dims);
        let top = u32_words(top);
        let leaf_masks = || leaf_masks.as_chunks().0.iter().map(|&b| u64::from_le_bytes(b)).collect();
        match header.layout {
            DagLayout::Plain => Self::Plain(Dag {
                size,
                root_level,
                top_dims,
                top,
                nodes: u32_words(nodes),
                leaf_masks: leaf_masks(),
            }),
            DagLayout::Packed => {
                let units = nodes.as_chunks().0.iter().map(|&b| u16::from_le_bytes(b)).collect();
                Self::Packed(PackedDag { size, root_level, top_dims, top, units, leaf_masks: leaf_masks() })
            }
        }
    }
}

fn u16_chunks(units: &[u16]) -> impl Iterator<Item = Vec<u8>> {
    units.chunks(CHUNK_BYTES / 2).map(|c| c.iter().flat_map(|u| u.to_le_bytes()).collect())
}

fn u64_chunks(words: &[u64]) -> impl Iterator<Item = Vec<u8>> {
    words.chunks(CHUNK_BYTES / 8).map(|c| c.iter().flat_map(|w| w.to_le_bytes()).collect())
}
