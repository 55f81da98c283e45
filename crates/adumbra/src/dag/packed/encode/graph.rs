//! What the encoder reads: a plain graph, wherever its words are.

use crate::dag::store::{MOST_WORDS, node_length};
use crate::dag::{Dag, PagedDag, STATE_LIT, STATE_SHADOWED};

/// A child of a plain node.
#[derive(Clone, Copy)]
pub(super) enum Child {
    Shadowed,
    Lit,
    /// Word or slab.
    Mixed(u32),
}

/// What is in memory in any case.
#[derive(Clone, Copy)]
pub(super) struct Head<'g> {
    pub(super) root_level: u32,
    pub(super) top_dims: [u32; 3],
    pub(super) top: &'g [u32],
}

/// A valid plain graph.
pub(super) trait Graph: Sync {
    fn head(&self) -> Head<'_>;
    fn node_words(&self) -> usize;
    fn slab_count(&self) -> usize;
    /// Words of the node at this word.
    fn length(&self, word: u32) -> usize;
    /// Children of the node at this word.
    fn children(&self, word: u32) -> [Child; 8];
    fn slab(&self, slab: u32) -> u64;
}

impl Graph for Dag {
    fn head(&self) -> Head<'_> {
        Head { root_level: self.root_level, top_dims: self.top_dims, top: &self.top }
    }

    fn node_words(&self) -> usize {
        self.nodes.len()
    }

    fn slab_count(&self) -> usize {
        self.slabs.len()
    }

    fn length(&self, word: u32) -> usize {
        node_length(self.nodes[word as usize])
    }

    fn children(&self, word: u32) -> [Child; 8] {
        children_of(&self.nodes[word as usize..])
    }

    fn slab(&self, slab: u32) -> u64 {
        self.slabs[slab as usize]
    }
}

/// Once its disk fails it ends, and its nodes have no children: nothing leads astray until the failure is asked for.
impl Graph for PagedDag {
    fn head(&self) -> Head<'_> {
        Head { root_level: self.root_level, top_dims: self.top_dims, top: &self.top }
    }

    fn node_words(&self) -> usize {
        self.nodes.len()
    }

    fn slab_count(&self) -> usize {
        self.slabs.len()
    }

    fn length(&self, word: u32) -> usize {
        let header = self.nodes.get(word as usize);
        if self.nodes.has_failed() { self.nodes.len() } else { node_length(header) }
    }

    fn children(&self, word: u32) -> [Child; 8] {
        let children = self.nodes.with::<MOST_WORDS, _>(word as usize, node_length, children_of);
        if self.nodes.has_failed() { [Child::Lit; 8] } else { children }
    }

    fn slab(&self, slab: u32) -> u64 {
        self.slabs.get(slab as usize)
    }
}

/// Children of the node with these words, and more behind them or not.
fn children_of(words: &[u32]) -> [Child; 8] {
    let header = words[0];
    let mut pointers = words[1..].iter();
    std::array::from_fn(|c| match header >> (2 * c) & 3 {
        STATE_SHADOWED => Child::Shadowed,
        STATE_LIT => Child::Lit,
        _ => pointers.next().map_or(Child::Lit, |&p| Child::Mixed(p)),
    })
}
