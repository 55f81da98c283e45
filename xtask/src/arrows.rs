//! Data flows one way: there is no cycle between the modules of a crate, and no crate depends on a later one.
//!
//! In Rust an arrow is any path in production code that leads from one module into another: in `use` declarations, types,
//! expressions and the arguments of macros, through `crate`, `super` and re-exports of a parent. In TypeScript it is an
//! import of another file, and folders are modules. Siblings are compared at every level of the module tree. A parent and
//! its children may use each other: that is how a module is divided into files, not a cycle. Tests (`#[cfg(test)]`) are
//! not production code.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, Meta, UseTree, Visibility};

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

/// Sources in Rust that are not below `crates/`.
const OTHER_RUST: [&str; 4] =
    ["integrations/bevy_adumbra/src", "integrations/three/generator/src", "xtask/src", "xtask/bakes/src"];
/// Sources in TypeScript.
const TYPESCRIPT: [&str; 2] = ["integrations/three/src", "integrations/three/demo"];

type ModulePath = Vec<String>;

/// One crate's modules and the arrows between them.
#[derive(Default)]
struct Modules {
    /// Absolute paths that each module names.
    named: BTreeMap<ModulePath, Vec<ModulePath>>,
    /// Re-exports of each module: the name there, and the path that it refers to.
    exports: BTreeMap<ModulePath, BTreeMap<String, ModulePath>>,
}

/// Arrows between siblings, keyed by their parent.
#[derive(Default)]
struct Arrows(BTreeMap<ModulePath, BTreeMap<String, BTreeSet<String>>>);

impl Arrows {
    fn add(&mut self, from: &ModulePath, to: &ModulePath) {
        let common = from.iter().zip(to).take_while(|(a, b)| a == b).count();
        if let (Some(a), Some(b)) = (from.get(common), to.get(common)) {
            let siblings = self.0.entry(from[..common].to_vec()).or_default();
            siblings.entry(a.clone()).or_default().insert(b.clone());
        }
    }

    fn circles(&self) -> Vec<String> {
        self.0.iter().flat_map(|(parent, siblings)| circles_among(parent, siblings)).collect()
    }
}

/// Returns every cycle of modules in the repository's sources, one line each.
///
/// # Errors
/// Returns a message if a file cannot be read or is not Rust.
pub(crate) fn circles(root: &Path) -> Result<Vec<String>, String> {
    let crates = ORDER.iter().map(|name| format!("crates/{name}/src"));
    let mut found = Vec::new();
    for source in crates.chain(OTHER_RUST.map(str::to_owned)) {
        let folder = root.join(&source);
        let starts = ["lib.rs", "main.rs"].map(|start| folder.join(start));
        let starts: Vec<_> = starts.iter().filter(|start| start.exists()).collect();
        if starts.is_empty() {
            return Err(format!("{source}: no lib.rs and no main.rs"));
        }
        for start in starts {
            let mut modules = Modules::default();
            modules.read(start, &folder, &Vec::new())?;
            found.extend(modules.circles().into_iter().map(|circle| format!("{source}: {circle}")));
        }
    }
    for source in TYPESCRIPT {
        let mut arrows = Arrows::default();
        add_imports(&root.join(source), &Vec::new(), &mut arrows)?;
        found.extend(arrows.circles().into_iter().map(|circle| format!("{source}: {circle}")));
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
        let parsed = syn::parse_file(&text).map_err(|e| format!("{}: {e}", file.display()))?;
        self.add(&parsed.items, folder, path)
    }

    fn add(&mut self, items: &[Item], folder: &Path, path: &ModulePath) -> Result<(), String> {
        let mut names = Names { module: path, found: Vec::new() };
        let mut exports = BTreeMap::new();
        for item in items {
            match item {
                Item::Mod(child) if !is_test(&child.attrs) => {
                    let name = child.ident.to_string();
                    let below = [path.clone(), vec![name.clone()]].concat();
                    match &child.content {
                        Some((_, items)) => self.add(items, &folder.join(&name), &below)?,
                        None => {
                            let flat = folder.join(format!("{name}.rs"));
                            let nested = folder.join(&name).join("mod.rs");
                            let file = if flat.exists() { flat } else { nested };
                            self.read(&file, &folder.join(&name), &below)?;
                        }
                    }
                }
                Item::Use(declared) if !is_test(&declared.attrs) => {
                    let mut imported = Vec::new();
                    flatten(&declared.tree, &mut Vec::new(), &mut imported);
                    for (name, parts) in imported {
                        let Some(target) = absolute(&parts, path) else { continue };
                        if !matches!(declared.vis, Visibility::Inherited) {
                            exports.insert(name, target.clone());
                        }
                        names.found.push(target);
                    }
                }
                item => names.visit_item(item),
            }
        }
        self.named.insert(path.clone(), names.found);
        self.exports.insert(path.clone(), exports);
        Ok(())
    }

    fn circles(&self) -> Vec<String> {
        let mut arrows = Arrows::default();
        for (from, named) in &self.named {
            named.iter().for_each(|path| arrows.add(from, &self.module_of(path)));
        }
        arrows.circles()
    }

    /// Returns the module that an absolute path leads into, following re-exports.
    fn module_of(&self, path: &ModulePath) -> ModulePath {
        let mut path = path.clone();
        // Chains of re-exports end after a few steps.
        for _ in 0..8 {
            let module = (0..=path.len()).rev().find(|&n| self.named.contains_key(&path[..n])).unwrap_or(0);
            let Some(name) = path.get(module) else { break };
            match self.exports.get(&path[..module]).and_then(|table| table.get(name)) {
                Some(target) if *target != path => path = [&target[..], &path[module + 1..]].concat(),
                _ => break,
            }
        }
        let module = (0..=path.len()).rev().find(|&n| self.named.contains_key(&path[..n])).unwrap_or(0);
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

/// The paths that a module's code names through `crate`, `super` and `self`.
struct Names<'m> {
    module: &'m ModulePath,
    found: Vec<ModulePath>,
}

impl Names<'_> {
    fn name(&mut self, parts: &[String]) {
        if matches!(parts.first().map(String::as_str), Some("crate" | "super" | "self")) && parts.len() > 1 {
            self.found.extend(absolute(parts, self.module));
        }
    }

    /// Finds paths in the arguments of a macro, which are no syntax tree.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Punct(p) if p.as_char() == ':' && !path.is_empty() => colons += 1,
                TokenTree::Ident(name) if path.is_empty() || colons == 2 => {
                    path.push(name.to_string());
                    colons = 0;
                }
                other => {
                    self.name(&path);
                    path.clear();
                    colons = 0;
                    match other {
                        TokenTree::Ident(name) => path.push(name.to_string()),
                        TokenTree::Group(group) => self.tokens(group.stream()),
                        _ => {}
                    }
                }
            }
        }
        self.name(&path);
    }
}

impl<'ast> Visit<'ast> for Names<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let parts: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.name(&parts);
        visit::visit_path(self, path);
    }

    fn visit_item_use(&mut self, declared: &'ast syn::ItemUse) {
        let mut imported = Vec::new();
        flatten(&declared.tree, &mut Vec::new(), &mut imported);
        imported.iter().for_each(|(_, parts)| self.name(parts));
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        visit::visit_macro(self, call);
        self.tokens(call.tokens.clone());
    }
}

/// Whether these are the attributes of what exists in tests alone.
fn is_test(attributes: &[Attribute]) -> bool {
    let names_test = |list: &syn::MetaList| {
        let text = list.tokens.to_string();
        text == "test" || text.starts_with("all (test")
    };
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) if list.path.is_ident("cfg") => names_test(list),
        _ => false,
    })
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(i) => &i.attrs,
        Item::Enum(i) => &i.attrs,
        Item::Fn(i) => &i.attrs,
        Item::Impl(i) => &i.attrs,
        Item::Macro(i) => &i.attrs,
        Item::Mod(i) => &i.attrs,
        Item::Static(i) => &i.attrs,
        Item::Struct(i) => &i.attrs,
        Item::Trait(i) => &i.attrs,
        Item::Type(i) => &i.attrs,
        Item::Use(i) => &i.attrs,
        _ => &[],
    }
}

/// Adds each name that a `use` declaration imports, and the path that it refers to.
fn flatten(tree: &UseTree, above: &mut Vec<String>, found: &mut Vec<(String, Vec<String>)>) {
    match tree {
        UseTree::Path(path) => {
            above.push(path.ident.to_string());
            flatten(&path.tree, above, found);
            above.pop();
        }
        UseTree::Name(name) if name.ident == "self" => {
            found.push((above.last().cloned().unwrap_or_default(), above.clone()));
        }
        UseTree::Name(name) => {
            let name = name.ident.to_string();
            found.push((name.clone(), [above.clone(), vec![name]].concat()));
        }
        UseTree::Rename(name) => {
            found.push((name.rename.to_string(), [above.clone(), vec![name.ident.to_string()]].concat()));
        }
        UseTree::Glob(_) => found.push(("*".to_owned(), above.clone())),
        UseTree::Group(group) => group.items.iter().for_each(|tree| flatten(tree, above, found)),
    }
}

/// Returns the path from the crate's root. `None` if it has too many `super`s.
fn absolute(parts: &[String], module: &ModulePath) -> Option<ModulePath> {
    let (base, rest) = match parts.first()?.as_str() {
        "crate" => (Vec::new(), &parts[1..]),
        "self" => (module.clone(), &parts[1..]),
        "super" => {
            let ups = parts.iter().take_while(|p| *p == "super").count();
            (module[..module.len().checked_sub(ups)?].to_vec(), &parts[ups..])
        }
        // A child, or another crate.
        _ => (module.clone(), parts),
    };
    Some([&base[..], rest].concat())
}

/// Adds the imports of the files in a folder of TypeScript, which is the module `path`. Its `index.ts` is the folder's
/// own.
fn add_imports(folder: &Path, path: &ModulePath, arrows: &mut Arrows) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("cannot read {}: {e}", folder.display()))?;
    for entry in entries.filter_map(Result::ok) {
        let file = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        if file.is_dir() {
            add_imports(&file, &[path.clone(), vec![name]].concat(), arrows)?;
        } else if let Some(stem) = name.strip_suffix(".ts") {
            let text =
                fs::read_to_string(&file).map_err(|e| format!("cannot read {}: {e}", file.display()))?;
            let from = file_module(path, stem);
            for target in imports(&text) {
                let relative = Path::new(target.trim_end_matches(".js").trim_end_matches(".ts"));
                arrows.add(&from, &resolved(path, relative));
            }
        }
    }
    Ok(())
}

fn file_module(folder: &ModulePath, stem: &str) -> ModulePath {
    if stem == "index" { folder.clone() } else { [folder.clone(), vec![stem.to_owned()]].concat() }
}

/// Returns the specifiers of relative imports and re-exports.
fn imports(text: &str) -> Vec<&str> {
    let before = ["from \"", "import \"", "import(\""];
    let after = before.iter().flat_map(|before| text.split(before).skip(1));
    after.filter_map(|rest| rest.split('"').next()).filter(|path| path.starts_with('.')).collect()
}

/// Returns the module of a file that is imported by a file in `folder`.
fn resolved(folder: &ModulePath, relative: &Path) -> ModulePath {
    let mut path = folder.clone();
    for part in relative.components() {
        match part {
            Component::ParentDir => drop(path.pop()),
            Component::Normal(name) => path.push(name.to_string_lossy().into_owned()),
            _ => {}
        }
    }
    if path.last().is_some_and(|name| name == "index") {
        path.pop();
    }
    path
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

    #[test]
    fn arrows_in_macros_and_inline_modules_count() {
        let found = modules(&[
            ("lib.rs", "mod a;\nmod b { pub fn f() -> u8 { crate::a::ONE } }"),
            ("a.rs", "pub const ONE: u8 = 1;\nfn g() { println!(\"{}\", [crate::b::f()].len()) }"),
        ]);
        assert_eq!(found, ["a -> b -> a"]);
    }

    #[test]
    fn arrows_between_folders_and_files_of_typescript_are_found() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("a.ts", "import { b } from \"./b.js\";"),
            ("b.ts", "export * from \"./a.js\";"),
            ("m/x.ts", "import type { N } from \"../n/index.js\";"),
            ("m/index.ts", "export { x } from \"./x.js\"; import fs from \"node:fs\";"),
            ("n/index.ts", "const later = () => import(\"../m/x\");"),
        ] {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let mut arrows = Arrows::default();
        add_imports(folder.path(), &Vec::new(), &mut arrows).unwrap();
        assert_eq!(arrows.circles(), ["a -> b -> a", "m -> n -> m"]);
    }
}
