//! Parses and validates the shaders of the papers' techniques with naga, and checks every structure's layout
//! against naga's. No GPU is needed.

#![cfg(feature = "gpu")]

use std::path::Path;

use adumbra_papers::dag::DagLayout;
use adumbra_papers::techniques::look_up_of;
use adumbra_papers::techniques::shaders::{
    CUBES, CUBES_FIXED, CUBES_LEVEL, CUBES_LEVEL_PASS, CUBES_MAP, CUBES_PASS, CUBES_RECEIVER, DECODE_TEXTURE,
    GRAPH_LEVEL, STRUCTS, WORDS_TEXTURE, tree_declarations,
};
use adumbra_shaders::source::{
    self, FRAME, GRID, POINTS, RESOLVE, SURFACE, VIEW_DEPTH, VOXEL_FIXED, VOXEL_LEVEL_PASS, VOXEL_PARAMS,
    VOXEL_PASS, VOXEL_READS, WORDS_1, WORDS_6, WORDS_LOGGED,
};
use adumbra_shaders::{Source, assemble};
use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// A module's name and files.
type Module = (String, Vec<Source>);

/// The modules of a look-up that answers visibilities and levels, for pixels and for points, and visibilities
/// of receivers in fixed point.
fn modules_of(
    name: &str,
    look_up: &[Source],
    visibility: Source,
    levels: [Source; 2],
    fixed: Source,
) -> Vec<Module> {
    let passes = [("visibility", vec![visibility]), ("levels", levels.to_vec())];
    let asked = passes.into_iter().flat_map(|(what, passes)| {
        [RESOLVE, POINTS].map(|pass| {
            let files = [&[SURFACE, VIEW_DEPTH, FRAME], look_up, &passes, &[pass]].concat();
            (format!("{name}, {what}, {}", pass.name), files)
        })
    });
    let files = [&[SURFACE], look_up, &[visibility, fixed]].concat();
    asked.chain([(format!("{name}, fixed point"), files)]).collect()
}

/// All modules that the techniques assemble.
fn modules() -> Vec<Module> {
    let mut modules = vec![("decode".to_owned(), vec![tree_declarations(), WORDS_TEXTURE, DECODE_TEXTURE])];
    for access in [WORDS_1, WORDS_6, WORDS_TEXTURE] {
        let look_up = [tree_declarations(), GRID, CUBES, CUBES_RECEIVER, access, CUBES_MAP];
        let name = format!("tree, {}", access.name);
        modules.extend(modules_of(&name, &look_up, CUBES_PASS, [CUBES_LEVEL, CUBES_LEVEL_PASS], CUBES_FIXED));
    }
    for layout in [DagLayout::Plain, DagLayout::Packed] {
        for access in [WORDS_1, WORDS_6] {
            let look_up = [look_up_of(layout), vec![access, VOXEL_PARAMS]].concat();
            let name = format!("graph, {layout:?}, {}", access.name);
            let levels = [GRAPH_LEVEL, VOXEL_LEVEL_PASS];
            modules.extend(modules_of(&name, &look_up, VOXEL_PASS, levels, VOXEL_FIXED));
        }
        let reads =
            [vec![SURFACE], look_up_of(layout), vec![WORDS_LOGGED, VOXEL_PARAMS, VOXEL_READS]].concat();
        modules.push((format!("graph, {layout:?}, reads"), reads));
    }
    modules
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
fn every_wgsl_file_is_part_of_a_module() {
    let modules = modules();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("wgsl");
    for folder in ["core", "access", "passes"] {
        for file in root.join(folder).read_dir().unwrap() {
            let name = format!("{folder}/{}", file.unwrap().file_name().display());
            let used = modules.iter().any(|(_, files)| files.iter().any(|f| f.name == name));
            assert!(used, "{name} is in no module");
            assert!(source::by_path(&name).is_none(), "{name} is the name of a file of adumbra-shaders");
        }
    }
}

#[test]
fn shader_structures_match_rust_layout() {
    let module = module("structures", &[tree_declarations()]);
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
