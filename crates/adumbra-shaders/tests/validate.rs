//! Every shader parsed and validated by naga, and every structure's layout held against naga's; no GPU is needed.

use adumbra_shaders::assemble;
use adumbra_shaders::layout::STRUCTS;
use adumbra_shaders::source::{self, Source};
use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// Every module that a pass of `adumbra-render` is made from.
const MODULES: &[(&str, &[Source])] = &[
    ("gbuffer", &[source::GBUFFER]),
    ("map_depth", &[source::MAP_DEPTH]),
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
    (
        "hybrid square, paper's layout",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_MEAN,
            source::HYBRID_PAPER,
            source::HYBRID,
            source::HYBRID_BOX,
            source::HYBRID_PCF,
            source::HYBRID_MAP,
            source::RESOLVE,
        ],
    ),
    (
        "hybrid nearest, paper's layout",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_PAPER,
            source::HYBRID,
            source::HYBRID_NEAREST,
            source::HYBRID_MAP,
            source::RESOLVE,
        ],
    ),
    (
        "hybrid nearest, planes",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_COMPACT,
            source::HYBRID,
            source::HYBRID_NEAREST,
            source::HYBRID_MAP,
            source::RESOLVE,
        ],
    ),
    (
        "hybrid square, means",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_MEAN,
            source::HYBRID_COMPACT,
            source::HYBRID,
            source::HYBRID_BOX,
            source::HYBRID_PCF,
            source::HYBRID_MAP,
            source::RESOLVE,
        ],
    ),
    (
        "hybrid levels",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_COMPACT,
            source::HYBRID,
            source::HYBRID_LEVELS,
            source::RESOLVE,
        ],
    ),
    (
        "hybrid square, planes",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_COMPACT,
            source::HYBRID,
            source::HYBRID_BOX,
            source::HYBRID_PCF,
            source::HYBRID_MAP,
            source::RESOLVE,
        ],
    ),
    (
        "hybrid square, planes, paper's layout",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_PAPER,
            source::HYBRID,
            source::HYBRID_BOX,
            source::HYBRID_PCF,
            source::HYBRID_MAP,
            source::RESOLVE,
        ],
    ),
    (
        "hybrid square, points",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_COMPACT,
            source::HYBRID,
            source::HYBRID_BOX,
            source::HYBRID_PCF,
            source::HYBRID_MAP,
            source::POINTS,
        ],
    ),
    (
        "hybrid levels, paper's layout",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_PLANE,
            source::HYBRID_PAPER,
            source::HYBRID,
            source::HYBRID_LEVELS,
            source::RESOLVE,
        ],
    ),
    (
        "hybrid levels, means",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::HYBRID_MEAN,
            source::HYBRID_COMPACT,
            source::HYBRID,
            source::HYBRID_LEVELS,
            source::RESOLVE,
        ],
    ),
    ("map_normals", &[source::OCTAHEDRAL, source::MAP_DEPTH, source::MAP_NORMALS]),
    ("none", &[source::SURFACE, source::FRAME, source::NONE, source::RESOLVE]),
    ("none, points", &[source::SURFACE, source::NONE, source::POINTS]),
    (
        "voxel",
        &[
            source::SURFACE,
            source::FRAME,
            source::GRID,
            source::VOXEL,
            source::WORDS_1,
            source::VOXEL_PASS,
            source::RESOLVE,
        ],
    ),
    (
        "voxel in six bindings, fixed point",
        &[
            source::SURFACE,
            source::GRID,
            source::VOXEL,
            source::WORDS_6,
            source::VOXEL_PASS,
            source::VOXEL_FIXED,
        ],
    ),
    (
        "voxel-cubes, points",
        &[
            source::SURFACE,
            source::GRID,
            source::VOXEL_CUBES,
            source::VOXEL_CUBES_RECEIVER,
            source::WORDS_1,
            source::VOXEL_CUBES_PASS,
            source::POINTS,
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
            source::VOXEL_CUBES_PASS,
            source::VOXEL_CUBES_FIXED,
        ],
    ),
    ("decode_texture", &[source::WORDS_TEXTURE, source::DECODE_TEXTURE]),
    (
        "nearest",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::PCF,
            source::DISC,
            source::MAP_NEAREST,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    (
        "hardware",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::DISC,
            source::PCF,
            source::MAP_HARDWARE,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    (
        "pcf",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::DISC,
            source::PCF,
            source::MAP_PCF,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    (
        "poisson",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::DISC,
            source::PCF,
            source::MAP_POISSON,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    (
        "pcss",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::DISC,
            source::PCF,
            source::PCSS,
            source::MAP_PCSS,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    (
        "vsm",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::MOMENTS,
            source::VSM,
            source::MAP_MOMENTS,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    (
        "vsm, loaded",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::MOMENTS,
            source::VSM,
            source::MAP_MOMENTS_LOADED,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    ("vsm, rows", &[source::SURFACE, source::MAPS, source::MOMENTS, source::VSM, source::MOMENTS_ROWS]),
    ("vsm, columns", &[source::SURFACE, source::MAPS, source::MOMENTS, source::VSM, source::MOMENTS_COLUMNS]),
    ("vsm, mip", &[source::SURFACE, source::MAPS, source::MOMENTS, source::VSM, source::MOMENTS_MIP]),
    (
        "evsm",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::MOMENTS,
            source::EVSM,
            source::MAP_MOMENTS,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    (
        "evsm, loaded",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::MOMENTS,
            source::EVSM,
            source::MAP_MOMENTS_LOADED,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    ("evsm, rows", &[source::SURFACE, source::MAPS, source::MOMENTS, source::EVSM, source::MOMENTS_ROWS]),
    (
        "evsm, columns",
        &[source::SURFACE, source::MAPS, source::MOMENTS, source::EVSM, source::MOMENTS_COLUMNS],
    ),
    ("evsm, mip", &[source::SURFACE, source::MAPS, source::MOMENTS, source::EVSM, source::MOMENTS_MIP]),
    (
        "msm",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::MOMENTS,
            source::MSM,
            source::MAP_MOMENTS,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    (
        "msm, loaded",
        &[
            source::SURFACE,
            source::FRAME,
            source::MAPS,
            source::MOMENTS,
            source::MSM,
            source::MAP_MOMENTS_LOADED,
            source::MAP_LOOKUP,
            source::MAP_ONLY,
            source::RESOLVE,
        ],
    ),
    ("msm, rows", &[source::SURFACE, source::MAPS, source::MOMENTS, source::MSM, source::MOMENTS_ROWS]),
    ("msm, columns", &[source::SURFACE, source::MAPS, source::MOMENTS, source::MSM, source::MOMENTS_COLUMNS]),
    ("msm, mip", &[source::SURFACE, source::MAPS, source::MOMENTS, source::MSM, source::MOMENTS_MIP]),
    ("cascade", &[source::SURFACE, source::FRAME, source::MAP_CASCADE, source::RESOLVE]),
    ("blur", &[source::SURFACE, source::FRAME, source::BLUR, source::BLUR_PASS]),
    ("blur_pairs", &[source::BLUR_PAIRS]),
    ("blur_edges", &[source::SURFACE, source::FRAME, source::BLUR, source::BLUR_EDGES]),
    ("blur_half", &[source::BLUR_HALF]),
    ("blur_half_edges", &[source::SURFACE, source::FRAME, source::BLUR, source::BLUR_HALF_EDGES]),
    ("given", &[source::SURFACE, source::FRAME, source::GIVEN, source::RESOLVE]),
    ("composite", &[source::SURFACE, source::FRAME, source::COMPOSITE]),
    (
        "voxel+csm",
        &[
            source::SURFACE,
            source::FRAME,
            source::GRID,
            source::VOXEL,
            source::WORDS_6,
            source::MAPS,
            source::DISC,
            source::PCF,
            source::MAP_PCF,
            source::MAP_LOOKUP,
            source::VOXEL_CSM,
            source::RESOLVE,
        ],
    ),
];

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
    for (name, files) in MODULES {
        module(name, files);
    }
}

#[test]
fn every_file_is_in_a_module() {
    for file in source::ALL {
        let used = MODULES.iter().any(|(_, files)| files.iter().any(|f| f.name == file.name));
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
