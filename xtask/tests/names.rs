//! The page of the most used names has names that exist, each with one line.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The headings of the page, and the files that declare the names below each.
const FACES: [(&str, &[&str]); 5] = [
    ("Rust: read a file (`adumbra`)", &["docs/api.txt"]),
    ("Rust: shaders and streaming (`adumbra`)", &["docs/api.txt"]),
    ("Rust: bake (`adumbra-bake`)", &["docs/api-bake.txt"]),
    ("Bevy (`bevy_adumbra`)", &["integrations/bevy_adumbra/src/lib.rs"]),
    (
        "three.js (`adumbra-three`)",
        &[
            "integrations/three/src/index.ts",
            "integrations/three/src/webgpu/index.ts",
            "integrations/three/src/webgl/index.ts",
            "integrations/three/src/stream/index.ts",
            "integrations/three/src/path/index.ts",
        ],
    ),
];

#[test]
fn page_of_names_has_forty_that_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the folder of the workspace");
    let read = |name: &str| fs::read_to_string(root.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let page = read("docs/names.md");
    let sections: Vec<&str> = page.split("\n## ").skip(1).collect();
    assert_eq!(sections.len(), FACES.len());
    let mut names = BTreeSet::new();
    for (section, (title, files)) in sections.into_iter().zip(FACES) {
        let (heading, rows) = section.split_once('\n').unwrap_or_else(|| panic!("{section}"));
        assert_eq!(heading, title);
        let public: BTreeSet<String> =
            files.iter().flat_map(|name| public_items(name, &read(name))).collect();
        for row in rows.lines().filter_map(|line| line.strip_prefix("| `")) {
            let (name, line) = row.split_once("` | ").unwrap_or_else(|| panic!("{row}"));
            assert!(public.contains(name), "{name} is not in {files:?}");
            assert!(line.len() > 10 && line.matches('|').count() == 1, "{row}");
            assert!(names.insert((title, name)), "{name} is there twice");
        }
    }
    assert_eq!(names.len(), 40);
}

/// Returns the names of the items that a list of public items, a crate's root or a package's entry has.
fn public_items(file: &str, text: &str) -> Vec<String> {
    let words = |list: &str| -> Vec<String> {
        let words = list.split(|c: char| !c.is_alphanumeric() && c != '_');
        words.filter(|word| !word.is_empty()).map(str::to_owned).collect()
    };
    // Braces within the statements that begin so.
    let lists = |begin: &str| -> Vec<String> {
        let statements = text.split(begin).skip(1).filter_map(|rest| rest.split(';').next());
        let lists = statements.filter_map(|statement| statement.split_once('{')?.1.split('}').next());
        lists.flat_map(words).collect()
    };
    if file.ends_with(".txt") {
        let items = text.lines().filter(|line| !line.starts_with(' '));
        return items.filter_map(|line| line.split_once(' ')).map(|(_, name)| name.to_owned()).collect();
    }
    if file.ends_with(".ts") {
        return lists("\nexport ");
    }
    let single = text.lines().filter_map(|line| line.strip_prefix("pub ")).filter(|line| !line.contains('{'));
    let single = single.filter_map(|line| words(line).pop());
    single.chain(lists("\npub use ")).collect()
}

#[test]
fn only_public_items_count_as_names() {
    let items = "About the crate.\n\nstruct Bias\n    constant_texels\nstruct gpu::LookUp\n";
    assert!(!public_items("a.txt", items).contains(&"constant_texels".to_owned()));
    assert!(public_items("a.txt", items).contains(&"gpu::LookUp".to_owned()));
    let root = "use bevy::App;\n\npub use bake::{RuntimeBake,\n    BakeError};\npub use moving::SunKeys;\npub struct Plugin;\nfn a() { Shader }\n";
    assert_eq!(public_items("lib.rs", root), ["SunKeys", "Plugin", "RuntimeBake", "BakeError"]);
    let entry = "// text\n\nexport { A } from './error.js';\nexport type { B, C } from './b.js';\n";
    assert_eq!(public_items("index.ts", entry), ["A", "B", "C"]);
}
