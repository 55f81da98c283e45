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
/// Radius about a texel's centre within which a ray counts as one from the centre, texels: the most that
/// snapping and rounding may move it.
const CENTER_TEXELS: f64 = 1.0 / 64.0;
/// How far before a surface its column may switch to shadow, voxels.
const ROUNDING_VOXELS: f64 = 0.5;
/// For points in space, blockers count as near up to this many voxels, or up to the bias at their slope if
/// that is more.
const NEAR_VOXELS: f64 = 2.0;

/// The ray-traced side of one sample.
pub(super) struct TracedSample<'a> {
    pub(super) grid: LightGrid,
    pub(super) tracer: &'a Tracer<'a>,
    pub(super) solids: &'a Solids,
    /// World position, before the bias.
    pub(super) p_world: [f64; 3],
    /// The surface normal, if the point is on a surface.
    pub(super) normal: Option<[f64; 3]>,
    /// The point after the bias.
    pub(super) receiver: Receiver,
    /// For points on ground below the scene: how far below an open surface its shadow may begin, voxels along
    /// the light.
    pub(super) thickness_voxels: Option<f64>,
}

impl TracedSample<'_> {
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
        let center = self.on_plane(self.to_center());
        let center_lit = self.lit(center);
        if self.is_thin(baked_bias) || center_lit && self.is_at_a_blocker(center) {
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
            if center_lit != truth {
                return Class::Narrow;
            }
            let grazes = |n: [f64; 3]| dot(n, self.grid.sun.towards()) <= MIN_N_DOT_L;
            return if self.normal.is_some_and(grazes) { Class::Grazing } else { Class::Interior };
        }
        // Light or shadow ends on both sides of the point, or another region begins and ends on one side.
        let between = |i: usize| !inner[i] || !outer[i];
        let narrow = (0..4).any(|i| between(i) && between(8 - i)) || (0..9).any(|i| !inner[i] && outer[i]);
        if narrow { Class::Narrow } else { Class::Edge }
    }

    /// Whether a ray about the centre of the point's texel, on its plane, gives this answer. Look-ups sample
    /// the centre.
    pub(super) fn is_answer_of_its_texel(&self, answer: bool) -> bool {
        let center = self.to_center();
        (0..9).any(|i| {
            let offset = [i % 3, i / 3].map(|c| (f64::from(c) - 1.0) * CENTER_TEXELS);
            self.lit(self.on_plane([center[0] + offset[0], center[1] + offset[1]])) == answer
        })
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

    /// The offset from the point to its texel's centre.
    fn to_center(&self) -> [f64; 2] {
        [0, 1].map(|a| self.receiver.p_grid[a].floor() + 0.5 - self.receiver.p_grid[a])
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
        // Add one voxel for the resolution of the grid.
        let Some(thickness_voxels) = self.thickness_voxels else {
            return voxels_to(&hit) < self.lifted_voxels() + 1.0;
        };
        // Below a solid, the shadow begins where ground could touch the solid, so a solid is too near only if
        // it is thin itself. The shadow of an open surface begins below it, as for points in space.
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
        voxels_to(&hit) < self.lifted_voxels() + begins_voxels
    }

    /// Whether the look-up of a point on a surface ends within rounding of a blocker other than the surface
    /// itself. The look-up ends in the light, at the texel's centre. Either answer is then possible.
    fn is_at_a_blocker(&self, [x, y, z]: [f64; 3]) -> bool {
        self.normal.is_some()
            && self.lifted_voxels() > ROUNDING_VOXELS
            && !self.lit([x, y, z + ROUNDING_VOXELS])
    }

    /// The distance along the light by which the look-up's own bias moves the point.
    fn lifted_voxels(&self) -> f64 {
        self.grid.to_grid(self.p_world)[2] - self.receiver.p_grid[2]
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
