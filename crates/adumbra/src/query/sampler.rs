//! Look-ups in a file.

use std::sync::Arc;

use crate::error::Result;
use crate::file::ShadowFile;
use crate::grid::{LightGrid, Placement};
use crate::layout::depths::{DepthTree, TreeWords};
use crate::query::columns::Columns;
use crate::query::fixed::{FIXED_BITS, FixedReceiver, GRADIENT_BITS};
use crate::query::{Filter, Receiver, receiver};
use crate::settings::Bias;

/// Looks up the visibility of points in a file: 1 = the point sees the sun.
///
/// It shares the file's voxels, so it outlives the file and is cheap to clone.
#[derive(Clone, Debug)]
pub struct Sampler {
    grid: LightGrid,
    tree: Arc<DepthTree>,
    bias: Bias,
    filter: Filter,
}

impl ShadowFile {
    /// Returns look-ups with this filter, and with the bias that the file was baked for.
    pub fn sampler(&self, filter: Filter) -> Sampler {
        Sampler { grid: self.grid, tree: Arc::clone(&self.tree), bias: self.settings.bias, filter }
    }
}

impl Sampler {
    /// Returns look-ups with another bias.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::Error::Range) if a term is out of its range.
    pub fn with_bias(self, bias: Bias) -> Result<Self> {
        bias.check()?;
        Ok(Self { bias, ..self })
    }

    /// Returns look-ups in the world of an app that has placed the file: points and normals are the app's.
    /// The bias is in texels and stays as it is. Placing placed look-ups combines the two placements.
    #[must_use]
    pub fn placed(self, placement: &Placement) -> Self {
        Self { grid: self.grid.placed(placement), ..self }
    }

    /// Returns the filter.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// Returns the bias that points are moved by.
    pub fn bias(&self) -> Bias {
        self.bias
    }

    /// Returns the visibility of a world point, 1 = lit. `normal` is the surface's unit normal there, if the
    /// point is on a surface.
    ///
    /// A point that is not finite is lit. Cost: one path of the quadtree per block of 8 × 8 texels, which is
    /// at most 1, 4, 4, 4, 9 paths for the filters in [`Filter::ALL`].
    pub fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.receiver_visibility(&receiver(&self.grid, &self.bias, p_world, normal))
    }

    /// Returns the visibility of a point that is already biased.
    #[doc(hidden)]
    pub fn receiver_visibility(&self, r: &Receiver) -> f32 {
        self.share(self.lit_taps(&FixedReceiver::new(r, self.tree.size())))
    }

    /// Returns how many of the filter's taps are lit, for a receiver in fixed point. A shader returns the
    /// same count.
    #[doc(hidden)]
    pub fn lit_taps(&self, r: &FixedReceiver) -> u32 {
        lit_taps(self.tree.words(), self.filter, r)
    }

    /// Returns a function that does what [`Sampler::lit_taps`] does, but costs less if successive receivers
    /// are close to each other: the depths of the columns of the most recent blocks are cached.
    #[doc(hidden)]
    pub fn successive_lit_taps(&self) -> impl FnMut(&FixedReceiver) -> u32 {
        let (tree, filter) = (self.tree.words(), self.filter);
        let mut columns = Columns::new(tree);
        move |r| match &mut columns {
            Some(columns) => columns.lit_taps(filter.width(), r),
            None => taps_one_by_one(tree, filter, r),
        }
    }

    pub(super) fn share(&self, lit_taps: u32) -> f32 {
        let width = self.filter.width();
        lit_taps as f32 / (width * width) as f32
    }

    pub(super) fn grid(&self) -> &LightGrid {
        &self.grid
    }

    pub(super) fn tree(&self) -> &DepthTree {
        &self.tree
    }
}

/// Returns how many of a filter's taps are lit in a quadtree whose pages under the filter are resident.
pub fn lit_taps(tree: TreeWords<'_>, filter: Filter, r: &FixedReceiver) -> u32 {
    if filter == Filter::Nearest {
        return taps_one_by_one(tree, filter, r);
    }
    match Columns::new(tree) {
        Some(mut columns) => columns.lit_taps(filter.width(), r),
        None => taps_one_by_one(tree, filter, r),
    }
}

/// Returns the number of lit taps, also in a grid in which the columns' depths do not fit 32 bits.
fn taps_one_by_one(tree: TreeWords<'_>, filter: Filter, r: &FixedReceiver) -> u32 {
    let reach = i64::from(filter.width() / 2);
    let [x, y] = r.texel();
    let taps = (y - reach..=y + reach).flat_map(|j| (x - reach..=x + reach).map(move |i| [i, j]));
    taps.map(|tap| u32::from(voxel_at(tree, r, tap).is_none_or(|[i, j, k]| k < tree.value(i, j)))).sum()
}

/// Returns the voxel that answers a tap, or `None` outside the grid's texels and before the grid. Behind the
/// last layer, the last layer answers.
fn voxel_at(tree: TreeWords<'_>, r: &FixedReceiver, [x, y]: [i64; 2]) -> Option<[u32; 3]> {
    let [nx, ny, nz] = tree.size.map(i64::from);
    let layer = r.depth([x, y]) >> (FIXED_BITS + GRADIENT_BITS);
    let is_inside = (0..nx).contains(&x) && (0..ny).contains(&y) && layer >= 0;
    is_inside.then(|| [x as u32, y as u32, layer.min(nz - 1) as u32])
}
