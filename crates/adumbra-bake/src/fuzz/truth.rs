//! The guarantees of a look-up, from every triangle over a texel's centre, read straight from the scene, and
//! from a ray.

use crate::columns::rules::{ColumnRules, ReceiverKind, ReceiverPlane};
use crate::fuzz::totals::Skip;
use crate::options::BakeOptions;
use crate::plan::Plan;
use crate::root_blocks::RootBlocks;
use crate::triangles::depth::SUBTEXEL;
use crate::triangles::project::Projected;
use adumbra::grid::LightGrid;
use adumbra::grid::vec3::dot;
use adumbra_scene::{AlphaMode, Scene, topology};
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};

/// Depths closer than this count as equal, voxels: a few times the 1/256 to which the bake rounds.
const DEPTH_SLACK: f64 = 1.0 / 64.0;
/// Centres this close to an outline may be covered or not, texels: 1/256 for closing seams and half of that
/// for snapping, along both axes.
const OUTLINE_SLACK: f64 = 3.0 / 256.0;

/// A triangle of an instance in grid space.
pub(crate) struct Triangle {
    pub(crate) instance: u32,
    /// Index into the mesh's triangles.
    pub(crate) triangle: u32,
    pub(crate) shape: Projected,
    pub(crate) casts: bool,
    pub(crate) solid: bool,
    masked: bool,
    /// Bounding box in the light's plane.
    low: [f64; 2],
    high: [f64; 2],
}

/// A scene prepared for deriving what look-ups must find.
pub(crate) struct Truth<'s> {
    pub(crate) grid: LightGrid,
    pub(crate) triangles: Vec<Triangle>,
    rules: ColumnRules,
    tracer: Tracer<'s>,
    /// How far rounding in world space may move a point in the grid, voxels.
    rounding: f64,
}

impl<'s> Truth<'s> {
    pub(crate) fn new(scene: &'s Scene, options: &BakeOptions, plan: &Plan<'_>) -> Self {
        let RootBlocks { grid, rules, .. } = plan.root_blocks;
        let mut triangles = Vec::new();
        let mut largest = 0.0_f64;
        for (number, instance) in scene.instances.iter().enumerate() {
            let mesh = &scene.meshes[instance.mesh as usize];
            let topology = topology::analyse(mesh, &scene.materials);
            for (t, vertices) in mesh.triangles.iter().enumerate() {
                let corners_world = vertices.map(|v| instance.to_world(mesh.positions[v as usize]));
                largest = corners_world.iter().flatten().fold(largest, |m, c| m.max(c.abs()));
                let corners = corners_world.map(|p| grid.to_grid(p));
                let material = &scene.materials[mesh.triangle_materials[t] as usize];
                let range = |a: usize| {
                    let c = corners.map(|p| p[a]);
                    [c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2])]
                };
                let ([x_low, x_high], [y_low, y_high]) = (range(0), range(1));
                triangles.push(Triangle {
                    instance: number as u32,
                    triangle: t as u32,
                    shape: Projected::new(corners, instance.determinant() < 0.0),
                    casts: instance.casts && material.casts,
                    solid: options.closed_regions && topology.is_solid(t),
                    masked: !options.ignore_alpha && material.alpha != AlphaMode::Opaque,
                    low: [x_low, y_low],
                    high: [x_high, y_high],
                });
            }
        }
        let tracer = Tracer::build(scene, TraceOptions { ignore_alpha: options.ignore_alpha });
        let longest_axis = grid.axes.into_iter().map(|axis| dot(axis, axis)).fold(0.0, f64::max).sqrt();
        let rounding = 16.0 * f64::EPSILON * largest * longest_axis / grid.voxel_size;
        Self { grid, triangles, rules, tracer, rounding }
    }

    /// Returns whether the sun is visible from `depth` on the axis of texel (i, j), which is where a look-up
    /// from triangle `own` samples the column, or why nothing is guaranteed there.
    ///
    /// # Errors
    /// Returns an error if rays and triangles contradict each other.
    pub(crate) fn is_lit(
        &self,
        own: usize,
        [i, j]: [i64; 2],
        depth: f64,
    ) -> Result<Result<bool, Skip>, String> {
        let triangle = &self.triangles[own];
        let Some(plane) = triangle.shape.true_plane() else { return Ok(Err(Skip::NoReceiver)) };
        if !triangle.shape.covers(i, j) {
            return Ok(Err(Skip::NotCovered));
        }
        let center = [i, j].map(|c| c as f64 + 0.5);
        let receiver = self.rules.receiver_on(plane);
        let blocked = match self.first_before(own, &receiver, center, depth) {
            Ok(blocked) => blocked,
            Err(skip) => return Ok(Err(skip)),
        };
        let ray = Ray {
            origin: self.grid.to_world([center[0], center[1], depth]),
            direction: self.grid.sun.towards(),
            t_min: 0.0,
            t_max: f64::INFINITY,
        };
        if self.tracer.occluded(&ray) != blocked {
            return Err(format!("triangles say blocked = {blocked}, the ray does not"));
        }
        Ok(Ok(!blocked))
    }

    /// Returns the layer in which a receiver on triangle `own` in texel (i, j) samples its column.
    pub(crate) fn sampled_layer(&self, own: usize, [i, j]: [i64; 2]) -> i64 {
        let Some(plane) = self.triangles[own].shape.true_plane() else { return i64::MIN };
        let receiver = self.rules.receiver_on(plane);
        let sampled = receiver.sampled(ReceiverKind::Footprint, i as f64 + 0.5, j as f64 + 0.5);
        i64::from(sampled.lifted).div_euclid(SUBTEXEL)
    }

    /// Whether anything over the centre is before `depth`.
    fn first_before(
        &self,
        own: usize,
        receiver: &ReceiverPlane,
        center: [f64; 2],
        depth: f64,
    ) -> Result<bool, Skip> {
        let outline = OUTLINE_SLACK + self.rounding;
        let surface = receiver.plane.at(center[0], center[1]);
        // The bake allows for the rounding of look-ups. With less than a voxel of bias, voxels are too coarse
        // to distinguish a surface from something one voxel before it.
        let least_lift = self.rules.least_lift_voxels();
        let before = (receiver.rounding_voxels + 2.0 / 256.0).max(1.0 - least_lift).max(DEPTH_SLACK);
        let (mut blocked, mut entered, mut within_bias) = (false, 0, false);
        for (n, t) in self.triangles.iter().enumerate() {
            if (!t.casts && n != own) || t.is_beside(center, outline) {
                continue;
            }
            if t.outline_is_near(center, outline) {
                return Err(Skip::Outline);
            }
            let Some(t_plane) = t.shape.plane else { continue };
            if !t.casts || !t.shape.covers(center[0] as i64, center[1] as i64) {
                continue;
            }
            if t.masked {
                return Err(Skip::Masked);
            }
            let z = t_plane.at(center[0], center[1]);
            let slack = DEPTH_SLACK + self.rounding * (1.0 + t_plane.gradient_sum());
            if t.solid && z < depth {
                entered += if t.shape.faces_sun { 1 } else { -1 };
            }
            if z < depth - before - slack {
                blocked = true;
            } else if (n != own && z < surface - slack) || z < depth + 1.0 - slack {
                within_bias = true;
            }
        }
        if entered > 0 {
            return Err(Skip::InsideSolid);
        }
        if within_bias { Err(Skip::WithinBias) } else { Ok(blocked) }
    }
}

impl Triangle {
    fn is_beside(&self, p: [f64; 2], margin: f64) -> bool {
        (0..2).any(|a| p[a] < self.low[a] - margin || p[a] > self.high[a] + margin)
    }

    /// Whether an edge passes within this distance of `p` in the light's plane.
    fn outline_is_near(&self, p: [f64; 2], distance: f64) -> bool {
        let c = &self.shape.corners;
        (0..3).any(|n| {
            let (a, b) = (c[n], c[(n + 1) % 3]);
            let (edge, to) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
            let length = edge[0] * edge[0] + edge[1] * edge[1];
            let along = if length > 0.0 {
                ((to[0] * edge[0] + to[1] * edge[1]) / length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let [x, y] = [to[0] - along * edge[0], to[1] - along * edge[1]];
            x * x + y * y < distance * distance
        })
    }
}
