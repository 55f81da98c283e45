//! Checks that no source compares a technique's name with a string. Only the registry knows the names;
//! everything else queries it.

use std::fs;
use std::path::{Path, PathBuf};

use adumbra_papers::techniques;
use adumbra_render::TECHNIQUES;

/// The registries of techniques, of ambient occlusion and of the papers' techniques. Ambient occlusion has
/// its own `none` and `truth`.
const REGISTRIES: [&str; 3] = [
    "crates/adumbra-render/src/techniques/product.rs",
    "crates/adumbra-render/src/occlusion/spec.rs",
    "lab/papers/src/techniques/mod.rs",
];
/// Names that are also everyday words or sections of the report. A comparison with them counts only if it
/// involves `.name()`.
const EVERYDAY: [&str; 5] = ["none", "truth", "blur", "hrsm", "sm"];
const COMPARING_CALLS: [&str; 5] = ["starts_with(", "ends_with(", "strip_prefix(", "contains(", ".eq("];

#[test]
fn technique_names_are_compared_only_in_registries() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut files = Vec::new();
    for folder in ["crates", "lab", "xtask/src"] {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 300, "only {} sources found", files.len());
    let mut found = Vec::new();
    for file in files {
        let path = file.strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/");
        if !REGISTRIES.contains(&path.as_str()) {
            let text = fs::read_to_string(&file).unwrap();
            found.extend(comparisons(&text).into_iter().map(|(line, name)| format!("{path}:{line}: {name}")));
        }
    }
    assert!(found.is_empty(), "ask TechniqueSpec or TechniqueEntry instead:\n{}", found.join("\n"));
}

#[test]
fn comparisons_with_technique_names_are_recognised() {
    for text in [
        r#"if spec.name() == "voxel" {}"#,
        r#"if "csm-vsm" != name {}"#,
        r#"if spec.name() == "truth" {}"#,
        r#"let soft = value == Some("voxel:soft");"#,
        r#"name.starts_with("voxel-")"#,
        r#"name.starts_with("csm")"#,
        r#"matches!(spec.innermost().name(), "voxel" | "voxel+csm")"#,
        r#"matches!(name, "pcss")"#,
        "match spec.name() {\n    \"none\" => 1,\n    _ => 2,\n}",
        r#"match name { "evsm" | "msm" => 1, _ => 2 }"#,
        r#"match name { Some("pcf") if deep => 1, _ => 2 }"#,
    ] {
        assert!(!comparisons(text).is_empty(), "{text}");
    }
    for text in [
        r#"build(gpu, &"none".parse()?, baked)"#,
        r#"// if name == "voxel""#,
        r#"let names = ["voxel", "csm"];"#,
        r#"if section == "blur" {}"#,
        r#"match section { "tree" | "hrsm" => 1, _ => 2 }"#,
        r#"names.map(|name| "csm")"#,
        r#"("blur-bilateral", "blurred within surfaces") => 3"#.split(" =>").next().unwrap(),
        r#"matches!(news, News::Baking { .. }); let name = (kind, "voxel");"#,
        "#[cfg(test)]\nmod tests { fn f() { assert!(name == \"voxel\"); } }",
    ] {
        assert_eq!(comparisons(text), [], "{text}");
    }
}

/// Collects the Rust sources under `folder` except tests.
fn sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && !matches!(name.as_str(), "tests" | "target") {
            sources(&path, files);
        } else if name.ends_with(".rs") && name != "tests.rs" {
            files.push(path);
        }
    }
}

/// Returns the line and text of each string in a source's production code that is compared with a technique's
/// name.
fn comparisons(source: &str) -> Vec<(usize, String)> {
    let source = source.split("#[cfg(test)]").next().unwrap_or_default();
    let compared = |(at, end): &(usize, usize)| {
        let value = &source[at + 1..end - 1];
        is_technique(value) && is_compared(&source[..*at], &source[*end..], value)
    };
    let line = |at: usize| source[..at].matches('\n').count() + 1;
    strings(source)
        .iter()
        .filter(|s| compared(s))
        .map(|&(at, end)| (line(at), source[at..end].to_owned()))
        .collect()
}

/// Whether a string is a technique's name, with or without parameters, or the beginning of one up to a
/// `-` or `+`.
fn is_technique(value: &str) -> bool {
    let name = value.split(':').next().unwrap_or_default();
    let mut known = TECHNIQUES.iter().chain(techniques::TECHNIQUES);
    known.any(|t| t.name == name || value.ends_with(['-', '+']) && t.name.starts_with(value))
}

fn is_compared(before: &str, after: &str, value: &str) -> bool {
    let before = before.trim_end().trim_end_matches(['&', '*']).trim_end();
    let before = before.strip_suffix("Some(").unwrap_or(before).trim_end();
    let after = after.trim_start();
    let closed = after.trim_start_matches(')').trim_start();
    let everyday = EVERYDAY.contains(&value);
    if COMPARING_CALLS.iter().any(|call| before.ends_with(call)) {
        return !everyday || before.rsplit([';', '{', '\n']).next().is_some_and(|b| b.contains("name"));
    }
    if ["==", "!="].iter().any(|sign| before.ends_with(sign) || closed.starts_with(sign)) {
        let other = before.rsplit([';', '{', '\n']).next().unwrap_or_default();
        return !everyday
            || other.contains(".name()")
            || after.lines().next().unwrap_or_default().contains(".name()");
    }
    let is_or = closed.starts_with('|') && !closed.starts_with("||");
    let is_arm = closed.starts_with("=>") || closed.starts_with("if ") || is_or;
    let matched = before.rfind("match ").map(|at| before[at..].split('{').next().unwrap_or_default());
    let asked = before.rfind("matches!(").map(|at| &before[at..]).filter(|b| is_open(b));
    match (asked, matched) {
        (Some(asked), _) => !everyday || asked.contains(".name()"),
        (None, Some(matched)) if is_arm => !everyday || matched.contains(".name()"),
        _ => false,
    }
}

/// Whether the first parenthesis that opens in `text` is not closed in it.
fn is_open(text: &str) -> bool {
    let mut depth = 0;
    let mut changes = text.bytes().filter_map(|b| match b {
        b'(' => Some(1),
        b')' => Some(-1),
        _ => None,
    });
    changes.all(|change| {
        depth += change;
        depth > 0
    })
}

/// Returns the begin and end of each plain string, including its quotes. Comments and character literals are
/// skipped.
fn strings(source: &str) -> Vec<(usize, usize)> {
    let bytes = source.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        match bytes[at] {
            b'/' if bytes[at..].starts_with(b"//") => {
                at += source[at..].find('\n').unwrap_or(bytes.len() - at);
            }
            b'\'' if bytes[at..].starts_with(b"'\"'") => at += 3,
            b'"' => {
                let begin = at;
                at += 1;
                while at < bytes.len() && bytes[at] != b'"' {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
                at += 1;
                if at <= bytes.len() {
                    found.push((begin, at));
                }
            }
            _ => at += 1,
        }
    }
    found
}
