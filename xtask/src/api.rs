//! The public APIs of the reader and the baker: every item that a crate exports, as text. A file of `docs/`
//! holds each text, so that every change of an API is visible as a change of that file.
//!
//! Items are found with `syn`: the items that `lib.rs` and its documented modules declare or re-export, with
//! their public methods and variants. Items marked `#[doc(hidden)]` are left out.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use syn::{Attribute, ImplItem, Item, UseTree, Visibility};

/// A crate whose public items are listed.
pub(crate) struct Api {
    name: &'static str,
    /// The file that holds the list.
    pub(crate) list: &'static str,
    /// Maximum number of public items, so that users can survey them.
    #[cfg(test)]
    most_items: usize,
}

pub(crate) const APIS: [Api; 2] = [
    Api {
        name: "adumbra",
        list: "docs/api.txt",
        #[cfg(test)]
        most_items: 60,
    },
    Api {
        name: "adumbra-bake",
        list: "docs/api-bake.txt",
        #[cfg(test)]
        most_items: 25,
    },
];

/// The kind and the members of an item.
#[derive(Default)]
struct Found {
    kind: &'static str,
    members: Vec<String>,
}

/// Returns the list and the number of its items.
///
/// # Errors
///
/// Returns a message if a source cannot be read.
pub(crate) fn list(root: &Path, api: &Api) -> Result<(String, usize), String> {
    let sources = root.join("crates").join(api.name).join("src");
    let mut found = BTreeMap::new();
    for file in rust_files(&sources)? {
        for item in parse(&file)?.items {
            note(&item, &mut found);
        }
    }
    let mut names = exported(&sources.join("lib.rs"), "")?;
    for module in documented_modules(&sources.join("lib.rs"))? {
        names.push((String::new(), module.clone()));
        let inner = sources.join(&module).join("mod.rs");
        names.extend(exported(&inner, &format!("{module}::"))?);
    }
    names.sort();
    let mut text = format!("The public items of the crate {}, by `cargo xtask api`.\n\n", api.name);
    for (prefix, name) in &names {
        let known = found.get(name);
        let kind = known.map_or("mod", |item| item.kind);
        text += &format!("{kind} {prefix}{name}\n");
        for member in known.map(|item| item.members.as_slice()).unwrap_or_default() {
            text += &format!("    {member}\n");
        }
    }
    text += &format!("\n{} items\n", names.len());
    Ok((text, names.len()))
}

fn parse(path: &Path) -> Result<syn::File, String> {
    let text = fs::read_to_string(path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
    syn::parse_file(&text).map_err(|e| format!("{}: {e}", path.display()))
}

fn rust_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("cannot read {}: {e}", folder.display()))?;
    let mut files = Vec::new();
    for entry in entries.filter_map(Result::ok) {
        let path = entry.path();
        if path.is_dir() {
            files.extend(rust_files(&path)?);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn is_hidden(attributes: &[Attribute]) -> bool {
    attributes
        .iter()
        .any(|a| a.path().is_ident("doc") && a.parse_args::<syn::Ident>().is_ok_and(|word| word == "hidden"))
}

fn is_shown(visibility: &Visibility, attributes: &[Attribute]) -> bool {
    matches!(visibility, Visibility::Public(_)) && !is_hidden(attributes)
}

/// Notes the kind of an item, or the public methods of an `impl`.
fn note(item: &Item, found: &mut BTreeMap<String, Found>) {
    let mut add = |name: &syn::Ident, kind: &'static str, members: Vec<String>| {
        let entry = found.entry(name.to_string()).or_default();
        entry.kind = kind;
        entry.members.splice(0..0, members);
    };
    match item {
        Item::Struct(item) => {
            let fields = item.fields.iter().filter(|f| is_shown(&f.vis, &f.attrs));
            let fields = fields.filter_map(|f| Some(f.ident.as_ref()?.to_string())).collect();
            add(&item.ident, "struct", fields);
        }
        Item::Enum(item) => {
            add(&item.ident, "enum", item.variants.iter().map(|v| v.ident.to_string()).collect());
        }
        Item::Trait(item) => add(&item.ident, "trait", Vec::new()),
        Item::Fn(item) => add(&item.sig.ident, "fn", Vec::new()),
        Item::Const(item) => add(&item.ident, "const", Vec::new()),
        Item::Type(item) => add(&item.ident, "type", Vec::new()),
        Item::Impl(item) if item.trait_.is_none() => {
            let syn::Type::Path(path) = &*item.self_ty else { return };
            let Some(of) = path.path.segments.last() else { return };
            let entry = found.entry(of.ident.to_string()).or_default();
            entry.members.extend(item.items.iter().filter_map(|member| match member {
                ImplItem::Fn(f) if is_shown(&f.vis, &f.attrs) => Some(format!("{}()", f.sig.ident)),
                ImplItem::Const(c) if is_shown(&c.vis, &c.attrs) => Some(c.ident.to_string()),
                _ => None,
            }));
        }
        _ => {}
    }
}

/// Returns the names that a file declares or re-exports publicly, each with `prefix`.
fn exported(file: &Path, prefix: &str) -> Result<Vec<(String, String)>, String> {
    let mut names = Vec::new();
    for item in parse(file)?.items {
        match &item {
            Item::Use(item) if is_shown(&item.vis, &item.attrs) => leaves(&item.tree, &mut names),
            Item::Struct(item) if is_shown(&item.vis, &item.attrs) => names.push(item.ident.to_string()),
            Item::Enum(item) if is_shown(&item.vis, &item.attrs) => names.push(item.ident.to_string()),
            Item::Fn(item) if is_shown(&item.vis, &item.attrs) => names.push(item.sig.ident.to_string()),
            Item::Const(item) if is_shown(&item.vis, &item.attrs) => names.push(item.ident.to_string()),
            _ => {}
        }
    }
    Ok(names.into_iter().map(|name| (prefix.to_owned(), name)).collect())
}

fn leaves(tree: &UseTree, names: &mut Vec<String>) {
    match tree {
        UseTree::Path(path) => leaves(&path.tree, names),
        UseTree::Name(name) => names.push(name.ident.to_string()),
        UseTree::Rename(rename) => names.push(rename.rename.to_string()),
        UseTree::Group(group) => group.items.iter().for_each(|tree| leaves(tree, names)),
        UseTree::Glob(_) => {}
    }
}

fn documented_modules(file: &Path) -> Result<Vec<String>, String> {
    let modules = parse(file)?.items.into_iter().filter_map(|item| match item {
        Item::Mod(item) if is_shown(&item.vis, &item.attrs) => Some(item.ident.to_string()),
        _ => None,
    });
    Ok(modules.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn apis_match_their_lists_and_are_small() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let items = [
            ["struct Sampler", "enum Filter", "struct gpu::FileForGpu", "    sampler()"],
            ["struct Bake", "trait BakeCache", "struct BakeOptions", "    in_memory()"],
        ];
        for (api, items) in APIS.iter().zip(items) {
            let (text, count) = list(root, api).unwrap();
            assert!(count <= api.most_items, "{count} items:\n{text}");
            let listed = fs::read_to_string(root.join(api.list)).unwrap();
            assert!(listed == text, "{} is not what the sources say; run cargo xtask api", api.list);
            for item in items {
                assert!(text.lines().any(|line| line == item), "{item} is missing:\n{text}");
            }
        }
    }
}
