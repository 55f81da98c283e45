//! Numbers of nodes: one for each level at which a node is used.

use std::collections::HashMap;

use super::graph::length;
use crate::dag::plain::Dag;

/// Numbers of the nodes of a plain graph, by header word and level.
///
/// A node's own number is its rank among the headers. Nodes without leaf masks below may be used at several
/// levels. At all but the first of those, they are numbered after the nodes' own numbers.
pub(super) struct Keys {
    chunks: Vec<Chunk>,
    /// For each own number: the level at which the node was first encountered; 0 before that.
    levels: Vec<u8>,
    /// Words and levels of the nodes numbered after the own numbers.
    pub(super) others: Vec<(u32, u32)>,
    other_keys: HashMap<(u32, u32), usize>,
}

/// 64 words of a plain graph.
#[derive(Clone, Copy, Default)]
struct Chunk {
    /// Bit w: a header is at word w.
    headers: u64,
    /// Bit w: the node there is used at several levels.
    several: u64,
    /// Number of headers before this chunk.
    rank: u32,
}

impl Keys {
    pub(super) fn new(graph: &Dag) -> Self {
        let mut chunks = vec![Chunk::default(); graph.nodes.len().div_ceil(64)];
        let mut at = 0;
        while at < graph.nodes.len() {
            chunks[at / 64].headers |= 1 << (at % 64);
            at += length(graph, at);
        }
        let mut count = 0;
        for chunk in &mut chunks {
            chunk.rank = count;
            count += chunk.headers.count_ones();
        }
        Self { chunks, levels: vec![0; count as usize], others: Vec::new(), other_keys: HashMap::new() }
    }

    /// Returns the number of nodes that have an own number.
    pub(super) fn nodes(&self) -> usize {
        self.levels.len()
    }

    /// Returns the level at which the node was first encountered.
    pub(super) fn level(&self, word: u32) -> u32 {
        u32::from(self.levels[self.rank(word)])
    }

    /// Returns the number of a node that already has one.
    pub(super) fn key(&self, word: u32, level: u32) -> usize {
        let rank = self.rank(word);
        let one_level = self.chunks[word as usize / 64].several >> (word % 64) & 1 == 0;
        if one_level || u32::from(self.levels[rank]) == level {
            rank
        } else {
            self.other_keys[&(word, level)]
        }
    }

    pub(super) fn key_or_new(&mut self, word: u32, level: u32) -> usize {
        let rank = self.rank(word);
        if self.levels[rank] == 0 {
            self.levels[rank] = level as u8;
        }
        if u32::from(self.levels[rank]) == level {
            return rank;
        }
        self.chunks[word as usize / 64].several |= 1 << (word % 64);
        let next = self.levels.len() + self.others.len();
        let key = *self.other_keys.entry((word, level)).or_insert(next);
        if key == next {
            self.others.push((word, level));
        }
        key
    }

    fn rank(&self, word: u32) -> usize {
        let chunk = self.chunks[word as usize / 64];
        (chunk.rank + (chunk.headers & ((1 << (word % 64)) - 1)).count_ones()) as usize
    }
}
