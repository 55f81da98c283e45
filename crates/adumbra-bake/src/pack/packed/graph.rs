//! The encoder's input: a plain graph, in memory or in pages.

use crate::store::PagedDag;
use crate::store::graph::{MAX_WORDS, node_length};
use adumbra::layout::plain::{Dag, STATE_LIT, STATE_SHADOWED};

/// A child of a plain node.
#[derive(Clone, Copy)]
pub(crate) enum Child {
    Shadowed,
    Lit,
    /// Index of a node's word, or of a leaf mask.
    Mixed(u32),
}

/// The parts of a graph that are always in memory.
#[derive(Clone, Copy)]
pub(crate) struct Head<'g> {
    pub(crate) root_level: u32,
    pub(crate) top_dims: [u32; 3],
    pub(crate) top: &'g [u32],
}

/// A valid plain graph.
pub(crate) trait Graph: Sync {
    fn head(&self) -> Head<'_>;
    fn node_words(&self) -> usize;
    fn leaf_mask_count(&self) -> usize;
    /// Returns the number of words of the node at this word.
    fn length(&self, word: u32) -> usize;
    /// Returns the children of the node at this word.
    fn children(&self, word: u32) -> [Child; 8];
    fn leaf_mask(&self, leaf_mask: u32) -> u64;
}

impl Graph for Dag {
    fn head(&self) -> Head<'_> {
        Head { root_level: self.root_level, top_dims: self.top_dims, top: &self.top }
    }

    fn node_words(&self) -> usize {
        self.nodes.len()
    }

    fn leaf_mask_count(&self) -> usize {
        self.leaf_masks.len()
    }

    fn length(&self, word: u32) -> usize {
        node_length(self.nodes[word as usize])
    }

    fn children(&self, word: u32) -> [Child; 8] {
        children_of(&self.nodes[word as usize..])
    }

    fn leaf_mask(&self, leaf_mask: u32) -> u64 {
        self.leaf_masks[leaf_mask as usize]
    }
}

/// After a disk failure the graph appears to end and its nodes have no children, so traversal stays safe until the
/// failure is checked.
impl Graph for PagedDag {
    fn head(&self) -> Head<'_> {
        Head { root_level: self.root_level, top_dims: self.top_dims, top: &self.top }
    }

    fn node_words(&self) -> usize {
        self.nodes.len()
    }

    fn leaf_mask_count(&self) -> usize {
        self.leaf_masks.len()
    }

    fn length(&self, word: u32) -> usize {
        let header = self.nodes.get(word as usize);
        if self.nodes.has_failed() { self.nodes.len() } else { node_length(header) }
    }

    fn children(&self, word: u32) -> [Child; 8] {
        let children = self.nodes.with::<MAX_WORDS, _>(word as usize, node_length, children_of);
        if self.nodes.has_failed() { [Child::Lit; 8] } else { children }
    }

    fn leaf_mask(&self, leaf_mask: u32) -> u64 {
        self.leaf_masks.get(leaf_mask as usize)
    }
}

/// Returns the children of the node that begins with these words. More words may follow.
fn children_of(words: &[u32]) -> [Child; 8] {
    let header = words[0];
    let mut pointers = words[1..].iter();
    std::array::from_fn(|c| match header >> (2 * c) & 3 {
        STATE_SHADOWED => Child::Shadowed,
        STATE_LIT => Child::Lit,
        _ => pointers.next().map_or(Child::Lit, |&p| Child::Mixed(p)),
    })
}
