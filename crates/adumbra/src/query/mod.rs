//! Point visibility: the CPU twin of the look-up shader.
//!
//! World point → bias → grid → K × K texels, each answered by the voxel that the receiver's plane passes there. Up to the bias it is `f64`;
//! from there on whole numbers, see [`FixedReceiver`].
//!
//! `spec/adumbra-file.md`, "Look-up bias and filters", has the rules. Where all taps in a block of 8 × 8 texels share a layer, [`TapLayers::Block`],
//! light leaks on slopes, in teeth below ledges and at the feet of walls; `docs/layouts.md` has what either gets wrong and costs.

mod cursor;
mod fixed;
mod penumbra;
mod plan;
mod taps;
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
use crate::settings::{Bias, MAX_PLANE_SLOPE};
use crate::tree::Voxels;
use taps::Cubes;

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

/// Which layer of voxels answers a filter's taps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TapLayers {
    /// Each tap's own: that which the receiver's plane passes there.
    #[default]
    Tap,
    /// One for all taps in a block of 8 × 8 texels, that of the tap at which the plane is nearest to the sun. A slab a block and no more, so
    /// cheaper; on a slope it loses every blocker within the plane's rise over the block.
    Block,
}

/// A look-up into what a bake has left, whatever its layout.
#[derive(Clone, Copy)]
pub struct Query<'d> {
    grid: &'d LightGrid,
    slabs: &'d dyn Slabs,
    bias: Bias,
    filter: u32,
    layers: TapLayers,
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
        Ok(Self { grid, slabs, bias, filter, layers: TapLayers::default() })
    }

    /// The same with other layers for its taps.
    #[must_use]
    pub fn with_layers(self, layers: TapLayers) -> Self {
        Self { layers, ..self }
    }

    /// Texels along a side of the filter.
    pub fn filter(&self) -> u32 {
        self.filter
    }

    /// The bias that points are moved by.
    pub fn bias(&self) -> Bias {
        self.bias
    }

    /// Visibility of a world point, 1 = lit; `normal` is the surface's unit normal there, if it lies on one.
    ///
    /// A point that is not finite is lit. Cost: one path of the graph a block of 8 × 8 texels, at most 1, 4, 4, 4, 9, and a step for each
    /// further eight layers that the taps of a block lie in.
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
        if self.filter == 1 {
            let lit = self
                .voxel(r)
                .is_none_or(|[i, j, k]| self.slabs.slab(i, j, k) >> ((j & 7) * 8 + (i & 7)) & 1 == 1);
            return u32::from(lit);
        }
        Cubes::<8>::new(self.slabs).lit_taps(self.filter, self.layers, r)
    }

    /// Level of the block in which the look-up of the filter's middle ends, as [`Slabs::end_level`]; none beside the grid and before it,
    /// where nothing is looked up. What a shader answers too.
    pub fn end_level(&self, r: &FixedReceiver) -> Option<u32> {
        self.voxel(r).map(|[i, j, k]| self.slabs.end_level(i, j, k))
    }

    /// The voxel that answers a receiver unfiltered; none beside the grid and before it.
    fn voxel(&self, r: &FixedReceiver) -> Option<[u32; 3]> {
        let [nx, ny, nz] = self.slabs.size().map(i64::from);
        let [x, y] = r.texel();
        let layer = r.depth([x, y]) >> (FIXED_BITS + GRADIENT_BITS);
        let is_inside = (0..nx).contains(&x) && (0..ny).contains(&y) && layer >= 0;
        is_inside.then(|| [x as u32, y as u32, layer.min(nz - 1) as u32])
    }
}

/// A normal, if all of its components are finite.
fn finite(normal: Option<[f64; 3]>) -> Option<[f64; 3]> {
    normal.filter(|n| n.iter().all(|c| c.is_finite()))
}

/// Moves a world point by `bias` and gives it in grid space, with its plane's slope.
///
/// The constant and the slope term move it along the light, so it stays on its own sun ray. The bias counts a slope of at most
/// [`MAX_SLOPE`](crate::settings::MAX_SLOPE); the plane is the surface's own, whichever side it turns to the sun, up to [`MAX_PLANE_SLOPE`].
/// A normal with a component that is not finite is none.
pub fn receiver(grid: &LightGrid, bias: &Bias, p_world: [f64; 3], normal: Option<[f64; 3]>) -> Receiver {
    let mut p_grid = grid.to_grid(p_world);
    let mut gradient = [0.0; 2];
    let mut slope = 0.0;
    if let Some(normal) = finite(normal) {
        let n = grid.direction_to_grid(normal);
        let tangent = (n[0] * n[0] + n[1] * n[1]).sqrt();
        // |n·l| is |n.z|: the grid's z runs away from the sun.
        let n_dot_l = n[2].abs().max(tangent / MAX_PLANE_SLOPE);
        if n_dot_l > 0.0 && n_dot_l.is_finite() {
            let towards_sun = if n[2] > 0.0 { -n_dot_l } else { n_dot_l };
            gradient = [n[0] / towards_sun, n[1] / towards_sun];
            slope = tangent / n_dot_l;
        }
        for a in 0..3 {
            p_grid[a] += n[a] * bias.normal_offset_texels;
        }
    }
    p_grid[2] -= bias.along_light(slope);
    Receiver { p_grid, gradient }
}
