//! The textures of a shadow map: depth, optional normals, and moments.

use wgpu::{Extent3d, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView};

use super::depth_pass::{DepthPassOptions, LayerTarget, NORMAL_FORMAT};
use crate::error::{Fix, RenderError, Result};
use crate::frame::Target;
use crate::gpu::Gpu;

/// Largest number of mip levels of moments.
const MAX_LEVELS: u32 = 6;

/// Depth of up to 8 layers, and normals if they are drawn too.
pub(crate) struct DepthTextures {
    /// All layers, as look-ups read them.
    pub(crate) all: Target,
    /// Each layer as a render target.
    pub(crate) layers: Vec<TextureView>,
    /// Normals in [`NORMAL_FORMAT`]: all layers, and each layer as a render target.
    pub(crate) normals: Option<(Target, Vec<TextureView>)>,
}

/// Moments of up to 8 layers, and the row-blurred moments of one.
pub(super) struct MomentTextures {
    /// All layers and mip levels.
    pub(super) all: Target,
    /// By layer, then by mip level.
    pub(super) levels: Vec<Vec<TextureView>>,
    /// One layer between the row pass and the column pass.
    pub(super) rows: Target,
}

impl DepthTextures {
    pub(crate) fn new(
        gpu: &Gpu,
        label: &'static str,
        size: u32,
        layers: u32,
        options: DepthPassOptions,
    ) -> Result<Self> {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_DST;
        let made = |label, format| -> Result<(Target, Vec<TextureView>)> {
            let all = array(gpu, label, size, layers, 1, format, usage)?;
            let each = (0..layers).map(|l| one(&all.texture, l, 0)).collect();
            Ok((all, each))
        };
        let (all, each) = made(label, options.format)?;
        let normals = options.normals.then(|| made("map::normals", NORMAL_FORMAT)).transpose()?;
        Ok(Self { all, layers: each, normals })
    }

    /// Returns a layer as a render target.
    pub(crate) fn target(&self, layer: usize) -> LayerTarget<'_> {
        let normals = self.normals.as_ref().map(|(_, layers)| &layers[layer]);
        LayerTarget { depth: &self.layers[layer], normals }
    }

    /// Copies a layer from textures with the same options.
    pub(crate) fn copy_layer(&self, encoder: &mut wgpu::CommandEncoder, source: &Self, layer: u32) {
        copy_layer(encoder, &source.all.texture, &self.all.texture, layer);
        if let (Some((from, _)), Some((to, _))) = (&source.normals, &self.normals) {
            copy_layer(encoder, &from.texture, &to.texture, layer);
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        bytes(&self.all.texture) + self.normals.as_ref().map_or(0, |(all, _)| bytes(&all.texture))
    }
}

impl MomentTextures {
    pub(super) fn new(gpu: &Gpu, format: TextureFormat, size: u32, layers: u32) -> Result<Self> {
        let count = (size.ilog2() + 1).min(MAX_LEVELS);
        let usage = TextureUsages::STORAGE_BINDING;
        let all = array(gpu, "map::moments", size, layers, count, format, usage)?;
        let mut rows = array(gpu, "map::moment_rows", size, 1, 1, format, usage)?;
        rows.view = one(&rows.texture, 0, 0);
        let levels = (0..layers).map(|l| (0..count).map(|m| one(&all.texture, l, m)).collect()).collect();
        Ok(Self { all, levels, rows })
    }

    pub(super) fn bytes(&self) -> u64 {
        bytes(&self.all.texture) + bytes(&self.rows.texture)
    }
}

fn array(
    gpu: &Gpu,
    label: &'static str,
    size: u32,
    layers: u32,
    mip_level_count: u32,
    format: TextureFormat,
    usage: TextureUsages,
) -> Result<Target> {
    let limit = gpu.max_texture_side();
    if size > limit {
        let texel = u64::from(format.block_copy_size(None).unwrap_or(4));
        return Err(RenderError::TooLarge {
            what: format!("a shadow map of {size} x {size} texels"),
            bytes: u64::from(size) * u64::from(size) * texel * u64::from(layers),
            limit: u64::from(limit) * u64::from(limit) * texel,
            fix: Fix::Other("give a smaller size="),
        });
    }
    let texture = gpu.device.create_texture(&TextureDescriptor {
        label: Some(label),
        size: Extent3d { width: size, height: size, depth_or_array_layers: layers },
        mip_level_count,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: usage | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    Ok(Target { texture, view })
}

fn one(texture: &wgpu::Texture, layer: u32, mip_level: u32) -> TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        base_array_layer: layer,
        array_layer_count: Some(1),
        base_mip_level: mip_level,
        mip_level_count: Some(1),
        ..Default::default()
    })
}

fn copy_layer(encoder: &mut wgpu::CommandEncoder, source: &wgpu::Texture, to: &wgpu::Texture, layer: u32) {
    let at = |texture| wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: 0,
        origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
        aspect: wgpu::TextureAspect::All,
    };
    let size = wgpu::Extent3d { width: to.width(), height: to.height(), depth_or_array_layers: 1 };
    encoder.copy_texture_to_texture(at(source), at(to), size);
}

fn bytes(texture: &wgpu::Texture) -> u64 {
    let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(4));
    let texels = |m: u32| u64::from(texture.width() >> m) * u64::from(texture.height() >> m);
    let levels: u64 = (0..texture.mip_level_count()).map(texels).sum();
    levels * texel * u64::from(texture.depth_or_array_layers())
}
