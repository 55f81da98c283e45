//! The page of the most used names has names that exist, each with one line.

use std::fs;
use std::path::Path;

#[test]
fn page_of_names_has_forty_that_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the folder of the workspace");
    let read = |name: &str| fs::read_to_string(root.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let page = read("docs/names.md");
    let faces = [
        ("## Rust: read a file", vec!["docs/api.txt"]),
        ("## Rust: shaders and streaming", vec!["docs/api.txt"]),
        ("## Rust: bake", vec!["docs/api-bake.txt"]),
        ("## Bevy", vec!["integrations/bevy_adumbra/src/lib.rs"]),
        (
            "## three.js",
            ["index", "webgpu/index", "webgl/index", "stream/index", "path/index"]
                .map(|entry| format!("integrations/three/src/{entry}.ts"))
                .map(|name| &*name.leak())
                .to_vec(),
        ),
    ];
    let mut names = 0;
    for section in page.split("\n## ").skip(1) {
        let title = format!("## {}", section.lines().next().unwrap_or_default());
        let (_, files) = faces.iter().find(|(face, _)| *face == title).unwrap_or_else(|| panic!("{title}"));
        let known: String = files.iter().map(|name| read(name)).collect();
        let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let known: Vec<&str> = known.split(|c| !is_part(c)).collect();
        for row in section.lines().filter_map(|line| line.strip_prefix("| `")) {
            let (name, line) = row.split_once("` | ").unwrap_or_else(|| panic!("{row}"));
            assert!(known.contains(&name), "{name} is not in {files:?}");
            assert!(line.len() > 10 && line.matches('|').count() == 1, "{row}");
            names += 1;
        }
    }
    assert_eq!(names, 40);
}
