//! Materials: a small uniform, the base-colour texture with mip levels, a sampler.

use adumbra::scene::{AlphaMode, Pixels, Scene, Texture, Wrap};
use adumbra_shaders::layout::MaterialParams;
use wgpu::{AddressMode, BindingResource, FilterMode, ShaderStages, TextureFormat};

use crate::error::{RenderError, Result};
use crate::gpu::{Gpu, binding};

/// Bind groups by material.
pub(super) struct Materials {
    groups: Vec<wgpu::BindGroup>,
    pub(super) bytes: u64,
}

pub(super) fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let bindings = [binding::UNIFORM, binding::SAMPLED, binding::SAMPLER];
    gpu.layout("material", ShaderStages::FRAGMENT, &bindings)
}

impl Materials {
    pub(super) fn new(gpu: &Gpu, scene: &Scene) -> Result<Self> {
        let layout = layout(gpu);
        let mut bytes = 0;
        let mut textures = Vec::new();
        for texture in &scene.textures {
            textures.push((upload(gpu, texture, &mut bytes)?, sampler(gpu, texture)));
        }
        let plain = Texture {
            name: "none".to_owned(),
            width: 1,
            height: 1,
            pixels: Pixels::Rgba(vec![255; 4]),
            wrap: [Wrap::Repeat; 2],
            nearest: true,
        };
        let plain = (upload(gpu, &plain, &mut bytes)?, sampler(gpu, &plain));
        let groups = scene.materials.iter().map(|material| {
            let cutoff = match material.alpha {
                AlphaMode::Opaque => 0.0,
                AlphaMode::Mask { cutoff } => cutoff,
            };
            let params = MaterialParams { base_color: material.base_color, alpha: [cutoff, 0.0, 0.0, 0.0] };
            let uniform = gpu.uniform("material", &params.bytes());
            let (view, sampler) = material.texture.map_or(&plain, |t| &textures[t as usize]);
            gpu.bind(
                "material",
                &layout,
                vec![
                    uniform.as_entire_binding(),
                    BindingResource::TextureView(view),
                    BindingResource::Sampler(sampler),
                ],
            )
        });
        Ok(Self { groups: groups.collect(), bytes })
    }

    pub(super) fn group(&self, material: u32) -> &wgpu::BindGroup {
        &self.groups[material as usize]
    }
}

fn sampler(gpu: &Gpu, texture: &Texture) -> wgpu::Sampler {
    let mode = |w: Wrap| match w {
        Wrap::Repeat => AddressMode::Repeat,
        Wrap::Mirror => AddressMode::MirrorRepeat,
        Wrap::Clamp => AddressMode::ClampToEdge,
    };
    let filter = if texture.nearest { FilterMode::Nearest } else { FilterMode::Linear };
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("material"),
        address_mode_u: mode(texture.wrap[0]),
        address_mode_v: mode(texture.wrap[1]),
        mag_filter: filter,
        min_filter: filter,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    })
}

fn upload(gpu: &Gpu, texture: &Texture, bytes: &mut u64) -> Result<wgpu::TextureView> {
    let limit = gpu.max_texture_side();
    if texture.width.max(texture.height) > limit {
        return Err(RenderError::TooLarge {
            what: format!("the texture {:?} of {} x {} texels", texture.name, texture.width, texture.height),
            bytes: u64::from(texture.width) * u64::from(texture.height) * 4,
            limit: u64::from(limit) * u64::from(limit) * 4,
            mend: "make it smaller",
        });
    }
    let mut level: Vec<u8> = match &texture.pixels {
        Pixels::Rgba(rgba) => rgba.clone(),
        Pixels::Alpha(alpha) => alpha.iter().flat_map(|&a| [255, 255, 255, a]).collect(),
    };
    let levels = texture.width.max(texture.height).ilog2() + 1;
    let created = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("material::color"),
        size: wgpu::Extent3d { width: texture.width, height: texture.height, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let (mut width, mut height) = (texture.width, texture.height);
    for mip_level in 0..levels {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level, ..created.as_image_copy() },
            &level,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 4), rows_per_image: None },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        *bytes += level.len() as u64;
        level = half_size(&level, [width, height]);
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
    }
    Ok(created.create_view(&Default::default()))
}

/// The next mip level: the mean of 2 × 2 texels, colours in linear light and weighted by alpha, so that what is cut away does
/// not colour the rest.
fn half_size(texels: &[u8], [width, height]: [u32; 2]) -> Vec<u8> {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let mut half = Vec::with_capacity((w * h * 4) as usize);
    for y in 0..h {
        for x in 0..w {
            let mut sum = [0.0_f32; 4];
            let mut plain = [0.0_f32; 3];
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let (sx, sy) = ((2 * x + dx).min(width - 1), (2 * y + dy).min(height - 1));
                let at = ((sy * width + sx) * 4) as usize;
                let alpha = f32::from(texels[at + 3]) / 255.0;
                for c in 0..3 {
                    let linear = (f32::from(texels[at + c]) / 255.0).powf(2.2);
                    sum[c] += linear * alpha;
                    plain[c] += linear * 0.25;
                }
                sum[3] += alpha;
            }
            for c in 0..3 {
                let mean = if sum[3] > 0.0 { sum[c] / sum[3] } else { plain[c] };
                half.push((mean.powf(1.0 / 2.2) * 255.0 + 0.5) as u8);
            }
            half.push((sum[3] * 0.25 * 255.0 + 0.5) as u8);
        }
    }
    half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mip_level_leaves_out_what_is_cut_away() {
        // One opaque red texel, three transparent green ones.
        let mut texels = [0, 255, 0, 0].repeat(4);
        texels[..4].copy_from_slice(&[255, 0, 0, 255]);
        assert_eq!(half_size(&texels, [2, 2]), [255, 0, 0, 64]);
        assert_eq!(half_size(&[7, 8, 9, 255], [1, 1]), [7, 8, 9, 255]);
    }
}
