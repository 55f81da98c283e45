//! Numbers of nodes: one for each level that a node is used at.

use std::collections::HashMap;

use crate::dag::Dag;

/// Numbers of the nodes of a plain graph, by the word of the header and the level.
///
/// A node's own number is its place among the headers. Those without slabs below may be used at several levels, and are
/// numbered behind the others for all but the first.
pub(super) struct Keys {
    /// Bit w: a header stands at word w.
    headers: Vec<u64>,
    /// Headers before each 64 words.
    ranks: Vec<u32>,
    /// By a node's own number: the level that it was met at first; 0 before.
    levels: Vec<u8>,
    /// Words and levels of what is numbered behind.
    pub(super) others: Vec<(u32, u32)>,
    other_keys: HashMap<(u32, u32), usize>,
}

impl Keys {
    pub(super) fn new(dag: &Dag) -> Self {
        let mut headers = vec![0_u64; dag.nodes.len().div_ceil(64)];
        let mut at = 0;
        while at < dag.nodes.len() {
            headers[at / 64] |= 1 << (at % 64);
            at += 1 + (dag.nodes[at] & 0xaaaa).count_ones() as usize;
        }
        let mut count = 0;
        let ranks = headers.iter().map(|&word| {
            let before = count;
            count += word.count_ones();
            before
        });
        let ranks = ranks.collect();
        Self {
            headers,
            ranks,
            levels: vec![0; count as usize],
            others: Vec::new(),
            other_keys: HashMap::new(),
        }
    }

    /// The level that the node was met at first.
    pub(super) fn level(&self, word: u32) -> u32 {
        u32::from(self.levels[self.rank(word)])
    }

    /// The number of a node that has one.
    pub(super) fn key(&self, word: u32, level: u32) -> usize {
        let rank = self.rank(word);
        if u32::from(self.levels[rank]) == level { rank } else { self.other_keys[&(word, level)] }
    }

    pub(super) fn key_or_new(&mut self, word: u32, level: u32) -> usize {
        let rank = self.rank(word);
        if self.levels[rank] == 0 {
            self.levels[rank] = level as u8;
        }
        if u32::from(self.levels[rank]) == level {
            return rank;
        }
        let next = self.levels.len() + self.others.len();
        let key = *self.other_keys.entry((word, level)).or_insert(next);
        if key == next {
            self.others.push((word, level));
        }
        key
    }

    fn rank(&self, word: u32) -> usize {
        let (chunk, bit) = (word as usize / 64, word % 64);
        (self.ranks[chunk] + (self.headers[chunk] & ((1 << bit) - 1)).count_ones()) as usize
    }
}
