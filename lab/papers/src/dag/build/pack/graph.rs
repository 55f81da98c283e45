//! Nodes of a plain graph, as the encoder reads them.

use crate::dag::build::store::node_length;
use crate::dag::plain::{Dag, STATE_LIT, STATE_SHADOWED};

/// A child of a plain node.
#[derive(Clone, Copy)]
pub(super) enum Child {
    Shadowed,
    Lit,
    /// Index of a node's word, or of a leaf mask.
    Mixed(u32),
}

/// Returns the number of words of the node at this word.
pub(super) fn length(graph: &Dag, word: usize) -> usize {
    node_length(graph.nodes[word])
}

/// Returns the children of the node at this word of a valid graph.
pub(super) fn children(graph: &Dag, word: u32) -> [Child; 8] {
    let words = &graph.nodes[word as usize..];
    let header = words[0];
    let mut pointers = words[1..].iter();
    std::array::from_fn(|c| match header >> (2 * c) & 3 {
        STATE_SHADOWED => Child::Shadowed,
        STATE_LIT => Child::Lit,
        _ => pointers.next().map_or(Child::Lit, |&p| Child::Mixed(p)),
    })
}
