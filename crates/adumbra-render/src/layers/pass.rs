//! From a frame to a picture of one of its layers.

use adumbra_shaders::constants::{
    LAYER_COLOR, LAYER_DEPTH, LAYER_NORMAL, LAYER_TINT, LAYER_VALUE, MAX_TINTS, PIXEL_GROUP,
};
use adumbra_shaders::layout::{Array, LayerParams};
use adumbra_shaders::{assemble, source};
use wgpu::{BindingResource, BufferUsages, ShaderStages, TextureFormat, TextureUsages};

use super::Layer;
use crate::error::Result;
use crate::frame::{FACTOR_FORMAT, Target, Targets};
use crate::gpu::{Gpu, binding};
use crate::readback::read_texture;
use crate::renderer::{Prepared, Renderer, Shot};
use crate::technique::Answer;
use crate::timing::FrameTimes;

/// Of pictures shown; display-encoded.
pub const SHOWN_FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

/// The passes.
pub struct LayerPass {
    layout: wgpu::BindGroupLayout,
    nearest: wgpu::ComputePipeline,
    show: wgpu::ComputePipeline,
    /// Where there is no value a pixel: unoccluded.
    one: wgpu::TextureView,
}

/// A layer of a frame, ready to be shown.
pub struct ShownPicture {
    pub(super) size: [u32; 2],
    pub(super) target: Target,
    pub(super) params: wgpu::Buffer,
    nearest: wgpu::Buffer,
    /// What a tint stands for, kept while the frame is drawn a second time.
    tint: Option<Target>,
}

impl ShownPicture {
    /// A picture of `size` pixels.
    ///
    /// # Errors
    /// What the device cannot hold.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self> {
        let usage = TextureUsages::STORAGE_BINDING
            | TextureUsages::RENDER_ATTACHMENT
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC;
        let target = target(gpu, "layer::shown", size, SHOWN_FORMAT, usage);
        let params = gpu.uniform("layer::params", &params(size, 1, Layer::Color).bytes());
        let nearest = gpu.buffer("layer::nearest", &[0; 4], BufferUsages::STORAGE);
        gpu.check()?;
        Ok(Self { size, target, params, nearest, tint: None })
    }

    /// Pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// RGBA, display-encoded, row 0 at the top.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>> {
        read_texture(gpu, &self.target.texture, 0, 0)
    }
}

impl LayerPass {
    /// Builds the pipelines.
    ///
    /// # Errors
    /// What the device reports.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let bindings = [
            binding::UNIFORM,
            binding::UNIFORM,
            binding::DEPTH,
            binding::LOADED,
            binding::LOADED,
            binding::LOADED,
            binding::STORAGE_OUT,
            binding::written(SHOWN_FORMAT),
        ];
        let layout = gpu.layout("layer", ShaderStages::COMPUTE, &bindings);
        let text = assemble(&[source::SURFACE, source::FRAME, source::SRGB, source::LAYER]);
        let pipeline = |entry| gpu.compute("layer", text.clone(), entry, &[Some(&layout)]);
        let one = gpu.float_texture("layer::one", [1, 1], &[1.0]).create_view(&Default::default());
        let (nearest, show) = (pipeline("layer_find_nearest"), pipeline("layer_show"));
        gpu.check()?;
        Ok(Self { layout, nearest, show, one })
    }
}

impl Renderer {
    /// Draws a frame and a layer of it into `picture`, each of whose pixels is the mean of `samples` × `samples`; `shot`'s camera has
    /// the picture's size. Cost: a frame of all samples, a tint's look-up besides; G-buffer and ambient occlusion once for all layers and
    /// techniques of one `shot`, as [`Renderer::draw_again`] has it.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn draw_layer(
        &mut self,
        shot: &Shot,
        prepared: &mut Prepared,
        (layer, samples): (Layer, u32),
        pass: &LayerPass,
        picture: &mut ShownPicture,
    ) -> Result<FrameTimes> {
        let mut fine = *shot;
        fine.camera.width = picture.size[0] * samples;
        fine.camera.height = picture.size[1] * samples;
        if let Some((answer, _)) = layer.tint() {
            self.draw_again(&fine, prepared, answer)?;
            self.keep_tint(picture)?;
        }
        let times = self.draw_again(&fine, prepared, Answer::Visibility)?;
        let Some(targets) = self.targets() else { return Ok(times) };
        let gpu = self.gpu();
        gpu.queue.write_buffer(&picture.params, 0, &params(picture.size, samples, layer).bytes());
        gpu.queue.write_buffer(&picture.nearest, 0, &[0; 4]);
        let values = match layer {
            Layer::Shadow => &self.factor_of(prepared, targets).view,
            Layer::Ambient => self.ambient_view().unwrap_or(&pass.one),
            _ => picture.tint.as_ref().map_or(&pass.one, |t| &t.view),
        };
        let view = BindingResource::TextureView;
        let group = gpu.bind(
            "layer",
            &pass.layout,
            vec![
                self.frame_buffer().as_entire_binding(),
                picture.params.as_entire_binding(),
                view(&targets.depth.view),
                view(&targets.normal.view),
                view(&targets.picture.view),
                view(values),
                picture.nearest.as_entire_binding(),
                view(&picture.target.view),
            ],
        );
        let mut encoder = gpu.encoder("layer");
        {
            let mut encoded = encoder.begin_compute_pass(&Default::default());
            encoded.set_bind_group(0, &group, &[]);
            let mut run = |pipeline, [w, h]: [u32; 2]| {
                encoded.set_pipeline(pipeline);
                encoded.dispatch_workgroups(w.div_ceil(PIXEL_GROUP), h.div_ceil(PIXEL_GROUP), 1);
            };
            if layer == Layer::Depth {
                run(&pass.nearest, targets.size);
            }
            run(&pass.show, picture.size);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.check()?;
        Ok(times)
    }

    /// Copies the factors of the frame drawn last.
    fn keep_tint(&self, picture: &mut ShownPicture) -> Result<()> {
        let Some(Targets { size, factor, .. }) = self.targets() else { return Ok(()) };
        let gpu = self.gpu();
        let tint = match picture.tint.take() {
            Some(kept) if [kept.texture.width(), kept.texture.height()] == *size => kept,
            _ => {
                let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
                target(gpu, "layer::tint", *size, FACTOR_FORMAT, usage)
            }
        };
        let mut encoder = gpu.encoder("layer::tint");
        encoder.copy_texture_to_texture(
            factor.texture.as_image_copy(),
            tint.texture.as_image_copy(),
            tint.texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        picture.tint = Some(tint);
        gpu.check()
    }
}

fn params([width, height]: [u32; 2], samples: u32, layer: Layer) -> LayerParams {
    let kind = match layer {
        Layer::Color => LAYER_COLOR,
        Layer::Shadow | Layer::Ambient => LAYER_VALUE,
        Layer::Depth => LAYER_DEPTH,
        Layer::Normal => LAYER_NORMAL,
        Layer::Cascades | Layer::HybridLevels | Layer::VoxelSize => LAYER_TINT,
    };
    let mut palette = [[0.0; 4]; MAX_TINTS as usize];
    let colors = layer.tint().map_or(&[][..], |(_, colors)| colors);
    for (slot, [r, g, b]) in palette.iter_mut().zip(colors) {
        *slot = [*r, *g, *b, 0.0];
    }
    LayerParams {
        shape: [width, height, samples, kind],
        counts: [colors.len().max(1) as u32, 0, 0, 0],
        palette: Array(palette),
    }
}

fn target(
    gpu: &Gpu,
    label: &str,
    [width, height]: [u32; 2],
    format: TextureFormat,
    usage: TextureUsages,
) -> Target {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    });
    Target { view: texture.create_view(&Default::default()), texture }
}
