//! A receiver in a layer's space. Twin of core/maps.wgsl.

use adumbra_shaders::constants::MAX_SLOPE;
use adumbra_shaders::layout::{MapLayer, ReceiverBias};

use super::Surface;

/// Twin of `AdumbraMapReceiver`, without the layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    pub(crate) p_texels: [f32; 2],
    pub(crate) depth: f32,
    deepest: f32,
    pub(crate) gradient: [f32; 2],
}

impl Receiver {
    pub(crate) fn new(
        layer: &MapLayer,
        size: u32,
        bias: &ReceiverBias,
        min_bias_depth: f32,
        s: &Surface,
    ) -> Self {
        let unit_world = layer.texel_world * bias.width_factor;
        let p: [f32; 3] =
            std::array::from_fn(|a| s.p_relative[a] + s.normal[a] * (bias.normal_offset_texels * unit_world));
        let along = |row: [f32; 4]| dot([row[0], row[1], row[2]], p) + row[3];
        let n_dot_l = dot(s.normal, s.towards_sun);
        let aside: [f32; 3] = std::array::from_fn(|a| s.normal[a] - n_dot_l * s.towards_sun[a]);
        let tangent = dot(aside, aside).sqrt();
        let slope = if tangent == 0.0 { 0.0 } else { tangent / n_dot_l.max(tangent / MAX_SLOPE) };
        let moved = ((bias.constant_texels + bias.slope_texels * slope) * unit_world / layer.depth_world)
            .max(min_bias_depth);
        let side = size as f32;
        let depth = along(layer.depth_from_relative) - moved;
        Self {
            p_texels: [along(layer.u_from_relative) * side, along(layer.v_from_relative) * side],
            depth,
            deepest: depth.min(1.0),
            gradient: gradient(layer, side, s, n_dot_l),
        }
    }

    pub(crate) fn plane_depth(&self, p_texels: [f32; 2]) -> f32 {
        let [x, y] = [p_texels[0] - self.p_texels[0], p_texels[1] - self.p_texels[1]];
        (self.depth + self.gradient[0] * x + self.gradient[1] * y).min(self.deepest)
    }

    pub(super) fn moved(&self, offset: [f32; 2]) -> Self {
        Self {
            p_texels: [self.p_texels[0] + offset[0], self.p_texels[1] + offset[1]],
            depth: self.depth + self.gradient[0] * offset[0] + self.gradient[1] * offset[1],
            ..*self
        }
    }
}

fn gradient(layer: &MapLayer, side: f32, s: &Surface, n_dot_l: f32) -> [f32; 2] {
    let edge_world = layer.texel_world * side;
    let n = [layer.u_from_relative, layer.v_from_relative]
        .map(|row| edge_world * dot([row[0], row[1], row[2]], s.normal));
    let tangent = (n[0] * n[0] + n[1] * n[1]).sqrt();
    if tangent == 0.0 {
        return [0.0; 2];
    }
    let scale = layer.texel_world / layer.depth_world / n_dot_l.max(tangent / MAX_SLOPE);
    n.map(|c| c * scale)
}

/// Twin of `adumbra_map_band`.
pub(super) fn band(begin: f32, end: f32, view_depth: f32) -> f32 {
    if view_depth <= begin { 0.0 } else { ((view_depth - begin) / (end - begin)).clamp(0.0, 1.0) }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
