//! Visibility of points: the CPU counterpart of the look-up shader.
//!
//! A look-up takes a world point through these steps: world point → bias → grid → K × K texels. Each texel is answered
//! by the voxel that the receiver's plane passes there. Computations up to the bias use `f64`, those after it integers,
//! see [`FixedReceiver`].
//!
//! The rules are in `spec/adumbra-file.md`, "Look-up bias and filters".

mod columns;
mod cursor;
mod fixed;
mod taps;

pub use cursor::Cursor;
pub use fixed::{
    FIXED_BITS, FIXED_ONE, FixedReceiver, GRADIENT_BITS, GRADIENT_ONE, MARGIN_VOXELS, MAX_FIXED_SIDE,
    MAX_GRADIENT,
};

use crate::error::{RangeError, RangeField, Result};
use crate::grid::LightGrid;
use crate::layout::LeafMasks;
use crate::settings::{Bias, MAX_PLANE_SLOPE};
use columns::Columns;
use taps::Cubes;

/// A source of visibility at points.
pub trait PointVisibility: Sync {
    /// Returns the visibility of a world point, 1 = lit. `normal` is the surface's unit normal there, if the point is
    /// on a surface.
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32;

    /// Returns the visibilities of successive points, with one normal per point or none at all. The results equal those
    /// of [`PointVisibility::visibility`], but cost less if successive points are close to each other.
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

/// Allowed filter widths, in texels.
pub const FILTER_WIDTHS: [u32; 5] = [1, 3, 5, 9, 17];

/// Look-ups in the voxels of a file, whatever their layout.
#[derive(Clone, Copy)]
pub struct Query<'d> {
    grid: &'d LightGrid,
    leaf_masks: &'d dyn LeafMasks,
    bias: Bias,
    filter: u32,
}

/// A point in grid space, with the slope of its surface there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Grid coordinates after the bias, in voxels.
    pub p_grid: [f64; 3],
    /// Slope of the receiver's plane: dz/dx and dz/dy, in voxels along the light per texel. Zero if no normal is known.
    pub gradient: [f64; 2],
}

impl<'d> Query<'d> {
    /// Creates look-ups with a filter of `filter` × `filter` texels.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::Error::Range) if the width is not in [`FILTER_WIDTHS`].
    pub fn new(grid: &'d LightGrid, leaf_masks: &'d dyn LeafMasks, bias: Bias, filter: u32) -> Result<Self> {
        if !FILTER_WIDTHS.contains(&filter) {
            return Err(RangeError::new(RangeField::FilterWidth, filter, "1, 3, 5, 9 or 17").into());
        }
        Ok(Self { grid, leaf_masks, bias, filter })
    }

    /// Returns the filter width in texels.
    pub fn filter(&self) -> u32 {
        self.filter
    }

    /// Returns the bias that points are moved by.
    pub fn bias(&self) -> Bias {
        self.bias
    }

    /// Returns the visibility of a world point, 1 = lit. `normal` is the surface's unit normal there, if the point is
    /// on a surface.
    ///
    /// A point that is not finite is lit. Cost: one path of the graph per block of 8 × 8 texels, which is at most 1, 4,
    /// 4, 4, 9 paths for the widths in [`FILTER_WIDTHS`]. In addition, one step for each further eight layers that the
    /// taps of a block span.
    pub fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.receiver_visibility(&receiver(self.grid, &self.bias, p_world, normal))
    }

    /// Returns the visibility of a point that is already biased.
    pub fn receiver_visibility(&self, r: &Receiver) -> f32 {
        let lit = self.lit_taps(&FixedReceiver::new(r, self.leaf_masks.size()));
        lit as f32 / (self.filter * self.filter) as f32
    }

    /// Returns how many of the filter² taps are lit, for a receiver in fixed point. A shader returns the same count.
    pub fn lit_taps(&self, r: &FixedReceiver) -> u32 {
        if self.filter == 1 {
            let lit = self.voxel(r).is_none_or(|[i, j, k]| self.leaf_masks.voxel(i, j, k));
            return u32::from(lit);
        }
        match Columns::new(self.leaf_masks) {
            Some(mut columns) => columns.lit_taps(self.filter, r),
            None => Cubes::<8>::new(self.leaf_masks).lit_taps(self.filter, r),
        }
    }

    /// Returns the level of the block in which the look-up of the filter's middle texel ends, see
    /// [`LeafMasks::end_level`]. `None` outside the grid's texels and before the grid, where nothing is looked up. A
    /// shader returns the same level.
    pub fn end_level(&self, r: &FixedReceiver) -> Option<u32> {
        self.voxel(r).map(|[i, j, k]| self.leaf_masks.end_level(i, j, k))
    }

    /// Returns the voxel that answers an unfiltered receiver, or `None` outside the grid's texels and before the grid.
    fn voxel(&self, r: &FixedReceiver) -> Option<[u32; 3]> {
        let [nx, ny, nz] = self.leaf_masks.size().map(i64::from);
        let [x, y] = r.texel();
        let layer = r.depth([x, y]) >> (FIXED_BITS + GRADIENT_BITS);
        let is_inside = (0..nx).contains(&x) && (0..ny).contains(&y) && layer >= 0;
        is_inside.then(|| [x as u32, y as u32, layer.min(nz - 1) as u32])
    }
}

/// Returns the normal if all of its components are finite.
pub fn finite(normal: Option<[f64; 3]>) -> Option<[f64; 3]> {
    normal.filter(|n| n.iter().all(|c| c.is_finite()))
}

/// Moves a world point by `bias` and converts it to grid space, with the slope of its plane.
///
/// The constant and slope terms move the point along the light, so it stays on its own sun ray. The bias clamps the
/// slope to [`MAX_SLOPE`](crate::settings::MAX_SLOPE). The plane is the surface's own, whichever side faces the sun,
/// with a slope of up to [`MAX_PLANE_SLOPE`]. A normal with a component that is not finite is ignored.
pub fn receiver(grid: &LightGrid, bias: &Bias, p_world: [f64; 3], normal: Option<[f64; 3]>) -> Receiver {
    let mut p_grid = grid.to_grid(p_world);
    let mut gradient = [0.0; 2];
    let mut slope = 0.0;
    if let Some(normal) = finite(normal) {
        let n = grid.normal_to_grid(normal);
        let tangent = (n[0] * n[0] + n[1] * n[1]).sqrt();
        // |n.z| is |n·l|, times the length of a voxel along the light in voxels.
        let n_dot_l = n[2].abs().max(tangent / MAX_PLANE_SLOPE);
        if n_dot_l > 0.0 && n_dot_l.is_finite() {
            let towards_sun = if n[2] > 0.0 { -n_dot_l } else { n_dot_l };
            gradient = [n[0] / towards_sun, n[1] / towards_sun];
            slope = tangent / n_dot_l;
        }
        let off_surface = grid.direction_to_grid(normal);
        for a in 0..3 {
            p_grid[a] += off_surface[a] * bias.normal_offset_texels;
        }
    }
    p_grid[2] -= bias.along_light(slope);
    Receiver { p_grid, gradient }
}
