//! The march: visibility towards one sun, from the depths of another sun's file.
//!
//! A file holds, for each column of a key sun's light space, the depth at which it becomes shadowed. The ray
//! from a point towards another sun is nearly parallel to the columns, so it crosses few of them. The march
//! follows the ray until it passes through the depths from behind, which is a hit, or leaves the grid. The
//! file lacks surfaces that are in the shadow of others, as seen from the key sun: a ray that has been in
//! shadow and out again may have met one.
//!
//! Near relatives: maximum mipmaps for rays over height fields (Tevs, Ihrke, Seidel, *Maximum Mipmaps for
//! Fast, Accurate, and Scalable Dynamic Height Field Rendering*, 2008). Here the height field is a light
//! space's, and the ray goes to another light.
//!
//! | number | fraction bits | range |
//! |---|---|---|
//! | grid position p | 12 | as in [`FixedReceiver`](super::FixedReceiver) |
//! | slope v: texels per voxel of depth | 16 | ±256 |
//! | rise t: how many voxels nearer to the sun | 12 | 0 to the depth of the point |
//! | v · t, shifted back by 16 bits | 12 | within the grid and one block beside it |
//!
//! Worked value: p = (10.5, 4.5, 20), v = (1/4, 0). After a rise of t = 6 (24576) the ray is at x = 10.5 +
//! 1.5 = 12, on a border of columns. (16384 · 24576) >> 16 = 6144 = 1.5.

use crate::grid::LightGrid;
use crate::layout::depths::code::{ColumnNode, Node};
use crate::layout::depths::{NEVER, TreeWords};
use crate::query::finite;
use crate::query::fixed::{FIXED_BITS, FIXED_ONE, MARGIN_VOXELS};
use crate::settings::{Bias, MAX_PLANE_SLOPE};

/// Number of fraction bits of a slope.
pub const SLOPE_BITS: u32 = 16;
/// Largest absolute value of a slope: 256 texels per voxel.
pub const MAX_MARCH_SLOPE: i32 = (256 << SLOPE_BITS) - 1;
/// A ray that leaves a column's shadow within this many voxels of its surface has passed through the
/// surface's edge.
pub const EDGE_VOXELS: u32 = 2;

/// The result of a march through a file's depths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marched {
    /// The ray passes through a surface.
    Blocked,
    /// The ray meets nothing.
    Clear,
    /// The ray meets nothing that the file shows, but has been in shadow, where something may be hidden.
    Unknown {
        /// The rise up to which the ray has been in shadow from its start on, in 2^-12 voxels. 0 if it begins
        /// in light.
        hidden_rise: u32,
    },
}

impl Marched {
    /// Returns whether a ray meets nothing. `self` is the result from the first file, `other` that from the
    /// second. A ray that is hidden from both for `dark_after_voxels` from its start counts as blocked; 0 =
    /// never.
    pub fn is_lit(self, other: impl FnOnce() -> Self, dark_after_voxels: u32) -> bool {
        let Self::Unknown { hidden_rise } = self else { return self == Self::Clear };
        match other() {
            Self::Blocked => false,
            Self::Clear => true,
            Self::Unknown { hidden_rise: in_other } => {
                let hidden_voxels = hidden_rise.min(in_other) >> FIXED_BITS;
                dark_after_voxels == 0 || hidden_voxels < dark_after_voxels
            }
        }
    }
}

/// The direction to a sun, in the grid of a file that was baked for another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MarchSlope {
    /// Texels along x and y per voxel of depth, sunward, in 2^-16.
    pub v_fixed: [i32; 2],
}

impl MarchSlope {
    /// Returns the direction to a sun, given as a unit vector. `None` if the sun is too far from the file's
    /// own: behind its plane, or more than 256 texels sideways per voxel of depth.
    pub fn new(grid: &LightGrid, towards_sun: [f64; 3]) -> Option<Self> {
        let [x, y, z] = grid.direction_to_grid(towards_sun);
        if z >= 0.0 {
            return None;
        }
        let fixed = [x, y].map(|c| (c / -z * f64::from(1 << SLOPE_BITS) + 0.5).floor());
        let limit = f64::from(MAX_MARCH_SLOPE);
        fixed.iter().all(|c| c.abs() <= limit).then(|| Self { v_fixed: fixed.map(|c| c as i32) })
    }

    /// Returns the start of the ray of a world point: its grid position, moved by the bias along the ray and
    /// the normal, in fixed point. Points far outside the grid are moved to its margin.
    pub fn start(
        &self,
        grid: &LightGrid,
        bias: &Bias,
        p_world: [f64; 3],
        normal: Option<[f64; 3]>,
    ) -> [i64; 3] {
        let v = self.v_fixed.map(|c| f64::from(c) / f64::from(1 << SLOPE_BITS));
        let mut p = grid.to_grid(p_world);
        let mut slope = 0.0;
        if let Some(normal) = finite(normal) {
            let n = grid.normal_to_grid(normal);
            let tangent = (n[0] * n[0] + n[1] * n[1]).sqrt();
            let along = (n[0] * v[0] + n[1] * v[1] - n[2]).abs().max(tangent / MAX_PLANE_SLOPE);
            if along > 0.0 && along.is_finite() {
                slope = tangent / along;
            }
            let off_surface = grid.direction_to_grid(normal);
            for a in 0..3 {
                p[a] += off_surface[a] * bias.normal_offset_texels;
            }
        }
        let rise = bias.along_light(slope);
        let p = [p[0] + v[0] * rise, p[1] + v[1] * rise, p[2] - rise];
        let is_finite = p.iter().all(|c| c.is_finite());
        std::array::from_fn(|a| {
            let far = i64::from(grid.size[a]) + i64::from(MARGIN_VOXELS);
            let [low, high] = [-i64::from(MARGIN_VOXELS), far].map(|voxels| voxels << FIXED_BITS);
            let fixed = (p[a] * f64::from(FIXED_ONE)).floor() as i64;
            if is_finite { fixed.clamp(low, high) } else { low }
        })
    }

    /// Returns the distance along an axis after a rise.
    fn aside(&self, axis: usize, rise: u32) -> i64 {
        let v = i64::from(self.v_fixed[axis]);
        ((v.abs() * i64::from(rise)) >> SLOPE_BITS) * v.signum()
    }

    /// Returns the rise from a position to the border of the block of 2^level columns a side that contains
    /// it. Where that is farther than 16 texels, it is up to one 16th of a voxel less.
    fn rise_to_border(&self, p: [i64; 2], level: u32) -> i64 {
        let side = 1_i64 << (FIXED_BITS + level);
        let along = |a: usize| {
            let v = i64::from(self.v_fixed[a]);
            let within = p[a] & (side - 1);
            let left = match v {
                0 => return i64::MAX,
                1.. => side - within,
                _ => within + 1,
            };
            if left < 1 << 16 { (left << 16) / v.abs() + 1 } else { ((left << 8) / v.abs()) << 8 }
        };
        along(0).min(along(1))
    }
}

/// Finds the blocks along a ray. The descent to a block begins at the last block's parent if the ray is still
/// inside it, which is the usual case.
struct Descent {
    parent: Node,
    /// The position of the parent among the blocks of its level.
    parent_block: [u32; 2],
}

impl Descent {
    const START: Self = Self { parent: Node { at: 0, base: 0, level: 0 }, parent_block: [u32::MAX; 2] };

    fn place(&mut self, tree: TreeWords<'_>, [i, j]: [u32; 2]) -> (ColumnNode, u32) {
        let is_within = [i, j].map(|c| c >> self.parent.level) == self.parent_block;
        let from = if is_within { self.parent } else { tree.root(i, j) };
        tree.shapes().descend_through(from, [i, j], |node| {
            self.parent_block = [i, j].map(|c| c >> node.level);
            self.parent = node;
        })
    }
}

/// Follows the ray from a start through a quadtree, all of whose pages are resident. Cost: one step in the
/// quadtree per block that the ray passes, usually three to eight, and a path from the root where it leaves a
/// node.
pub fn march(tree: TreeWords<'_>, slope: MarchSlope, start: [i64; 3]) -> Marched {
    let last_depth = (i64::from(tree.size[2]) << FIXED_BITS) - 1;
    let depth = start[2].min(last_depth);
    let mut has_been_dark = false;
    // The rise at which the ray first was in light.
    let mut lit_from = i64::MAX;
    // The surface of the previous column, if the ray was in its shadow.
    let mut behind: Option<i64> = None;
    // The block that the ray is in. In a leaf it passes several columns, whose depths have these bounds.
    let (mut block, mut level) = ([u32::MAX; 2], 0);
    let (mut place, mut bounds) = (ColumnNode::Uniform(NEVER), [NEVER; 2]);
    let mut descent = Descent::START;
    let mut rise = 0_i64;
    loop {
        let z = depth - rise;
        let at = [0, 1].map(|a| start[a] + slope.aside(a, rise as u32));
        let texel = at.map(|c| c >> FIXED_BITS);
        let is_outside = (0..2).any(|a| !(0..i64::from(tree.size[a])).contains(&texel[a]));
        if z < 0 || is_outside {
            let hidden_rise = lit_from.min(rise).min(depth) as u32;
            return if has_been_dark { Marched::Unknown { hidden_rise } } else { Marched::Clear };
        }
        let [i, j] = texel.map(|c| c as u32);
        if [i, j].map(|c| c >> level) != block {
            (place, level) = descent.place(tree, [i, j]);
            block = [i, j].map(|c| c >> level);
            if let ColumnNode::Leaf { at, base } = place {
                bounds = tree.shapes().leaf(at, base).bounds();
            }
        }
        let [nearest, farthest] = bounds;
        let to_border = slope.rise_to_border(at, level);
        let is_dark = |depth: u32| depth != NEVER && z - to_border >= fixed(depth) + fixed(EDGE_VOXELS);
        let (value, to_border) = match place {
            ColumnNode::Uniform(value) => (value, to_border),
            // All of the leaf's columns are lit, or all are dark up to its border.
            ColumnNode::Leaf { .. } if nearest == NEVER || z < fixed(nearest) => (nearest, to_border),
            ColumnNode::Leaf { .. } if is_dark(farthest) => (farthest, to_border),
            ColumnNode::Leaf { at: leaf, base } => {
                let column = (j & 7) * 8 + (i & 7);
                (tree.shapes().leaf(leaf, base).value(column), slope.rise_to_border(at, 0))
            }
        };
        if value == NEVER || z < fixed(value) {
            if behind.is_some_and(|surface| z - surface < fixed(EDGE_VOXELS)) {
                return Marched::Blocked;
            }
            behind = None;
            lit_from = lit_from.min(rise);
        } else {
            if z - to_border < fixed(value) {
                return Marched::Blocked;
            }
            has_been_dark = true;
            behind = Some(fixed(value));
        }
        rise += to_border;
    }
}

fn fixed(voxels: u32) -> i64 {
    i64::from(voxels) << FIXED_BITS
}
