//! Builds nodes from the columns of a tile. Min/max pyramids decide cubes, and leaf masks are written where they
//! cannot.
//!
//! A cube [a, b) over a set of columns is shadowed if a >= max e, otherwise lit if b <= min x, otherwise mixed. Testing
//! for shadow first keeps the switch at the first surface wherever the choice is free and costs nothing.

use crate::columns::rules::Columns;
use crate::store::{NodeState, NodeStore};
use crate::texel_mask::texels_where;
use adumbra::layout::LEAF_NODE_LEVEL;

/// max e and min x of every 2^level block, level by level.
struct Pyramid {
    /// Level 3 first; each level row by row.
    levels: Vec<Vec<[u32; 2]>>,
}

/// Builds the root cubes of one tile, nearest first, into `store`.
///
/// `columns` may be smaller than the root cube at the grid's border; missing columns count as free. Cost: proportional
/// to the number of cubes that silhouettes and surfaces cross.
pub(crate) fn build_roots(
    columns: &Columns,
    root_level: u32,
    root_count: u32,
    store: &NodeStore,
) -> Vec<NodeState> {
    let pyramid = Pyramid::new(columns, root_level);
    let builder = Builder { columns, pyramid: &pyramid, root_level, store };
    (0..root_count).map(|k| builder.cube(root_level, 0, 0, k << root_level)).collect()
}

impl Pyramid {
    fn new(columns: &Columns, root_level: u32) -> Self {
        let side = 1_u32 << (root_level - LEAF_NODE_LEVEL);
        let mut first = Vec::with_capacity((side * side) as usize);
        for by in 0..side {
            for bx in 0..side {
                let mut block = [0, u32::MAX];
                for y in by * 8..(by * 8 + 8).min(columns.height) {
                    let row = (y * columns.width) as usize;
                    let (start, end) = (bx * 8, (bx * 8 + 8).min(columns.width));
                    for i in (start..end).map(|x| row + x as usize) {
                        block = [block[0].max(columns.e[i]), block[1].min(columns.x[i])];
                    }
                }
                first.push(block);
            }
        }
        let mut levels = vec![first];
        let mut side = side as usize;
        while side > 1 {
            let below = &levels[levels.len() - 1];
            let half = side / 2;
            let mut level = Vec::with_capacity(half * half);
            for y in 0..half {
                for x in 0..half {
                    let at = |dx: usize, dy: usize| below[(2 * y + dy) * side + 2 * x + dx];
                    let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                    level.push(four.iter().fold([0, u32::MAX], |m, b| [m[0].max(b[0]), m[1].min(b[1])]));
                }
            }
            levels.push(level);
            side = half;
        }
        Self { levels }
    }
}

struct Builder<'a> {
    columns: &'a Columns,
    pyramid: &'a Pyramid,
    root_level: u32,
    store: &'a NodeStore,
}

impl Builder<'_> {
    /// Builds the cube of 2^level voxels at block (bx, by) of its level, from depth z. Recursion depth: the number of
    /// levels.
    fn cube(&self, level: u32, bx: u32, by: u32, z: u32) -> NodeState {
        let across = 1 << (self.root_level - level);
        let [max_e, min_x] =
            self.pyramid.levels[(level - LEAF_NODE_LEVEL) as usize][(by * across + bx) as usize];
        if z >= max_e {
            return NodeState::Shadowed;
        }
        if z + (1 << level) <= min_x {
            return NodeState::Lit;
        }
        if level == LEAF_NODE_LEVEL {
            return self.leaf_masks(bx, by, z);
        }
        let half = 1 << (level - 1);
        let children = std::array::from_fn(|c| {
            let c = c as u32;
            self.cube(level - 1, 2 * bx + (c >> 2), 2 * by + (c >> 1 & 1), z + (c & 1) * half)
        });
        self.store.inner(&children)
    }

    /// Builds an 8 × 8 × 8 cube. Each leaf mask is fully shadowed if allowed. Otherwise it keeps the preceding leaf
    /// mask (initially all lit) if allowed, and otherwise lights only the columns that must be lit.
    fn leaf_masks(&self, bx: u32, by: u32, z: u32) -> NodeState {
        let block = Block::new(self.columns, bx, by);
        let mut states = [NodeState::Shadowed; 8];
        let mut mask = u64::MAX;
        for (k, state) in (z..z + 8).zip(&mut states) {
            let must_be_lit = block.must_be_lit(k);
            mask = if must_be_lit == 0 {
                0
            } else if mask & block.must_be_shadowed(k) == 0 {
                mask
            } else {
                must_be_lit
            };
            *state = self.store.leaf_mask(mask);
        }
        self.store.cube(&states)
    }
}

/// e and x of an 8 × 8 block. Columns outside the tile are free.
struct Block {
    e: [u32; 64],
    x: [u32; 64],
}

impl Block {
    fn new(columns: &Columns, bx: u32, by: u32) -> Self {
        let mut block = Self { e: [0; 64], x: [u32::MAX; 64] };
        for y in 0..8.min(columns.height.saturating_sub(by * 8)) {
            let width = 8.min(columns.width.saturating_sub(bx * 8)) as usize;
            let from = ((by * 8 + y) * columns.width + bx * 8) as usize;
            let to = (y * 8) as usize;
            block.e[to..to + width].copy_from_slice(&columns.e[from..from + width]);
            block.x[to..to + width].copy_from_slice(&columns.x[from..from + width]);
        }
        block
    }

    fn must_be_lit(&self, k: u32) -> u64 {
        texels_where(|i| k < self.e[i])
    }

    fn must_be_shadowed(&self, k: u32) -> u64 {
        texels_where(|i| k >= self.x[i])
    }
}
