//! Converts blocks of columns to nodes, as runs along z. Below a silhouette the same leaf mask repeats, so a
//! curtain of any height costs a few operations.
//!
//! A block of level n is a list of runs of equal nodes of 2^n voxels a side, nearest first. A parent is built
//! from the aligned pieces of its quarters' runs.

mod switches;

use crate::dag::roots::{LEAF_NODE_LEVEL, top_dims};
use adumbra_bake::Error;
use adumbra_bake::structure::{BlockColumns, BlockSink, Structure};

use crate::dag::build::store::{NodeState, NodeStore};
use crate::dag::plain::Dag;
use switches::{FOREVER, for_each_cube, roundest};

/// Builds a [`Dag`] from blocks.
pub struct GraphSink {
    store: NodeStore,
    /// Number of voxels along x, y, z. The space behind the last voxel along the light is free.
    size: [u32; 3],
    /// Level of the root cubes.
    level: u32,
    /// Number of root cubes.
    roots: u64,
}

/// Nodes of one level over a block, nearest first. The last run has no end.
pub struct Runs(Vec<Run>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    /// Index of the first node after the run.
    end: u32,
    state: NodeState,
}

impl Runs {
    fn push(&mut self, end: u32, state: NodeState) {
        match self.0.last_mut() {
            Some(last) if last.state == state => last.end = end,
            _ => self.0.push(Run { end, state }),
        }
    }
}

/// Steps through runs node by node.
struct Cursor<'r> {
    runs: &'r [Run],
    at: usize,
}

impl Cursor<'_> {
    /// Returns the state at node `z` and the end of its run. Successive calls must not decrease `z`.
    fn state(&mut self, z: u32) -> Run {
        while self.runs[self.at].end <= z {
            self.at += 1;
        }
        self.runs[self.at]
    }
}

impl GraphSink {
    /// Creates a sink for a grid of `size` voxels along x, y, z, whose root cubes have `root_level`.
    pub fn new(size: [u32; 3], root_level: u32) -> Self {
        let roots = top_dims(size, root_level).iter().map(|&n| u64::from(n)).product();
        Self { store: NodeStore::default(), size, level: root_level, roots }
    }

    /// Returns the store that the nodes are in.
    pub(super) fn store(&self) -> &NodeStore {
        &self.store
    }

    /// Takes the store out.
    pub(super) fn into_store(self) -> NodeStore {
        self.store
    }

    /// Returns the first `count` nodes of a root block.
    pub(super) fn roots(&self, runs: &Runs, level: u32, count: u32) -> Vec<NodeState> {
        debug_assert!(count.saturating_sub(1) << level < self.size[2].max(1));
        let mut cursor = Cursor { runs: &runs.0, at: 0 };
        (0..count).map(|z| cursor.state(z).state).collect()
    }

    /// Returns runs that are lit before `depth` and shadowed from there on.
    fn switch_at(&self, level: u32, depth: u32) -> Runs {
        let whole = depth >> level;
        let mut runs = Runs(Vec::with_capacity(3));
        if depth >= self.size[2] {
            runs.push(FOREVER, NodeState::Lit);
            return runs;
        }
        if whole > 0 {
            runs.push(whole, NodeState::Lit);
        }
        let inside = depth & ((1 << level) - 1);
        if inside > 0 {
            runs.push(whole + 1, self.split_node(level, inside));
        }
        runs.push(FOREVER, NodeState::Shadowed);
        runs
    }

    /// Returns a node that is lit before its layer `inside` and shadowed from there on, in all columns.
    fn split_node(&self, level: u32, inside: u32) -> NodeState {
        let half = 1 << (level - 1);
        if level == LEAF_NODE_LEVEL {
            return self.store.cube(&std::array::from_fn(|k| {
                if (k as u32) < inside { NodeState::Lit } else { NodeState::Shadowed }
            }));
        }
        let below = |from: u32| match inside {
            _ if inside <= from => NodeState::Shadowed,
            _ if inside >= from + half => NodeState::Lit,
            _ => self.split_node(level - 1, inside - from),
        };
        let [near, far] = [below(0), below(half)];
        self.store.inner(&[near, far, near, far, near, far, near, far])
    }
}

impl BlockSink for GraphSink {
    type Block = Runs;

    fn uniform(&self, level: u32, [e, x]: [u32; 2]) -> Runs {
        self.switch_at(level, roundest(e, x))
    }

    fn leaf(&self, columns: &BlockColumns) -> Runs {
        let mut runs = Runs(Vec::with_capacity(8));
        for_each_cube(columns, self.size[2], |end, masks| {
            let states = masks.map(|mask| self.store.leaf_mask(mask));
            runs.push(end, self.store.cube(&states));
        });
        runs
    }

    fn join(&self, _level: u32, quarters: [Runs; 4]) -> Runs {
        let mut runs = Runs(Vec::with_capacity(8));
        let mut cursors = quarters.each_ref().map(|q| Cursor { runs: &q.0, at: 0 });
        let mut z = 0;
        loop {
            let near = cursors.each_mut().map(|c| c.state(2 * z));
            // Parents whose eight children are all in the same four runs.
            let together = near.iter().map(|r| r.end).min().unwrap_or(FOREVER);
            let whole = if together == FOREVER { FOREVER } else { together / 2 };
            let (end, far) = if whole > z {
                (whole, near)
            } else {
                (z + 1, cursors.each_mut().map(|c| c.state(2 * z + 1)))
            };
            let [a, b, c, d] = near.map(|r| r.state);
            let [e, f, g, h] = far.map(|r| r.state);
            runs.push(end, self.store.inner(&[a, e, b, f, c, g, d, h]));
            if end == FOREVER {
                return runs;
            }
            z = end;
        }
    }

    fn known(&self, _number: usize) -> Option<Runs> {
        None
    }

    fn taken(&self, _number: usize, block: Runs) -> Runs {
        block
    }
}

impl Structure for GraphSink {
    type Output = Dag;
    const SO_FAR: &'static str = "the graph so far";
    const FINISHING: &'static str = "numbering the graph";

    fn memory_bytes(&self) -> u64 {
        self.store.memory_bytes()
    }

    fn result_bytes(&self) -> u64 {
        self.store.graph_bytes()
    }

    /// The numbered copy, and for each root cube its state and its word.
    fn finish_bytes(&self) -> u64 {
        self.store.numbers_bytes()
            + self.store.graph_bytes()
            + self.roots * (size_of::<NodeState>() as u64 + 4)
    }

    fn check_room(&self) -> Result<(), Error> {
        if self.store.is_full() { Err(Error::TooManyWords { what: "the graph" }) } else { Ok(()) }
    }

    fn finish(self, blocks: Vec<Runs>) -> Dag {
        let (size, level) = (self.size, self.level);
        let dims = top_dims(size, level);
        let columns: Vec<_> = blocks.iter().map(|runs| self.roots(runs, level, dims[2])).collect();
        // x fastest, then y, then z.
        let top: Vec<_> =
            (0..dims[2] as usize).flat_map(|z| columns.iter().map(move |roots| roots[z])).collect();
        self.store.finish(size, level, dims, &top)
    }
}
