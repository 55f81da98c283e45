//! Why words or bytes are not a tree, and why a light-aligned graph and a tree cannot be converted into each
//! other.

use crate::dag::MAX_CONVERTED_ROOTS;
use crate::dag::plain::GraphError;
use crate::dag::roots::{LEAF_NODE_LEVEL, MAX_ROOT_LEVEL};

use crate::tree::word::MAX_DEPTH;

/// Why words are not a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TreeError {
    /// The depth is out of range.
    #[error("the depth is {depth}, but must be from 1 to {MAX_DEPTH}")]
    Depth {
        /// The depth given.
        depth: u32,
    },
    /// The number of words is not one root plus whole blocks.
    #[error("{words} words are not one root plus whole blocks of eight")]
    Length {
        /// Number of words given.
        words: usize,
    },
    /// A word has bits that no node has.
    #[error("word {index} is {word:#010x}, which is not a node")]
    Word {
        /// The index of the word.
        index: usize,
        /// Its value.
        word: u32,
    },
    /// An index points outside the words or not to the start of a block.
    #[error("word {index} points to word {target}, where no block begins")]
    Index {
        /// The index of the word.
        index: usize,
        /// The index that it points to.
        target: u32,
    },
    /// Blocks are not in the order in which a walk from the root first visits them, or are never visited.
    #[error("the block at word {block} is out of order, or not reachable from the root")]
    Order {
        /// First word of the block.
        block: usize,
    },
    /// A node has more levels below it than the depth allows, or is its own descendant.
    #[error("the block at word {block} is deeper than {depth} levels")]
    TooDeep {
        /// First word of the block.
        block: usize,
        /// The tree's depth.
        depth: u32,
    },
    /// A block has eight uniform children: their parent should be a leaf.
    #[error("the block at word {block} holds eight uniform children; its parent should be a leaf")]
    NotMerged {
        /// First word of the block.
        block: usize,
    },
}

/// Why bytes are not a symmetric tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SymmetricError {
    /// The depth is out of range.
    #[error("the depth is {depth}, but must be from 1 to {MAX_DEPTH}")]
    Depth {
        /// The depth given.
        depth: u32,
    },
    /// The body is too short or too long, or not whole words.
    #[error("{bytes} bytes are not a header, nodes and padding")]
    Length {
        /// Number of bytes given.
        bytes: usize,
    },
    /// An unknown flag is set.
    #[error("the flags are {flags:#010x}; only bit 0 is known")]
    Flags {
        /// The flags.
        flags: u32,
    },
    /// The root is an impossible leaf.
    #[error("the root is {root:#010x}, which is not a node")]
    Root {
        /// The word of the root.
        root: u32,
    },
    /// A node is cut off, or the padding is not four to seven zeros.
    #[error("the bytes from {at} on are neither a whole node nor the padding")]
    Cut {
        /// Byte offset.
        at: u32,
    },
    /// A node has eight uniform children: its parent should have a leaf instead.
    #[error("the node at {at} holds eight uniform children; its parent should be a leaf")]
    NotMerged {
        /// Where the node begins.
        at: u32,
    },
    /// A mask of eight equal bits.
    #[error("the node at {at} holds the mask {mask:#04x}, which should be a uniform child")]
    Mask {
        /// Where the node begins.
        at: u32,
        /// The mask.
        mask: u8,
    },
    /// A pointer does not lead to the start of a node.
    #[error("the node at {at} points to {target}, where no node begins")]
    Pointer {
        /// Where the node begins; 0 = the root's pointer.
        at: u32,
        /// The address that it points to.
        target: u32,
    },
    /// A node has more levels below it than the depth allows, or is its own descendant.
    #[error("the node at {at} is deeper than {depth} levels")]
    TooDeep {
        /// Where the node begins.
        at: u32,
        /// The tree's depth.
        depth: u32,
    },
    /// Some nodes are not referenced.
    #[error("{nodes} nodes are not reachable from the root")]
    Unreached {
        /// The number of those nodes.
        nodes: u64,
    },
}

/// Why a graph cannot be converted to a tree, or a tree to a graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LightTreeError {
    /// The root level is out of range.
    #[error("root level {root_level} is not from {LEAF_NODE_LEVEL} to {MAX_ROOT_LEVEL}; bake it again")]
    RootLevel {
        /// The level given.
        root_level: u32,
    },
    /// The cube around the grid has too many levels.
    #[error(
        "a cube around {size:?} voxels has {depth} levels, but a tree has at most {MAX_DEPTH}; bake at a lower resolution"
    )]
    TooDeep {
        /// Number of voxels along each axis.
        size: [u32; 3],
        /// Number of levels that they need.
        depth: u32,
    },
    /// The top grid is larger than that of any bake.
    #[error("the top grid has {roots} roots, but at most {MAX_CONVERTED_ROOTS} are allowed; bake it again")]
    TooManyRoots {
        /// Number of roots that follows from the size and the root level.
        roots: u128,
    },
    /// The result does not fit 31-bit indices.
    #[error("the result has more words than 31 bits can address; bake at a lower resolution")]
    TooManyWords,
    /// The tree's cube is not the one around the grid.
    #[error(
        "the tree has {depth} levels, but a grid of {size:?} voxels needs {expected}; give the grid that it was made from"
    )]
    WrongDepth {
        /// Number of levels of the tree.
        depth: u32,
        /// Number of voxels along each axis.
        size: [u32; 3],
        /// Number of levels that they need.
        expected: u32,
    },
    /// The graph cannot be traversed.
    #[error("the graph is not valid: {0}; bake it again")]
    Graph(#[from] GraphError),
}
