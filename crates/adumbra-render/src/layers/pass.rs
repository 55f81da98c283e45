//! Turns a frame into a picture of one of its layers.

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

/// Format of displayed pictures, which are display-encoded.
pub const SHOWN_FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

/// The passes that turn a layer into a picture.
pub struct LayerPass {
    layout: wgpu::BindGroupLayout,
    nearest: wgpu::ComputePipeline,
    show: wgpu::ComputePipeline,
    /// A single texel of 1, unoccluded, used if there are no values per pixel.
    one: wgpu::TextureView,
}

/// A layer of a frame, ready to be displayed.
pub struct ShownPicture {
    pub(super) size: [u32; 2],
    pub(super) target: Target,
    pub(super) params: wgpu::Buffer,
    nearest: wgpu::Buffer,
    /// The values that select the tint, kept while the frame is drawn a second time.
    tint: Option<Target>,
}

impl ShownPicture {
    /// Creates a picture of `size` pixels.
    ///
    /// # Errors
    /// Returns an error if the device cannot hold it.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self> {
        let usage = TextureUsages::STORAGE_BINDING
            | TextureUsages::RENDER_ATTACHMENT
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC;
        let target = Target::new(gpu, "layer::shown", size, SHOWN_FORMAT, usage);
        let params = gpu.uniform("layer::params", &params(size, 1, Layer::Color).bytes());
        let nearest = gpu.buffer("layer::nearest", &[0; 4], BufferUsages::STORAGE);
        gpu.check()?;
        Ok(Self { size, target, params, nearest, tint: None })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Reads the picture back: RGBA, display-encoded, row 0 at the top.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>> {
        read_texture(gpu, &self.target.texture, 0, 0)
    }
}

impl LayerPass {
    /// Builds the pipelines.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
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
        let text =
            assemble(&[source::SURFACE, source::VIEW_DEPTH, source::FRAME, source::SRGB, source::LAYER]);
        let pipeline = |entry| gpu.compute("layer", text.clone(), entry, &[Some(&layout)]);
        let one = gpu.float_texture("layer::one", [1, 1], &[1.0]).create_view(&Default::default());
        let (nearest, show) = (pipeline("layer_find_nearest"), pipeline("layer_show"));
        gpu.check()?;
        Ok(Self { layout, nearest, show, one })
    }
}

impl Renderer {
    /// Draws a frame, and a layer of it into `picture`. Each pixel of the picture is the mean of `samples` ×
    /// `samples` samples. The camera of `shot` must have the picture's size. Cost: a frame with one pixel per
    /// sample, plus a second look-up for layers with a tint. G-buffer and ambient occlusion are drawn once
    /// for all layers and techniques of one `shot`: see [`Renderer::draw_again`].
    ///
    /// # Errors
    /// Returns the errors of [`Renderer::draw`].
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

    /// Copies the answers of the last frame to the picture's tint.
    fn keep_tint(&self, picture: &mut ShownPicture) -> Result<()> {
        let Some(Targets { size, factor, .. }) = self.targets() else { return Ok(()) };
        let gpu = self.gpu();
        let tint = match picture.tint.take() {
            Some(kept) if [kept.texture.width(), kept.texture.height()] == *size => kept,
            _ => {
                let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
                Target::new(gpu, "layer::tint", *size, FACTOR_FORMAT, usage)
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

fn params(size: [u32; 2], samples: u32, layer: Layer) -> LayerParams {
    let kind = match layer {
        Layer::Color => LAYER_COLOR,
        Layer::Shadow | Layer::Ambient => LAYER_VALUE,
        Layer::Depth => LAYER_DEPTH,
        Layer::Normal => LAYER_NORMAL,
        Layer::Cascades | Layer::HybridLevels | Layer::VoxelSize | Layer::ResidentLevel => LAYER_TINT,
    };
    let mut palette = [[0.0; 3]; MAX_TINTS as usize];
    let colors = layer.tint().map_or(&[][..], |(_, colors)| colors);
    palette.iter_mut().zip(colors).for_each(|(slot, color)| *slot = *color);
    let tint_count = colors.len().max(1) as u32;
    LayerParams { palette: Array(palette), size, samples, kind, tint_count }
}
