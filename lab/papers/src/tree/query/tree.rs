//! Visibility of points from a world-aligned tree, with voxel PCF. Source: the paper's §4.
//!
//! World point → bias along the light → voxel → 1, 3 × 3 × 3 or 5 × 5 × 5 voxels around it, with weights.
//! Departures: if the normal is known, taps whose centre is behind the receiver's plane are skipped, because
//! all of them are in the receiver's own shadow. If a tree has several depths, the whole kernel uses one
//! voxel size, the coarsest within its reach, so that neither bias nor kernel changes along the seam.
//! Computations up to bias and entry into the cube use `f64`; those after it use integers, see
//! [`TreeReceiver`].

use crate::tree::error::Result;
use crate::tree::query::plan::PlanLevels;
use crate::tree::query::receiver::TreeReceiver;
use crate::tree::space::{Regions, TreeSpace};
use crate::tree::voxels::Voxels;
use adumbra::grid::Sun;
use adumbra::grid::vec3::dot;
use adumbra::query::{PointVisibility, finite};
use adumbra::{Bias, MAX_SLOPE};
use adumbra::{RangeError, RangeField};

/// Kernel sides in voxels that a look-up supports.
pub const KERNEL_SIDES: [u32; 3] = [1, 3, 5];

/// Weights of the taps, by their distance from the centre along each axis; the three factors are multiplied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weights {
    /// All weights are equal.
    #[default]
    Mean,
    /// The Poisson distribution with mean 1/2, λ^d / d!, in eighths: 8, 4, 1.
    Poisson,
}

impl Weights {
    /// Returns the factor of a tap `distance` voxels from the centre along one axis, 0 to 2.
    pub fn along_axis(self, distance: u32) -> u32 {
        match self {
            Self::Mean => 1,
            Self::Poisson => [8, 4, 1][distance as usize],
        }
    }
}

impl<T: Voxels + Sync> PointVisibility for TreeQuery<'_, T> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        TreeQuery::visibility(self, p_world, normal)
    }
}

/// Look-ups into a tree.
#[derive(Clone, Debug)]
pub struct TreeQuery<'t, T> {
    space: TreeSpace,
    tree: &'t T,
    towards_sun: [f64; 3],
    bias: Bias,
    reach: i32,
    weights: Weights,
    all_taps: bool,
    plan: PlanLevels,
}

impl<'t, T: Voxels> TreeQuery<'t, T> {
    /// Creates look-ups with `kernel_side`³ voxels.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::tree::Error::Range) if the side is not in [`KERNEL_SIDES`].
    pub fn new(
        space: &TreeSpace,
        regions: &Regions,
        sun: &Sun,
        tree: &'t T,
        bias: Bias,
        kernel_side: u32,
        weights: Weights,
    ) -> Result<Self> {
        if !KERNEL_SIDES.contains(&kernel_side) {
            return Err(RangeError::new(
                RangeField::FilterWidth,
                kernel_side,
                "1, 3 or 5 for a world-aligned tree",
            )
            .into());
        }
        Ok(Self {
            space: *space,
            tree,
            towards_sun: sun.towards(),
            bias,
            reach: (kernel_side / 2) as i32,
            weights,
            all_taps: false,
            plan: PlanLevels::new(space, regions),
        })
    }

    /// Counts taps behind the receiver's plane too, as the paper's filter does.
    pub fn with_all_taps(self) -> Self {
        Self { all_taps: true, ..self }
    }

    /// Returns the visibility of a world point, 1 = lit. `normal` is the unit normal of the surface at the
    /// point, if the point is on a surface.
    ///
    /// A point beside the cube or sunward of it is lit. A point behind it has the visibility of the point
    /// where its sun ray enters the cube. A point that is not finite, or is 10^9 voxels away or farther, is
    /// lit. Cost: one path per tap.
    pub fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        let Some(receiver) = self.receiver(p_world, normal) else { return 1.0 };
        let [lit, weights] = self.lit_weights(&receiver);
        lit as f32 / weights as f32
    }

    /// Returns the receiver of a point: the point moved by the bias and, if needed, to where its sun ray
    /// enters the cube. Returns `None` if the point is lit because that ray misses the cube or because it is
    /// not finite. A normal with a component that is not finite counts as unknown.
    pub fn receiver(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> Option<TreeReceiver> {
        let normal = finite(normal);
        let p_tree = self.space.to_tree(p_world);
        if !p_tree.iter().all(|c| c.abs() < 1e9) {
            return None;
        }
        let level = self.level(p_tree, normal);
        let lifted = self.lifted(p_tree, normal, level);
        // Not finite if the normal is far too long.
        let inside = lifted.iter().all(|c| c.is_finite()).then(|| self.entered(lifted)).flatten()?;
        let n = normal.filter(|_| !self.all_taps).unwrap_or_default();
        let height = dot(n, std::array::from_fn(|a| inside[a] - p_tree[a])) / f64::from(1_u32 << level);
        Some(TreeReceiver::new(inside, self.space.side_voxels(), level, n, height))
    }

    /// Returns the sum of the weights of the lit taps, and of all taps that count. A shader computes the same
    /// integers.
    pub fn lit_weights(&self, r: &TreeReceiver) -> [u32; 2] {
        let (cell, plane) = (r.cell(), r.plane());
        let (mut lit, mut weights) = (0, 0);
        for x in -self.reach..=self.reach {
            for y in -self.reach..=self.reach {
                for z in -self.reach..=self.reach {
                    let offset = [x, y, z];
                    if !r.counts(plane, offset) {
                        continue;
                    }
                    let factors = offset.map(|o| self.weights.along_axis(o.unsigned_abs()));
                    let weight = factors[0] * factors[1] * factors[2];
                    weights += weight;
                    let tap = std::array::from_fn(|a| cell[a] + offset[a]);
                    lit += weight * u32::from(self.tree.voxel(self.voxel_of(tap, r.level)));
                }
            }
        }
        [lit, weights]
    }

    /// Returns the level of the cube in which the look-up of the centre tap ends; the cube has sides of
    /// 2^level voxels. A shader computes the same level.
    pub fn end_level(&self, r: &TreeReceiver) -> u32 {
        self.tree.find(self.voxel_of(r.cell(), r.level)).1
    }

    /// Returns the voxel at the centre of the kernel for this point, or `None` if the point is lit because
    /// its sun ray misses the cube or because it is not finite.
    pub fn voxel_at(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> Option<[u32; 3]> {
        let receiver = self.receiver(p_world, normal)?;
        Some(self.voxel_of(receiver.cell(), receiver.level))
    }

    /// Returns the edge of the voxels that answer this point, in world units.
    pub fn voxel_size_at(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f64 {
        let level = self.level(self.space.to_tree(p_world), finite(normal));
        self.space.voxel_size * f64::from(1_u32 << level)
    }

    /// The bias that points are moved by, in voxels.
    pub fn bias(&self) -> Bias {
        self.bias
    }

    /// The cube of the tree.
    pub fn space(&self) -> &TreeSpace {
        &self.space
    }

    /// Returns the voxel in the middle of a cell with sides of 2^level voxels; for a cell outside the cube,
    /// that of the nearest cell inside.
    fn voxel_of(&self, cell: [i32; 3], level: u32) -> [u32; 3] {
        let last = (self.space.side_voxels() >> level) as i32 - 1;
        let half = (1 << level) >> 1;
        cell.map(|c| (c.clamp(0, last) as u32) << level | half)
    }

    /// Moves a point by the bias, in cells of this level.
    fn lifted(&self, p_tree: [f64; 3], normal: Option<[f64; 3]>, level: u32) -> [f64; 3] {
        let (slope, offset) = match normal {
            Some(n) => {
                let n_dot_l = dot(n, self.towards_sun);
                let tangent = (1.0 - n_dot_l * n_dot_l).max(0.0).sqrt();
                let slope = tangent / n_dot_l.max(tangent / MAX_SLOPE);
                let slope = if slope.is_finite() { slope } else { 0.0 };
                (slope, n.map(|c| c * self.bias.normal_offset_texels))
            }
            None => (0.0, [0.0; 3]),
        };
        let along = self.bias.along_light(slope);
        let cell = f64::from(1_u32 << level);
        std::array::from_fn(|a| p_tree[a] + cell * (self.towards_sun[a] * along + offset[a]))
    }

    /// Returns the first point of a sun ray that is inside the cube, in voxels, or `None` if the ray misses
    /// the cube.
    fn entered(&self, p_tree: [f64; 3]) -> Option<[f64; 3]> {
        let side = f64::from(self.space.side_voxels());
        let last = side - 1e-6;
        if p_tree.iter().all(|c| (0.0..side).contains(c)) {
            return Some(p_tree);
        }
        let (mut from, mut to) = (0.0_f64, f64::INFINITY);
        for (c, d) in p_tree.iter().zip(self.towards_sun) {
            if d == 0.0 {
                if !(0.0..side).contains(c) {
                    return None;
                }
                continue;
            }
            let [near, far] = if d > 0.0 { [-c / d, (side - c) / d] } else { [(side - c) / d, -c / d] };
            (from, to) = (from.max(near), to.min(far));
        }
        (from < to)
            .then(|| std::array::from_fn(|a| (p_tree[a] + self.towards_sun[a] * from).clamp(0.0, last)))
    }

    /// Returns the level of the coarsest cells within reach of the kernel, around the point, its lifted
    /// position and all points between them.
    fn level(&self, p_tree: [f64; 3], normal: Option<[f64; 3]>) -> u32 {
        let mut level = self.plan.coarsest_over([p_tree[0]; 2], [p_tree[2]; 2]);
        loop {
            let lifted = self.lifted(p_tree, normal, level);
            let margin = f64::from(self.reach + 1) * f64::from(1_u32 << level);
            let range = |a: usize| [p_tree[a].min(lifted[a]) - margin, p_tree[a].max(lifted[a]) + margin];
            let coarsest = self.plan.coarsest_over(range(0), range(2));
            if coarsest <= level {
                return level;
            }
            level = coarsest;
        }
    }
}
