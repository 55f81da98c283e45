//! Every shader parsed and validated by naga, and every structure's layout held against naga's; no GPU is needed.

use adumbra_shaders::assemble;
use adumbra_shaders::layout::STRUCTS;
use adumbra_shaders::source::{self, Source};
use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// What techniques answer with: put between [`source::SURFACE`], [`source::FRAME`] and the pass that asks, for pixels and for points.
const LOOK_UPS: &[(&str, &[Source])] = &[
    (
        "hybrid square, paper's layout",
        &[
            source::MAPS,
            source::HYBRID_MEAN,
            source::HYBRID_PAPER,
            source::HYBRID,
            source::HYBRID_BOX,
            source::HYBRID_PCF,
            source::HYBRID_MAP,
        ],
    ),
    (
        "hybrid nearest, paper's layout",
        &[
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_PAPER,
            source::HYBRID,
            source::HYBRID_NEAREST,
            source::HYBRID_MAP,
        ],
    ),
    (
        "hybrid nearest, planes",
        &[
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_COMPACT,
            source::HYBRID,
            source::HYBRID_NEAREST,
            source::HYBRID_MAP,
        ],
    ),
    (
        "hybrid square, means",
        &[
            source::MAPS,
            source::HYBRID_MEAN,
            source::HYBRID_COMPACT,
            source::HYBRID,
            source::HYBRID_BOX,
            source::HYBRID_PCF,
            source::HYBRID_MAP,
        ],
    ),
    (
        "voxel levels",
        &[
            source::GRID,
            source::VOXEL,
            source::VOXEL_GRAPH,
            source::VOXEL_PLAIN,
            source::WORDS_1,
            source::VOXEL_LEVEL,
            source::VOXEL_LEVEL_PASS,
        ],
    ),
    (
        "voxel levels, packed",
        &[
            source::GRID,
            source::VOXEL,
            source::VOXEL_GRAPH,
            source::VOXEL_PACKED,
            source::WORDS_6,
            source::VOXEL_LEVEL,
            source::VOXEL_LEVEL_PASS,
        ],
    ),
    (
        "hierarchy levels",
        &[
            source::GRID,
            source::VOXEL,
            source::HIERARCHY,
            source::WORDS_1,
            source::HIERARCHY_LEVEL,
            source::HIERARCHY_LEVEL_PASS,
        ],
    ),
    (
        "cubes levels",
        &[
            source::GRID,
            source::VOXEL_CUBES,
            source::VOXEL_CUBES_RECEIVER,
            source::WORDS_TEXTURE,
            source::VOXEL_CUBES_MAP,
            source::VOXEL_CUBES_LEVEL,
            source::VOXEL_CUBES_LEVEL_PASS,
        ],
    ),
    (
        "hybrid levels",
        &[source::MAPS, source::HYBRID_PLANE, source::HYBRID_COMPACT, source::HYBRID, source::HYBRID_LEVELS],
    ),
    (
        "hybrid square, planes",
        &[
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_COMPACT,
            source::HYBRID,
            source::HYBRID_BOX,
            source::HYBRID_PCF,
            source::HYBRID_MAP,
        ],
    ),
    (
        "hybrid square, planes, paper's layout",
        &[
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_PAPER,
            source::HYBRID,
            source::HYBRID_BOX,
            source::HYBRID_PCF,
            source::HYBRID_MAP,
        ],
    ),
    (
        "hybrid levels, paper's layout",
        &[source::MAPS, source::HYBRID_PLANE, source::HYBRID_PAPER, source::HYBRID, source::HYBRID_LEVELS],
    ),
    (
        "hybrid levels, means",
        &[source::MAPS, source::HYBRID_MEAN, source::HYBRID_COMPACT, source::HYBRID, source::HYBRID_LEVELS],
    ),
    ("none", &[source::NONE]),
    (
        "voxel, plain",
        &[
            source::GRID,
            source::VOXEL,
            source::VOXEL_GRAPH,
            source::VOXEL_PLAIN,
            source::WORDS_1,
            source::VOXEL_PASS,
        ],
    ),
    (
        "voxel, packed",
        &[
            source::GRID,
            source::VOXEL,
            source::VOXEL_GRAPH,
            source::VOXEL_PACKED,
            source::WORDS_1,
            source::VOXEL_PASS,
        ],
    ),
    (
        "voxel, hierarchy",
        &[source::GRID, source::VOXEL, source::HIERARCHY, source::WORDS_1, source::HIERARCHY_PASS],
    ),
    (
        "voxel:soft",
        &[
            source::GRID,
            source::VOXEL,
            source::HIERARCHY,
            source::DISC,
            source::HIERARCHY_SOFT,
            source::WORDS_6,
            source::HIERARCHY_SOFT_PASS,
        ],
    ),
    (
        "voxel-cubes",
        &[
            source::GRID,
            source::VOXEL_CUBES,
            source::VOXEL_CUBES_RECEIVER,
            source::WORDS_1,
            source::VOXEL_CUBES_MAP,
            source::VOXEL_CUBES_PASS,
        ],
    ),
    (
        "nearest",
        &[source::MAPS, source::PCF, source::DISC, source::MAP_NEAREST, source::MAP_LOOKUP, source::MAP_ONLY],
    ),
    (
        "hardware",
        &[
            source::MAPS,
            source::DISC,
            source::PCF,
            source::MAP_HARDWARE,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
        ],
    ),
    (
        "pcf",
        &[source::MAPS, source::DISC, source::PCF, source::MAP_PCF, source::MAP_LOOKUP, source::MAP_ONLY],
    ),
    (
        "poisson",
        &[source::MAPS, source::DISC, source::PCF, source::MAP_POISSON, source::MAP_LOOKUP, source::MAP_ONLY],
    ),
    (
        "pcss",
        &[
            source::MAPS,
            source::DISC,
            source::PCF,
            source::PCSS,
            source::MAP_PCSS,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
        ],
    ),
    (
        "vsm",
        &[
            source::MAPS,
            source::MOMENTS,
            source::VSM,
            source::MAP_MOMENTS,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
        ],
    ),
    (
        "vsm, loaded",
        &[
            source::MAPS,
            source::MOMENTS,
            source::VSM,
            source::MAP_MOMENTS_LOADED,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
        ],
    ),
    (
        "evsm",
        &[
            source::MAPS,
            source::MOMENTS,
            source::EVSM,
            source::MAP_MOMENTS,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
        ],
    ),
    (
        "evsm, loaded",
        &[
            source::MAPS,
            source::MOMENTS,
            source::EVSM,
            source::MAP_MOMENTS_LOADED,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
        ],
    ),
    (
        "msm",
        &[
            source::MAPS,
            source::MOMENTS,
            source::MSM,
            source::MAP_MOMENTS,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
        ],
    ),
    (
        "msm, loaded",
        &[
            source::MAPS,
            source::MOMENTS,
            source::MSM,
            source::MAP_MOMENTS_LOADED,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
        ],
    ),
    ("cascade", &[source::MAP_CASCADE]),
    ("given", &[source::GIVEN]),
    (
        "voxel+csm",
        &[
            source::GRID,
            source::VOXEL,
            source::VOXEL_GRAPH,
            source::VOXEL_PACKED,
            source::WORDS_6,
            source::MAPS,
            source::DISC,
            source::PCF,
            source::MAP_PCF,
            source::MAP_LOOKUP,
            source::VOXEL_CSM,
        ],
    ),
];

/// Every other module that a pass of `adumbra-render` is made from.
const MODULES: &[(&str, &[Source])] = &[
    ("gbuffer", &[source::INSTANCE, source::SRGB, source::GBUFFER]),
    ("map_depth", &[source::INSTANCE, source::MAP_DEPTH]),
    ("depth_image", &[source::DEPTH_IMAGE]),
    (
        "hybrid plane, sweep",
        &[source::HYBRID_PLANE, source::HYBRID_BUILD, source::HYBRID_MERGE_PLANE, source::HYBRID_SWEEP],
    ),
    (
        "hybrid plane, blocks",
        &[source::HYBRID_PLANE, source::HYBRID_BUILD, source::HYBRID_MERGE_PLANE, source::HYBRID_BLOCKS],
    ),
    (
        "hybrid mean, sweep",
        &[source::HYBRID_MEAN, source::HYBRID_BUILD, source::HYBRID_MERGE_MEAN, source::HYBRID_SWEEP],
    ),
    (
        "hybrid mean, blocks",
        &[source::HYBRID_MEAN, source::HYBRID_BUILD, source::HYBRID_MERGE_MEAN, source::HYBRID_BLOCKS],
    ),
    ("hybrid scan", &[source::HYBRID_BUILD, source::HYBRID_SCAN]),
    ("hybrid place", &[source::HYBRID_BUILD, source::HYBRID_PLACE]),
    (
        "hybrid place, paper's layout, means",
        &[
            source::HYBRID_MEAN,
            source::OCTAHEDRAL,
            source::HYBRID_NORMALS,
            source::HYBRID_BUILD,
            source::HYBRID_PLACE_PAPER,
        ],
    ),
    (
        "hybrid place, paper's layout, planes",
        &[
            source::HYBRID_PLANE,
            source::OCTAHEDRAL,
            source::HYBRID_NORMALS,
            source::HYBRID_BUILD,
            source::HYBRID_PLACE_PAPER,
        ],
    ),
    ("map_normals", &[source::OCTAHEDRAL, source::INSTANCE, source::MAP_DEPTH, source::MAP_NORMALS]),
    (
        "voxel in six bindings, fixed point",
        &[
            source::SURFACE,
            source::GRID,
            source::VOXEL,
            source::VOXEL_GRAPH,
            source::VOXEL_PLAIN,
            source::WORDS_6,
            source::VOXEL_PASS,
            source::VOXEL_FIXED,
        ],
    ),
    (
        "packed voxel in six bindings, fixed point",
        &[
            source::SURFACE,
            source::GRID,
            source::VOXEL,
            source::VOXEL_GRAPH,
            source::VOXEL_PACKED,
            source::WORDS_6,
            source::VOXEL_PASS,
            source::VOXEL_FIXED,
        ],
    ),
    (
        "hierarchy, fixed point",
        &[
            source::SURFACE,
            source::GRID,
            source::VOXEL,
            source::HIERARCHY,
            source::DISC,
            source::HIERARCHY_SOFT,
            source::WORDS_1,
            source::HIERARCHY_SOFT_PASS,
            source::HIERARCHY_FIXED,
        ],
    ),
    (
        "voxel-texture, fixed point",
        &[
            source::SURFACE,
            source::GRID,
            source::VOXEL_CUBES,
            source::VOXEL_CUBES_RECEIVER,
            source::WORDS_TEXTURE,
            source::VOXEL_CUBES_MAP,
            source::VOXEL_CUBES_PASS,
            source::VOXEL_CUBES_FIXED,
        ],
    ),
    ("decode_texture", &[source::WORDS_TEXTURE, source::DECODE_TEXTURE]),
    ("vsm, rows", &[source::SURFACE, source::MAPS, source::MOMENTS, source::VSM, source::MOMENTS_ROWS]),
    ("vsm, columns", &[source::SURFACE, source::MAPS, source::MOMENTS, source::VSM, source::MOMENTS_COLUMNS]),
    ("vsm, mip", &[source::SURFACE, source::MAPS, source::MOMENTS, source::VSM, source::MOMENTS_MIP]),
    ("evsm, rows", &[source::SURFACE, source::MAPS, source::MOMENTS, source::EVSM, source::MOMENTS_ROWS]),
    (
        "evsm, columns",
        &[source::SURFACE, source::MAPS, source::MOMENTS, source::EVSM, source::MOMENTS_COLUMNS],
    ),
    ("evsm, mip", &[source::SURFACE, source::MAPS, source::MOMENTS, source::EVSM, source::MOMENTS_MIP]),
    ("msm, rows", &[source::SURFACE, source::MAPS, source::MOMENTS, source::MSM, source::MOMENTS_ROWS]),
    ("msm, columns", &[source::SURFACE, source::MAPS, source::MOMENTS, source::MSM, source::MOMENTS_COLUMNS]),
    ("msm, mip", &[source::SURFACE, source::MAPS, source::MOMENTS, source::MSM, source::MOMENTS_MIP]),
    ("blur", &[source::SURFACE, source::FRAME, source::BLUR, source::BLUR_PASS]),
    ("blur_pairs", &[source::BLUR_PAIRS]),
    ("blur_edges", &[source::SURFACE, source::FRAME, source::BLUR, source::BLUR_EDGES]),
    ("blur_half", &[source::BLUR_HALF]),
    ("blur_half_edges", &[source::SURFACE, source::FRAME, source::BLUR, source::BLUR_HALF_EDGES]),
    ("occlusion, surface", &[source::OCCLUSION_SURFACE]),
    (
        "issao",
        &[source::OCCLUSION, source::OCCLUSION_PASS, source::OCCLUSION_ISSAO, source::OCCLUSION_ISSAO_TERM],
    ),
    (
        "issao, second reading",
        &[
            source::OCCLUSION,
            source::OCCLUSION_PASS,
            source::OCCLUSION_ISSAO,
            source::OCCLUSION_ISSAO_FALLOFF,
        ],
    ),
    (
        "issao, no attenuation",
        &[source::OCCLUSION, source::OCCLUSION_PASS, source::OCCLUSION_ISSAO, source::OCCLUSION_ISSAO_BARE],
    ),
    ("ssao", &[source::OCCLUSION, source::OCCLUSION_PASS, source::OCCLUSION_SSAO]),
    ("alchemy", &[source::OCCLUSION, source::OCCLUSION_PASS, source::OCCLUSION_ALCHEMY]),
    ("hbao", &[source::OCCLUSION, source::OCCLUSION_PASS, source::OCCLUSION_MARCH, source::OCCLUSION_HBAO]),
    ("gtao", &[source::OCCLUSION, source::OCCLUSION_PASS, source::OCCLUSION_MARCH, source::OCCLUSION_GTAO]),
    ("occlusion, normals", &[source::OCCLUSION_NORMALS]),
    ("occlusion, history", &[source::OCCLUSION, source::OCCLUSION_HISTORY]),
    ("occlusion, filter", &[source::OCCLUSION_PLANE, source::OCCLUSION_FILTER]),
    ("occlusion, up", &[source::OCCLUSION_PLANE, source::OCCLUSION_UP]),
    ("composite", &[source::SURFACE, source::FRAME, source::SRGB, source::COMPOSITE]),
    ("layer", &[source::SURFACE, source::FRAME, source::SRGB, source::LAYER]),
    ("present", &[source::SRGB, source::PRESENT]),
    ("lines", &[source::LINES]),
];

/// All of them by name.
fn modules() -> Vec<(String, Vec<Source>)> {
    let asked = LOOK_UPS.iter().flat_map(|(name, files)| {
        [source::RESOLVE, source::POINTS].map(|pass| {
            let all = [source::SURFACE, source::FRAME].into_iter().chain(files.iter().copied());
            (format!("{name}, {}", pass.name), all.chain([pass]).collect())
        })
    });
    let others = MODULES.iter().map(|(name, files)| ((*name).to_owned(), files.to_vec()));
    asked.chain(others).collect()
}

fn module(name: &str, files: &[Source]) -> naga::Module {
    let text = assemble(files);
    let module =
        naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&text)));
    if let Err(e) = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module) {
        panic!("{name}: {}", e.emit_to_string(&text));
    }
    module
}

#[test]
fn every_module_is_valid_without_a_gpu() {
    for (name, files) in modules() {
        module(&name, &files);
    }
}

#[test]
fn every_file_is_in_a_module() {
    let modules = modules();
    for file in source::ALL {
        let used = modules.iter().any(|(_, files)| files.iter().any(|f| f.name == file.name));
        assert!(used, "{} is in no module", file.name);
    }
}

#[test]
fn structures_have_the_layout_that_rust_writes() {
    let module = module("structures", &[]);
    for expected in STRUCTS {
        let (_, found) = module
            .types
            .iter()
            .find(|(_, t)| t.name.as_deref() == Some(expected.name))
            .unwrap_or_else(|| panic!("{} is not in the module", expected.name));
        let TypeInner::Struct { members, span } = &found.inner else { panic!("{}", expected.name) };
        assert_eq!(*span as usize, expected.size, "{}", expected.name);
        let offsets: Vec<_> =
            members.iter().map(|m| (m.name.as_deref().unwrap_or_default(), m.offset as usize)).collect();
        assert_eq!(offsets, (expected.fields)(), "{}", expected.name);
    }
}
