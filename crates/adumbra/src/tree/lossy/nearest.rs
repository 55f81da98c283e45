//! The few targets of each block that change least.

use super::choose::Candidate;

/// Most targets kept for a block.
const TARGETS: usize = 3;

/// One block might give way to another.
#[derive(Clone, Copy)]
pub(super) struct Offer {
    pub(super) source: u32,
    pub(super) target: u32,
    /// Cells that would change.
    pub(super) cells: u32,
}

/// No target: dearer than any.
const NONE: (u32, u32) = (u32::MAX, u32::MAX);

/// For each block from a first one on, targets as cells and block, fewest cells first.
pub(super) struct Nearest {
    first: usize,
    targets: Vec<[(u32, u32); TARGETS]>,
}

impl Nearest {
    pub(super) fn new(first: usize, count: usize) -> Self {
        Self { first, targets: vec![[NONE; TARGETS]; count] }
    }

    /// Most cells that an offer to `source` may change if it is to be kept.
    pub(super) fn useful(&self, source: u32) -> u32 {
        self.targets[source as usize - self.first][TARGETS - 1].0
    }

    pub(super) fn take(&mut self, offer: Offer) {
        let targets = &mut self.targets[offer.source as usize - self.first];
        let offered = (offer.cells, offer.target);
        if offered >= targets[TARGETS - 1] || targets.contains(&offered) {
            return;
        }
        let place = targets.partition_point(|t| *t < offered);
        targets[place..].rotate_right(1);
        targets[place] = offered;
    }

    /// All that were kept, `voxels` telling the voxels in a source's cells.
    pub(super) fn candidates(self, voxels: impl Fn(u32, u64) -> u64) -> Vec<Candidate> {
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
