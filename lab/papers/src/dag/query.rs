//! Look-ups in a graph on the CPU, voxel by voxel: the counterpart of a shadow file's
//! [`Sampler`](adumbra::Sampler).

use adumbra::query::{FixedReceiver, Receiver, receiver};
use adumbra::{Bias, Filter, LightGrid, PointVisibility};

use crate::dag::LeafMasks;
use crate::dag::taps::Cubes;

/// Look-ups in the voxels of a graph, or of a quadtree.
#[derive(Clone, Copy)]
pub struct DagQuery<'d> {
    grid: &'d LightGrid,
    leaf_masks: &'d dyn LeafMasks,
    bias: Bias,
    filter: Filter,
}

impl<'d> DagQuery<'d> {
    /// Creates look-ups.
    pub fn new(grid: &'d LightGrid, leaf_masks: &'d dyn LeafMasks, bias: Bias, filter: Filter) -> Self {
        Self { grid, leaf_masks, bias, filter }
    }

    /// Returns the filter.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// Returns the bias that points are moved by.
    pub fn bias(&self) -> Bias {
        self.bias
    }

    /// Returns the visibility of a point that is already biased.
    pub fn receiver_visibility(&self, r: &Receiver) -> f32 {
        let width = self.filter.width();
        self.lit_taps(&FixedReceiver::new(r, self.leaf_masks.size())) as f32 / (width * width) as f32
    }

    /// Returns how many of the filter's taps are lit, for a receiver in fixed point. A shader returns the
    /// same count.
    pub fn lit_taps(&self, r: &FixedReceiver) -> u32 {
        if self.filter == Filter::Nearest {
            return u32::from(self.voxel(r).is_none_or(|[i, j, k]| self.leaf_masks.voxel(i, j, k)));
        }
        Cubes::<8>::new(self.leaf_masks).lit_taps(self.filter.width(), r)
    }

    /// Returns the level of the block in which the look-up of the filter's middle texel ends, see
    /// [`LeafMasks::end_level`]. `None` outside the grid's texels and before the grid.
    pub fn end_level(&self, r: &FixedReceiver) -> Option<u32> {
        self.voxel(r).map(|[i, j, k]| self.leaf_masks.end_level(i, j, k))
    }

    fn voxel(&self, r: &FixedReceiver) -> Option<[u32; 3]> {
        let [nx, ny, nz] = self.leaf_masks.size().map(i64::from);
        let [x, y] = r.texel();
        let layer = r.layer([x, y]);
        let is_inside = (0..nx).contains(&x) && (0..ny).contains(&y) && layer >= 0;
        is_inside.then(|| [x as u32, y as u32, layer.min(nz - 1) as u32])
    }
}

impl PointVisibility for DagQuery<'_> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.receiver_visibility(&receiver(self.grid, &self.bias, p_world, normal))
    }

    fn visibilities(&self, points_world: &[[f64; 3]], normals: Option<&[[f64; 3]]>) -> Vec<f32> {
        let mut cubes = Cubes::<32>::new(self.leaf_masks);
        let width = self.filter.width();
        let points = points_world.iter().enumerate();
        points
            .map(|(i, &p)| {
                let r = receiver(self.grid, &self.bias, p, normals.map(|n| n[i]));
                let lit = cubes.lit_taps(width, &FixedReceiver::new(&r, self.leaf_masks.size()));
                lit as f32 / (width * width) as f32
            })
            .collect()
    }
}
