//! Shadows blurred in screen space: the shadow factor is written to its own target, blurred there, and then
//! composited.
//!
//! Source: ZwqXin, notes on soft shadows, 2009 (MRT, separable Gaussian, dilation). They report a halo where
//! a shadow crosses a silhouette, a gap that no dilation closes, and a cost that grows with samples and with
//! weights computed in the shader. `blur` and `blur-dilate` reproduce that. `blur-bilateral` fixes it: its
//! weights depend on depth and normal, as in J. Gumbau, M. Chover, M. Sbert, *Screen Space Soft Shadows*, GPU
//! Pro, 2010. But its width is fixed in pixels instead of following the penumbra. Departure: a line has an
//! odd number of texels, so that nothing shifts.

mod passes;
mod settings;
pub mod twin;

pub use passes::{BlurInput, BlurPasses};
pub(crate) use settings::BlurName;
pub use settings::{BlurKind, BlurPass, BlurSettings, BlurStep, BlurWeights};

use adumbra_shaders::Source;

use crate::error::Result;
use crate::frame::Targets;
use crate::gpu::Gpu;
use crate::technique::{Answer, FrameInput, Technique};

/// A technique whose factor is blurred in screen space.
pub struct ScreenBlur {
    name: String,
    base: Box<dyn Technique>,
    asked: BlurSettings,
    passes: BlurPasses,
}

impl ScreenBlur {
    /// Puts a blur over `base`. `name` is the name of the combined technique.
    pub fn new(gpu: &Gpu, name: String, base: Box<dyn Technique>, settings: BlurSettings) -> Self {
        Self { name, base, asked: settings, passes: BlurPasses::new(gpu, settings) }
    }
}

impl Technique for ScreenBlur {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        self.base.prepare(input)
    }

    fn encode_depth(&mut self, input: &FrameInput<'_>, encoder: &mut wgpu::CommandEncoder) {
        self.base.encode_depth(input, encoder);
    }

    fn check(&self, gpu: &Gpu) -> Result<()> {
        self.base.check(gpu)
    }

    fn encode_build(&mut self, input: &FrameInput<'_>, encoder: &mut wgpu::CommandEncoder) {
        self.base.encode_build(input, encoder);
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        self.base.sources(answer)
    }

    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        self.base.layouts()
    }

    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        self.base.groups()
    }

    fn has_screen_passes(&self) -> bool {
        true
    }

    fn encode_screen(
        &mut self,
        input: &FrameInput<'_>,
        frame: &wgpu::Buffer,
        targets: &Targets,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        let blur = BlurInput {
            size: targets.size,
            frame,
            depth: &targets.depth.view,
            normal: &targets.normal.view,
            factor: &targets.factor.view,
            filtered: &targets.filtered.view,
        };
        self.passes.encode(input.gpu, encoder, &blur);
    }

    fn texel_world(&self, view_depth: f32) -> Option<f64> {
        self.base.texel_world(view_depth)
    }

    fn voxel_world(&self) -> Option<f64> {
        self.base.voxel_world()
    }

    fn bytes(&self) -> u64 {
        self.base.bytes() + self.passes.bytes()
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = self.base.notes();
        if self.asked.pairs && !self.passes.settings().pairs {
            notes.push("pairs=on is ignored: this device does not filter 32-bit floats".to_owned());
        }
        notes
    }
}
