//! Proves that a graph from anywhere can be walked: every pointer leads to a node or slab that exists, every path
//! ends, and the words are the only ones that this graph can be written with.
//!
//! Nodes are numbered in pre-order of first visit, so one walk proves everything: the first pointer to a node must be
//! the next free word, every later one must name a header that the walk has already met at the same level, or one with
//! no slab below it, which means the same at every level that leaves room for its height. A node is entered once, and
//! the level falls by one a step; so the walk takes time linear in the words and its depth is at most
//! `root_level - 2`. Whether equal nodes were merged is not checked: that decides the size, not the answers.

use super::top_error::{TopError, check_count, check_dims};
use super::{Dag, LIT, SHADOWED, SLAB_NODE_LEVEL};

/// Largest root level: a root cube of 2^20 voxels a side.
pub const MAX_ROOT_LEVEL: u32 = 20;

/// Where in the graph a fault lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraphPlace {
    /// An entry of the top grid.
    Top {
        /// Its index.
        index: usize,
    },
    /// A word of the nodes.
    Node {
        /// Its index.
        word: usize,
    },
    /// A slab.
    Slab {
        /// Its index.
        index: usize,
    },
}

impl std::fmt::Display for GraphPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Top { index } => write!(f, "top grid entry {index}"),
            Self::Node { word } => write!(f, "node word {word}"),
            Self::Slab { index } => write!(f, "slab {index}"),
        }
    }
}

/// A structural fault of a graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphError {
    /// Of the top grid, or of a size.
    #[error(transparent)]
    Top(#[from] TopError),
    /// A pointer leads behind the end of the nodes or slabs.
    #[error("{place} points to {target} {pointer}, but there are only {count}")]
    PointerRange {
        /// The pointer's place.
        place: GraphPlace,
        /// "node word" or "slab".
        target: &'static str,
        /// The pointer.
        pointer: u32,
        /// How many words or slabs there are.
        count: u64,
    },
    /// The first pointer to a node or slab is not the next in order of first visit.
    #[error("{place} points to {target} {pointer}, but in order of first visit the next one is {expected}")]
    Order {
        /// The pointer's place.
        place: GraphPlace,
        /// "node word" or "slab".
        target: &'static str,
        /// The pointer.
        pointer: u32,
        /// The next free word or slab.
        expected: usize,
    },
    /// A pointer leads into the middle of a node.
    #[error("{place} points to node word {pointer}, which is a pointer and not a node's header")]
    NotAHeader {
        /// The pointer's place.
        place: GraphPlace,
        /// The pointer.
        pointer: u32,
    },
    /// A node with slabs below it is used at two levels, or one without at a level too low; every cycle is one of these.
    #[error(
        "{place} points to node word {pointer} as a node of level {level}, but it is one of level {first_level}"
    )]
    TwoLevels {
        /// The pointer's place.
        place: GraphPlace,
        /// The pointer.
        pointer: u32,
        /// Level that this pointer asks for.
        level: u32,
        /// Level at which the node was met first; for one without slabs the lowest at which it could be.
        first_level: u32,
    },
    /// A header's upper half is not zero.
    #[error("{place} is the header {header:#010x}, whose bits 31 to 16 are not zero")]
    HeaderBits {
        /// The header's place.
        place: GraphPlace,
        /// The header.
        header: u32,
    },
    /// A child state is 3, which means nothing.
    #[error("{place} is the header {header:#010x}, whose child {child} has the state 3")]
    ChildState {
        /// The header's place.
        place: GraphPlace,
        /// The header.
        header: u32,
        /// The first such child.
        child: u32,
    },
    /// A node's pointers go on behind the end of the nodes.
    #[error("{place} is a header with {pointers} pointers, but the nodes end at word {count}")]
    NodeEnd {
        /// The header's place.
        place: GraphPlace,
        /// Pointers that must follow.
        pointers: usize,
        /// Node words there are.
        count: usize,
    },
    /// A node or slab that is all lit or all shadowed; its parent should say so.
    #[error("{place} is all {state}; the entry that points to it should say so itself")]
    Uniform {
        /// The node's or slab's place.
        place: GraphPlace,
        /// "lit" or "shadowed".
        state: &'static str,
    },
    /// Words or slabs that no pointer leads to.
    #[error("{place} and everything behind it ({count} in all) is not reached from any root")]
    Unreachable {
        /// The first of them.
        place: GraphPlace,
        /// How many words or slabs.
        count: usize,
    },
}

impl GraphError {
    /// The variant's name, stable across versions; test vectors use it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Top(error) => error.kind(),
            Self::PointerRange { .. } => "PointerRange",
            Self::Order { .. } => "Order",
            Self::NotAHeader { .. } => "NotAHeader",
            Self::TwoLevels { .. } => "TwoLevels",
            Self::HeaderBits { .. } => "HeaderBits",
            Self::ChildState { .. } => "ChildState",
            Self::NodeEnd { .. } => "NodeEnd",
            Self::Uniform { .. } => "Uniform",
            Self::Unreachable { .. } => "Unreachable",
        }
    }
}

impl Dag {
    /// Roots along x, y, z that cover `size` voxels: `ceil(size / 2^root_level)`. `root_level` is at most 31.
    pub fn top_dims_covering(size: [u32; 3], root_level: u32) -> [u32; 3] {
        size.map(|n| n.div_ceil(1 << root_level.min(31)))
    }

    /// Checks that every look-up ends at an answer and that the words are canonical; see the module's text.
    ///
    /// Cost: one pass over all words, and a byte of memory a node word.
    ///
    /// # Errors
    /// The first fault in pre-order.
    pub fn validate(&self) -> Result<(), GraphError> {
        check_dims(self.size, self.root_level, self.top_dims)?;
        let (found, expected) =
            (self.top.len() as u64, self.top_dims.iter().map(|&n| u128::from(n)).product());
        if u128::from(found) != expected {
            return Err(TopError::TopLength { found, expected }.into());
        }
        check_count("node words", self.nodes.len() as u64, SHADOWED.into())?;
        check_count("slabs", self.slabs.len() as u64, 1 << 32)?;

        let mut walk = Walk { dag: self, level_of: vec![0; self.nodes.len()], nodes_seen: 0, slabs_seen: 0 };
        for (index, &entry) in self.top.iter().enumerate() {
            if entry != LIT && entry != SHADOWED {
                walk.node(entry, self.root_level, GraphPlace::Top { index })?;
            }
        }
        walk.finish()
    }
}

/// A node with no slab below it means the same at every level that its height fits; its byte is this plus the height.
const SLAB_FREE: u32 = 128;

/// The pre-order walk: everything below `nodes_seen` and `slabs_seen` has been met and found good.
struct Walk<'a> {
    dag: &'a Dag,
    /// Level of the node whose header stands at a word, or [`SLAB_FREE`] plus its height; 0 for pointers and for words
    /// not met yet.
    level_of: Vec<u8>,
    nodes_seen: usize,
    slabs_seen: usize,
}

impl Walk<'_> {
    fn node(&mut self, pointer: u32, level: u32, from: GraphPlace) -> Result<u8, GraphError> {
        let (at, count) = (pointer as usize, self.dag.nodes.len());
        if at < self.nodes_seen {
            return match u32::from(self.level_of[at]) {
                0 => Err(GraphError::NotAHeader { place: from, pointer }),
                kind if kind >= SLAB_FREE && level >= SLAB_NODE_LEVEL + (kind - SLAB_FREE) => Ok(kind as u8),
                kind if kind == level => Ok(kind as u8),
                kind => {
                    let first_level =
                        if kind >= SLAB_FREE { SLAB_NODE_LEVEL + kind - SLAB_FREE } else { kind };
                    Err(GraphError::TwoLevels { place: from, pointer, level, first_level })
                }
            };
        }
        let target = "node word";
        let Some(&header) = self.dag.nodes.get(at) else {
            return Err(GraphError::PointerRange { place: from, target, pointer, count: count as u64 });
        };
        if at != self.nodes_seen {
            return Err(GraphError::Order { place: from, target, pointer, expected: self.nodes_seen });
        }
        let pointers = check_header(header, GraphPlace::Node { word: at })?;
        let end = at + 1 + pointers;
        if end > count {
            return Err(GraphError::NodeEnd { place: GraphPlace::Node { word: at }, pointers, count });
        }
        self.level_of[at] = level as u8;
        self.nodes_seen = end;
        let mut kind = SLAB_FREE as u8;
        for word in at + 1..end {
            let place = GraphPlace::Node { word };
            if level == SLAB_NODE_LEVEL {
                self.slab(self.dag.nodes[word], place)?;
                kind = level as u8;
            } else {
                let child = self.node(self.dag.nodes[word], level - 1, place)?;
                let slab_free = u32::from(child) >= SLAB_FREE && u32::from(kind) >= SLAB_FREE;
                kind = if slab_free { kind.max(child + 1) } else { level as u8 };
            }
        }
        self.level_of[at] = kind;
        Ok(kind)
    }

    fn slab(&mut self, pointer: u32, from: GraphPlace) -> Result<(), GraphError> {
        let (index, count) = (pointer as usize, self.dag.slabs.len());
        if index < self.slabs_seen {
            return Ok(());
        }
        let target = "slab";
        let Some(&mask) = self.dag.slabs.get(index) else {
            return Err(GraphError::PointerRange { place: from, target, pointer, count: count as u64 });
        };
        if index != self.slabs_seen {
            return Err(GraphError::Order { place: from, target, pointer, expected: self.slabs_seen });
        }
        self.slabs_seen += 1;
        match mask {
            0 => Err(GraphError::Uniform { place: GraphPlace::Slab { index }, state: "shadowed" }),
            u64::MAX => Err(GraphError::Uniform { place: GraphPlace::Slab { index }, state: "lit" }),
            _ => Ok(()),
        }
    }

    fn finish(&self) -> Result<(), GraphError> {
        let (nodes, slabs) = (self.dag.nodes.len() - self.nodes_seen, self.dag.slabs.len() - self.slabs_seen);
        if nodes > 0 {
            let place = GraphPlace::Node { word: self.nodes_seen };
            return Err(GraphError::Unreachable { place, count: nodes });
        }
        if slabs > 0 {
            let place = GraphPlace::Slab { index: self.slabs_seen };
            return Err(GraphError::Unreachable { place, count: slabs });
        }
        Ok(())
    }
}

/// Checks a header by itself; returns how many pointers follow it.
fn check_header(header: u32, place: GraphPlace) -> Result<usize, GraphError> {
    if header >> 16 != 0 {
        return Err(GraphError::HeaderBits { place, header });
    }
    let threes = header & header >> 1 & 0x5555;
    if threes != 0 {
        return Err(GraphError::ChildState { place, header, child: threes.trailing_zeros() / 2 });
    }
    match header {
        0x0000 => Err(GraphError::Uniform { place, state: "shadowed" }),
        0x5555 => Err(GraphError::Uniform { place, state: "lit" }),
        _ => Ok((header & 0xAAAA).count_ones() as usize),
    }
}
