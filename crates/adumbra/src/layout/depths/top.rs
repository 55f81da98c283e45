//! The table of blocks at which look-ups begin. A file has one root per page, 512 × 512 columns. Where the
//! grid is small, a table of smaller blocks costs little and saves the steps above them, so it is made when
//! the file is read. No answer depends on it.

use crate::layout::depths::child::{Child, ShapeRef};
use crate::layout::depths::code::Code;
use crate::layout::depths::page::{IN_PAGE, PAGE_LEVEL, Page};
use crate::layout::depths::{NEVER, NODE_LEVELS, UNIFORM};

/// Largest number of blocks of a table that is finer than pages: 64 KiB.
const MAX_FINE_BLOCKS: u64 = 1 << 13;
/// The levels that a table may have, finest first. They are those of nodes.
const LEVELS: [u32; 3] = [5, 7, PAGE_LEVEL];

/// Returns the level of the blocks of a grid of this size: a block spans 2^level columns along each side.
pub fn block_level(size: [u32; 3]) -> u32 {
    let is_small =
        |level: u32| block_dims(size, level).map(u64::from).iter().product::<u64>() <= MAX_FINE_BLOCKS;
    LEVELS.into_iter().find(|&level| is_small(level)).unwrap_or(PAGE_LEVEL)
}

/// Returns the number of blocks of a level along x and y.
pub fn block_dims(size: [u32; 3], level: u32) -> [u32; 2] {
    [size[0], size[1]].map(|n| n.div_ceil(1 << level))
}

/// Returns the blocks of a page, x fastest: the address of each block's node, as that of a page's root, and
/// its base. The page must be valid.
pub fn page_blocks(page: &Page<'_>, common: &[u32], level: u32) -> Vec<[u32; 2]> {
    let side = 1 << (PAGE_LEVEL - level);
    let columns = (0..side).flat_map(|y| (0..side).map(move |x| [x << level, y << level]));
    columns.map(|column| block(page, common, level, column)).collect()
}

/// Returns the block of `level` that contains a column, which is counted from the page's first one.
fn block(page: &Page<'_>, common: &[u32], level: u32, [i, j]: [u32; 2]) -> [u32; 2] {
    if page.root == UNIFORM {
        return [UNIFORM, page.base];
    }
    let mut is_in_page = page.root & IN_PAGE != 0;
    let (mut at, mut base) = (page.root & !IN_PAGE, page.base);
    let mut reached = PAGE_LEVEL;
    while reached > level {
        reached -= NODE_LEVELS;
        let code = Code { words: if is_in_page { page.words } else { common } };
        match code.child(at, (j >> reached & 3) << 2 | i >> reached & 3) {
            Child::Never => return [UNIFORM, NEVER],
            Child::Uniform(delta) => return [UNIFORM, base.wrapping_add(delta)],
            Child::Shape { shape, delta } => {
                is_in_page &= matches!(shape, ShapeRef::Here(_));
                at = shape.at();
                base = base.wrapping_add(delta);
            }
        }
    }
    [if is_in_page { IN_PAGE | at } else { at }, base]
}
