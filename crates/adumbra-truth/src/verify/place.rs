//! Traces rays at one point and its neighbourhood.

use crate::trace::{Hit, Ray, Tracer};
use crate::verify::classes::Class;
use crate::verify::points::Solids;
use crate::verify::{MIN_N_DOT_L, NEIGHBOUR_TEXELS};
use adumbra::grid::LightGrid;
use adumbra::grid::vec3::dot;
use adumbra::query::Receiver;
use adumbra::{Bias, MAX_PLANE_SLOPE, MAX_SLOPE};

/// Distance at which a ray starts off its own surface, voxels.
const OFF_SURFACE_VOXELS: f64 = 1e-3;
/// Radius about a texel's centre within which a ray counts as one from the centre, texels: the most that snapping and
/// rounding may move it.
const CENTER_TEXELS: f64 = 1.0 / 64.0;
/// For points in space, blockers count as near up to this many voxels, or up to the bias at their slope if that is
/// more.
const NEAR_VOXELS: f64 = 2.0;

/// The ray-traced side of one sample.
pub(super) struct Place<'a> {
    pub(super) grid: LightGrid,
    pub(super) tracer: &'a Tracer<'a>,
    pub(super) solids: &'a Solids,
    /// World position, before the bias.
    pub(super) p_world: [f64; 3],
    /// The surface normal, if the point is on a surface.
    pub(super) normal: Option<[f64; 3]>,
    /// The point after the bias.
    pub(super) receiver: Receiver,
    /// For points on ground below the scene: how far below an open surface its shadow may begin, voxels along the light.
    pub(super) thickness_voxels: Option<f64>,
}

impl Place<'_> {
    /// Whether the sun is visible from the lifted point.
    pub(super) fn truth(&self) -> bool {
        self.lit(self.receiver.p_grid)
    }

    /// Classifies the point; `truth` is its own ray-traced visibility.
    pub(super) fn class(&self, truth: bool, baked_bias: &Bias) -> Class {
        let [gx, gy] = self.receiver.gradient;
        if gx * gx + gy * gy >= (MAX_PLANE_SLOPE * MAX_PLANE_SLOPE) * (1.0 - 1e-9) {
            return Class::EdgeOn;
        }
        if self.is_thin(baked_bias) {
            return Class::Thin;
        }
        // A 3 × 3 neighbourhood whose middle is the point itself.
        let agrees = |i: usize, texels: f64| {
            let offset = [i % 3, i / 3].map(|o| (o as f64 - 1.0) * texels);
            self.lit(self.on_plane(offset)) == truth
        };
        let [inner, outer]: [[bool; 9]; 2] =
            NEIGHBOUR_TEXELS.map(|texels| std::array::from_fn(|i| i == 4 || agrees(i, texels)));
        if inner.iter().chain(&outer).all(|a| *a) {
            let grazes = |n: [f64; 3]| dot(n, self.grid.sun.towards()) <= MIN_N_DOT_L;
            return if self.normal.is_some_and(grazes) { Class::Grazing } else { Class::Interior };
        }
        // Light or shadow ends on both sides of the point, or another region begins and ends on one side.
        let between = |i: usize| !inner[i] || !outer[i];
        let narrow = (0..4).any(|i| between(i) && between(8 - i)) || (0..9).any(|i| !inner[i] && outer[i]);
        if narrow { Class::Narrow } else { Class::Edge }
    }

    /// Whether rays from the point's texel, on its plane, give this answer: one about the texel's centre, where
    /// look-ups sample, or more than half of those spread over the texel, the criterion by which surfaces with holes
    /// are rasterised.
    pub(super) fn is_answer_of_its_texel(&self, answer: bool) -> bool {
        let p = self.receiver.p_grid;
        let answers = |i: u32, spread: f64| {
            let [x, y] = [i % 3, i / 3].map(|c| 0.5 + (f64::from(c) - 1.0) * spread);
            self.lit(self.on_plane([p[0].floor() + x - p[0], p[1].floor() + y - p[1]])) == answer
        };
        (0..9).any(|i| answers(i, CENTER_TEXELS)) || (0..9).filter(|&i| answers(i, 1.0 / 3.0)).count() > 4
    }

    /// Mean ray-traced visibility of points in grid space.
    pub(super) fn mean_lit(&self, points_grid: &[[f64; 3]]) -> f64 {
        let lit = points_grid.iter().filter(|p| self.lit(**p)).count();
        lit as f64 / points_grid.len() as f64
    }

    /// A point on the lifted receiver plane, offset from the point by some texels.
    fn on_plane(&self, offset: [f64; 2]) -> [f64; 3] {
        let Receiver { p_grid: p, gradient: g } = self.receiver;
        [p[0] + offset[0], p[1] + offset[1], p[2] + g[0] * offset[0] + g[1] * offset[1]]
    }

    fn lit(&self, p_grid: [f64; 3]) -> bool {
        !self.tracer.occluded(&self.ray(self.grid.to_world(p_grid), 0.0))
    }

    fn ray(&self, origin: [f64; 3], t_min: f64) -> Ray {
        Ray { origin, direction: self.grid.sun.towards(), t_min, t_max: f64::INFINITY }
    }

    /// A ray from the point itself, starting slightly off its surface.
    fn ray_from_surface(&self) -> Ray {
        let t_min = if self.normal.is_some() { OFF_SURFACE_VOXELS * self.grid.voxel_size } else { 0.0 };
        self.ray(self.p_world, t_min)
    }

    /// Whether the nearest blocker on the point's sun ray is within the bias, where no look-up can see it.
    fn is_thin(&self, baked_bias: &Bias) -> bool {
        let mut ray = self.ray_from_surface();
        let Some(mut hit) = self.tracer.nearest_blocker(&ray) else { return false };
        let bias_at_hit = |hit: &Hit| {
            let n = self.grid.normal_to_grid(hit.normal);
            let slope = ((n[0] * n[0] + n[1] * n[1]).sqrt() / n[2].abs().max(1e-6)).min(MAX_SLOPE);
            baked_bias.along_light(slope)
        };
        let voxels_to = |hit: &Hit| hit.t / self.grid.voxel_along_light();
        if self.normal.is_none() {
            return voxels_to(&hit) < NEAR_VOXELS.max(bias_at_hit(&hit));
        }
        // The distance by which the look-up's own bias moves the point towards the sun, plus one voxel for the grid.
        let lifted_voxels = self.grid.to_grid(self.p_world)[2] - self.receiver.p_grid[2];
        let Some(thickness_voxels) = self.thickness_voxels else {
            return voxels_to(&hit) < lifted_voxels + 1.0;
        };
        // Below a solid, the shadow begins where ground could meet it, so only one that is thin itself is too near. That of an
        // open surface begins below it, as for points in space.
        let bounds_solid = |hit: &Hit| self.solids.contains(hit.instance, hit.triangle);
        while hit.front && bounds_solid(&hit) {
            ray.t_min = hit.t + OFF_SURFACE_VOXELS * self.grid.voxel_size;
            match self.tracer.nearest_blocker(&ray) {
                Some(next) => hit = next,
                None => break,
            }
        }
        let begins_voxels =
            if bounds_solid(&hit) { 1.0 } else { bias_at_hit(&hit).max(thickness_voxels).max(1.0) };
        voxels_to(&hit) < lifted_voxels + begins_voxels
    }

    /// Whether the winding of solids above the point is nonzero, so that it cannot be seen.
    pub(super) fn is_inside_solid(&self) -> bool {
        let mut winding = 0;
        self.tracer.for_each_hit(&self.ray_from_surface(), |hit| {
            if self.solids.contains(hit.instance, hit.triangle) {
                winding += if hit.front { -1 } else { 1 };
            }
        });
        winding != 0
    }
}
