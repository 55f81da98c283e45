//! The style of sources and documents: names and options that have been replaced appear nowhere, types have
//! names that say what they hold, and comments are narrow enough for two files side by side.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Each retired word, and what stands in its place.
const RETIRED: [(&str, &str); 61] = [
    // The bake cache.
    ("FolderObjects", "DiskCache"),
    ("MemoryObjects", "MemoryCache"),
    ("StoreObjects", "StoreCache"),
    ("CachedObjects", "BestEffortCache"),
    ("FolderContents", "CacheReport"),
    ("FolderReport", "CacheReport"),
    ("ObjectKey", "CacheKey"),
    ("PageObject", "OwnedPage"),
    ("Keeper", "PartCache"),
    ("bake_with_objects", "Bake::cache"),
    ("bake_with_cache", "Bake::cache"),
    ("bake_to", "Bake::write_to"),
    ("bake_again", "Bake::cache"),
    ("with_objects", "with_cache"),
    ("OBJECT_MAGIC", "ENTRY_MAGIC"),
    ("ADUMOBJ1", "ADUMENT1"),
    // Root blocks, and what progress counts.
    ("done_tiles", "done"),
    ("total_tiles", "total"),
    ("reused_tiles", "reused_root_blocks"),
    ("sampled_tiles", "sampled_root_blocks"),
    ("texels_per_tile", "texels_per_unit"),
    ("TileRect", "TexelRect"),
    ("TileSurfaces", "BinSurfaces"),
    ("on_pages_of", "snapped_to"),
    // How a file is stored.
    ("AtRest", "Encoding"),
    ("at_rest", "encoding"),
    ("AT_REST", "ENCODING"),
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
    // What users link, and what pages import.
    ("wgsl_files", "FileForGpu::wgsl"),
    ("WordSource", "TexelFormat"),
    ("VOXEL_TEXTURE_PASS", "LOOK_UP_FILE"),
    ("VOXEL_LEVELS_SOFT_PASS", "VOXEL_LEVELS_SOFT"),
    ("BakerPage", "PlannedPart"),
    ("CacheUsage", "CacheReport"),
    ("DEFAULT_REGION_TEXELS", "RegionPlan::DEFAULT_TEXELS"),
    ("bytesPerUpdate", "uploadBytesPerFrame"),
    ("fadeUpdates", "fadeFrames"),
];

/// Where a retired word means something else, or is named as such: the word, and the file.
const ELSEWHERE: [(&str, &str); 2] = [
    // A control of the demo's page.
    ("softness", "integrations/three/demo/main.ts"),
    ("softness", "integrations/three/demo/index.html"),
];

/// Files that tell of the old words.
const HISTORY: [&str; 2] = ["CHANGELOG.md", "xtask/tests/house_style.rs"];

/// Names of types that say nothing: a place of what, a step of what?
const VAGUE: [&str; 10] =
    ["Baked", "Builder", "Built", "Document", "Made", "Parts", "Place", "Seen", "Step", "Written"];

/// Largest width of a comment, columns. Rows of tables may be wider.
const COMMENT_COLUMNS: usize = 110;

/// Largest width of a line of Markdown, columns. Tables, code and check comments may be wider, and so may a
/// line with a code span or a link that is longer than [`LONG_SPAN`].
const MARKDOWN_COLUMNS: usize = 120;
const LONG_SPAN: usize = 60;

/// Endings of files with text.
const ENDINGS: [&str; 17] = [
    "rs", "ts", "tsx", "js", "mjs", "py", "pyi", "md", "txt", "wgsl", "toml", "html", "mk", "sh", "yaml",
    "yml", "ipynb",
];

/// Returns the files of this repository, without recorded measurements.
fn files(root: &Path) -> Vec<String> {
    let listed = Command::new("git").args(["ls-files", "-z"]).current_dir(root).output().unwrap();
    assert!(listed.status.success(), "git ls-files: {}", String::from_utf8_lossy(&listed.stderr));
    let all = String::from_utf8(listed.stdout).unwrap();
    let is_text =
        |name: &&str| ENDINGS.iter().any(|end| name.rsplit_once('.').is_some_and(|(_, e)| e == *end));
    let files = all.split('\0').filter(is_text).filter(|name| !name.starts_with("docs/bench/"));
    files.map(str::to_owned).collect()
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
    let sources = files(root);
    assert!(sources.len() > 1000, "{}", sources.len());
    let mut faults = Vec::new();
    for name in sources.iter().filter(|name| !HISTORY.contains(&&***name)) {
        // A file that is listed may have been removed.
        let Ok(text) = fs::read_to_string(root.join(name)) else { continue };
        for (word, instead) in RETIRED {
            if has_word(&text, word) && !ELSEWHERE.contains(&(word, name)) {
                faults.push(format!("{name}: {word}; write {instead}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Returns the name of the type that a line of Rust declares.
fn declared_type(line: &str) -> Option<&str> {
    let line = line.trim_start();
    let rest = match line.strip_prefix("pub(") {
        Some(rest) => rest.split_once(") ")?.1,
        None => line.strip_prefix("pub ").unwrap_or(line),
    };
    let rest = ["enum ", "struct ", "trait ", "type "].iter().find_map(|word| rest.strip_prefix(word))?;
    rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next()
}

#[test]
fn types_have_specific_names() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut faults = Vec::new();
    for name in
        files(root).iter().filter(|name| name.ends_with(".rs")).filter(|name| !HISTORY.contains(&&***name))
    {
        let Ok(text) = fs::read_to_string(root.join(name)) else { continue };
        for (line, text) in text.lines().enumerate() {
            if let Some(vague) = declared_type(text).filter(|name| VAGUE.contains(name)) {
                faults.push(format!("{name}:{}: say what a {vague} is", line + 1));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn declared_types_are_found() {
    let cases = [
        ("pub(crate) struct Seen<'a> {", Some("Seen")),
        ("    pub enum Step {", Some("Step")),
        ("pub(in crate::cmd) struct Baked {", Some("Baked")),
        ("type Built = Option<Word>;", Some("Built")),
        ("let step = Step::new();", None),
    ];
    for (line, expected) in cases {
        assert_eq!(declared_type(line), expected, "{line}");
    }
}

#[test]
fn comments_are_narrow() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let is_source = |name: &&String| {
        ["rs", "ts", "tsx", "wgsl"].iter().any(|end| name.rsplit_once('.').is_some_and(|(_, e)| e == *end))
            && !name.contains("/generated/")
    };
    let mut faults = Vec::new();
    for name in files(root).iter().filter(is_source) {
        let Ok(text) = fs::read_to_string(root.join(name)) else { continue };
        for (number, line) in text.lines().enumerate() {
            let Some(comment) = line.trim_start().strip_prefix("//") else { continue };
            let is_row = comment.trim_start_matches(['/', '!', ' ']).starts_with('|');
            if !is_row && line.chars().count() > COMMENT_COLUMNS {
                faults.push(format!("{name}:{}: wrap at {COMMENT_COLUMNS} columns", number + 1));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Returns the numbers of the lines of a Markdown text that should be wrapped.
fn wide_lines(text: &str) -> Vec<usize> {
    let (mut is_fenced, mut is_comment, mut is_indented) = (false, false, false);
    // Whether a code span goes on from the line before.
    let mut is_span = false;
    let mut wide = Vec::new();
    let mut before = "";
    for (number, line) in (1..).zip(text.lines()) {
        let words = line.trim_start();
        if words.starts_with("```") {
            is_fenced = !is_fenced;
        }
        is_comment |= words.starts_with("<!--");
        is_indented = line.starts_with("    ") && (is_indented || before.is_empty());
        let is_exempt = is_fenced || is_comment || is_indented || words.starts_with("| ");
        if words.is_empty() {
            is_span = false;
        }
        let spans = words.split('`').skip(usize::from(!is_span)).step_by(2);
        let longest = spans.chain(links(words)).map(str::len).max().unwrap_or_default();
        if !is_exempt && line.chars().count() > MARKDOWN_COLUMNS && longest <= LONG_SPAN {
            wide.push(number);
        }
        if !is_exempt {
            is_span ^= words.matches('`').count() % 2 == 1;
        }
        is_comment &= !line.contains("-->");
        before = line;
    }
    wide
}

/// Returns the links of a line, `[text](target)`.
fn links(line: &str) -> impl Iterator<Item = &str> {
    line.split('[').skip(1).filter(|link| link.contains("](")).filter_map(|link| link.split(')').next())
}

#[test]
fn markdown_is_narrow() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut faults = Vec::new();
    for name in files(root).iter().filter(|name| name.ends_with(".md")) {
        let Ok(text) = fs::read_to_string(root.join(name)) else { continue };
        let wide = wide_lines(&text).into_iter();
        faults.extend(wide.map(|line| format!("{name}:{line}: wrap at {MARKDOWN_COLUMNS} columns")));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn wide_lines_of_markdown_are_found() {
    let wide = "word ".repeat(30);
    let long = "x".repeat(130);
    for text in [wide.clone(), format!("`x` {wide}"), format!("[a](b) {wide}"), format!("- {wide}")] {
        assert_eq!(wide_lines(&text), [1], "{text}");
    }
    for text in [
        format!("| {wide} |"),
        format!("see `{long}`"),
        format!("[a]({long})"),
        format!("```\n{wide}\n```"),
        format!("<!-- check\n{wide}\n-->"),
        format!("text:\n\n    {wide}"),
    ] {
        assert!(wide_lines(&text).is_empty(), "{text}");
    }
    // A code span that is wrapped, and nested text of a list.
    assert_eq!(wide_lines(&format!("`a\nb` {wide}")), [2]);
    assert_eq!(wide_lines(&format!("1. one\n    {wide}")), [2]);
}

#[test]
fn words_are_whole() {
    assert!(has_word("a --into b", "--into") && has_word("InBake", "InBake"));
    assert!(!has_word("IncludedInBake", "InBake") && !has_word("InBakes", "InBake"));
}
