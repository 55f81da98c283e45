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
    /// sRGB's curve.
    SRGB = "core/srgb.wgsl";
    /// From a mesh to the world.
    INSTANCE = "core/instance.wgsl";
    /// From relative positions to a grid of voxels.
    GRID = "core/grid.wgsl";
    /// What look-ups in light-aligned files share.
    VOXEL = "core/voxel.wgsl";
    /// Look-up in a light-aligned graph.
    VOXEL_GRAPH = "core/voxel_graph.wgsl";
    /// Its nodes in the plain layout.
    VOXEL_PLAIN = "core/voxel_plain.wgsl";
    /// Its nodes in the packed layout.
    VOXEL_PACKED = "core/voxel_packed.wgsl";
    /// Look-up in a hierarchy.
    HIERARCHY = "core/hierarchy.wgsl";
    /// Penumbrae from a hierarchy's depths.
    HIERARCHY_SOFT = "core/hierarchy_soft.wgsl";
    /// The level at which a look-up in a light-aligned graph ends.
    VOXEL_LEVEL = "core/voxel_level.wgsl";
    /// The level at which a look-up in a hierarchy ends.
    HIERARCHY_LEVEL = "core/hierarchy_level.wgsl";
    /// The level at which a look-up in a tree ends.
    VOXEL_CUBES_LEVEL = "core/voxel_cubes_level.wgsl";
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
    /// A unit vector as two bytes.
    OCTAHEDRAL = "core/octahedral.wgsl";
    /// Depth from the light, and normals.
    MAP_NORMALS = "passes/map_normals.wgsl";
    /// A point as a layer of a shadow map sees it.
    MAPS = "core/maps.wgsl";
    /// Discs of taps, turned from pixel to pixel.
    DISC = "core/disc.wgsl";
    /// Comparisons with a depth map, and their means.
    PCF = "core/pcf.wgsl";
    /// Penumbrae by the distance of blockers.
    PCSS = "core/pcss.wgsl";
    /// What all statistics of depth share.
    MOMENTS = "core/moments.wgsl";
    /// Mean and mean square of depth.
    VSM = "core/vsm.wgsl";
    /// The same of two exponentials.
    EVSM = "core/evsm.wgsl";
    /// Four moments of depth.
    MSM = "core/msm.wgsl";
    /// Layers of a map, their blends and where shadows end.
    MAP_LOOKUP = "passes/map_lookup.wgsl";
    /// A shadow map as the whole technique.
    MAP_ONLY = "passes/map_only.wgsl";
    /// The layer that a point falls in.
    MAP_CASCADE = "passes/map_cascade.wgsl";
    /// One texel compared.
    MAP_NEAREST = "passes/map_nearest.wgsl";
    /// The sampler's 2 × 2 comparisons.
    MAP_HARDWARE = "passes/map_hardware.wgsl";
    /// A square of comparisons.
    MAP_PCF = "passes/map_pcf.wgsl";
    /// A disc of comparisons.
    MAP_POISSON = "passes/map_poisson.wgsl";
    /// Soft shadows of a sun with a size.
    MAP_PCSS = "passes/map_pcss.wgsl";
    /// Moments through a filtering sampler.
    MAP_MOMENTS = "passes/map_moments.wgsl";
    /// Moments blended in the shader.
    MAP_MOMENTS_LOADED = "passes/map_moments_loaded.wgsl";
    /// Moments of a layer's depth, blurred along rows.
    MOMENTS_ROWS = "passes/moments_rows.wgsl";
    /// Moments blurred along columns.
    MOMENTS_COLUMNS = "passes/moments_columns.wgsl";
    /// The next mip level of moments.
    MOMENTS_MIP = "passes/moments_mip.wgsl";
    /// A depth image into a shadow map.
    DEPTH_IMAGE = "passes/depth_image.wgsl";
    /// Down the levels of a hybrid map.
    HYBRID = "core/hybrid.wgsl";
    /// A mean over a square of a hybrid map.
    HYBRID_BOX = "core/hybrid_box.wgsl";
    /// Texels of a hybrid map that are planes.
    HYBRID_PLANE = "core/hybrid_plane.wgsl";
    /// Texels of a hybrid map that are mean depths.
    HYBRID_MEAN = "core/hybrid_mean.wgsl";
    /// Words of a hybrid map of 32 bits a texel.
    HYBRID_COMPACT = "access/hybrid_compact.wgsl";
    /// Texels of a hybrid map of 128 bits, and the list of links.
    HYBRID_PAPER = "access/hybrid_paper.wgsl";
    /// Means of packed normals.
    HYBRID_NORMALS = "core/hybrid_normals.wgsl";
    /// What the passes that build a hybrid map share.
    HYBRID_BUILD = "passes/hybrid_build.wgsl";
    /// Blocks that lie in a plane.
    HYBRID_MERGE_PLANE = "passes/hybrid_merge_plane.wgsl";
    /// Blocks whose depths differ little from their mean.
    HYBRID_MERGE_MEAN = "passes/hybrid_merge_mean.wgsl";
    /// Merging, a thread a strip.
    HYBRID_SWEEP = "passes/hybrid_sweep.wgsl";
    /// Merging, a thread a block.
    HYBRID_BLOCKS = "passes/hybrid_blocks.wgsl";
    /// Where each section's children go.
    HYBRID_SCAN = "passes/hybrid_scan.wgsl";
    /// Children to their places.
    HYBRID_PLACE = "passes/hybrid_place.wgsl";
    /// The same as texels of 128 bits, with their links.
    HYBRID_PLACE_PAPER = "passes/hybrid_place_paper.wgsl";
    /// The technique `hrsm`, bindings.
    HYBRID_MAP = "passes/hybrid_map.wgsl";
    /// `hrsm`, one texel compared.
    HYBRID_NEAREST = "passes/hybrid_nearest.wgsl";
    /// `hrsm`, a square of comparisons.
    HYBRID_PCF = "passes/hybrid_pcf.wgsl";
    /// The level that a look-up in a hybrid map ends at.
    HYBRID_LEVELS = "passes/hybrid_levels.wgsl";
    /// A technique's answer for every pixel of the G-buffer.
    RESOLVE = "passes/resolve.wgsl";
    /// A technique's answer for a list of points.
    POINTS = "passes/points.wgsl";
    /// The technique without shadows.
    NONE = "passes/none.wgsl";
    /// Weights of the screen-space blur.
    BLUR = "core/blur.wgsl";
    /// The shadow factor blurred over the picture.
    BLUR_PASS = "passes/blur.wgsl";
    /// The same with two neighbours a sample.
    BLUR_PAIRS = "passes/blur_pairs.wgsl";
    /// The shadow factor blurred within surfaces.
    BLUR_EDGES = "passes/blur_edges.wgsl";
    /// To half size and back.
    BLUR_HALF = "passes/blur_half.wgsl";
    /// To half size and back within surfaces.
    BLUR_HALF_EDGES = "passes/blur_half_edges.wgsl";
    /// Factors made elsewhere, as a technique.
    GIVEN = "passes/given.wgsl";
    /// The technique `voxel`.
    VOXEL_PASS = "passes/voxel.wgsl";
    /// The technique `voxel+csm`.
    VOXEL_CSM = "passes/voxel_csm.wgsl";
    /// The technique `voxel` on a hierarchy.
    HIERARCHY_PASS = "passes/hierarchy.wgsl";
    /// The technique `voxel:soft`.
    HIERARCHY_SOFT_PASS = "passes/hierarchy_soft.wgsl";
    /// Its counts, depths and penumbrae for receivers in fixed point.
    HIERARCHY_FIXED = "passes/hierarchy_fixed.wgsl";
    /// Counts of `voxel` for receivers in fixed point.
    VOXEL_FIXED = "passes/voxel_fixed.wgsl";
    /// `voxel`, the level at which its look-up ends.
    VOXEL_LEVEL_PASS = "passes/voxel_level.wgsl";
    /// The same on a hierarchy.
    HIERARCHY_LEVEL_PASS = "passes/hierarchy_level.wgsl";
    /// The same of a tree.
    VOXEL_CUBES_LEVEL_PASS = "passes/voxel_cubes_level.wgsl";
    /// A tree's uniform and regions.
    VOXEL_CUBES_MAP = "passes/voxel_cubes_map.wgsl";
    /// The techniques `voxel-cubes` and `voxel-texture`.
    VOXEL_CUBES_PASS = "passes/voxel_cubes.wgsl";
    /// Their counts for receivers in fixed point.
    VOXEL_CUBES_FIXED = "passes/voxel_cubes_fixed.wgsl";
    /// A texture's words into a storage buffer.
    DECODE_TEXTURE = "passes/decode_texture.wgsl";
    /// A texel's place in view space, for ambient occlusion.
    OCCLUSION = "core/occlusion.wgsl";
    /// Depth along an axis of the screen, for ambient occlusion.
    OCCLUSION_PLANE = "core/occlusion_plane.wgsl";
    /// View depth for ambient occlusion.
    OCCLUSION_SURFACE = "passes/occlusion_surface.wgsl";
    /// What estimators of ambient occlusion share.
    OCCLUSION_PASS = "passes/occlusion.wgsl";
    /// The estimator `issao`.
    OCCLUSION_ISSAO = "passes/occlusion_issao.wgsl";
    /// Its term.
    OCCLUSION_ISSAO_TERM = "passes/occlusion_issao_term.wgsl";
    /// Its term in the second reading.
    OCCLUSION_ISSAO_FALLOFF = "passes/occlusion_issao_falloff.wgsl";
    /// Its term without the attenuation.
    OCCLUSION_ISSAO_BARE = "passes/occlusion_issao_bare.wgsl";
    /// The estimator `ssao`.
    OCCLUSION_SSAO = "passes/occlusion_ssao.wgsl";
    /// The estimator `alchemy`.
    OCCLUSION_ALCHEMY = "passes/occlusion_alchemy.wgsl";
    /// What `hbao` and `gtao` share.
    OCCLUSION_MARCH = "passes/occlusion_march.wgsl";
    /// The estimator `hbao`.
    OCCLUSION_HBAO = "passes/occlusion_hbao.wgsl";
    /// The estimator `gtao`.
    OCCLUSION_GTAO = "passes/occlusion_gtao.wgsl";
    /// World normals from depth.
    OCCLUSION_NORMALS = "passes/occlusion_normals.wgsl";
    /// Ambient visibility of the frames before.
    OCCLUSION_HISTORY = "passes/occlusion_history.wgsl";
    /// Filters of ambient visibility.
    OCCLUSION_FILTER = "passes/occlusion_filter.wgsl";
    /// Ambient visibility from half size to the frame's.
    OCCLUSION_UP = "passes/occlusion_up.wgsl";
    /// Sun, sky, shadow factor and ambient visibility on the G-buffer.
    COMPOSITE = "passes/composite.wgsl";
    /// A layer of a frame, as it is shown.
    LAYER = "passes/layer.wgsl";
    /// One or two pictures onto a window.
    PRESENT = "passes/present.wgsl";
    /// Lines over a picture.
    LINES = "passes/lines.wgsl";
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
