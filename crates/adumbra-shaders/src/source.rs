//! The WGSL files.

/// A WGSL file, or an engine's own WGSL text.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Path below `wgsl/`; any name for other text.
    pub name: &'static str,
    /// The WGSL text.
    pub text: &'static str,
}

/// The files that define `adumbra_voxel_factor`, the look-up in any shadow file. They must follow
/// [`SURFACE`]. The words come from a file of `access/`.
pub const LOOK_UP: &[Source] = &[GRID, VOXEL, DEPTHS, DEPTHS_LEAF];

/// Returns the file at a path below `wgsl/`; `None` if there is no such file.
pub fn by_path(path: &str) -> Option<Source> {
    ALL.iter().copied().find(|source| source.name == path)
}

macro_rules! sources {
    ($($(#[$doc:meta])* $name:ident = $path:literal;)*) => {
        $($(#[$doc])* pub const $name: Source = Source { name: $path, text: include_str!(concat!("../wgsl/", $path)) };)*

        /// Every file.
        pub const ALL: &[Source] = &[$($name),*];
    };
}

sources! {
    /// A visible point, the input of every technique.
    SURFACE = "core/surface.wgsl";
    /// Converts stored depth to view depth.
    VIEW_DEPTH = "core/view_depth.wgsl";
    /// Reconstructs the visible point from a pixel and its depth.
    FRAME = "core/frame.wgsl";
    /// The sRGB transfer function.
    SRGB = "core/srgb.wgsl";
    /// Transforms a mesh instance to world space.
    INSTANCE = "core/instance.wgsl";
    /// Transforms relative positions to a voxel grid.
    GRID = "core/grid.wgsl";
    /// Code shared by look-ups in light-aligned files.
    VOXEL = "core/voxel.wgsl";
    /// Look-up in a light-aligned file.
    DEPTHS = "core/depths.wgsl";
    /// Leaves of the quadtree.
    DEPTHS_LEAF = "core/depths_leaf.wgsl";
    /// The blend of a streamed file's levels.
    DEPTHS_BLEND = "core/depths_blend.wgsl";
    /// The march towards another sun than a file's own.
    DEPTHS_MARCH = "core/depths_march.wgsl";
    /// Penumbrae from switch depths.
    DEPTHS_SOFT = "core/depths_soft.wgsl";
    /// The level at which a look-up ends.
    DEPTHS_LEVEL = "core/depths_level.wgsl";
    /// Words from one storage buffer.
    WORDS_1 = "access/words_1.wgsl";
    /// Words from one storage buffer, each logged as it is read.
    WORDS_LOGGED = "access/words_logged.wgsl";
    /// Words from six storage buffers.
    WORDS_6 = "access/words_6.wgsl";
    /// The parameters of a file that was uploaded whole.
    VOXEL_PARAMS = "access/voxel_params.wgsl";
    /// The parameters of a streamed file's levels.
    VOXEL_LEVELS = "access/voxel_levels.wgsl";
    /// Penumbrae in a file that was uploaded whole.
    VOXEL_PARAMS_SOFT = "access/voxel_params_soft.wgsl";
    /// Penumbrae in a streamed file.
    VOXEL_LEVELS_SOFT = "access/voxel_levels_soft.wgsl";
    /// The parameters of two keys of a sun path.
    VOXEL_PATH = "access/voxel_path.wgsl";
    /// The look-up between two keys of a sun path, with a filter.
    VOXEL_PATH_FILTER = "access/voxel_path_filter.wgsl";
    /// The look-up between two keys of a sun path, for the sun's disc.
    VOXEL_PATH_DISC = "access/voxel_path_disc.wgsl";
    /// Texels of a look-up texture of format `R32Uint`.
    TEXTURE_R32UINT = "access/texture_r32uint.wgsl";
    /// Texels of a look-up texture of format `Rgba8Unorm`.
    TEXTURE_RGBA8UNORM = "access/texture_rgba8unorm.wgsl";
    /// Words of a look-up texture.
    LOOK_UP_TEXTURE = "access/look_up_texture.wgsl";
    /// Header and parameters of a look-up texture.
    LOOK_UP_PARAMETERS = "access/look_up_parameters.wgsl";
    /// The look-up in a file that is a look-up texture.
    LOOK_UP_FILE = "access/look_up_file.wgsl";
    /// The functions that an engine's shader calls.
    VISIBILITY = "access/visibility.wgsl";
    /// Renders depth, normals and base colour into the G-buffer.
    GBUFFER = "passes/gbuffer.wgsl";
    /// The vertex input and the material shared by the passes that draw the scene.
    SCENE_CORNER = "passes/scene_corner.wgsl";
    /// Renders depth from the light.
    MAP_DEPTH = "passes/map_depth.wgsl";
    /// Packs a unit vector into two bytes.
    OCTAHEDRAL = "core/octahedral.wgsl";
    /// Renders depth and normals from the light.
    MAP_NORMALS = "passes/map_normals.wgsl";
    /// A point's position in a layer of a shadow map.
    MAP_LAYER = "core/map_layer.wgsl";
    /// A receiver in a layer of a shadow map.
    MAPS = "core/maps.wgsl";
    /// Disc taps, rotated per pixel.
    DISC = "core/disc.wgsl";
    /// Comparisons with a depth map and their means: percentage-closer filtering.
    PCF = "core/pcf.wgsl";
    /// Percentage-closer soft shadows: penumbrae from the distance of blockers.
    PCSS = "core/pcss.wgsl";
    /// Code shared by all depth moments.
    MOMENTS = "core/moments.wgsl";
    /// Variance shadow maps: mean and mean square of depth.
    VSM = "core/vsm.wgsl";
    /// Exponential variance shadow maps: mean and mean square of two exponentials of depth.
    EVSM = "core/evsm.wgsl";
    /// Moment shadow maps: four moments of depth.
    MSM = "core/msm.wgsl";
    /// Layer selection, blending between layers, and the fade at the end of the shadows.
    MAP_LOOKUP = "passes/map_lookup.wgsl";
    /// The technique that is a shadow map alone.
    MAP_ONLY = "passes/map_only.wgsl";
    /// The layer that a point falls in.
    MAP_CASCADE = "passes/map_cascade.wgsl";
    /// Map filter: a single texel compared.
    MAP_NEAREST = "passes/map_nearest.wgsl";
    /// Map filter: the sampler's 2 × 2 comparisons.
    MAP_HARDWARE = "passes/map_hardware.wgsl";
    /// Map filter: the mean of comparisons over a square.
    MAP_PCF = "passes/map_pcf.wgsl";
    /// Map filter: the mean of comparisons over a disc.
    MAP_POISSON = "passes/map_poisson.wgsl";
    /// Map filter: soft shadows of an area sun.
    MAP_PCSS = "passes/map_pcss.wgsl";
    /// Map filter: moments read through a filtering sampler.
    MAP_MOMENTS = "passes/map_moments.wgsl";
    /// Map filter: moments interpolated in the shader.
    MAP_MOMENTS_LOADED = "passes/map_moments_loaded.wgsl";
    /// One axis of the separable blur of moments.
    MOMENTS_LINE = "passes/moments_line.wgsl";
    /// Moments of a layer's depth, blurred along rows.
    MOMENTS_ROWS = "passes/moments_rows.wgsl";
    /// Moments blurred along columns.
    MOMENTS_COLUMNS = "passes/moments_columns.wgsl";
    /// The next mip level of moments.
    MOMENTS_MIP = "passes/moments_mip.wgsl";
    /// Writes a depth image into a shadow map.
    DEPTH_IMAGE = "passes/depth_image.wgsl";
    /// Traversal of the levels of a hybrid map.
    HYBRID = "core/hybrid.wgsl";
    /// The mean of comparisons over a square of a hybrid map.
    HYBRID_BOX = "core/hybrid_box.wgsl";
    /// Texels of a hybrid map that are planes.
    HYBRID_PLANE = "core/hybrid_plane.wgsl";
    /// Texels of a hybrid map that are mean depths.
    HYBRID_MEAN = "core/hybrid_mean.wgsl";
    /// Words of a hybrid map of 32 bits per texel.
    HYBRID_COMPACT = "access/hybrid_compact.wgsl";
    /// 128-bit texels of a hybrid map, and their linked lists.
    HYBRID_PAPER = "access/hybrid_paper.wgsl";
    /// Means of packed normals.
    HYBRID_NORMALS = "core/hybrid_normals.wgsl";
    /// Code shared by the passes that build a hybrid map.
    HYBRID_BUILD = "passes/hybrid_build.wgsl";
    /// Merges blocks that fit a plane.
    HYBRID_MERGE_PLANE = "passes/hybrid_merge_plane.wgsl";
    /// Merges blocks whose depths are close to their mean.
    HYBRID_MERGE_MEAN = "passes/hybrid_merge_mean.wgsl";
    /// Merging with one thread per strip.
    HYBRID_SWEEP = "passes/hybrid_sweep.wgsl";
    /// Merging with one thread per block.
    HYBRID_BLOCKS = "passes/hybrid_blocks.wgsl";
    /// Computes the offset of each section's children.
    HYBRID_SCAN = "passes/hybrid_scan.wgsl";
    /// Writes the children of unmerged blocks to the map.
    HYBRID_PLACE = "passes/hybrid_place.wgsl";
    /// Writes the children of unmerged blocks to the map as 128-bit texels, with their links.
    HYBRID_PLACE_PAPER = "passes/hybrid_place_paper.wgsl";
    /// The technique `hrsm`: bindings and entry function.
    HYBRID_MAP = "passes/hybrid_map.wgsl";
    /// Filter of `hrsm`: a single texel compared.
    HYBRID_NEAREST = "passes/hybrid_nearest.wgsl";
    /// Filter of `hrsm`: the mean of comparisons over a square.
    HYBRID_PCF = "passes/hybrid_pcf.wgsl";
    /// The level at which a look-up in a hybrid map ends.
    HYBRID_LEVELS = "passes/hybrid_levels.wgsl";
    /// Evaluates a technique for every pixel of the G-buffer.
    RESOLVE = "passes/resolve.wgsl";
    /// Evaluates a technique for a list of points.
    POINTS = "passes/points.wgsl";
    /// The technique without shadows.
    NONE = "passes/none.wgsl";
    /// Weights of the screen-space blur.
    BLUR = "core/blur.wgsl";
    /// Bindings and helpers shared by all blur passes.
    BLUR_FACTOR = "passes/blur_factor.wgsl";
    /// Bindings and helpers shared by the edge-aware blur passes.
    BLUR_SURFACES = "passes/blur_surfaces.wgsl";
    /// Blurs the shadow factor in screen space.
    BLUR_PASS = "passes/blur.wgsl";
    /// One axis of the blur, reading two neighbours per sample.
    BLUR_PAIRS = "passes/blur_pairs.wgsl";
    /// Blurs the shadow factor within surfaces.
    BLUR_EDGES = "passes/blur_edges.wgsl";
    /// Scales the shadow factor to half size and back.
    BLUR_HALF = "passes/blur_half.wgsl";
    /// Scales the shadow factor to half size and back within surfaces.
    BLUR_HALF_EDGES = "passes/blur_half_edges.wgsl";
    /// The technique that reads precomputed factors.
    GIVEN = "passes/given.wgsl";
    /// The technique `voxel`.
    VOXEL_PASS = "passes/voxel.wgsl";
    /// The technique `voxel+csm`.
    VOXEL_CSM = "passes/voxel_csm.wgsl";
    /// The technique `voxel:soft`.
    VOXEL_SOFT_PASS = "passes/voxel_soft.wgsl";
    /// Lit taps, switch depths and penumbrae for receivers in fixed point.
    DEPTHS_FIXED = "passes/depths_fixed.wgsl";
    /// Lit taps of `voxel` for receivers in fixed point.
    VOXEL_FIXED = "passes/voxel_fixed.wgsl";
    /// Marches in both keys of a sun path, from starts in fixed point.
    MARCH_FIXED = "passes/march_fixed.wgsl";
    /// Lit taps of `voxel` for receivers in fixed point, and the words that were read for them.
    VOXEL_READS = "passes/voxel_reads.wgsl";
    /// Visibility between two keys of a sun path, and the number of words that were read for it.
    PATH_READS = "passes/path_reads.wgsl";
    /// The level at which a look-up of `voxel` ends, as a pass.
    VOXEL_LEVEL_PASS = "passes/voxel_level.wgsl";
    /// The level at which a look-up in a streamed file ends.
    VOXEL_LEVELS_BLOCK_PASS = "passes/voxel_levels_block.wgsl";
    /// The level of a streamed file that answers.
    VOXEL_LEVELS_RESIDENT_PASS = "passes/voxel_levels_resident.wgsl";
    /// Conversions between texels and view space, for ambient occlusion.
    OCCLUSION = "core/occlusion.wgsl";
    /// Depth extrapolated along a screen axis, for ambient occlusion.
    OCCLUSION_PLANE = "core/occlusion_plane.wgsl";
    /// View depth for ambient occlusion.
    OCCLUSION_SURFACE = "passes/occlusion_surface.wgsl";
    /// Code shared by the ambient occlusion estimators.
    OCCLUSION_PASS = "passes/occlusion.wgsl";
    /// The estimator `issao`.
    OCCLUSION_ISSAO = "passes/occlusion_issao.wgsl";
    /// The term of `issao`.
    OCCLUSION_ISSAO_TERM = "passes/occlusion_issao_term.wgsl";
    /// The term of `issao` in the second reading of the paper.
    OCCLUSION_ISSAO_FALLOFF = "passes/occlusion_issao_falloff.wgsl";
    /// The term of `issao` without the attenuation.
    OCCLUSION_ISSAO_BARE = "passes/occlusion_issao_bare.wgsl";
    /// The estimator `ssao`.
    OCCLUSION_SSAO = "passes/occlusion_ssao.wgsl";
    /// The estimator `alchemy`.
    OCCLUSION_ALCHEMY = "passes/occlusion_alchemy.wgsl";
    /// Code shared by `hbao` and `gtao`.
    OCCLUSION_MARCH = "passes/occlusion_march.wgsl";
    /// The estimator `hbao`.
    OCCLUSION_HBAO = "passes/occlusion_hbao.wgsl";
    /// The estimator `gtao`.
    OCCLUSION_GTAO = "passes/occlusion_gtao.wgsl";
    /// Reconstructs world normals from depth.
    OCCLUSION_NORMALS = "passes/occlusion_normals.wgsl";
    /// Temporal accumulation of ambient visibility.
    OCCLUSION_HISTORY = "passes/occlusion_history.wgsl";
    /// Filters of ambient visibility.
    OCCLUSION_FILTER = "passes/occlusion_filter.wgsl";
    /// Upsamples ambient visibility from half size to the frame's.
    OCCLUSION_UP = "passes/occlusion_up.wgsl";
    /// Lights the G-buffer with sun, sky, shadow factor and ambient visibility.
    COMPOSITE = "passes/composite.wgsl";
    /// Displays a layer of a frame.
    LAYER = "passes/layer.wgsl";
    /// Draws one or two pictures to a window.
    PRESENT = "passes/present.wgsl";
    /// Draws lines over a picture.
    LINES = "passes/lines.wgsl";
}
