//! What every shadow technique is: buffers of its own, passes before the look-up, the look-up, and passes on the screen after it.

mod build;
mod describe;
mod given;
pub(crate) mod parameter;
mod parameters;
mod reader;
mod resolve;
pub mod spec;

pub use build::{Baked, TECHNIQUES, build};
pub(crate) use describe::changed;
pub use describe::{change, describe};
pub use given::Given;
pub use parameter::{Parameter, ParameterKind};
pub use parameters::{parameter_texts, parameters};
pub use reader::SpecReader;
pub use resolve::{Lookup, Resolver};
pub use spec::TechniqueSpec;

use adumbra::camera::{Camera, View};
use adumbra::scene::Bounds;
use adumbra_shaders::{Source, source};

use crate::error::Result;
use crate::frame::Targets;
use crate::gpu::Gpu;
use crate::hybrid::HybridMap;
use crate::maps::ShadowMap;
use crate::scene::SceneBuffers;

/// What a frame is drawn from.
#[derive(Clone, Copy)]
pub struct FrameInput<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// Pixels and projection.
    pub camera: &'a Camera,
    /// The same, with axes.
    pub view: &'a View,
    /// World position that relative positions count from.
    pub anchor_world: [f64; 3],
    /// Unit vector.
    pub towards_sun: [f64; 3],
    /// What stands still.
    pub scene: &'a SceneBuffers,
    /// What moves, placed as in this frame.
    pub movers: Option<&'a SceneBuffers>,
    /// Box of everything, movers included.
    pub bounds: Bounds,
    /// Number of the frame, for the caller's use: nothing is kept or dropped because of it.
    pub number: u32,
}

/// What a look-up answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Visibility of the sun, 1 = lit.
    Visibility,
    /// The cascade that a point falls in, from 0; -1 beyond the last, and where nothing is.
    Cascade,
    /// The level that a look-up in a hybrid map ends at, 0 the finest; -1 beside the map, and where nothing is.
    Level,
    /// Log2 of the edge, in voxels ([`Technique::voxel_world`]), of the block or cube of a baked file in which the look-up of the unfiltered
    /// point ends, which is all lit or all shadowed: 0 = a single voxel or column, up to the root; -1 beside the file, and where nothing is.
    Voxel,
}

/// A shadow technique on one device.
pub trait Technique {
    /// Its name and parameters, as it is called for.
    fn name(&self) -> String;

    /// Fills uniforms and lists for a frame. Called before every other method of that frame.
    ///
    /// # Errors
    /// Whatever the technique cannot do.
    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()>;

    /// Depth passes.
    fn encode_depth(&mut self, _input: &FrameInput<'_>, _encoder: &mut wgpu::CommandEncoder) {}

    /// What is made of depth before the look-up.
    fn encode_build(&mut self, _input: &FrameInput<'_>, _encoder: &mut wgpu::CommandEncoder) {}

    /// After a frame's commands were submitted: what went wrong in them that only the device knew. Waits for it only where something may
    /// have.
    ///
    /// # Errors
    /// What the technique could not do.
    fn check(&self, _gpu: &Gpu) -> Result<()> {
        Ok(())
    }

    /// The WGSL files that define `shadow_factor`, with what they need but core/surface.wgsl; none where the technique has
    /// no such answer.
    fn sources(&self, answer: Answer) -> Option<Vec<Source>>;

    /// Layouts of bind groups 1 and 2.
    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        [None, None]
    }

    /// Bind groups 1 and 2.
    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        [None, None]
    }

    /// Whether [`Technique::encode_screen`] does something.
    fn has_screen_passes(&self) -> bool {
        false
    }

    /// Whether it answers points apart from a picture of them.
    fn answers_points(&self) -> bool {
        !self.has_screen_passes()
    }

    /// Passes on the factor after the look-up, from `targets.factor` to `targets.filtered`.
    fn encode_screen(
        &mut self,
        _input: &FrameInput<'_>,
        _frame: &wgpu::Buffer,
        _targets: &Targets,
        _encoder: &mut wgpu::CommandEncoder,
    ) {
    }

    /// Bytes that the technique holds on the GPU for its shadows.
    fn bytes(&self) -> u64 {
        0
    }

    /// Its shadow map, where it has one, for those who read it back.
    fn map(&self) -> Option<&ShadowMap> {
        None
    }

    /// Edge of what it compares with, a texel or a voxel, at a view depth, world units; as of the frame prepared last. None where it
    /// compares with nothing.
    fn texel_world(&self, _view_depth: f32) -> Option<f64> {
        None
    }

    /// Edge of the finest voxels of its baked file, world units: a block of level n ([`Answer::Voxel`]) spans 2^n of them a side. None
    /// where it has no file.
    fn voxel_world(&self) -> Option<f64> {
        None
    }

    /// Its hybrid map, where it has one, for those who read it back.
    fn hybrid(&self) -> Option<&HybridMap> {
        None
    }

    /// What it had to leave out on this device, or changed of what was asked.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// No shadows: what faces the sun is lit.
pub struct NoShadows;

impl Technique for NoShadows {
    fn name(&self) -> String {
        "none".to_owned()
    }

    fn prepare(&mut self, _input: &FrameInput<'_>) -> Result<()> {
        Ok(())
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        (answer == Answer::Visibility).then(|| vec![source::NONE])
    }
}
