//! A depth image from anywhere as the shadow map that a hybrid map is built from. Same stem as passes/depth_image.wgsl.

use adumbra_shaders::{assemble, source};
use wgpu::{CompareFunction, LoadOp, ShaderStages, TextureFormat, TextureView};

use super::twin::DepthImage;
use crate::error::{RenderError, Result};
use crate::gpu::{Gpu, binding};
use crate::maps::DepthPrecision;
use crate::maps::depth_pass::DepthPassOptions;
use crate::maps::textures::DepthTextures;
use crate::readback::read_depth;

/// A square of light depth on the GPU: 0 near the sun, 1 far and where no caster is.
pub struct StartDepth {
    depth: DepthTextures,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl StartDepth {
    /// A texture of `side` texels a side, a power of two, for images of that size; [`Builder::new`](super::build::Builder::new) takes
    /// its [`StartDepth::view`].
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] for a side that the device does not take; what else it reports.
    pub fn new(gpu: &Gpu, side: u32, precision: DepthPrecision) -> Result<Self> {
        let options = DepthPassOptions { format: precision.format(), normals: false };
        let depth = DepthTextures::new(gpu, "hybrid::start", side, 1, options)?;
        let layout = gpu.layout("depth_image", ShaderStages::FRAGMENT, &[binding::LOADED]);
        let pipeline = pipeline(gpu, &layout, options.format);
        gpu.check()?;
        Ok(Self { depth, layout, pipeline })
    }

    /// Replaces what the texture holds, all of it. 32-bit depths come back bit for bit, others as the nearest of 65,536.
    ///
    /// # Errors
    /// [`RenderError::DepthImage`] for an image of another size; what the device reports.
    pub fn write(&self, gpu: &Gpu, image: &DepthImage) -> Result<()> {
        let side = self.depth.all.texture.width();
        if image.side() as u64 != u64::from(side) {
            let what = format!("{0} x {0} texels for a map of {side} x {side}", image.side());
            return Err(RenderError::DepthImage { what });
        }
        let source = gpu.float_texture("depth_image", [side; 2], image.texels());
        let source = source.create_view(&Default::default());
        let group = gpu.bind("depth_image", &self.layout, vec![wgpu::BindingResource::TextureView(&source)]);
        let mut encoder = gpu.encoder("depth_image");
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("depth_image"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: self.depth.target(0).depth,
                depth_ops: Some(wgpu::Operations { load: LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        gpu.finish(encoder.finish())
    }

    /// The texture as a `texture_depth_2d_array` of one layer.
    pub fn view(&self) -> &TextureView {
        &self.depth.all.view
    }

    /// What the texture holds; waits for the device.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read(&self, gpu: &Gpu) -> Result<DepthImage> {
        let side = self.depth.all.texture.width() as usize;
        DepthImage::new(side, read_depth(gpu, &self.depth.all.texture, 0)?)
    }
}

fn pipeline(gpu: &Gpu, layout: &wgpu::BindGroupLayout, format: TextureFormat) -> wgpu::RenderPipeline {
    let module = gpu.shader("depth_image", assemble(&[source::DEPTH_IMAGE]));
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("depth_image"),
        layout: Some(&gpu.pipeline_layout("depth_image", &[Some(layout)])),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("depth_image_vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("depth_image_fragment"),
            compilation_options: Default::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    })
}
