//! Draws one or two displayed pictures to a window's texture, or to one that is read back.

use adumbra_shaders::constants::{PRESENT_DIFFERENCE, PRESENT_FIRST, PRESENT_SPLIT};
use adumbra_shaders::layout::PresentParams;
use adumbra_shaders::{assemble, source};
use wgpu::{BindingResource, ShaderStages, TextureFormat};

use super::pass::ShownPicture;
use crate::error::Result;
use crate::gpu::{Gpu, binding};

/// Colour where the second picture is darker than the first, display-encoded, as in the comparison sheets.
const TOO_DARK: [f32; 3] = [0.95, 0.10, 0.08];
/// Colour where the second picture is brighter than the first, display-encoded.
const TOO_BRIGHT: [f32; 3] = [0.10, 0.30, 1.00];

/// How two pictures are displayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PresentKind {
    /// The first picture alone.
    First,
    /// The first picture left of the divider, the second from there on.
    Split {
        /// Column of the divider, pixels.
        divider: u32,
    },
    /// The first picture in grey; red where the second is darker, blue where it is brighter.
    Difference {
        /// Factor applied to the difference in brightness. With 1, black against white gives the full colour.
        gain: f32,
    },
}

/// The pass that displays pictures, for targets of one format.
pub struct PresentPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    params: wgpu::Buffer,
    /// Whether the target's format encodes to sRGB on write.
    encodes: bool,
}

impl PresentPass {
    /// Builds the pipeline.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn new(gpu: &Gpu, format: TextureFormat) -> Result<Self> {
        let bindings = [binding::UNIFORM, binding::LOADED, binding::LOADED];
        let layout = gpu.layout("present", ShaderStages::FRAGMENT, &bindings);
        let module = gpu.shader("present", assemble(&[source::SRGB, source::PRESENT]));
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("present"),
            layout: Some(&gpu.pipeline_layout("present", &[Some(&layout)])),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("present_vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("present_fragment"),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let encodes = format.is_srgb();
        let params = gpu.uniform("present::params", &params(PresentKind::First, encodes).bytes());
        gpu.check()?;
        Ok(Self { layout, pipeline, params, encodes })
    }

    /// Draws over the whole of `target`, which must be as large as the pictures.
    pub fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        [first, second]: [&ShownPicture; 2],
        kind: PresentKind,
    ) {
        gpu.queue.write_buffer(&self.params, 0, &params(kind, self.encodes).bytes());
        let resources = vec![
            self.params.as_entire_binding(),
            BindingResource::TextureView(&first.target.view),
            BindingResource::TextureView(&second.target.view),
        ];
        let group = gpu.bind("present", &self.layout, resources);
        let black = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
        let mut pass = Gpu::color_pass(encoder, "present", target, black);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn params(kind: PresentKind, encodes: bool) -> PresentParams {
    let (number, divider, gain) = match kind {
        PresentKind::First => (PRESENT_FIRST, 0, 0.0),
        PresentKind::Split { divider } => (PRESENT_SPLIT, divider, 0.0),
        PresentKind::Difference { gain } => (PRESENT_DIFFERENCE, 0, gain),
    };
    PresentParams {
        too_dark: TOO_DARK,
        gain,
        too_bright: TOO_BRIGHT,
        kind: number,
        divider,
        window_encodes: u32::from(encodes),
    }
}
