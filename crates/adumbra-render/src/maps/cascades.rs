//! Placement of the layers of a shadow map: over the scene, or in cascades fitted to a camera. Pure
//! arithmetic in `f64`.
//!
//! Sources: Dimitrov, *Cascaded Shadow Maps*, 2007; Zhang, Sun, Xu, Lun, *Parallel-Split Shadow Maps*, 2006;
//! Valient, *Stable Rendering of Cascaded Shadow Maps*, 2008 (spheres and snapping).
//!
//! Texels of a layer lie on a lattice that is fixed to the scene. Its origin is at the position of the
//! scene's first instance, and its axes depend only on the light's rotation. A texel's edge does not change
//! while the camera moves or turns, and a layer's corner is a whole number of texels from the origin. So a
//! point keeps its position within its texel whatever the camera does, and wherever in the world the scene
//! is. If a layer's slice of the view is larger than the scene, the layer covers the scene instead, which is
//! finer and never moves.

use adumbra::LightExtent;
use adumbra_scene::View;
use adumbra_shaders::layout::MapLayer;

use super::params::{CascadeSettings, Split};
use crate::frame::depths_in_view;
use crate::scene::Volume;

/// A view depth beyond every point: the end of a single layer over the whole scene.
pub const ENDLESS: f64 = 1e30;

/// Nearest depth of the logarithmic split, as a share of the far depth, if the view starts at the eye.
const LOG_START: f64 = 1e-3;

/// A layer's placement in light space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerFit {
    /// The light's unit axes in world space: x along u, y along v, z away from the sun.
    pub axes: [[f64; 3]; 3],
    /// Edge of a texel, world units.
    pub texel_world: f64,
    /// Light-space coordinates of the lattice's origin, world units.
    pub lattice: [f64; 3],
    /// Lattice coordinates of the first texel.
    pub corner: [i64; 2],
    /// Texels per side.
    pub size: u32,
    /// Coordinates along axis z of depth 0 and depth 1, world units.
    pub depth_world: [f64; 2],
    /// View depths at which the layer ends, and at which its blend into the next begins.
    pub end: [f64; 2],
}

impl LayerFit {
    /// Returns the layer as shaders take it, for positions relative to `anchor_world`.
    pub fn layer(&self, anchor_world: [f64; 3]) -> MapLayer {
        let row = |axis: usize, unit: f64, first: f64| {
            let a = self.axes[axis];
            let shift = (dot(a, anchor_world) - first) / unit;
            [(a[0] / unit) as f32, (a[1] / unit) as f32, (a[2] / unit) as f32, shift as f32]
        };
        let extent = self.texel_world * f64::from(self.size);
        let range = self.depth_world[1] - self.depth_world[0];
        MapLayer {
            u_from_relative: row(0, extent, self.first(0)),
            v_from_relative: row(1, extent, self.first(1)),
            depth_from_relative: row(2, range, self.depth_world[0]),
            texel_world: self.texel_world as f32,
            depth_world: range as f32,
            end_view_depth: self.end[0] as f32,
            blend_view_depth: self.end[1] as f32,
        }
    }

    /// Projects a world point: x and y in texels from the layer's corner, then depth.
    pub fn project(&self, p_world: [f64; 3]) -> [f64; 3] {
        let range = self.depth_world[1] - self.depth_world[0];
        [
            (dot(self.axes[0], p_world) - self.first(0)) / self.texel_world,
            (dot(self.axes[1], p_world) - self.first(1)) / self.texel_world,
            (dot(self.axes[2], p_world) - self.depth_world[0]) / range,
        ]
    }

    /// The volume of possible casters: everything within the layer's sides, including all that is sunward of
    /// it.
    pub(crate) fn caster_volume(&self) -> Volume {
        let planes = (0..2).flat_map(|a| {
            let [x, y, z] = self.axes[a];
            let first = self.first(a);
            let last = first + self.texel_world * f64::from(self.size);
            [[x, y, z, -first], [-x, -y, -z, last]]
        });
        Volume { planes: planes.collect() }
    }

    /// Coordinate along an axis at which the first texel begins, world units.
    pub fn first(&self, axis: usize) -> f64 {
        self.lattice[axis] + self.corner[axis] as f64 * self.texel_world
    }

    /// Whether both layers hold the same depths, that is, differ at most in their view depths.
    pub(crate) fn same_place(&self, other: &Self) -> bool {
        Self { end: other.end, ..*self } == *other
    }
}

/// Fits one layer over everything in `extent`, with `margin` texels on every side.
///
/// `depth_world` is the result of [`depth_range`], and `lattice_world` the lattice's origin.
pub(crate) fn scene_layer(
    extent: &LightExtent,
    depth_world: [f64; 2],
    lattice_world: [f64; 3],
    size: u32,
    margin: f64,
) -> LayerFit {
    let lattice = extent.axes.map(|axis| dot(axis, lattice_world));
    // Rounding the corner may lose up to one whole texel.
    let texels = (f64::from(size) - 2.0 * margin - 1.0).max(1.0);
    let side = extent.longest_side().max(1e-6 * (depth_world[1] - depth_world[0]));
    let texel_world = side / texels;
    let corner = std::array::from_fn(|a| {
        let middle = (0.5 * (extent.min[a] + extent.max[a]) - lattice[a]) / texel_world;
        libm::floor(middle - 0.5 * f64::from(size) + 0.5) as i64
    });
    LayerFit { axes: extent.axes, texel_world, lattice, corner, size, depth_world, end: [ENDLESS; 2] }
}

/// Fits layers to slices of the view, nearest first. Slices that would both cover the scene share one layer,
/// so there may be fewer layers than cascades.
///
/// `scene` is the layer over the whole scene, `reach` the view depths from [`reach`], and `margin` as for
/// [`scene_layer`]. With `presses`, casters sunward of a layer's range are clamped onto its near plane
/// (pancaking), so the range need only hold the receivers of its slice. Otherwise it begins where the scene's
/// does.
pub(crate) fn cascade_layers(
    view: &View,
    scene: &LayerFit,
    settings: &CascadeSettings,
    reach: [f64; 2],
    margin: f64,
    presses: bool,
) -> Vec<LayerFit> {
    let size = scene.size;
    let ends = split_depths(settings.split, settings.cascades, reach);
    let mut begin = 0.0;
    let mut layers: Vec<LayerFit> = Vec::with_capacity(ends.len());
    for (i, &end) in ends.iter().enumerate() {
        let slice = end - if i == 0 { reach[0] } else { ends[i - 1] };
        let blend_begin = end - settings.blend * slice;
        let (centre, radius) = slice_sphere(view, [begin, end]);
        // One texel of rounding, and the margin, on either side.
        let texel_world = 2.0 * radius / (f64::from(size) - 2.0 * margin - 2.0).max(1.0);
        let mut layer = *scene;
        if texel_world < scene.texel_world {
            layer.texel_world = texel_world;
            layer.corner = std::array::from_fn(|a| {
                let middle = (dot(scene.axes[a], centre) - scene.lattice[a]) / texel_world;
                (libm::floor(middle + 0.5) as i64).saturating_sub(i64::from(size / 2))
            });
            let along = dot(scene.axes[2], centre) - scene.lattice[2];
            let [near, far] = receiver_range(along, radius).map(|depth| scene.lattice[2] + depth);
            layer.depth_world[0] =
                if presses { near.max(scene.depth_world[0]) } else { scene.depth_world[0] };
            layer.depth_world[1] = far.min(scene.depth_world[1]).max(layer.depth_world[0] + radius);
        }
        layer.end = [end, blend_begin];
        begin = blend_begin;
        match layers.last_mut() {
            // The layer is drawn once and used for both slices.
            Some(before) if before.same_place(&layer) => *before = layer,
            _ => layers.push(layer),
        }
    }
    layers
}

/// Range along the light of the receivers in a sphere, rounded outwards to steps of an eighth of its diameter
/// so that it does not follow every camera movement. At least one step on either side is spare for receivers
/// that the bias moves.
fn receiver_range(centre: f64, radius: f64) -> [f64; 2] {
    let step = 0.25 * radius;
    [libm::floor((centre - radius) / step - 1.0) * step, libm::ceil((centre + radius) / step + 1.0) * step]
}

/// The view depths that cascades divide: where the slices begin, and where shadows end.
///
/// With a given far depth, the range is from the eye to it. Otherwise it ends at the smallest power of two
/// (in world units) that includes the whole part of the scene's box in view. So it stays the same over most
/// camera movements and does not depend on the rest of the scene. If the nearest part is beyond half of that
/// depth, the range begins at the largest power of √2 in front of it instead of at the eye.
pub fn reach(view: &View, scene: &adumbra::Bounds, far_world: Option<f64>) -> [f64; 2] {
    if let Some(far) = far_world {
        return [0.0, far];
    }
    let [nearest, farthest] = depths_in_view(view, scene).unwrap_or_default();
    // A minimum, so that a scene of one point, or an empty one, still has a reach.
    let far = libm::exp2(libm::ceil(libm::log2(farthest.max(1e-6))));
    let near =
        if nearest > 0.5 * far { libm::exp2(0.5 * libm::floor(2.0 * libm::log2(nearest))) } else { 0.0 };
    [near, far]
}

/// Returns the view depth at which each of `count` slices of `reach` ends.
///
/// The logarithmic split needs a start above 0. It uses a thousandth of the far depth if the view starts
/// nearer than that.
pub(crate) fn split_depths(split: Split, count: u32, reach: [f64; 2]) -> Vec<f64> {
    let [near, far] = reach;
    let log_near = near.max(LOG_START * far);
    let slice = |i: u32| {
        let share = f64::from(i) / f64::from(count);
        let uniform = near + (far - near) * share;
        let logarithmic = log_near * libm::pow(far / log_near, share);
        match split {
            Split::Uniform => uniform,
            Split::Logarithmic => logarithmic,
            Split::Practical { lambda } => lambda * logarithmic + (1.0 - lambda) * uniform,
        }
    };
    // The last end is exactly the far depth, regardless of rounding in the power.
    (1..=count).map(|i| if i == count { far } else { slice(i) }).collect()
}

/// World centre and radius of the smallest sphere that holds a slice of the view and has its centre on the
/// view axis. The radius does not depend on the camera's position or direction.
pub(crate) fn slice_sphere(view: &View, slice: [f64; 2]) -> ([f64; 3], f64) {
    let [a, b] = slice;
    let k2 = view.half[0] * view.half[0] + view.half[1] * view.half[1];
    let (along, radius) = if view.orthographic {
        let half = 0.5 * (b - a);
        (0.5 * (a + b), (k2 + half * half).sqrt())
    } else {
        // Equally far from the corners of both ends, or the middle of the far end if that point is beyond it.
        let along = (0.5 * (a + b) * (1.0 + k2)).min(b);
        (along, ((b - along) * (b - along) + k2 * b * b).sqrt())
    };
    (std::array::from_fn(|c| view.eye[c] + along * view.forward[c]), radius)
}

/// Light-space z of depth 0 and of depth 1. The range holds all of `still` plus a small margin, so that a
/// receiver moved by its bias stays inside. With `all`, it holds all of that too, and grows in whole steps so
/// that it does not follow every movement.
///
/// On devices with depth clip control, casters sunward of the range are clamped onto its near plane, and
/// `all` is not needed.
pub(crate) fn depth_range(still: &LightExtent, all: Option<&LightExtent>) -> [f64; 2] {
    let [near, far] = [still.min[2], still.max[2]];
    let length = (far - near).max(still.longest_side()).max(1e-6);
    let steps = |past: f64| 0.01 * length + 0.25 * length * libm::ceil((past / (0.25 * length)).max(0.0));
    let [before, behind] = all.map_or([0.0; 2], |a| [near - a.min[2], a.max[2] - far]);
    [near - steps(before), far + steps(behind)]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests;
