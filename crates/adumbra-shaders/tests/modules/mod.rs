//! All modules that the passes of `adumbra-render` use, as lists of file names.

use adumbra_shaders::source::{self, Source};

/// The files of each technique. They go between core/surface, core/view_depth, core/frame and the pass that
/// evaluates the technique, for pixels or for points.
const LOOK_UPS: &[(&str, &str)] = &[
    (
        "hybrid square, paper's layout",
        "core/map_layer core/maps core/hybrid_mean access/hybrid_paper core/hybrid core/hybrid_box \
         passes/hybrid_pcf passes/hybrid_map",
    ),
    (
        "hybrid nearest, paper's layout",
        "core/map_layer core/maps core/hybrid_plane access/hybrid_paper core/hybrid passes/hybrid_nearest \
         passes/hybrid_map",
    ),
    (
        "hybrid nearest, planes",
        "core/map_layer core/maps core/hybrid_plane access/hybrid_compact core/hybrid passes/hybrid_nearest \
         passes/hybrid_map",
    ),
    (
        "hybrid square, means",
        "core/map_layer core/maps core/hybrid_mean access/hybrid_compact core/hybrid core/hybrid_box \
         passes/hybrid_pcf passes/hybrid_map",
    ),
    (
        "voxel levels",
        "core/grid core/voxel core/depths core/depths_leaf access/words_1 access/voxel_params \
         core/depths_level passes/voxel_level",
    ),
    (
        "hybrid levels",
        "core/map_layer core/maps core/hybrid_plane access/hybrid_compact core/hybrid passes/hybrid_levels",
    ),
    (
        "hybrid square, planes",
        "core/map_layer core/maps core/hybrid_plane access/hybrid_compact core/hybrid core/hybrid_box \
         passes/hybrid_pcf passes/hybrid_map",
    ),
    (
        "hybrid square, planes, paper's layout",
        "core/map_layer core/maps core/hybrid_plane access/hybrid_paper core/hybrid core/hybrid_box \
         passes/hybrid_pcf passes/hybrid_map",
    ),
    (
        "hybrid levels, paper's layout",
        "core/map_layer core/maps core/hybrid_plane access/hybrid_paper core/hybrid passes/hybrid_levels",
    ),
    (
        "hybrid levels, means",
        "core/map_layer core/maps core/hybrid_mean access/hybrid_compact core/hybrid passes/hybrid_levels",
    ),
    ("none", "passes/none"),
    (
        "voxel",
        "core/grid core/voxel core/depths core/depths_leaf access/words_1 access/voxel_params passes/voxel",
    ),
    (
        "voxel, streamed",
        "core/grid core/voxel core/depths core/depths_leaf access/words_1 core/depths_blend access/voxel_levels passes/voxel",
    ),
    (
        "voxel:soft, streamed",
        "core/grid core/voxel core/depths core/depths_leaf core/disc core/depths_soft access/words_6 \
         core/depths_blend access/voxel_levels access/voxel_levels_soft passes/voxel_soft",
    ),
    (
        "voxel levels, streamed",
        "core/grid core/voxel core/depths core/depths_leaf access/words_1 core/depths_blend access/voxel_levels \
         core/depths_level passes/voxel_levels_block",
    ),
    (
        "resident levels",
        "core/grid core/voxel core/depths core/depths_leaf access/words_1 core/depths_blend access/voxel_levels \
         passes/voxel_levels_resident",
    ),
    (
        "voxel, sun path",
        "core/grid core/voxel core/depths core/depths_leaf core/depths_march access/words_6 access/voxel_path \
         access/voxel_path_filter passes/voxel",
    ),
    (
        "voxel, sun path, disc",
        "core/grid core/voxel core/depths core/depths_leaf core/depths_march core/disc access/words_6 access/voxel_path \
         access/voxel_path_disc passes/voxel",
    ),
    (
        "voxel, R32Uint texture",
        "core/grid core/voxel core/depths core/depths_leaf core/depths_blend core/disc core/depths_soft \
         access/texture_r32uint access/look_up_texture access/look_up_parameters access/look_up_file passes/voxel",
    ),
    (
        "voxel, Rgba8Unorm texture",
        "core/grid core/voxel core/depths core/depths_leaf core/depths_blend core/disc core/depths_soft \
         access/texture_rgba8unorm access/look_up_texture access/look_up_parameters access/look_up_file \
         passes/voxel_soft",
    ),
    (
        "voxel:soft",
        "core/grid core/voxel core/depths core/depths_leaf core/disc core/depths_soft access/words_6 \
         access/voxel_params access/voxel_params_soft passes/voxel_soft",
    ),
    (
        "nearest",
        "core/map_layer core/maps core/pcf core/disc passes/map_nearest passes/map_lookup passes/map_only",
    ),
    (
        "hardware",
        "core/map_layer core/maps core/disc core/pcf passes/map_hardware passes/map_lookup passes/map_only",
    ),
    ("pcf", "core/map_layer core/maps core/disc core/pcf passes/map_pcf passes/map_lookup passes/map_only"),
    (
        "poisson",
        "core/map_layer core/maps core/disc core/pcf passes/map_poisson passes/map_lookup passes/map_only",
    ),
    (
        "pcss",
        "core/map_layer core/maps core/disc core/pcf core/pcss passes/map_pcss passes/map_lookup \
         passes/map_only",
    ),
    (
        "vsm",
        "core/map_layer core/maps core/moments core/vsm passes/map_moments passes/map_lookup passes/map_only",
    ),
    (
        "vsm, loaded",
        "core/map_layer core/maps core/moments core/vsm passes/map_moments_loaded passes/map_lookup \
         passes/map_only",
    ),
    (
        "evsm",
        "core/map_layer core/maps core/moments core/evsm passes/map_moments passes/map_lookup passes/map_only",
    ),
    (
        "evsm, loaded",
        "core/map_layer core/maps core/moments core/evsm passes/map_moments_loaded passes/map_lookup \
         passes/map_only",
    ),
    (
        "msm",
        "core/map_layer core/maps core/moments core/msm passes/map_moments passes/map_lookup passes/map_only",
    ),
    (
        "msm, loaded",
        "core/map_layer core/maps core/moments core/msm passes/map_moments_loaded passes/map_lookup \
         passes/map_only",
    ),
    ("cascade", "passes/map_cascade"),
    ("given", "passes/given"),
    (
        "voxel+csm",
        "core/grid core/voxel core/depths core/depths_leaf access/words_1 core/map_layer core/maps core/disc \
         core/pcf passes/map_pcf passes/map_lookup access/voxel_params passes/voxel_csm",
    ),
];

/// All other modules.
const MODULES: &[(&str, &str)] = &[
    ("gbuffer", "core/instance core/srgb passes/scene_corner passes/gbuffer"),
    ("map_depth", "core/instance passes/scene_corner core/map_layer passes/map_depth"),
    ("depth_image", "passes/depth_image"),
    (
        "hybrid plane, sweep",
        "core/hybrid_plane passes/hybrid_build passes/hybrid_merge_plane passes/hybrid_sweep",
    ),
    (
        "hybrid plane, blocks",
        "core/hybrid_plane passes/hybrid_build passes/hybrid_merge_plane passes/hybrid_blocks",
    ),
    (
        "hybrid mean, sweep",
        "core/hybrid_mean passes/hybrid_build passes/hybrid_merge_mean passes/hybrid_sweep",
    ),
    (
        "hybrid mean, blocks",
        "core/hybrid_mean passes/hybrid_build passes/hybrid_merge_mean passes/hybrid_blocks",
    ),
    ("hybrid scan", "passes/hybrid_build passes/hybrid_scan"),
    ("hybrid place", "passes/hybrid_build passes/hybrid_place"),
    (
        "hybrid place, paper's layout, means",
        "core/hybrid_mean core/octahedral core/hybrid_normals passes/hybrid_build passes/hybrid_place_paper",
    ),
    (
        "hybrid place, paper's layout, planes",
        "core/hybrid_plane core/octahedral core/hybrid_normals passes/hybrid_build passes/hybrid_place_paper",
    ),
    (
        "map_normals",
        "core/octahedral core/instance passes/scene_corner core/map_layer passes/map_depth passes/map_normals",
    ),
    (
        "voxel in six bindings, fixed point",
        "core/surface core/grid core/voxel core/depths core/depths_leaf access/words_6 access/voxel_params \
         passes/voxel_fixed",
    ),
    (
        "marches, fixed point",
        "core/surface core/grid core/voxel core/depths core/depths_leaf core/depths_march access/words_1 \
         access/voxel_path access/voxel_path_filter passes/march_fixed",
    ),
    (
        "words that a look-up between keys reads",
        "core/surface core/grid core/voxel core/depths core/depths_leaf core/depths_march access/words_logged \
         access/voxel_path access/voxel_path_filter passes/path_reads",
    ),
    (
        "words that a look-up reads",
        "core/surface core/grid core/voxel core/depths core/depths_leaf access/words_logged access/voxel_params \
         passes/voxel_reads",
    ),
    (
        "penumbrae, fixed point",
        "core/surface core/grid core/voxel core/depths core/depths_leaf core/disc core/depths_soft \
         access/words_1 access/voxel_params access/voxel_params_soft passes/voxel_soft passes/depths_fixed",
    ),
    (
        "an engine's functions",
        "core/surface core/grid core/voxel core/depths core/depths_leaf core/disc core/depths_soft \
         access/words_1 access/voxel_params access/voxel_params_soft access/visibility",
    ),
    (
        "vsm, rows",
        "core/surface core/map_layer core/maps core/moments core/vsm passes/moments_line passes/moments_rows",
    ),
    (
        "vsm, columns",
        "core/surface core/map_layer core/maps core/moments core/vsm passes/moments_line \
         passes/moments_columns",
    ),
    ("vsm, mip", "core/surface core/map_layer core/maps core/moments core/vsm passes/moments_mip"),
    (
        "evsm, rows",
        "core/surface core/map_layer core/maps core/moments core/evsm passes/moments_line passes/moments_rows",
    ),
    (
        "evsm, columns",
        "core/surface core/map_layer core/maps core/moments core/evsm passes/moments_line \
         passes/moments_columns",
    ),
    ("evsm, mip", "core/surface core/map_layer core/maps core/moments core/evsm passes/moments_mip"),
    (
        "msm, rows",
        "core/surface core/map_layer core/maps core/moments core/msm passes/moments_line passes/moments_rows",
    ),
    (
        "msm, columns",
        "core/surface core/map_layer core/maps core/moments core/msm passes/moments_line \
         passes/moments_columns",
    ),
    ("msm, mip", "core/surface core/map_layer core/maps core/moments core/msm passes/moments_mip"),
    ("blur", "core/surface core/view_depth core/frame core/blur passes/blur_factor passes/blur"),
    ("blur_pairs", "passes/blur_factor passes/blur_pairs"),
    (
        "blur_edges",
        "core/surface core/view_depth core/frame core/blur passes/blur_factor passes/blur_surfaces \
         passes/blur_edges",
    ),
    ("blur_half", "passes/blur_factor passes/blur_half"),
    (
        "blur_half_edges",
        "core/surface core/view_depth core/frame core/blur passes/blur_factor passes/blur_surfaces \
         passes/blur_half_edges",
    ),
    ("occlusion, surface", "core/view_depth passes/occlusion_surface"),
    ("issao", "core/occlusion passes/occlusion passes/occlusion_issao passes/occlusion_issao_term"),
    (
        "issao, second reading",
        "core/occlusion passes/occlusion passes/occlusion_issao passes/occlusion_issao_falloff",
    ),
    (
        "issao, no attenuation",
        "core/occlusion passes/occlusion passes/occlusion_issao passes/occlusion_issao_bare",
    ),
    ("ssao", "core/occlusion passes/occlusion passes/occlusion_ssao"),
    ("alchemy", "core/occlusion passes/occlusion passes/occlusion_alchemy"),
    ("hbao", "core/occlusion passes/occlusion passes/occlusion_march passes/occlusion_hbao"),
    ("gtao", "core/occlusion passes/occlusion passes/occlusion_march passes/occlusion_gtao"),
    ("occlusion, normals", "core/occlusion passes/occlusion_normals"),
    ("occlusion, history", "core/occlusion passes/occlusion_history"),
    ("occlusion, filter", "core/occlusion_plane passes/occlusion_filter"),
    ("occlusion, up", "core/view_depth core/occlusion_plane passes/occlusion_up"),
    ("composite", "core/surface core/view_depth core/frame core/srgb passes/composite"),
    ("layer", "core/surface core/view_depth core/frame core/srgb passes/layer"),
    ("present", "core/srgb passes/present"),
    ("lines", "passes/lines"),
];

fn files(names: &str) -> Vec<Source> {
    let file = |name: &str| {
        let path = format!("{name}.wgsl");
        source::by_path(&path).unwrap_or_else(|| panic!("{path} is no file"))
    };
    names.split_whitespace().map(file).collect()
}

/// All modules by name.
pub(crate) fn modules() -> Vec<(String, Vec<Source>)> {
    let asked = LOOK_UPS.iter().flat_map(|(name, names)| {
        [source::RESOLVE, source::POINTS].map(|pass| {
            let before = vec![source::SURFACE, source::VIEW_DEPTH, source::FRAME];
            (format!("{name}, {}", pass.name), [before, files(names), vec![pass]].concat())
        })
    });
    let others = MODULES.iter().map(|(name, names)| ((*name).to_owned(), files(names)));
    asked.chain(others).collect()
}
