//! The WGSL files, and how a module is put together from them.

use crate::{constants, layout};

/// A WGSL file.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Path below `wgsl/`.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
}

macro_rules! sources {
    ($($(#[$doc:meta])* $name:ident = $path:literal;)*) => {
        $($(#[$doc])* pub const $name: Source = Source { name: $path, text: include_str!(concat!("../wgsl/", $path)) };)*

        /// Every file.
        pub const ALL: &[Source] = &[$($name),*];
    };
}

sources! {
    /// A visible point, as every technique takes it.
    SURFACE = "core/surface.wgsl";
    /// From a pixel and its depth to the point behind it.
    FRAME = "core/frame.wgsl";
    /// From relative positions to a grid of voxels.
    GRID = "core/grid.wgsl";
    /// Look-up in a light-aligned graph.
    VOXEL = "core/voxel.wgsl";
    /// Look-up in a tree.
    VOXEL_CUBES = "core/voxel_cubes.wgsl";
    /// Surface to receiver, for a tree.
    VOXEL_CUBES_RECEIVER = "core/voxel_cubes_receiver.wgsl";
    /// Words from one storage buffer.
    WORDS_1 = "access/words_1.wgsl";
    /// Words from six storage buffers.
    WORDS_6 = "access/words_6.wgsl";
    /// Words from the pages of an RGBA8 texture.
    WORDS_TEXTURE = "access/words_texture.wgsl";
    /// World positions and normals into the G-buffer.
    GBUFFER = "passes/gbuffer.wgsl";
    /// Depth from the light.
    MAP_DEPTH = "passes/map_depth.wgsl";
    /// A technique's answer for every pixel of the G-buffer.
    RESOLVE = "passes/resolve.wgsl";
    /// A technique's answer for a list of points.
    POINTS = "passes/points.wgsl";
    /// The technique without shadows.
    NONE = "passes/none.wgsl";
    /// The technique `voxel`.
    VOXEL_PASS = "passes/voxel.wgsl";
    /// Counts of `voxel` for receivers in fixed point.
    VOXEL_FIXED = "passes/voxel_fixed.wgsl";
    /// The techniques `voxel-cubes` and `voxel-texture`.
    VOXEL_CUBES_PASS = "passes/voxel_cubes.wgsl";
    /// Their counts for receivers in fixed point.
    VOXEL_CUBES_FIXED = "passes/voxel_cubes_fixed.wgsl";
    /// A texture's words into a storage buffer.
    DECODE_TEXTURE = "passes/decode_texture.wgsl";
    /// Sun, sky and shadow factor on the G-buffer.
    COMPOSITE = "passes/composite.wgsl";
}

/// One module: every shared structure and constant, then `files` in this order.
pub fn assemble(files: &[Source]) -> String {
    let mut text = layout::declarations() + &constants::declarations();
    for file in files {
        text += "// ";
        text += file.name;
        text += "\n";
        text += file.text;
        text += "\n";
    }
    text
}
