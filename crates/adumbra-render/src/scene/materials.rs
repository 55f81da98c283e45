//! Materials: a small uniform, the base-colour texture with mip levels, and a sampler.

use adumbra_scene::{AlphaMode, MipLevel, Pixels, Scene, Texture, Wrap};
use adumbra_shaders::layout::MaterialParams;
use wgpu::{AddressMode, BindingResource, FilterMode, ShaderStages, TextureFormat};

use crate::error::{Fix, RenderError, Result};
use crate::gpu::{Gpu, binding};

/// Bind groups, indexed by material.
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
            let [r, g, b, alpha] = material.base_color;
            let params = MaterialParams { base_color: [r, g, b], alpha, alpha_cutoff: cutoff };
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
            fix: Fix::Other("make it smaller"),
        });
    }
    let levels = texture.mip_levels();
    let created = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("material::color"),
        size: wgpu::Extent3d { width: texture.width, height: texture.height, depth_or_array_layers: 1 },
        mip_level_count: levels.len() as u32 + 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let mut write = |mip_level: u32, [width, height]: [u32; 2], rgba: &[u8]| {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level, ..created.as_image_copy() },
            rgba,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 4), rows_per_image: None },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        *bytes += rgba.len() as u64;
    };
    write(0, [texture.width, texture.height], &texture.rgba());
    for (mip_level, MipLevel { width, height, rgba }) in (1..).zip(&levels) {
        write(mip_level, [*width, *height], rgba);
    }
    Ok(created.create_view(&Default::default()))
}
