//! The look-up on the CPU, step by step as in the shaders, on textures filled by the GPU. Counterpart of
//! core/*.wgsl.

mod maps;
mod moments;
mod pcf;
mod pcss;

use adumbra_shaders::layout::MapParams;

use super::params::{MapFilter, MomentKind};
use super::shadow_map::ShadowMap;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::readback::read_depth;
pub(crate) use maps::Receiver;
use moments::MomentImage;
pub(crate) use pcf::{turn, turned};

/// A visible point, like the shaders' `AdumbraSurface`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// World position minus the frame's anchor.
    pub p_relative: [f32; 3],
    /// Unit normal, or zero.
    pub normal: [f32; 3],
    /// Unit vector towards the sun.
    pub towards_sun: [f32; 3],
    /// Distance along the camera's forward direction.
    pub view_depth: f32,
    /// Pixel coordinates, or the point's index in x.
    pub pixel: [u32; 2],
}

/// A shadow map in memory.
pub struct MapTwin {
    params: MapParams,
    filter: MapFilter,
    /// By layer, row by row.
    depth: Vec<Vec<f32>>,
    moments: Option<MomentImage>,
}

impl MapTwin {
    /// Reads back a map's contents after a frame.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn read(gpu: &Gpu, map: &ShadowMap) -> Result<Self> {
        let layers = map.settings().layers();
        let depth = (0..layers).map(|l| read_depth(gpu, map.depth_texture(), l)).collect::<Result<_>>()?;
        let moments = match (&map.settings().filter, map.moments_texture()) {
            (MapFilter::Moments(m), Some(texture)) => {
                Some(MomentImage::read(gpu, texture, layers, m.kind, map.is_filtering())?)
            }
            _ => None,
        };
        Ok(Self { params: *map.params(), filter: map.settings().filter, depth, moments })
    }

    /// Visibility of the sun at a point, 1 = lit.
    pub fn visibility(&self, s: &Surface) -> f32 {
        let params = &self.params;
        if s.view_depth >= params.fade_end_view_depth {
            return 1.0;
        }
        let count = params.layer_count as usize;
        let ends = params.layers.0[..count].iter().map(|l| l.end_view_depth);
        let layer = ends.take(count - 1).take_while(|&end| s.view_depth >= end).count();
        let own = &params.layers.0[layer];
        let mut lit = self.filtered(s, layer);
        let next = maps::band(own.blend_view_depth, own.end_view_depth, s.view_depth);
        if next > 0.0 && layer + 1 < count {
            lit = mix(lit, self.filtered(s, layer + 1), next);
        }
        mix(lit, 1.0, maps::band(params.fade_view_depth, params.fade_end_view_depth, s.view_depth))
    }

    /// Unblurred moments of the depth at a texel. `None` for other filters.
    pub fn moments_of_depth(&self, layer: usize, x: u32, y: u32) -> Option<[f32; 4]> {
        let MapFilter::Moments(m) = self.filter else { return None };
        let depth = self.depth[layer][(y * self.params.side_texels + x) as usize];
        Some(moments::from_depth(m.kind, depth, self.params.moments.exponents))
    }

    /// Blurred moments at a texel of a mip level, as the GPU stored them. `None` for other filters.
    pub fn moments_stored(&self, layer: usize, level: usize, x: u32, y: u32) -> Option<[f32; 4]> {
        self.moments.as_ref().map(|m| m.texel(layer, level, i64::from(x), i64::from(y)))
    }

    fn filtered(&self, s: &Surface, layer: usize) -> f32 {
        let own = &self.params.layers.0[layer];
        let size = self.params.side_texels;
        let r = Receiver::new(own, size, &self.params.bias, self.params.min_bias_depth, s);
        if r.p_texels.iter().any(|c| !(0.0..=size as f32).contains(c)) {
            return 1.0;
        }
        let image = pcf::DepthImage { texels: &self.depth[layer], size: i64::from(size) };
        let radius = self.params.max_radius_texels;
        match &self.filter {
            MapFilter::Nearest => image.nearest(&r),
            MapFilter::Pcf { width: 2 } => image.hardware(&r),
            MapFilter::Pcf { width } => image.mean(&r, *width),
            MapFilter::Poisson { .. } => image.disc(&r, radius, self.params.tap_count, pcf::turn(s.pixel)),
            MapFilter::Pcss { .. } => {
                let cone_texels = self.params.sun_tangent * own.depth_world / own.texel_world;
                pcss::visibility(&image, &r, cone_texels, radius, pcf::turn(s.pixel))
            }
            MapFilter::Moments(m) => {
                let Some(image) = &self.moments else { return 1.0 };
                let deviation = self.params.moments.min_deviation_texels * own.texel_world / own.depth_world;
                let level = moments::level(&self.params, own, s.view_depth);
                let stored = image.sample(layer, r.p_texels, level);
                moments::visibility(m.kind, stored, r.depth.clamp(0.0, 1.0), deviation, &self.params.moments)
            }
        }
    }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// Number of channels in a kind's texture.
fn channels(kind: MomentKind) -> usize {
    if kind == MomentKind::Variance { 2 } else { 4 }
}
