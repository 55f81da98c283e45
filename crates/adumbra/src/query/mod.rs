//! Point visibility: the CPU twin of the look-up shader.
//!
//! World point → bias → grid → K × K texels. All taps that fall in one 8 × 8 block share one receiver depth, that of the
//! receiver's plane at the centre of those taps less half the slope times their extent; the block's slab at that depth is
//! fetched once and its bits counted under a mask. Specification §6. Up to the bias it is `f64`; from there on whole
//! numbers, see [`FixedReceiver`].

mod cursor;
mod fixed;
mod penumbra;
mod plan;
mod tree;
mod tree_receiver;

pub use cursor::Cursor;
pub use fixed::{
    FIXED_BITS, FIXED_ONE, FixedReceiver, GRADIENT_BITS, GRADIENT_ONE, MARGIN_VOXELS, MAX_FIXED_SIDE,
    MAX_GRADIENT,
};
pub use penumbra::PenumbraQuery;
pub use plan::PlanLevels;
pub use tree::{KERNEL_SIDES, TreeQuery, Weights};
pub use tree_receiver::{MAX_HEIGHT_CELLS, NORMAL_BITS, NORMAL_ONE, TreeReceiver};

use crate::dag::Slabs;
use crate::error::{Error, Result};
use crate::light::LightGrid;
use crate::settings::{Bias, MAX_SLOPE};
use crate::tree::Voxels;

/// Anything that answers points.
pub trait PointVisibility: Sync {
    /// Visibility of a world point, 1 = lit; `normal` is the surface's unit normal there, if it lies on one.
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32;

    /// Visibilities of points one after the other, with a normal each or none; the same answers, cheaper where neighbours
    /// follow each other.
    fn visibilities(&self, points_world: &[[f64; 3]], normals: Option<&[[f64; 3]]>) -> Vec<f32> {
        let points = points_world.iter().enumerate();
        points.map(|(i, &p)| self.visibility(p, normals.map(|n| n[i]))).collect()
    }
}

impl PointVisibility for Query<'_> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        Query::visibility(self, p_world, normal)
    }

    fn visibilities(&self, points_world: &[[f64; 3]], normals: Option<&[[f64; 3]]>) -> Vec<f32> {
        let mut cursor = Cursor::new(*self);
        let points = points_world.iter().enumerate();
        points.map(|(i, &p)| cursor.visibility(p, normals.map(|n| n[i]))).collect()
    }
}

impl<T: Voxels + Sync> PointVisibility for TreeQuery<'_, T> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        TreeQuery::visibility(self, p_world, normal)
    }
}

/// Filter widths in texels that a look-up may use.
pub const FILTER_WIDTHS: [u32; 5] = [1, 3, 5, 9, 17];

/// A look-up into what a bake has left, whatever its layout.
#[derive(Clone, Copy)]
pub struct Query<'d> {
    grid: &'d LightGrid,
    slabs: &'d dyn Slabs,
    bias: Bias,
    filter: u32,
}

/// A point of the grid with the slope of its surface there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Grid coordinates after the bias, voxels.
    pub p_grid: [f64; 3],
    /// Slope of the receiver's plane: dz/dx and dz/dy, voxels along the light a texel; zero where no normal is known.
    pub gradient: [f64; 2],
}

impl<'d> Query<'d> {
    /// Look-ups with `filter` × `filter` texels.
    ///
    /// # Errors
    /// [`Error::OptionRange`] for a width that is not in [`FILTER_WIDTHS`].
    pub fn new(grid: &'d LightGrid, slabs: &'d dyn Slabs, bias: Bias, filter: u32) -> Result<Self> {
        if !FILTER_WIDTHS.contains(&filter) {
            return Err(Error::OptionRange {
                option: "--filter",
                value: filter.to_string(),
                range: "1, 3, 5, 9 or 17",
            });
        }
        Ok(Self { grid, slabs, bias, filter })
    }

    /// The bias that points are moved by.
    pub fn bias(&self) -> Bias {
        self.bias
    }

    /// Visibility of a world point, 1 = lit; `normal` is the surface's unit normal there, if it lies on one.
    ///
    /// A point that is not finite is lit. Cost: one path of the graph a block of 8 × 8 texels, at most 1, 4, 4, 4, 9.
    pub fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.receiver_visibility(&receiver(self.grid, &self.bias, p_world, normal))
    }

    /// Visibility of a point that is already biased.
    pub fn receiver_visibility(&self, r: &Receiver) -> f32 {
        let lit = self.lit_taps(&FixedReceiver::new(r, self.slabs.size()));
        lit as f32 / (self.filter * self.filter) as f32
    }

    /// Taps of filter² that are lit, for a point in fixed point: what a shader answers too.
    pub fn lit_taps(&self, r: &FixedReceiver) -> u32 {
        self.lit_taps_of(r, |i, j, k| self.slabs.slab(i, j, k))
    }

    /// Level of the block in which the look-up of the filter's middle ends, as [`Slabs::end_level`]; none beside the grid and before it,
    /// where nothing is looked up. What a shader answers too.
    pub fn end_level(&self, r: &FixedReceiver) -> Option<u32> {
        let [nx, ny, nz] = self.slabs.size().map(i64::from);
        let [x, y] = r.texel();
        let layer = r.shared_layer([x, x], [y, y]);
        let is_inside = (0..nx).contains(&x) && (0..ny).contains(&y) && layer >= 0;
        is_inside.then(|| self.slabs.end_level(x as u32, y as u32, layer.min(nz - 1) as u32))
    }

    /// [`Query::lit_taps`] with slabs from `slab`.
    fn lit_taps_of(&self, r: &FixedReceiver, mut slab: impl FnMut(u32, u32, u32) -> u64) -> u32 {
        let size = self.slabs.size().map(i64::from);
        let reach = i64::from(self.filter / 2);
        let texel = r.texel();
        let (low, high) = (texel.map(|t| t - reach), texel.map(|t| t + reach));
        let mut lit = 0;
        let mut y = low[1];
        while y <= high[1] {
            let y_last = (y | 7).min(high[1]);
            let mut x = low[0];
            while x <= high[0] {
                let x_last = (x | 7).min(high[0]);
                lit += block(size, r, [x, x_last], [y, y_last], &mut slab);
                x = x_last + 1;
            }
            y = y_last + 1;
        }
        lit
    }
}

/// Lit taps among texels x[0]..=x[1], y[0]..=y[1], all in one block.
fn block(
    [nx, ny, nz]: [i64; 3],
    r: &FixedReceiver,
    x: [i64; 2],
    y: [i64; 2],
    slab: &mut impl FnMut(u32, u32, u32) -> u64,
) -> u32 {
    let mut mask = rectangle(x, y);
    let taps = mask.count_ones();
    // Texels beside the grid are lit.
    let inside_x = [x[0].max(0), x[1].min(nx - 1)];
    let inside_y = [y[0].max(0), y[1].min(ny - 1)];
    if inside_x[0] > inside_x[1] || inside_y[0] > inside_y[1] {
        return taps;
    }
    let layer = r.shared_layer(x, y);
    if layer < 0 {
        return taps;
    }
    let k = layer.min(nz - 1) as u32;
    mask &= rectangle(inside_x, inside_y);
    let outside = taps - mask.count_ones();
    outside + (slab(inside_x[0] as u32, inside_y[0] as u32, k) & mask).count_ones()
}

/// Bits y·8 + x of a rectangle within one block.
fn rectangle(x: [i64; 2], y: [i64; 2]) -> u64 {
    let width = (x[1] - x[0] + 1) as u32;
    let row = ((1_u64 << width) - 1) << (x[0] & 7);
    let rows = u64::MAX >> (56 - 8 * (y[1] - y[0])) << ((y[0] & 7) * 8);
    (row * 0x0101_0101_0101_0101) & rows
}

/// Moves a world point by `bias` and gives it in grid space, with its plane's slope.
///
/// The constant and the slope term move it along the light, so it stays on its own sun ray; the slope counts at most
/// [`MAX_SLOPE`], also for faces turned away.
pub fn receiver(grid: &LightGrid, bias: &Bias, p_world: [f64; 3], normal: Option<[f64; 3]>) -> Receiver {
    let mut p_grid = grid.to_grid(p_world);
    let mut gradient = [0.0; 2];
    let mut slope = 0.0;
    if let Some(normal) = normal {
        let n = grid.direction_to_grid(normal);
        let tangent = (n[0] * n[0] + n[1] * n[1]).sqrt();
        // n·l is -n.z: the grid's z runs away from the sun.
        let n_dot_l = (-n[2]).max(tangent / MAX_SLOPE);
        if n_dot_l > 0.0 && n_dot_l.is_finite() {
            gradient = [n[0] / n_dot_l, n[1] / n_dot_l];
            slope = tangent / n_dot_l;
        }
        for a in 0..3 {
            p_grid[a] += n[a] * bias.normal_offset_texels;
        }
    }
    p_grid[2] -= bias.along_light(slope);
    Receiver { p_grid, gradient }
}
