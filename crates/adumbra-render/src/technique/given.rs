//! Factors computed elsewhere, such as ray-traced truth, composited like those of any technique.

use adumbra_shaders::{Source, source};
use wgpu::ShaderStages;

use super::{Answer, FrameInput, Technique};
use crate::error::{RenderError, Result};
use crate::gpu::{Gpu, binding};

/// A technique that returns one given factor per pixel. It supports frames of its own size, not lists of
/// points.
pub struct Given {
    name: String,
    size: [u32; 2],
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

impl Given {
    /// Uploads `factors`, row 0 at the top; 1 = lit.
    ///
    /// # Errors
    /// Returns [`RenderError::Technique`] if there is not exactly one factor per pixel of `size`.
    pub fn new(gpu: &Gpu, name: &str, size: [u32; 2], factors: &[f32]) -> Result<Self> {
        let [width, height] = size;
        if factors.len() != width as usize * height as usize {
            let reason = format!("{} factors for {width} x {height} pixels", factors.len());
            return Err(RenderError::Technique { name: name.to_owned(), reason });
        }
        let texture = gpu.float_texture("given::factors", size, factors);
        let layout = gpu.layout("given", ShaderStages::COMPUTE, &[binding::LOADED]);
        let view = texture.create_view(&Default::default());
        let group = gpu.bind("given", &layout, vec![wgpu::BindingResource::TextureView(&view)]);
        gpu.check()?;
        Ok(Self { name: name.to_owned(), size, layout, group })
    }
}

impl Technique for Given {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        let asked = [input.camera.width, input.camera.height];
        if asked == self.size {
            return Ok(());
        }
        let reason = format!("it was made for {:?} pixels, not {asked:?}", self.size);
        Err(RenderError::Technique { name: self.name.clone(), reason })
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        (answer == Answer::Visibility).then(|| vec![source::GIVEN])
    }

    fn supports_points(&self) -> bool {
        false
    }

    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        [Some(&self.layout), None]
    }

    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        [Some(&self.group), None]
    }
}
