//! Names and options that have been replaced appear in no source and no document.

use std::fs;
use std::path::{Path, PathBuf};

/// Each retired word, and what stands in its place.
const RETIRED: [(&str, &str); 45] = [
    // The bake cache.
    ("FolderObjects", "DiskCache"),
    ("MemoryObjects", "MemoryCache"),
    ("StoreObjects", "StoreCache"),
    ("CachedObjects", "BestEffortCache"),
    ("FolderContents", "CacheUsage"),
    ("FolderReport", "CacheReport"),
    ("ObjectKey", "CacheKey"),
    ("PageObject", "CachedPage"),
    ("Keeper", "PartCache"),
    ("bake_with_objects", "bake_with_cache"),
    ("with_objects", "with_cache"),
    ("ADUMOBJ1", "ADUMENT1"),
    // Root blocks, and what progress counts.
    ("done_tiles", "done"),
    ("total_tiles", "total"),
    ("reused_tiles", "reused_root_blocks"),
    ("sampled_tiles", "sampled_root_blocks"),
    ("texels_per_tile", "texels_per_unit"),
    ("on_pages_of", "snapped_to"),
    // How a file is stored.
    ("AtRest", "Encoding"),
    ("at_rest", "encoding"),
    ("--at-rest", "--encoding"),
    ("adumbra pack", "adumbra convert"),
    ("adumbra unpack", "adumbra convert"),
    ("adumbra export", "adumbra info --snippet"),
    ("export --web", "info --snippet"),
    // Options.
    ("--into", "--link-in"),
    ("--sun-angle", "--sun-degrees"),
    ("sun_angle", "sun_degrees"),
    ("sun_angle_degrees", "sun_degrees"),
    ("angle_degrees", "sun_degrees"),
    ("SunAngle", "SunDegrees"),
    ("softnessDegrees", "sunDegrees"),
    ("angleDegrees", "sunDegrees"),
    ("METRES", "LENGTH"),
    // Bevy.
    ("BakeShadow", "RuntimeBake"),
    ("BakeShadowCommands", "RuntimeBakeCommands"),
    ("ShadowBake", "AssetBake"),
    ("ShadowBakeError", "AssetBakeError"),
    ("ShadowBakeLoader", "AssetBakeLoader"),
    ("ShadowBakeProcess", "AssetBakeProcess"),
    ("BakedStatic", "ShadowStatic"),
    ("InBake", "IncludedInBake"),
    ("NotBaked", "ExcludeFromBake"),
    ("NotYetBaked", "AwaitingBake"),
    ("softness", "sun_degrees, sunDegrees"),
];

/// Where a retired word means something else: the word, and the end of the file's path.
const ELSEWHERE: [(&str, &str); 2] = [
    // A control of the demo's page.
    ("softness", "integrations/three/demo/main.ts"),
    ("softness", "integrations/three/demo/index.html"),
];

/// Folders without sources of this repository's own.
const SKIPPED: [&str; 9] =
    ["target", "node_modules", "dist", "bench", "generated", ".git", "test_vectors", "shared", "fuzz"];

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        let name = entry.file_name().into_string().unwrap();
        if path.is_dir() {
            if !SKIPPED.contains(&&*name) {
                files(&path, found);
            }
        } else if ["rs", "ts", "py", "pyi", "md", "wgsl", "toml", "html", "js", "tsx", "mk", "sh", "yaml"]
            .iter()
            .any(|end| path.extension().is_some_and(|e| e == *end))
        {
            found.push(path);
        }
    }
}

/// Whether a text has a word, and not as a part of a longer one.
fn has_word(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word)
        .any(|(at, _)| !text[..at].ends_with(is_part) && !text[at + word.len()..].starts_with(is_part))
}

#[test]
fn retired_words_are_used_nowhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut sources = Vec::new();
    files(root, &mut sources);
    assert!(sources.len() > 1000, "{}", sources.len());
    let mut faults = Vec::new();
    for path in sources {
        let name = path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
        if name == "xtask/tests/retired_words.rs" {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        for (word, instead) in RETIRED {
            if has_word(&text, word) && !ELSEWHERE.contains(&(word, &*name)) {
                faults.push(format!("{name}: {word}; write {instead}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn words_are_whole() {
    assert!(has_word("a --into b", "--into") && has_word("InBake", "InBake"));
    assert!(!has_word("IncludedInBake", "InBake") && !has_word("InBakes", "InBake"));
}
