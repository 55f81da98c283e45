//! The interface of shadow techniques: their own buffers, passes before the look-up, the look-up, and
//! screen-space passes after it. This module also reads a technique's text, a name and parameters
//! ([`SpecText`], [`SpecReader`]). The list of techniques is in [`crate::techniques`].

mod changed;
mod given;
pub(crate) mod parameter;
mod reader;
mod resolve;
mod text;

pub(crate) use changed::changed;
pub use given::Given;
pub use parameter::{Parameter, ParameterKind};
pub use reader::SpecReader;
pub use resolve::{Lookup, Resolver};
pub use text::SpecText;

use std::any::Any;

use adumbra::Bounds;
use adumbra_scene::{Camera, View};
use adumbra_shaders::Source;

use crate::error::Result;
use crate::frame::Targets;
use crate::gpu::Gpu;
use crate::scene::SceneBuffers;

/// The input of a frame.
#[derive(Clone, Copy)]
pub struct FrameInput<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The camera: picture size and projection.
    pub camera: &'a Camera,
    /// The camera's position and axes.
    pub view: &'a View,
    /// World position that is the origin of relative positions.
    pub anchor_world: [f64; 3],
    /// Unit vector towards the sun.
    pub towards_sun: [f64; 3],
    /// The static scene.
    pub scene: &'a SceneBuffers,
    /// The movers, if any, placed as in this frame.
    pub movers: Option<&'a SceneBuffers>,
    /// Bounding box of everything, movers included.
    pub bounds: Bounds,
    /// Frame number, for the caller's use. Caches do not depend on it.
    pub number: u32,
}

/// The quantity that a look-up returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Visibility of the sun, 1 = lit.
    Visibility,
    /// The cascade that contains the point, from 0; -1 beyond the last cascade and for the background.
    Cascade,
    /// The level at which a look-up in a hybrid map ends, 0 = finest; -1 outside the map and for the
    /// background.
    Level,
    /// The size of the block or cube of a baked file in which the unfiltered look-up of the point ends. Such
    /// a block is entirely lit or entirely shadowed. The value is log2 of its edge in voxels
    /// ([`Technique::voxel_world`]): 0 = a single voxel or column, up to the root; -1 outside the file and
    /// for the background.
    Voxel,
    /// The level of detail of a streamed file that answers: 0 = the finest in use; -1 outside the file and
    /// for the background.
    Resident,
}

/// A shadow technique on one device.
pub trait Technique {
    /// The technique's name and parameters, as given in text.
    fn name(&self) -> String;

    /// Fills uniforms and lists for a frame. Called before any other method that concerns the frame.
    ///
    /// # Errors
    /// Returns an error if the technique cannot draw this frame.
    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()>;

    /// Encodes the depth passes.
    fn encode_depth(&mut self, _input: &FrameInput<'_>, _encoder: &mut wgpu::CommandEncoder) {}

    /// Encodes the passes between the depth passes and the look-up.
    fn encode_build(&mut self, _input: &FrameInput<'_>, _encoder: &mut wgpu::CommandEncoder) {}

    /// Reports errors that only the device could detect. Called after a frame's commands were submitted.
    /// Waits for the device only if something may have gone wrong.
    ///
    /// # Errors
    /// Returns an error that describes the failure.
    fn check(&self, _gpu: &Gpu) -> Result<()> {
        Ok(())
    }

    /// The WGSL files that define `adumbra_shadow_factor` and everything that they need except
    /// core/surface.wgsl. `None` if the technique does not support this answer.
    fn sources(&self, answer: Answer) -> Option<Vec<Source>>;

    /// Layouts of bind groups 1 and 2.
    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        [None, None]
    }

    /// Bind groups 1 and 2.
    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        [None, None]
    }

    /// Whether [`Technique::encode_screen`] does anything.
    fn has_screen_passes(&self) -> bool {
        false
    }

    /// Whether the technique can look up points that are not part of a picture.
    fn supports_points(&self) -> bool {
        !self.has_screen_passes()
    }

    /// Encodes screen-space passes after the look-up, from `targets.factor` to `targets.filtered`.
    fn encode_screen(
        &mut self,
        _input: &FrameInput<'_>,
        _frame: &wgpu::Buffer,
        _targets: &Targets,
        _encoder: &mut wgpu::CommandEncoder,
    ) {
    }

    /// GPU memory that the technique holds for its shadows, bytes.
    fn bytes(&self) -> u64 {
        0
    }

    /// The part that can be read back, such as a shadow map, to be downcast to its type.
    fn readable(&self) -> Option<&dyn Any> {
        None
    }

    /// Edge of the texel or voxel that the look-up compares with at a view depth, world units, as of the last
    /// prepared frame. `None` if there is none.
    fn texel_world(&self, _view_depth: f32) -> Option<f64> {
        None
    }

    /// Edge of the finest voxels of the baked file, world units. A block of level n ([`Answer::Voxel`]) spans
    /// 2^n of them per side. `None` if there is no file.
    fn voxel_world(&self) -> Option<f64> {
        None
    }

    /// Notes for the user: features omitted on this device, and changes of the requested settings.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}
