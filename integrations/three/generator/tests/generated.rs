//! The committed look-ups of web pages equal those generated from the workspace's WGSL.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

#[test]
fn committed_look_ups_are_the_generated_ones() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../src/generated");
    let files = adumbra_three_generator::generate().expect("shaders");
    let names: BTreeSet<&str> = files.iter().map(|file| file.name.as_str()).collect();
    let found = fs::read_dir(&folder).expect("the folder of generated files");
    let found: Vec<_> = found.map(|entry| entry.expect("entry").file_name()).collect();
    assert_eq!(names, found.iter().filter_map(|name| name.to_str()).collect());
    for file in &files {
        let committed = fs::read_to_string(folder.join(&file.name)).expect("a generated file");
        assert!(committed == file.text, "{} is not up to date; run: cargo xtask shaders-web", file.name);
    }
}

#[test]
fn committed_answers_equal_those_of_the_crate() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for file in adumbra_three_generator::golden(&package.join("../../test_vectors")).expect("answers") {
        let committed = fs::read_to_string(package.join("tests/golden").join(&file.name)).expect("the file");
        assert!(committed == file.text, "{} is not up to date; run: cargo xtask shaders-web", file.name);
    }
}

#[test]
fn texts_declare_no_textures_and_no_entry_point() {
    for file in adumbra_three_generator::generate().expect("shaders") {
        for word in ["@group", "uniform", "void main", "@fragment", "#version", "_group_", "${"] {
            assert!(!file.text.contains(word), "{} contains {word}", file.name);
        }
        for name in ["adumbra_words", "adumbra_headers", "adumbra_visibility"] {
            assert!(file.text.contains(name), "{} has no {name}", file.name);
        }
    }
}

/// A page may put the look-ups of two lights into one shader, and gives each a prefix in place of `adumbra`.
#[test]
fn all_names_of_a_text_have_the_prefix() {
    for file in adumbra_three_generator::generate().expect("shaders") {
        let is_wgsl = file.name.contains("wgsl");
        let mut depth = 0;
        for line in file.text.lines().skip(1) {
            let line = line.trim_start_matches("const text: string = `");
            if depth == 0 && !matches!(line, "}" | "};" | "`;" | "" | "export default text;") {
                let name = match line.split(['(', '{', '=', ':', ';', '[']).next() {
                    Some(start) if is_wgsl => start.split_whitespace().last(),
                    Some(start) => {
                        start.split_whitespace().nth(if line.starts_with("const") { 2 } else { 1 })
                    }
                    None => None,
                };
                let name = name.unwrap_or_default();
                assert!(name.to_lowercase().contains("adumbra"), "{}: {line}", file.name);
            }
            depth += line.matches('{').count() as i32 - line.matches('}').count() as i32;
        }
        assert_eq!(depth, 0, "{}", file.name);
    }
}
