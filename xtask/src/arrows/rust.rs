//! Arrows between the modules of a crate in Rust, from its syntax trees.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, Meta, UseTree, Visibility};

use super::{Arrows, ModulePath};

/// One crate's modules and the arrows between them.
#[derive(Default)]
pub(super) struct Modules {
    /// Absolute paths that each module names.
    named: BTreeMap<ModulePath, Vec<ModulePath>>,
    /// Re-exports of each module: the name there, and the path that it refers to.
    exports: BTreeMap<ModulePath, BTreeMap<String, ModulePath>>,
}

impl Modules {
    /// Reads a module's file and those of its children, without tests.
    pub(super) fn read(&mut self, file: &Path, folder: &Path, path: &ModulePath) -> Result<(), String> {
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

    pub(super) fn circles(&self) -> Vec<String> {
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

    /// Finds paths in the arguments of a macro, which are tokens without a syntax tree.
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

/// Whether these attributes mark an item as test-only.
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
