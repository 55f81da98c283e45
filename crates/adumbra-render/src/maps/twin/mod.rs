//! The look-up on the CPU, step by step as in the shaders, on the textures that the GPU filled. Same stems as core/*.wgsl.

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

/// A visible point, as the shaders' `Surface`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// World position less the frame's anchor.
    pub p_relative: [f32; 3],
    /// Unit normal, or zero.
    pub normal: [f32; 3],
    /// Unit vector towards the sun.
    pub towards_sun: [f32; 3],
    /// Distance along the camera's forward direction.
    pub view_depth: f32,
    /// Of the pixel, or the point's number in x.
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
    /// Reads back what a map holds after a frame.
    ///
    /// # Errors
    /// What the device reports.
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
        let [fade_begin, fade_end, ..] = self.params.reach;
        if s.view_depth >= fade_end {
            return 1.0;
        }
        let count = self.params.counts[0] as usize;
        let ends = self.params.layers.0[..count].iter().map(|l| l.scale[2]);
        let layer = ends.take(count - 1).take_while(|&end| s.view_depth >= end).count();
        let scale = self.params.layers.0[layer].scale;
        let mut lit = self.filtered(s, layer);
        let next = maps::band(scale[3], scale[2], s.view_depth);
        if next > 0.0 && layer + 1 < count {
            lit = mix(lit, self.filtered(s, layer + 1), next);
        }
        mix(lit, 1.0, maps::band(fade_begin, fade_end, s.view_depth))
    }

    /// Moments of the depth at a texel, unblurred; none for other filters.
    pub fn moments_of_depth(&self, layer: usize, x: u32, y: u32) -> Option<[f32; 4]> {
        let MapFilter::Moments(m) = self.filter else { return None };
        let depth = self.depth[layer][(y * self.params.counts[1] + x) as usize];
        Some(moments::of_depth(m.kind, depth, [self.params.moments[2], self.params.moments[3]]))
    }

    /// Blurred moments at a texel of a mip level, as the GPU stored them; none for other filters.
    pub fn moments_stored(&self, layer: usize, level: usize, x: u32, y: u32) -> Option<[f32; 4]> {
        self.moments.as_ref().map(|m| m.texel(layer, level, i64::from(x), i64::from(y)))
    }

    fn filtered(&self, s: &Surface, layer: usize) -> f32 {
        let place = &self.params.layers.0[layer];
        let size = self.params.counts[1];
        let r = Receiver::new(place, size, self.params.bias, self.params.pixel[3], s);
        if r.p_texels.iter().any(|c| !(0.0..=size as f32).contains(c)) {
            return 1.0;
        }
        let image = pcf::DepthImage { texels: &self.depth[layer], size: i64::from(size) };
        let [_, _, half_tangent, radius] = self.params.reach;
        match &self.filter {
            MapFilter::Nearest => image.nearest(&r),
            MapFilter::Pcf { width: 2 } => image.hardware(&r),
            MapFilter::Pcf { width } => image.mean(&r, *width),
            MapFilter::Poisson { .. } => image.disc(&r, radius, self.params.counts[3], pcf::turn(s.pixel)),
            MapFilter::Pcss { .. } => {
                let cone_texels = half_tangent * place.scale[1] / place.scale[0];
                pcss::visibility(&image, &r, cone_texels, radius, pcf::turn(s.pixel))
            }
            MapFilter::Moments(m) => {
                let Some(image) = &self.moments else { return 1.0 };
                let deviation = self.params.moments[0] * place.scale[0] / place.scale[1];
                let level = moments::level(self.params.pixel, place, s.view_depth);
                let stored = image.sample(layer, r.p_texels, level);
                moments::visibility(m.kind, stored, r.depth.clamp(0.0, 1.0), deviation, self.params.moments)
            }
        }
    }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// Channels of a kind's texture.
fn channels(kind: MomentKind) -> usize {
    if kind == MomentKind::Variance { 2 } else { 4 }
}
