//! Keeps the few cheapest targets of each block.

use crate::tree::lossy::candidate::Candidate;

/// Maximum number of targets kept per block.
const TARGETS: usize = 3;

/// A possible merge of `source` into `target`.
#[derive(Clone, Copy)]
pub(crate) struct Offer {
    pub(crate) source: u32,
    pub(crate) target: u32,
    /// Number of cells that would change.
    pub(crate) cells: u32,
}

/// Marks a missing target. It costs more than any target.
const NONE: (u32, u32) = (u32::MAX, u32::MAX);

/// For each block from `first` on, its targets as (cells, block), fewest cells first.
pub(crate) struct Nearest {
    first: usize,
    targets: Vec<[(u32, u32); TARGETS]>,
}

impl Nearest {
    pub(crate) fn new(first: usize, count: usize) -> Self {
        Self { first, targets: vec![[NONE; TARGETS]; count] }
    }

    /// Upper bound of the cells that an offer for `source` may change in order to be kept.
    pub(crate) fn useful(&self, source: u32) -> u32 {
        self.targets[source as usize - self.first][TARGETS - 1].0
    }

    pub(crate) fn take(&mut self, offer: Offer) {
        let targets = &mut self.targets[offer.source as usize - self.first];
        let offered = (offer.cells, offer.target);
        if offered >= targets[TARGETS - 1] || targets.contains(&offered) {
            return;
        }
        let place = targets.partition_point(|t| *t < offered);
        targets[place..].rotate_right(1);
        targets[place] = offered;
    }

    /// Returns all offers that were kept. `voxels` converts a number of cells of a source to voxels.
    pub(crate) fn candidates(self, voxels: impl Fn(u32, u64) -> u64) -> Vec<Candidate> {
        let kept = || (self.first as u32..).zip(&self.targets).flat_map(|(s, t)| t.map(|t| (s, t)));
        let mut candidates = Vec::with_capacity(kept().filter(|(_, t)| *t != NONE).count());
        candidates.extend(kept().filter(|(_, t)| *t != NONE).map(|(source, (cells, target))| Candidate {
            source,
            target,
            cost: voxels(source, u64::from(cells)),
        }));
        candidates
    }
}
