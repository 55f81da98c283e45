//! Baked voxels on the GPU: the technique `voxel`.
//!
//! A file's words → [`WordBuffers`] → [`VoxelBindings`] (group 1) → [`BakedLight`]. The words are the file's
//! unchanged sections. An engine binds a uniform at binding 0, then one storage buffer, or six if the words
//! exceed one binding. The words of a [`StreamedFile`] are a pool that changes from frame to frame, and its
//! uniform has the parameters of each level. The CPU twin is `adumbra::Sampler`; receivers in fixed point get
//! equal counts from the GPU and the CPU.

mod bindings;
mod depths;
pub mod fixed;
mod grid;
mod light;
mod moving;
mod palette;
mod path_disc;
mod reads;
mod settings;
mod soft;
mod source;
mod streamed;
mod technique;
mod words;

pub use bindings::VoxelBindings;
pub use depths::DepthsAnswer;
pub use grid::grid_transform;
pub use light::{BakedLight, queries};
pub use moving::MovingLight;
pub use palette::{VOXEL_LEVEL_COLORS, voxel_level_color};
pub use path_disc::PathDiscTwin;
pub use reads::{Reads, reads};
pub use settings::{VoxelSettings, read_bias, read_filter};
pub use soft::SoftTwin;
pub use source::LightFile;
pub use streamed::{StreamedFile, view_of};
pub(crate) use technique::NO_FILE;
pub use technique::Voxel;
pub use words::{MAX_WORD_BINDINGS, WordBuffers};

use adumbra::Bias;
use adumbra_shaders::layout::ReceiverBias;

/// Returns a bias as shaders take it.
pub fn bias_uniform(bias: Bias) -> ReceiverBias {
    ReceiverBias {
        constant_texels: bias.constant_texels as f32,
        slope_texels: bias.slope_texels as f32,
        normal_offset_texels: bias.normal_offset_texels as f32,
        width_factor: 1.0,
    }
}
