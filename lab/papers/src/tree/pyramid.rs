//! A min/max pyramid over a depth image: bounds on all columns of a block, so that whole cubes can be
//! decided.

use crate::tree::depth_image::{DepthImage, FRACTION, NO_SURFACE, TILE_SIDE};
use adumbra_bake::structure::layers::FixedDepth;

/// Log2 of the side of the finest blocks, 8 × 8 texels. That side divides the side of a tile.
const FINEST_BLOCK: u32 = 3;

/// Bounds on the columns of a block.
#[derive(Clone, Copy)]
pub(crate) struct Block {
    pub(crate) depth_min: FixedDepth,
    pub(crate) depth_max: FixedDepth,
    /// Minimum and maximum over all intervals inside solids.
    pub(crate) entries_min: FixedDepth,
    pub(crate) exits_max: FixedDepth,
    /// Bounds over the first interval of each column. A column without an interval leaves no common interval.
    pub(crate) entries_first_max: FixedDepth,
    pub(crate) exits_first_min: FixedDepth,
}

impl Block {
    const EMPTY: Self = Self {
        depth_min: FixedDepth::MAX,
        depth_max: FixedDepth::MIN,
        entries_min: FixedDepth::MAX,
        exits_max: FixedDepth::MIN,
        entries_first_max: FixedDepth::MIN,
        exits_first_min: FixedDepth::MAX,
    };
    /// A column outside the image.
    const OUTSIDE: Self = Self {
        depth_min: NO_SURFACE,
        depth_max: NO_SURFACE,
        entries_min: FixedDepth::MAX,
        exits_max: FixedDepth::MIN,
        entries_first_max: FixedDepth::MAX,
        exits_first_min: FixedDepth::MIN,
    };

    fn from_column(first: FixedDepth, insides: &[[FixedDepth; 2]]) -> Self {
        let mut block = Self { depth_min: first, depth_max: first, ..Self::OUTSIDE };
        if let [[from, to], ..] = insides {
            (block.entries_first_max, block.exits_first_min) = (*from, *to);
        }
        for [from, to] in insides {
            block.entries_min = block.entries_min.min(*from);
            block.exits_max = block.exits_max.max(*to);
        }
        block
    }

    fn join(self, o: Self) -> Self {
        Self {
            depth_min: self.depth_min.min(o.depth_min),
            depth_max: self.depth_max.max(o.depth_max),
            entries_min: self.entries_min.min(o.entries_min),
            exits_max: self.exits_max.max(o.exits_max),
            entries_first_max: self.entries_first_max.max(o.entries_first_max),
            exits_first_min: self.exits_first_min.min(o.exits_first_min),
        }
    }
}

/// A pyramid of blocks of columns; a block of each level covers four of the level before.
pub(crate) struct Pyramid {
    /// Finest level first, blocks of 8 × 8 texels.
    levels: Vec<PyramidLevel>,
    /// Size of the image in texels.
    size: [u32; 2],
}

struct PyramidLevel {
    width: usize,
    height: usize,
    blocks: Vec<Block>,
}

impl Pyramid {
    pub(crate) fn of(image: &DepthImage) -> Self {
        let size = image.size();
        let [width, height] = size.map(|s| s.div_ceil(1 << FINEST_BLOCK) as usize);
        debug_assert!(TILE_SIDE.is_multiple_of(1 << FINEST_BLOCK));
        let mut blocks = Vec::with_capacity(width * height);
        for by in 0..height as u32 {
            for bx in 0..width as u32 {
                let mut block = Block::EMPTY;
                for v in (by << FINEST_BLOCK)..((by + 1) << FINEST_BLOCK).min(size[1]) {
                    for u in (bx << FINEST_BLOCK)..((bx + 1) << FINEST_BLOCK).min(size[0]) {
                        block = block.join(Block::from_column(image.depth(u, v), image.insides(u, v)));
                    }
                }
                blocks.push(block);
            }
        }
        let mut levels = vec![PyramidLevel { width, height, blocks }];
        loop {
            let below = &levels[levels.len() - 1];
            if below.width == 1 && below.height == 1 {
                break;
            }
            let (width, height) = (below.width.div_ceil(2), below.height.div_ceil(2));
            let mut blocks = Vec::with_capacity(width * height);
            for y in 0..height {
                for x in 0..width {
                    let mut block = Block::EMPTY;
                    for v in 2 * y..(2 * y + 2).min(below.height) {
                        for u in 2 * x..(2 * x + 2).min(below.width) {
                            block = block.join(below.blocks[v * below.width + u]);
                        }
                    }
                    blocks.push(block);
                }
            }
            levels.push(PyramidLevel { width, height, blocks });
        }
        Self { levels, size }
    }

    /// Returns about how many bytes the pyramid over an image takes: a third more than its finest level.
    pub(crate) fn bytes_of(image: &DepthImage) -> u64 {
        let [width, height] = image.size().map(|s| u64::from(s.div_ceil(1 << FINEST_BLOCK)));
        (width * height + width + height) * size_of::<Block>() as u64 * 4 / 3
    }

    /// Size in bytes.
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.levels.iter().map(|l| (l.blocks.capacity() * size_of::<Block>()) as u64).sum()
    }

    /// Returns bounds on the columns from `low` to `high`, in 2^-32 texels, or `None` if the blocks are too
    /// coarse to decide.
    pub(crate) fn over(&self, low: [i64; 2], high: [i64; 2]) -> Option<Block> {
        // In whole texels.
        let [low, high] = [low, high].map(|p| p.map(|c| c >> FRACTION));
        let extent = (high[0] - low[0]).max(high[1] - low[1]) as u64;
        if extent < (1 << FINEST_BLOCK) / 2 {
            return None;
        }
        let level = (extent.ilog2()).max(FINEST_BLOCK).min(FINEST_BLOCK + self.levels.len() as u32 - 1);
        let blocks = &self.levels[(level - FINEST_BLOCK) as usize];
        let mut block = Block::EMPTY;
        for a in 0..2 {
            if low[a] < 0 || high[a] >= i64::from(self.size[a]) {
                block = Block::OUTSIDE;
            }
        }
        let range = |a: usize, count: usize| {
            let first = (low[a] >> level).max(0) as usize;
            let end = ((high[a] >> level) + 1).clamp(0, count as i64) as usize;
            first.min(count)..end
        };
        for y in range(1, blocks.height) {
            for x in range(0, blocks.width) {
                block = block.join(blocks.blocks[y * blocks.width + x]);
            }
        }
        Some(block)
    }
}
