//! Visibility of points: the CPU counterpart of the look-up shader.
//!
//! A look-up takes a world point through these steps: world point → bias → grid → K × K texels. Each texel is
//! answered by the voxel that the receiver's plane crosses there. Computations up to the bias use `f64`,
//! those after it integers, see [`FixedReceiver`].
//!
//! The rules are in `spec/adumbra-file.md`, "Look-up bias and filters".

mod batch;
mod columns;
mod filter;
mod fixed;
mod march;
mod sampler;

pub use filter::Filter;
pub use fixed::{
    FIXED_BITS, FIXED_ONE, FixedReceiver, GRADIENT_BITS, GRADIENT_ONE, MARGIN_VOXELS, MAX_FIXED_SIDE,
    MAX_GRADIENT,
};
pub use march::{EDGE_VOXELS, MAX_MARCH_SLOPE, MarchSlope, Marched, SLOPE_BITS, march};
pub use sampler::{Sampler, lit_taps};

use crate::grid::LightGrid;
use crate::settings::{Bias, MAX_PLANE_SLOPE};

/// A source of visibility at points.
pub trait PointVisibility: Sync {
    /// Returns the visibility of a world point, 1 = lit. `normal` is the surface's unit normal there, if the
    /// point is on a surface.
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32;

    /// Returns the visibilities of successive points, with one normal per point or none at all. The results
    /// equal those of [`PointVisibility::visibility`], but cost less if successive points are close to each
    /// other.
    fn visibilities(&self, points_world: &[[f64; 3]], normals: Option<&[[f64; 3]]>) -> Vec<f32> {
        let points = points_world.iter().enumerate();
        points.map(|(i, &p)| self.visibility(p, normals.map(|n| n[i]))).collect()
    }
}

impl<V: PointVisibility + ?Sized> PointVisibility for Box<V> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        (**self).visibility(p_world, normal)
    }

    fn visibilities(&self, points_world: &[[f64; 3]], normals: Option<&[[f64; 3]]>) -> Vec<f32> {
        (**self).visibilities(points_world, normals)
    }
}

/// A point in grid space, with the slope of its surface there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Grid coordinates after the bias, in voxels.
    pub p_grid: [f64; 3],
    /// Slope of the receiver's plane: dz/dx and dz/dy, in voxels along the light per texel. Zero if no normal
    /// is known.
    pub gradient: [f64; 2],
}

/// Returns the normal if all of its components are finite.
pub fn finite(normal: Option<[f64; 3]>) -> Option<[f64; 3]> {
    normal.filter(|n| n.iter().all(|c| c.is_finite()))
}

/// Moves a world point by `bias` and converts it to grid space, with the slope of its plane.
///
/// The constant and slope terms move the point along the light, so it stays on its own sun ray. The bias
/// clamps the slope to [`MAX_SLOPE`](crate::settings::MAX_SLOPE). The plane is the surface's own, whichever
/// side faces the sun, with a slope of up to [`MAX_PLANE_SLOPE`]. A normal with a component that is not
/// finite is ignored.
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
