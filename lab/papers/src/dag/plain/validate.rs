//! Validates a graph from an untrusted source: every pointer leads to an existing node or leaf mask, every
//! path ends, and the words are the only ones in which this graph can be written.
//!
//! Nodes are numbered in pre-order of first visit, so one walk proves all of this. The first pointer to a
//! node must be the next free word. Every later pointer to it must name a header that the walk has already
//! visited at the same level. A node without leaf masks below it may also be named at another level, because
//! it means the same at every level that its height fits. A node is entered once, and each step goes down one
//! level, so the walk takes time linear in the words and its depth is at most `root_level - 2`. Whether equal
//! nodes were merged is not checked, since that affects the size and not the results.

use crate::dag::plain::{Dag, LIT, SHADOWED};
use crate::dag::roots::LEAF_NODE_LEVEL;
use crate::dag::top_error::{TopError, check_count, check_dims};

/// Location of a fault in a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraphPlace {
    /// An entry of the top grid.
    Top {
        /// Index of the entry.
        index: usize,
    },
    /// A word of the nodes.
    Node {
        /// Index of the word.
        word: usize,
    },
    /// A leaf mask.
    LeafMask {
        /// Index of the leaf mask.
        index: usize,
    },
}

impl std::fmt::Display for GraphPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Top { index } => write!(f, "top grid entry {index}"),
            Self::Node { word } => write!(f, "node word {word}"),
            Self::LeafMask { index } => write!(f, "leaf mask {index}"),
        }
    }
}

/// A structural fault of a graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphError {
    /// A fault of the top grid, or of a size.
    #[error(transparent)]
    Top(#[from] TopError),
    /// A pointer leads past the end of the nodes or leaf masks.
    #[error("{place} points to {target} {pointer}, but there are only {count}")]
    PointerRange {
        /// Location of the pointer.
        place: GraphPlace,
        /// "node word" or "leaf mask".
        target: &'static str,
        /// The pointer.
        pointer: u32,
        /// Number of words or leaf masks in the graph.
        count: u64,
    },
    /// The first pointer to a node or leaf mask does not lead to the next one in order of first visit.
    #[error("{place} points to {target} {pointer}, but in order of first visit the next one is {expected}")]
    Order {
        /// Location of the pointer.
        place: GraphPlace,
        /// "node word" or "leaf mask".
        target: &'static str,
        /// The pointer.
        pointer: u32,
        /// The next free node word or leaf mask.
        expected: usize,
    },
    /// A pointer leads to the inside of a node.
    #[error("{place} points to node word {pointer}, which is a pointer and not a node's header")]
    NotAHeader {
        /// Location of the pointer.
        place: GraphPlace,
        /// The pointer.
        pointer: u32,
    },
    /// A node with leaf masks below it is used at two levels, or a node without any is used at a level below
    /// its height. Every cycle is one of these.
    #[error(
        "{place} points to node word {pointer} as a node of level {level}, but it is one of level {first_level}"
    )]
    TwoLevels {
        /// Location of the pointer.
        place: GraphPlace,
        /// The pointer.
        pointer: u32,
        /// The level that this pointer requires.
        level: u32,
        /// The level at which the node was visited first. For a node without leaf masks, the lowest level
        /// that its height fits.
        first_level: u32,
    },
    /// Bits 31 to 16 of a header are not zero.
    #[error("{place} is the header {header:#010x}, whose bits 31 to 16 are not zero")]
    HeaderBits {
        /// Location of the header.
        place: GraphPlace,
        /// The header.
        header: u32,
    },
    /// A child has the state 3, which is invalid.
    #[error("{place} is the header {header:#010x}, whose child {child} has the state 3")]
    ChildState {
        /// Location of the header.
        place: GraphPlace,
        /// The header.
        header: u32,
        /// The first child with that state.
        child: u32,
    },
    /// A node's pointers extend past the end of the nodes.
    #[error("{place} is a header with {pointers} pointers, but the nodes end at word {count}")]
    NodeEnd {
        /// Location of the header.
        place: GraphPlace,
        /// Number of pointers that must follow the header.
        pointers: usize,
        /// Number of node words in the graph.
        count: usize,
    },
    /// A node or leaf mask is all lit or all shadowed. Its parent should store that state instead.
    #[error("{place} is all {state}; the entry that points to it should store that state instead")]
    Uniform {
        /// Location of the node or leaf mask.
        place: GraphPlace,
        /// "lit" or "shadowed".
        state: &'static str,
    },
    /// Node words or leaf masks are not reachable from any root.
    #[error("{place} and everything after it ({count} in total) cannot be reached from any root")]
    Unreachable {
        /// Location of the first of them.
        place: GraphPlace,
        /// Number of unreachable words or leaf masks.
        count: usize,
    },
}

impl GraphError {
    /// Returns the variant's name. It is stable across versions and is used by the test vectors.
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
    /// Checks that every look-up in the graph terminates, and that the words are canonical: nodes are
    /// numbered in pre-order of first visit, no node or leaf mask is uniform, and nothing is unreachable.
    ///
    /// Cost: one pass over all words, and one byte of memory per node word.
    ///
    /// # Errors
    /// Returns the first fault in pre-order.
    pub fn validate(&self) -> Result<(), GraphError> {
        check_dims(self.size, self.root_level, self.top_dims)?;
        let (found, expected) =
            (self.top.len() as u64, self.top_dims.iter().map(|&n| u128::from(n)).product());
        if u128::from(found) != expected {
            return Err(TopError::TopLength { found, expected }.into());
        }
        check_count("node words", self.nodes.len() as u64, SHADOWED.into())?;
        check_count("leaf masks", self.leaf_masks.len() as u64, 1 << 32)?;

        let mut walk =
            Walk { dag: self, level_of: vec![0; self.nodes.len()], nodes_seen: 0, leaf_masks_seen: 0 };
        for (index, &entry) in self.top.iter().enumerate() {
            if entry != LIT && entry != SHADOWED {
                walk.node(entry, self.root_level, GraphPlace::Top { index })?;
            }
        }
        walk.finish()
    }
}

/// Added to the height of a node without leaf masks below it, in `Walk::level_of`. Such a node means the same
/// at every level that its height fits.
const LEAF_MASK_FREE: u32 = 128;

/// The pre-order walk. Everything below `nodes_seen` and `leaf_masks_seen` has been visited and is valid.
struct Walk<'a> {
    dag: &'a Dag,
    /// For the word of a header, the node's level, or [`LEAF_MASK_FREE`] plus its height. 0 for pointers and
    /// for words that have not been visited.
    level_of: Vec<u8>,
    nodes_seen: usize,
    leaf_masks_seen: usize,
}

impl Walk<'_> {
    fn node(&mut self, pointer: u32, level: u32, from: GraphPlace) -> Result<u8, GraphError> {
        let (at, count) = (pointer as usize, self.dag.nodes.len());
        if at < self.nodes_seen {
            return match u32::from(self.level_of[at]) {
                0 => Err(GraphError::NotAHeader { place: from, pointer }),
                kind if kind >= LEAF_MASK_FREE && level >= LEAF_NODE_LEVEL + (kind - LEAF_MASK_FREE) => {
                    Ok(kind as u8)
                }
                kind if kind == level => Ok(kind as u8),
                kind => {
                    let first_level =
                        if kind >= LEAF_MASK_FREE { LEAF_NODE_LEVEL + kind - LEAF_MASK_FREE } else { kind };
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
        let mut kind = LEAF_MASK_FREE as u8;
        for word in at + 1..end {
            let place = GraphPlace::Node { word };
            if level == LEAF_NODE_LEVEL {
                self.leaf_mask(self.dag.nodes[word], place)?;
                kind = level as u8;
            } else {
                let child = self.node(self.dag.nodes[word], level - 1, place)?;
                let leaf_mask_free = u32::from(child) >= LEAF_MASK_FREE && u32::from(kind) >= LEAF_MASK_FREE;
                kind = if leaf_mask_free { kind.max(child + 1) } else { level as u8 };
            }
        }
        self.level_of[at] = kind;
        Ok(kind)
    }

    fn leaf_mask(&mut self, pointer: u32, from: GraphPlace) -> Result<(), GraphError> {
        let (index, count) = (pointer as usize, self.dag.leaf_masks.len());
        if index < self.leaf_masks_seen {
            return Ok(());
        }
        let target = "leaf mask";
        let Some(&mask) = self.dag.leaf_masks.get(index) else {
            return Err(GraphError::PointerRange { place: from, target, pointer, count: count as u64 });
        };
        if index != self.leaf_masks_seen {
            return Err(GraphError::Order { place: from, target, pointer, expected: self.leaf_masks_seen });
        }
        self.leaf_masks_seen += 1;
        match mask {
            0 => Err(GraphError::Uniform { place: GraphPlace::LeafMask { index }, state: "shadowed" }),
            u64::MAX => Err(GraphError::Uniform { place: GraphPlace::LeafMask { index }, state: "lit" }),
            _ => Ok(()),
        }
    }

    fn finish(&self) -> Result<(), GraphError> {
        let (nodes, leaf_masks) =
            (self.dag.nodes.len() - self.nodes_seen, self.dag.leaf_masks.len() - self.leaf_masks_seen);
        if nodes > 0 {
            let place = GraphPlace::Node { word: self.nodes_seen };
            return Err(GraphError::Unreachable { place, count: nodes });
        }
        if leaf_masks > 0 {
            let place = GraphPlace::LeafMask { index: self.leaf_masks_seen };
            return Err(GraphError::Unreachable { place, count: leaf_masks });
        }
        Ok(())
    }
}

/// Checks a header on its own. Returns the number of pointers that follow it.
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
