//! How the grid of a bake is divided into parts.

use adumbra::layout::depths::page::{PAGE_LEVEL, page_dims};

/// How a grid is cut into parts: a part is one root block, or all root blocks of a page.
#[derive(Clone, Debug)]
pub(crate) struct PartGrid {
    /// Number of voxels of the grid along x and y.
    size: [u32; 2],
    root_level: u32,
}

impl PartGrid {
    /// Cuts a grid whose root blocks have this level.
    pub(crate) fn new(size: [u32; 3], root_level: u32) -> Self {
        Self { size: [size[0], size[1]], root_level }
    }

    fn level(&self) -> u32 {
        self.root_level.max(PAGE_LEVEL)
    }

    fn dims(&self) -> [u32; 2] {
        self.size.map(|n| n.div_ceil(1 << self.level()))
    }

    /// Returns the number of parts.
    pub(crate) fn count(&self) -> usize {
        self.dims().iter().product::<u32>() as usize
    }

    fn place(&self, part: usize) -> [u32; 2] {
        let across = self.dims()[0];
        [part as u32 % across, part as u32 / across]
    }

    /// Returns the first texel of a part along x and y, and the number of its texels inside the grid.
    pub(crate) fn texels(&self, part: usize) -> [[u32; 2]; 2] {
        let corner = self.place(part).map(|n| n << self.level());
        [corner, [0, 1].map(|a| (1 << self.level()).min(self.size[a] - corner[a]))]
    }

    /// Returns the part at a page.
    pub(crate) fn at_page(&self, page: [u32; 2]) -> usize {
        let [x, y] = page.map(|n| n >> (self.level() - PAGE_LEVEL));
        (y * self.dims()[0] + x) as usize
    }

    /// Returns the part that has a root block, by the block's number, x fastest.
    pub(crate) fn of_root_block(&self, root_block: usize) -> usize {
        let across = self.size[0].div_ceil(1 << self.root_level);
        let at = [root_block as u32 % across, root_block as u32 / across];
        let [x, y] = at.map(|n| n >> (self.level() - self.root_level));
        (y * self.dims()[0] + x) as usize
    }

    /// Returns the root blocks of a part, x fastest.
    pub(crate) fn root_blocks(&self, part: usize) -> impl Iterator<Item = usize> {
        let root_blocks = self.size.map(|n| n.div_ceil(1 << self.root_level));
        inside(self.place(part), self.level() - self.root_level, root_blocks)
            .map(move |[x, y]| (y * root_blocks[0] + x) as usize)
    }

    /// Returns the pages of a part, x fastest.
    pub(crate) fn pages(&self, part: usize) -> impl Iterator<Item = [u32; 2]> {
        inside(self.place(part), self.level() - PAGE_LEVEL, page_dims([self.size[0], self.size[1], 1]))
    }

    /// Returns the number of pages of a part along x and y.
    pub(super) fn page_dims(&self, part: usize) -> [u32; 2] {
        let side = 1 << (self.level() - PAGE_LEVEL);
        let [at, all] = [self.place(part), page_dims([self.size[0], self.size[1], 1])];
        [0, 1].map(|a| side.min(all[a] - at[a] * side))
    }
}

/// Returns the squares of a grid of `dims` that are in the square at `place` of 2^shift a side, x fastest.
fn inside(place: [u32; 2], shift: u32, dims: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    let [xs, ys] = [0, 1].map(|a| place[a] << shift..((place[a] + 1) << shift).min(dims[a]));
    ys.flat_map(move |y| xs.clone().map(move |x| [x, y]))
}
