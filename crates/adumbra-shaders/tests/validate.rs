//! Parses and validates every shader with naga, and checks every structure's layout against naga's. No GPU is
//! needed.

mod modules;

use adumbra_shaders::layout::STRUCTS;
use adumbra_shaders::source::{self, Source};
use adumbra_shaders::{assemble, constants, identifiers};
use modules::modules;
use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

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
    // A text that uses all structures.
    let fields: String = STRUCTS.iter().map(|s| format!("    of_{0}: {0},\n", s.name)).collect();
    let text = format!("struct All {{\n{fields}}}\n").leak();
    let module = module("structures", &[Source { name: "all", text }]);
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

/// Names that a text declares at module scope with the given keyword.
fn declared<'t>(text: &'t str, keyword: &str) -> Vec<&'t str> {
    let lines = text.lines().filter_map(|line| line.strip_prefix(keyword)?.strip_prefix(' '));
    lines.filter_map(|line| identifiers(line).next()).collect()
}

/// Structures of a module that are declared but never used.
fn unused_structs(text: &str) -> Vec<&str> {
    declared(text, "struct")
        .into_iter()
        .filter(|name| identifiers(text).filter(|i| i == name).count() < 2)
        .collect()
}

#[test]
fn modules_contain_only_the_shared_items_that_they_use() {
    for (name, files) in modules() {
        let text = assemble(&files);
        assert_eq!(unused_structs(&text), Vec::<&str>::new(), "{name}");
        for constant in declared(&text, "const").into_iter().filter(|c| c.starts_with("ADUMBRA_")) {
            assert!(identifiers(&text).filter(|i| *i == constant).count() > 1, "{name}: {constant}");
        }
    }
    let look_up = [
        source::SURFACE,
        source::GRID,
        source::VOXEL,
        source::DEPTHS,
        source::DEPTHS_LEAF,
        source::WORDS_1,
        source::VOXEL_PARAMS,
        source::VOXEL_PASS,
    ];
    let text = assemble(&look_up);
    let shared: Vec<_> =
        STRUCTS.iter().map(|s| s.name).filter(|s| declared(&text, "struct").contains(s)).collect();
    assert_eq!(shared, ["AdumbraReceiverBias", "AdumbraGridTransform", "AdumbraVoxelParams"]);
}

#[test]
fn names_in_engine_includes_have_the_prefix() {
    let shared =
        STRUCTS.iter().map(|s| s.name).chain(constants::declarations().into_iter().map(|(name, _)| name));
    for name in shared {
        assert!(name.to_ascii_lowercase().starts_with("adumbra"), "{name}");
    }
    for file in source::ALL.iter().filter(|f| f.name.starts_with("core/") || f.name.starts_with("access/")) {
        for (keyword, prefix) in
            [("fn", "adumbra_"), ("struct", "Adumbra"), ("alias", "Adumbra"), ("const", "ADUMBRA_")]
        {
            for name in declared(file.text, keyword) {
                assert!(name.starts_with(prefix), "{}: {name}", file.name);
            }
        }
        // In `@group(…) @binding(…) var<…> name: type;` the name is the last word before the colon.
        for binding in file.text.lines().filter(|line| line.starts_with('@')) {
            let name = binding.split(':').next().and_then(|declared| declared.rsplit(' ').next());
            assert!(name.is_some_and(|name| name.starts_with("adumbra_")), "{}: {binding}", file.name);
        }
    }
}
