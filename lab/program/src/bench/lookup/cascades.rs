//! Counts the reads of percentage-closer filtering in cascades: the texels that its gathers fetch, four per
//! gather, at the positions given by the technique's parameters.
//!
//! The layout of depth maps in memory depends on the GPU. Here a sector of 32 bytes has 4 × 2 texels of 32
//! bits.

use std::collections::HashSet;

use adumbra_render::maps::ShadowMap;

use super::Counts;
use super::pixels::{Group, Pixel};

/// Texels of a sector along x and y, as shifts.
const SECTOR_SHIFTS: [u32; 2] = [2, 1];

/// Counts the reads of a map whose frame was drawn from `eye`.
pub(super) fn count(map: &ShadowMap, eye: [f64; 3], groups: &[Group]) -> Counts {
    let mut counts = Counts::default();
    for group in groups {
        let mut sectors = HashSet::new();
        for pixel in group {
            for (layer, [x, y]) in texels(map, eye, pixel) {
                counts.reads += 1;
                sectors.insert((layer, x >> SECTOR_SHIFTS[0], y >> SECTOR_SHIFTS[1]));
            }
        }
        counts.pixels += group.len();
        counts.sectors += sectors.len();
        // The address of a gather does not depend on another read.
        counts.chains += 1;
    }
    counts
}

/// Returns the layers and texels that a pixel's gathers fetch. Twin of
/// `map_visibility` with `adumbra_pcf_box`.
fn texels(map: &ShadowMap, eye: [f64; 3], pixel: &Pixel) -> Vec<(usize, [i64; 2])> {
    let params = map.params();
    let depth = pixel.view_depth as f32;
    if depth >= params.fade_end_view_depth {
        return Vec::new();
    }
    let layers = &params.layers.0[..params.layer_count as usize];
    let last = layers.len() - 1;
    let layer = layers[..last].iter().position(|layer| depth < layer.end_view_depth).unwrap_or(last);
    let blends = depth > layers[layer].blend_view_depth && layer < last;
    let used = layer..=layer + usize::from(blends);
    let side = f64::from(params.side_texels);
    let fetched = used.flat_map(|at| {
        let axes = [layers[at].u_from_relative, layers[at].v_from_relative];
        let offset_world = f64::from(params.bias.normal_offset_texels * layers[at].texel_world);
        let p = p_texels(axes, side, offset_world, eye, pixel);
        let inside = p.iter().all(|c| (0.0..=side).contains(c));
        let pairs = if inside { params.filter_width.div_ceil(2) } else { 0 };
        let low = p.map(|c| (c - 0.5 * (f64::from(params.filter_width) - 1.0)).floor() as i64);
        let along = move |axis: usize| (0..2 * i64::from(pairs)).map(move |t| low[axis] + t);
        along(0).flat_map(move |x| along(1).map(move |y| (at, [x, y].map(|c| c.clamp(0, side as i64 - 1)))))
    });
    fetched.collect()
}

/// Returns a pixel's position in a layer, in texels.
fn p_texels(
    axes: [[f32; 4]; 2],
    side: f64,
    normal_offset_world: f64,
    eye: [f64; 3],
    pixel: &Pixel,
) -> [f64; 2] {
    // Shaders take positions relative to the eye in single precision.
    let p: [f64; 3] = std::array::from_fn(|a| {
        pixel.p_world[a] - f64::from(eye[a] as f32) + normal_offset_world * pixel.normal[a]
    });
    axes.map(|axis| {
        let [x, y, z, w] = axis.map(f64::from);
        (x * p[0] + y * p[1] + z * p[2] + w) * side
    })
}
