//! The root blocks of the light's plane, and the inputs for building each one. Both builders share them.

use adumbra::LightGrid;

use crate::columns::capture::TileRect;
use crate::columns::rules::ColumnRules;
use crate::triangles::casters::Casters;

/// A scene divided into root blocks.
pub(crate) struct Tiles<'s> {
    pub(crate) grid: LightGrid,
    pub(crate) rules: ColumnRules,
    pub(crate) casters: Casters<'s>,
    /// A root block is 2^root_level texels a side. A root cube is as deep as it is wide.
    pub(crate) root_level: u32,
    /// Number of root cubes along x, y, z.
    pub(crate) top_dims: [u32; 3],
}

impl Tiles<'_> {
    /// Returns the number of root blocks; they are ordered with x fastest.
    pub(crate) fn count(&self) -> usize {
        (self.top_dims[0] * self.top_dims[1]) as usize
    }

    /// Returns the texels of a root block that are inside the grid.
    pub(crate) fn rect(&self, tile: usize) -> TileRect {
        let side = 1 << self.root_level;
        let (tx, ty) = (tile as u32 % self.top_dims[0], tile as u32 / self.top_dims[0]);
        let (x, y) = (tx * side, ty * side);
        TileRect { x, y, width: side.min(self.grid.size[0] - x), height: side.min(self.grid.size[1] - y) }
    }
}
