//! The techniques `voxel` (K × K texels), `voxel:path` (the same for a sun path) and `voxel:soft`
//! (penumbrae), which use only a light-aligned file.

use adumbra_shaders::Source;

use super::{BakedLight, LightFile, VoxelSettings};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::technique::{Answer, FrameInput, SpecText, Technique};

/// A light-aligned file as a technique.
pub struct Voxel {
    name: String,
    light: BakedLight,
}

impl Voxel {
    /// Wraps an uploaded file as a technique of this name.
    pub fn new(name: String, light: BakedLight) -> Self {
        Self { name, light }
    }

    /// Creates the technique `voxel` with the settings of [`VoxelSettings::from_spec`].
    ///
    /// # Errors
    /// Returns the errors of [`BakedLight::new`], and [`crate::RenderError::Technique`] if a parameter is
    /// unknown or there is no file.
    pub fn from_spec(gpu: &Gpu, spec: &SpecText, file: Option<LightFile<'_>>) -> Result<Self> {
        let file = file.ok_or_else(|| spec.wrong(NO_FILE.to_owned()))?;
        let settings = VoxelSettings::from_spec(spec, Some(file))?;
        if VoxelSettings::needs_path(spec) && !file.is_path() {
            return Err(spec.wrong("it needs a moment of a sun path, and the file is of one sun".to_owned()));
        }
        Ok(Self::new(spec.to_string(), BakedLight::new(gpu, file, settings)?))
    }

    /// The uploaded file.
    pub fn light(&self) -> &BakedLight {
        &self.light
    }
}

/// Error text of techniques that need a light-aligned file and have none.
pub(crate) const NO_FILE: &str = "it needs a light-aligned shadow file";

impl Technique for Voxel {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        self.light.prepare(input)
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        match answer {
            Answer::Visibility => Some(self.light.visibility_sources()),
            Answer::Voxel => self.light.level_sources(),
            Answer::Resident => self.light.resident_sources(),
            Answer::Cascade | Answer::Level => None,
        }
    }

    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        [Some(self.light.bindings().layout()), None]
    }

    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        [Some(self.light.bindings().group()), None]
    }

    fn texel_world(&self, _view_depth: f32) -> Option<f64> {
        Some(self.light.voxel_world())
    }

    fn voxel_world(&self) -> Option<f64> {
        Some(self.light.voxel_world())
    }

    fn bytes(&self) -> u64 {
        self.light.bytes()
    }
}
