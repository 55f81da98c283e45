//! What holds the voxels of a light-aligned file, by layout. A layout is one arm in each function here: its number in the
//! header, its sections' elements, how they are read, written and checked.

use serde::{Deserialize, Serialize};

use super::FormatError;
use super::header::Header;
use super::sections::{u16_chunks, u32_chunks, u32_words, u64_chunks};
use crate::dag::packed::{MAX_SHARED_SLABS, MAX_UNITS, PackError, PackedDag};
use crate::dag::{Composition, Dag, SHADOWED, Slabs};
use crate::hierarchy::Hierarchy;

/// How a file holds its graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// [`Dag`]: headers and pointers of 32 bits.
    Plain,
    /// [`PackedDag`]: units of 16 bits, about a third of the bytes.
    #[default]
    Packed,
    /// [`Hierarchy`]: an image of depths, the smallest.
    Hierarchy,
}

impl Layout {
    /// `plain`, `packed` or `hierarchy`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Packed => "packed",
            Self::Hierarchy => "hierarchy",
        }
    }

    /// Its number in the header.
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Plain => 0,
            Self::Packed => 1,
            Self::Hierarchy => 2,
        }
    }

    pub(super) fn of_number(number: u32) -> Option<Self> {
        [Self::Plain, Self::Packed, Self::Hierarchy].into_iter().find(|layout| layout.number() == number)
    }

    /// Bytes of an element of each section, and the most that a section may have; the top's length is another check's.
    pub(super) fn elements(self) -> [(u64, u64); 3] {
        let top = (4, u64::MAX);
        match self {
            Self::Plain => [top, (4, 4 * SHADOWED as u64), (8, 8 << 32)],
            Self::Packed => [top, (4, 2 * MAX_UNITS as u64), (8, 8 * MAX_SHARED_SLABS as u64)],
            Self::Hierarchy => [top, (4, 2 * u64::from(u32::MAX)), (8, 8 << 32)],
        }
    }
}

/// The voxels of a light-aligned file.
#[derive(Clone, Debug, PartialEq)]
pub enum LightBody {
    /// As the bake leaves it.
    Plain(Dag),
    /// Packed.
    Packed(PackedDag),
    /// Depths.
    Hierarchy(Hierarchy),
}

impl LightBody {
    /// The graph in this layout.
    ///
    /// # Errors
    /// [`PackError`] where it has no packed form, or too many columns for a hierarchy.
    pub fn of_dag(dag: Dag, layout: Layout) -> Result<Self, PackError> {
        Ok(match layout {
            Layout::Plain => Self::Plain(dag),
            Layout::Packed => Self::Packed(PackedDag::of_dag(&dag)?),
            Layout::Hierarchy => Self::Hierarchy(Hierarchy::of_slabs(&dag, dag.root_level)?),
        })
    }

    /// Its layout.
    pub fn layout(&self) -> Layout {
        match self {
            Self::Plain(_) => Layout::Plain,
            Self::Packed(_) => Layout::Packed,
            Self::Hierarchy(_) => Layout::Hierarchy,
        }
    }

    /// What look-ups read.
    pub fn slabs(&self) -> &dyn Slabs {
        match self {
            Self::Plain(dag) => dag,
            Self::Packed(packed) => packed,
            Self::Hierarchy(hierarchy) => hierarchy,
        }
    }

    /// What its bytes are spent on.
    ///
    /// # Errors
    /// [`FormatError::Packed`] where a packed graph is not valid.
    pub fn composition(&self) -> Result<Composition, FormatError> {
        Ok(match self {
            Self::Plain(dag) => dag.composition(),
            Self::Packed(packed) => packed.composition()?,
            Self::Hierarchy(hierarchy) => hierarchy.composition(),
        })
    }

    pub(super) fn validate(&self) -> Result<(), FormatError> {
        match self {
            Self::Plain(dag) => dag.validate()?,
            Self::Packed(packed) => packed.validate()?,
            Self::Hierarchy(hierarchy) => hierarchy.validate()?,
        }
        Ok(())
    }

    /// A root cube spans 2^root_level voxels a side.
    pub fn root_level(&self) -> u32 {
        self.space().1
    }

    /// Root cubes along x, y, z.
    pub fn top_dims(&self) -> [u32; 3] {
        self.space().2
    }

    /// Size, root level, roots along each axis.
    pub(super) fn space(&self) -> ([u32; 3], u32, [u32; 3]) {
        match self {
            Self::Plain(dag) => (dag.size, dag.root_level, dag.top_dims),
            Self::Packed(packed) => (packed.size, packed.root_level, packed.top_dims),
            Self::Hierarchy(Hierarchy { size, root_level, .. }) => {
                (*size, *root_level, Dag::top_dims_covering(*size, *root_level))
            }
        }
    }

    /// Bytes of the sections.
    pub(super) fn section_lengths(&self) -> [u64; 3] {
        let [top, nodes, slabs] = match self {
            Self::Plain(dag) => [dag.top.len() * 4, dag.nodes.len() * 4, dag.slabs.len() * 8],
            Self::Packed(packed) => [packed.top.len() * 4, packed.units.len() * 2, packed.slabs.len() * 8],
            Self::Hierarchy(h) => [h.top.len() * 8, h.code.len() * 4, h.wide.len() * 8],
        };
        [top as u64, nodes as u64, slabs as u64]
    }

    /// The bytes of a section, in pieces of some 64 KiB.
    pub(super) fn chunks(&self, section: usize) -> Box<dyn Iterator<Item = Vec<u8>> + '_> {
        match (self, section) {
            (Self::Plain(dag), 0) => Box::new(u32_chunks(&dag.top)),
            (Self::Plain(dag), 1) => Box::new(u32_chunks(&dag.nodes)),
            (Self::Plain(dag), _) => Box::new(u64_chunks(&dag.slabs)),
            (Self::Packed(packed), 0) => Box::new(u32_chunks(&packed.top)),
            (Self::Packed(packed), 1) => Box::new(u16_chunks(&packed.units)),
            (Self::Packed(packed), _) => Box::new(u64_chunks(&packed.slabs)),
            (Self::Hierarchy(h), 0) => Box::new(u32_chunks(h.top.as_flattened())),
            (Self::Hierarchy(h), 1) => Box::new(u32_chunks(&h.code)),
            (Self::Hierarchy(h), _) => Box::new(u32_chunks(h.wide.as_flattened())),
        }
    }

    /// The body whose sections' bytes these are, not yet checked.
    pub(super) fn parse(header: &Header, [top, nodes, slabs]: [&[u8]; 3]) -> Self {
        let (size, root_level, top_dims) = (header.grid.size, header.root_level, header.top_dims);
        let top = u32_words(top);
        let wide = slabs;
        let slabs = || slabs.as_chunks().0.iter().map(|&b| u64::from_le_bytes(b)).collect();
        match header.layout {
            Layout::Plain => {
                Self::Plain(Dag { size, root_level, top_dims, top, nodes: u32_words(nodes), slabs: slabs() })
            }
            Layout::Packed => {
                let units = nodes.as_chunks().0.iter().map(|&b| u16::from_le_bytes(b)).collect();
                Self::Packed(PackedDag { size, root_level, top_dims, top, units, slabs: slabs() })
            }
            Layout::Hierarchy => {
                let top = top.as_chunks().0.to_vec();
                let wide = u32_words(wide).as_chunks().0.to_vec();
                let top_dims = [top_dims[0], top_dims[1]];
                Self::Hierarchy(Hierarchy { size, root_level, top_dims, top, wide, code: u32_words(nodes) })
            }
        }
    }
}
