//! Baked voxels on the GPU: the techniques `voxel`, `voxel-cubes` and `voxel-texture`.
//!
//! A file's words → [`WordBuffers`] or [`PageTexture`] → [`VoxelBindings`] (group 1) → [`Voxel`], [`VoxelHierarchy`] or [`Cubes`]. The words of a
//! light-aligned file are its sections as they are, plain, packed or hierarchy, and its layout says which core/ file reads them. What an engine binds:
//! binding 0 a uniform, then either one storage buffer, or six for what is larger than one may be, or one texture. The CPU twins are
//! `adumbra::query::Query` and `TreeQuery`; receivers in fixed point get the very same counts from both.

mod bindings;
mod cubes;
mod fixed;
mod grid;
mod hierarchy;
mod light;
mod palette;
mod settings;
mod soft;
mod texture;
mod words;

pub use bindings::VoxelBindings;
pub use cubes::{Cubes, CubesOptions, CubesStore};
pub use grid::grid_transform;
pub use hierarchy::{HierarchyAnswer, HierarchyFilter, VoxelHierarchy};
pub use light::Voxel;
pub use palette::{VOXEL_LEVEL_COLORS, voxel_level_color};
pub use settings::VoxelSettings;
pub(crate) use settings::{read_layers, read_width};
pub use soft::SoftTwin;
pub use texture::PageTexture;
pub use words::{MAX_WORD_BINDINGS, WordBuffers};

use adumbra::query::TapLayers;
use adumbra::settings::Bias;

/// As `places` has it.
fn layers_word(layers: TapLayers) -> u32 {
    u32::from(layers == TapLayers::Block)
}

fn bias_uniform(bias: Bias) -> [f32; 4] {
    [bias.constant_texels as f32, bias.slope_texels as f32, bias.normal_offset_texels as f32, 0.0]
}
