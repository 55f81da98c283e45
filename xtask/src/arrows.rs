//! Data flows one way: there is no cycle between the modules of a crate, and no crate depends on a later one.
//!
//! An arrow is any path in production code that leads from one module into another: `use` declarations and paths in
//! expressions, through `crate`, `super` and re-exports of a parent. Siblings are compared at every level of the module
//! tree. A parent and its children may use each other: that is how a module is divided into files, not a cycle. Tests
//! (`#[cfg(test)]`) are not production code.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Crates in the order in which data flows. A crate depends only on earlier ones.
const ORDER: [&str; 14] = [
    "adumbra",
    "adumbra-files",
    "adumbra-scene",
    "adumbra-bake",
    "adumbra-tree",
    "adumbra-shaders",
    "adumbra-render",
    "adumbra-truth",
    "adumbra-program",
    "adumbra-compare",
    "adumbra-view",
    "adumbra-testing",
    "adumbra-cli",
    "adumbra-lab",
];

type ModulePath = Vec<String>;

/// One crate's modules and the arrows between them.
#[derive(Default)]
struct Modules {
    /// Code of each module, without comments, literals and tests.
    code: BTreeMap<ModulePath, String>,
    /// Re-exports of each module: the name there, and the path that it refers to.
    exports: BTreeMap<ModulePath, BTreeMap<String, ModulePath>>,
}

/// Returns every cycle of modules below `root/crates`, one line each.
///
/// # Errors
/// Returns a message if a file cannot be read.
pub(crate) fn circles(root: &Path) -> Result<Vec<String>, String> {
    let mut found = Vec::new();
    for name in ORDER {
        let source = root.join("crates").join(name).join("src");
        for start in ["lib.rs", "main.rs"] {
            let file = source.join(start);
            if file.exists() {
                let mut modules = Modules::default();
                modules.read(&file, &source, &Vec::new())?;
                found.extend(modules.circles().into_iter().map(|circle| format!("{name}: {circle}")));
            }
        }
    }
    Ok(found)
}

/// Returns every dependency on a later crate of [`ORDER`], and every crate that is missing from it, one line each.
///
/// # Errors
/// Returns a message if the folder of the crates cannot be read.
pub(crate) fn back_arrows(root: &Path) -> Result<Vec<String>, String> {
    let mut found = Vec::new();
    let folder = root.join("crates");
    let entries = fs::read_dir(&folder).map_err(|e| format!("cannot read {}: {e}", folder.display()))?;
    let place = |name: &str| ORDER.iter().position(|&known| known == name);
    for entry in entries.filter_map(Result::ok) {
        let name = entry.file_name().to_string_lossy().into_owned();
        let manifest = entry.path().join("Cargo.toml");
        let Ok(text) = fs::read_to_string(&manifest) else { continue };
        let Some(own) = place(&name) else {
            found.push(format!("{name} is not in the order of crates"));
            continue;
        };
        let product = text.split("[dev-dependencies]").next().unwrap_or_default();
        let dependencies = product.split("[dependencies]").nth(1).unwrap_or_default();
        for line in dependencies.lines() {
            let dependency = line.split(['.', ' ', '=']).next().unwrap_or_default();
            if place(dependency).is_some_and(|other| other >= own) {
                found.push(format!("{name} depends on {dependency}, which comes later"));
            }
        }
    }
    Ok(found)
}

impl Modules {
    /// Reads a module's file and those of its children, without tests.
    fn read(&mut self, file: &Path, folder: &Path, path: &ModulePath) -> Result<(), String> {
        let text = fs::read_to_string(file).map_err(|e| format!("cannot read {}: {e}", file.display()))?;
        let code = without_tests(&plain_code(&text));
        for line in code.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let Some(at) = words.iter().position(|&w| w == "mod") else { continue };
            let is_declaration = words[..at].iter().all(|w| w.starts_with("pub"));
            let Some(child) = words.get(at + 1).and_then(|w| w.strip_suffix(';')) else { continue };
            if !is_declaration {
                continue;
            }
            let below = [path.clone(), vec![child.to_owned()]].concat();
            let (flat, nested) = (folder.join(format!("{child}.rs")), folder.join(child).join("mod.rs"));
            let child_file = if flat.exists() { flat } else { nested };
            self.read(&child_file, &folder.join(child), &below)?;
        }
        self.code.insert(path.clone(), code);
        Ok(())
    }

    fn circles(mut self) -> Vec<String> {
        let uses: BTreeMap<ModulePath, Vec<(String, ModulePath, bool)>> =
            self.code.iter().map(|(path, code)| (path.clone(), use_declarations(code, path))).collect();
        for (path, declared) in &uses {
            let table = declared.iter().filter(|(.., is_export)| *is_export);
            self.exports.insert(
                path.clone(),
                table.map(|(name, target, _)| (name.clone(), target.clone())).collect(),
            );
        }
        // Arrows between siblings, keyed by their parent.
        let mut arrows: BTreeMap<ModulePath, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
        for (from, code) in &self.code {
            let declared = uses[from].iter().map(|(_, target, _)| target.clone());
            for target in declared.chain(inline_paths(code, from)) {
                let to = self.module_of(&target);
                let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
                if let (Some(a), Some(b)) = (from.get(common), to.get(common)) {
                    let siblings = arrows.entry(from[..common].to_vec()).or_default();
                    siblings.entry(a.clone()).or_default().insert(b.clone());
                }
            }
        }
        arrows.iter().flat_map(|(parent, siblings)| circles_among(parent, siblings)).collect()
    }

    /// Returns the module that an absolute path leads into, following re-exports.
    fn module_of(&self, path: &ModulePath) -> ModulePath {
        let mut path = path.clone();
        // Chains of re-exports end after a few steps.
        for _ in 0..8 {
            let module = (0..=path.len()).rev().find(|&n| self.code.contains_key(&path[..n])).unwrap_or(0);
            let Some(name) = path.get(module) else { break };
            match self.exports.get(&path[..module]).and_then(|table| table.get(name)) {
                Some(target) if *target != path => path = [&target[..], &path[module + 1..]].concat(),
                _ => break,
            }
        }
        let module = (0..=path.len()).rev().find(|&n| self.code.contains_key(&path[..n])).unwrap_or(0);
        path[..module].to_vec()
    }
}

/// Returns the cycles in a graph of siblings: the shortest path from each module back to itself, each cycle once.
fn circles_among(parent: &ModulePath, siblings: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let mut found = BTreeSet::new();
    for start in siblings.keys() {
        let mut ways = vec![vec![start.clone()]];
        let mut seen = BTreeSet::new();
        while !ways.is_empty() {
            let mut longer = Vec::new();
            for way in &ways {
                for next in way.last().and_then(|last| siblings.get(last)).into_iter().flatten() {
                    if next == start {
                        // Starts at the alphabetically first name, so that each cycle is found once.
                        let first =
                            way.iter().enumerate().min_by_key(|(_, name)| *name).map_or(0, |(i, _)| i);
                        let mut names: Vec<&str> =
                            way[first..].iter().chain(&way[..first]).map(String::as_str).collect();
                        names.push(names[0]);
                        found.insert(format!("{}{}", prefix(parent), names.join(" -> ")));
                    } else if seen.insert(next.clone()) {
                        longer.push([way.clone(), vec![next.clone()]].concat());
                    }
                }
            }
            ways = longer;
        }
    }
    found.into_iter().collect()
}

fn prefix(parent: &ModulePath) -> String {
    if parent.is_empty() { String::new() } else { format!("{}: ", parent.join("::")) }
}

/// Returns the text without comments and with empty string and character literals.
fn plain_code(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        if rest.starts_with("//") {
            rest = rest.find('\n').map_or("", |end| &rest[end..]);
        } else if rest.starts_with("/*") {
            rest = rest.find("*/").map_or("", |end| &rest[end + 2..]);
        } else if let Some(hashes) = raw_string(rest) {
            let close = format!("\"{}", "#".repeat(hashes));
            let body = &rest[hashes + 2..];
            out.push_str("\"\"");
            rest = body.find(&close).map_or("", |end| &body[end + close.len()..]);
        } else if c == '"' {
            out.push_str("\"\"");
            rest = after_string(&rest[1..]);
        } else if c == '\'' && is_character(rest) {
            let end =
                rest[1..].char_indices().skip(1).find(|&(i, c)| c == '\'' && rest.as_bytes()[i] != b'\\');
            out.push_str("' '");
            rest = end.map_or("", |(i, _)| &rest[i + 2..]);
        } else {
            out.push(c);
            rest = &rest[c.len_utf8()..];
        }
    }
    out
}

/// Returns the number of hashes of a raw string that begins here.
fn raw_string(rest: &str) -> Option<usize> {
    let body = rest.strip_prefix('r')?;
    let hashes = body.len() - body.trim_start_matches('#').len();
    body[hashes..].starts_with('"').then_some(hashes)
}

fn after_string(body: &str) -> &str {
    let mut escaped = false;
    for (i, c) in body.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return &body[i + 1..],
            _ => {}
        }
    }
    ""
}

/// Whether a quote begins a character literal and not a lifetime.
fn is_character(rest: &str) -> bool {
    let mut chars = rest.chars().skip(1);
    match chars.next() {
        Some('\\') => true,
        Some(_) => chars.next() == Some('\''),
        None => false,
    }
}

/// Returns the code without items after `#[cfg(test)]`.
fn without_tests(code: &str) -> String {
    let mut out = String::new();
    let mut rest = code;
    while let Some(at) = rest.find("#[cfg(test)]") {
        out.push_str(&rest[..at]);
        let item = &rest[at..];
        let end = match (item.find(';'), item.find('{')) {
            (Some(semicolon), brace) if brace.is_none_or(|b| semicolon < b) => semicolon + 1,
            (_, Some(brace)) => brace + block_length(&item[brace..]),
            _ => item.len(),
        };
        rest = &item[end..];
    }
    out.push_str(rest);
    out
}

fn block_length(from_brace: &str) -> usize {
    let mut depth = 0;
    for (i, c) in from_brace.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => {
                depth -= 1;
                if depth == 0 {
                    return i + 1;
                }
            }
            _ => {}
        }
    }
    from_brace.len()
}

/// Returns the name, the absolute path and the visibility outside the module of each name that a module's `use`
/// declarations import from its own crate.
fn use_declarations(code: &str, module: &ModulePath) -> Vec<(String, ModulePath, bool)> {
    let mut found = Vec::new();
    for statement in code.split(';') {
        let start = statement.rfind(['}', '{']).filter(|_| !statement.contains("use ")).map_or(0, |i| i + 1);
        let statement = statement[start..].trim();
        let Some(at) = statement.find("use ") else { continue };
        let before = statement[..at].rsplit(['}', '\n']).next().unwrap_or_default().trim();
        if !(before.is_empty() || before.starts_with("pub")) {
            continue;
        }
        let is_export = before.starts_with("pub");
        for path in expand(statement[at + 4..].trim()) {
            let (path, alias) = match path.split_once(" as ") {
                Some((path, alias)) => (path.trim().to_owned(), Some(alias.trim().to_owned())),
                None => (path, None),
            };
            let Some(absolute) = absolute(&path, module) else { continue };
            let name = alias.or_else(|| absolute.last().cloned()).unwrap_or_default();
            found.push((name, absolute, is_export));
        }
    }
    found
}

/// Expands a tree of braces into single paths.
fn expand(tree: &str) -> Vec<String> {
    let Some(open) = tree.find('{') else { return vec![tree.trim().to_owned()] };
    let inner = tree[open + 1..].rfind('}').map_or("", |close| &tree[open + 1..open + 1 + close]);
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (i, c) in inner.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&inner[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&inner[start..]);
    let parts = parts.into_iter().map(str::trim).filter(|p| !p.is_empty());
    parts.flat_map(expand).map(|p| format!("{}{p}", tree[..open].trim())).collect()
}

/// Returns the path from the crate's root. `None` if it has too many `super`s.
fn absolute(path: &str, module: &ModulePath) -> Option<ModulePath> {
    let parts: Vec<&str> = path.split("::").map(str::trim).filter(|p| *p != "*").collect();
    let parts = parts.strip_suffix(&["self"]).filter(|rest| !rest.is_empty()).unwrap_or(&parts);
    let (base, rest) = match *parts.first()? {
        "crate" => (Vec::new(), &parts[1..]),
        "self" => (module.clone(), &parts[1..]),
        "super" => {
            let ups = parts.iter().take_while(|p| **p == "super").count();
            (module[..module.len().checked_sub(ups)?].to_vec(), &parts[ups..])
        }
        // A child, or another crate.
        _ => (module.clone(), parts),
    };
    Some(base.into_iter().chain(rest.iter().map(|&p| p.to_owned())).collect())
}

/// Returns the absolute paths that expressions name through `crate` and `super`.
fn inline_paths(code: &str, module: &ModulePath) -> Vec<ModulePath> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    code.split(|c| !is_name(c))
        .filter(|word| word.starts_with("crate::") || word.starts_with("super::"))
        .filter_map(|word| absolute(word.trim_end_matches(':'), module))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root() -> &'static Path {
        Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
    }

    #[test]
    fn arrows_between_modules_make_no_circle() {
        let found = circles(root()).unwrap();
        assert!(found.is_empty(), "cycles between modules:\n{}", found.join("\n"));
    }

    #[test]
    fn arrows_between_crates_point_to_earlier_ones() {
        let found = back_arrows(root()).unwrap();
        assert!(found.is_empty(), "{}", found.join("\n"));
    }

    /// Everything that a crate depends on, through others too.
    fn reached(arrows: &BTreeMap<String, BTreeSet<String>>, from: &str) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        let mut open = vec![from.to_owned()];
        while let Some(name) = open.pop() {
            for next in arrows.get(&name).into_iter().flatten() {
                if found.insert(next.clone()) {
                    open.push(next.clone());
                }
            }
        }
        found
    }

    #[test]
    fn arrows_in_the_architecture_are_those_of_the_manifests() {
        let own = |name: &str| ORDER.contains(&name);
        let mut stated = BTreeMap::new();
        for line in fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap().lines() {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let &["", name, _, below, ""] = &cells[..] else { continue };
            let name = name.split('`').nth(1).unwrap_or_default();
            if own(name) && below != "all" {
                let full = |short: &str| match short {
                    "" | "adumbra" => short.to_owned(),
                    short => format!("adumbra-{short}"),
                };
                stated
                    .insert(name.to_owned(), below.split(", ").map(full).filter(|n| !n.is_empty()).collect());
            }
        }
        let mut real = BTreeMap::new();
        for name in ORDER {
            let manifest = root().join("crates").join(name).join("Cargo.toml");
            let text = fs::read_to_string(manifest).unwrap();
            let section = text.split("[dependencies]").nth(1).unwrap_or_default();
            let section = section.split("\n[").next().unwrap_or_default();
            let names = section.lines().filter_map(|line| line.split(['.', ' ', '=']).next());
            real.insert(name.to_owned(), names.filter(|n| own(n)).map(str::to_owned).collect());
        }
        assert!(stated.len() > 10, "{stated:?}");
        for name in stated.keys() {
            assert_eq!(reached(&stated, name), reached(&real, name), "{name}");
        }
    }

    fn modules(files: &[(&str, &str)]) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let mut modules = Modules::default();
        modules.read(&folder.path().join("lib.rs"), folder.path(), &Vec::new()).unwrap();
        modules.circles()
    }

    #[test]
    fn arrows_of_a_deliberate_circle_are_found() {
        let two = modules(&[
            ("lib.rs", "mod a;\npub mod b;"),
            ("a.rs", "use crate::b::B;\npub struct A;"),
            ("b.rs", "pub struct B;\nfn f() -> crate::a::A { crate::a::A }"),
        ]);
        assert_eq!(two, ["a -> b -> a"]);
        // Through a re-export of the root, and below a module.
        let deep = modules(&[
            ("lib.rs", "mod m;\nmod n;\npub use m::x::X;\n#[cfg(test)]\nmod tests;"),
            ("tests.rs", "use crate::n::N;"),
            ("m/mod.rs", "pub mod x;\npub mod y;\nuse x::X;"),
            ("m/x.rs", "use super::y::Y;\npub struct X;"),
            ("m/y.rs", "pub struct Y(super::x::X);\n#[cfg(test)]\nmod tests { use crate::n::N; }"),
            (
                "n.rs",
                "use crate::{X};\npub struct N; // crate::m uses crate::n\nconst S: &str = \"crate::n\";",
            ),
        ]);
        assert_eq!(deep, ["m: x -> y -> x"]);
    }
}
