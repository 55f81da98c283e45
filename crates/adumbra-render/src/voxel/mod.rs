//! Baked voxels on the GPU: the techniques `voxel`, `voxel-cubes` and `voxel-texture`.
//!
//! A file's words → [`WordBuffers`] or [`PageTexture`] → [`VoxelBindings`] (group 1) → [`BakedLight`] or [`Cubes`]. The
//! words of a light-aligned file are its unchanged sections, in the layout plain, packed or depths. The layout
//! determines which core/ file reads them. An engine binds a uniform at binding 0, then one storage buffer, or six if
//! the words exceed one binding, or one texture. The CPU twins are `adumbra::Query` and `TreeQuery`; receivers in fixed
//! point get equal counts from the GPU and the CPU.

mod bindings;
mod cubes;
mod cubes_options;
mod depths;
mod filter;
mod fixed;
mod grid;
mod light;
mod palette;
mod reads;
mod settings;
mod soft;
mod technique;
mod texture;
mod words;

pub use bindings::VoxelBindings;
pub use cubes::Cubes;
pub use cubes_options::{CubesOptions, CubesStore};
pub use depths::DepthsAnswer;
pub use filter::VoxelFilter;
pub(crate) use grid::grid_transform;
pub use light::BakedLight;
pub use palette::{VOXEL_LEVEL_COLORS, voxel_level_color};
pub use reads::Reads;
pub use settings::VoxelSettings;
pub(crate) use settings::read_width;
pub use soft::SoftTwin;
pub(crate) use technique::NO_FILE;
pub use technique::Voxel;
pub use texture::PageTexture;
pub use words::{MAX_WORD_BINDINGS, WordBuffers};

use adumbra::Bias;
use adumbra_shaders::layout::ReceiverBias;

fn bias_uniform(bias: Bias) -> ReceiverBias {
    ReceiverBias {
        constant_texels: bias.constant_texels as f32,
        slope_texels: bias.slope_texels as f32,
        normal_offset_texels: bias.normal_offset_texels as f32,
        width_factor: 1.0,
    }
}
