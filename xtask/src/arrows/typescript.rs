//! Arrows between the files and folders of sources in TypeScript, from their imports.

use std::fs;
use std::path::{Component, Path};

use super::{Arrows, ModulePath};

/// Adds the imports of the files in a folder of TypeScript, which is the module `path`. Its `index.ts`
/// belongs to the module of the folder itself.
pub(super) fn add_imports(folder: &Path, path: &ModulePath, arrows: &mut Arrows) -> Result<(), String> {
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
    let after = ["from ", "import ", "import("].iter().flat_map(|before| text.split(before).skip(1));
    let quoted = after.filter_map(|rest| {
        let quote = rest.chars().next().filter(|c| ['\'', '"'].contains(c))?;
        rest[1..].split(quote).next()
    });
    quoted.filter(|path| path.starts_with('.')).collect()
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
