//! Data flows one way: there is no cycle between the modules of a crate, and no crate depends on a later one.
//!
//! In Rust an arrow is any path in production code that leads from one module into another: in `use`
//! declarations, types, expressions and the arguments of macros, through `crate`, `super` and re-exports of a
//! parent. In TypeScript it is an import of another file, and folders are modules. Siblings are compared at
//! every level of the module tree. A parent and its children may use each other: that is how a module is
//! divided into files, not a cycle. Tests (`#[cfg(test)]`) are not production code.

mod rust;
mod typescript;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use rust::Modules;
use typescript::add_imports;

/// Crates in the order in which data flows. A crate depends only on earlier ones.
const ORDER: [&str; 19] = [
    "adumbra-shaders",
    "adumbra",
    "adumbra-files",
    "adumbra-solar",
    "adumbra-scene",
    "adumbra-bake",
    "adumbra-store",
    "adumbra-render",
    "adumbra-truth",
    "adumbra-path",
    "adumbra-sunlight",
    "adumbra-program",
    "adumbra-html",
    "adumbra-compare",
    "adumbra-view",
    "adumbra-testing",
    "adumbra-cli",
    "adumbra-papers",
    "adumbra-lab",
];

/// Crates that are not in `crates/` but in another folder.
const LABORATORY: [(&str, &str); 2] = [("adumbra-papers", "lab/papers"), ("adumbra-lab", "lab/program")];
/// Other sources in Rust.
const OTHER_RUST: [&str; 5] = [
    "integrations/bevy_adumbra/src",
    "integrations/three/generator/src",
    "xtask/src",
    "xtask/bakes/src",
    "python/src",
];
/// Sources in TypeScript.
const TYPESCRIPT: [&str; 2] = ["integrations/three/src", "integrations/three/demo"];

type ModulePath = Vec<String>;

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

/// Returns the folder of a crate of [`ORDER`], relative to the root.
fn folder_of(name: &str) -> String {
    let elsewhere = LABORATORY.iter().find(|(lab, _)| *lab == name);
    elsewhere.map_or_else(|| format!("crates/{name}"), |(_, folder)| (*folder).to_owned())
}

/// Returns every cycle of modules in the repository's sources, one line each.
///
/// # Errors
/// Returns a message if a file cannot be read or is not Rust.
pub(crate) fn circles(root: &Path) -> Result<Vec<String>, String> {
    let crates = ORDER.iter().map(|name| format!("{}/src", folder_of(name)));
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

/// Returns every dependency on a later crate of [`ORDER`], and every crate that is missing from it, one line
/// each.
///
/// # Errors
/// Returns a message if a folder of crates cannot be read.
pub(crate) fn back_arrows(root: &Path) -> Result<Vec<String>, String> {
    let mut found = Vec::new();
    let mut folders = Vec::new();
    for parent in ["crates", "lab"].map(|name| root.join(name)) {
        let entries = fs::read_dir(&parent).map_err(|e| format!("cannot read {}: {e}", parent.display()))?;
        folders.extend(entries.filter_map(Result::ok).map(|entry| entry.path()));
    }
    let place = |name: &str| ORDER.iter().position(|&known| known == name);
    for folder in folders {
        let Ok(text) = fs::read_to_string(folder.join("Cargo.toml")) else { continue };
        let name = text.split("name = \"").nth(1).and_then(|rest| rest.split('"').next()).unwrap_or_default();
        let Some(own) = place(name) else {
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

/// Returns the cycles in a graph of siblings: the shortest path from each module back to itself, each cycle
/// once.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn root() -> &'static Path {
        Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
    }

    #[test]
    fn modules_have_no_cyclic_dependencies() {
        let found = circles(root()).unwrap();
        assert!(found.is_empty(), "cycles between modules:\n{}", found.join("\n"));
    }

    #[test]
    fn crates_depend_only_on_earlier_crates() {
        let found = back_arrows(root()).unwrap();
        assert!(found.is_empty(), "{}", found.join("\n"));
    }

    /// Returns the direct and indirect dependencies of a crate.
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
    fn dependencies_in_architecture_match_manifests() {
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
            let manifest = root().join(folder_of(name)).join("Cargo.toml");
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
    fn finds_cycles_between_modules() {
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
    fn finds_cycles_through_macros_and_inline_modules() {
        let found = modules(&[
            ("lib.rs", "mod a;\nmod b { pub fn f() -> u8 { crate::a::ONE } }"),
            ("a.rs", "pub const ONE: u8 = 1;\nfn g() { println!(\"{}\", [crate::b::f()].len()) }"),
        ]);
        assert_eq!(found, ["a -> b -> a"]);
    }

    #[test]
    fn finds_cycles_between_typescript_files_and_folders() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("a.ts", "import { b } from \"./b.js\";"),
            ("b.ts", "export * from './a.js';"),
            ("m/x.ts", "import type { N } from '../n/index.js';"),
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
