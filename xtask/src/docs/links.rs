//! Links and pictures of the documents: every link has a target, and no picture is of a single colour or too
//! large to load.

use std::collections::HashMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::check::{is_one_colour, picture};
use super::markdown::{Link, MarkdownFile};

/// Maximum size of a picture in bytes.
const MAX_BYTES: u64 = 2_000_000;

/// Returns every broken link of the documents, which are given by their paths below `root`.
pub(crate) fn faults(root: &Path, documents: &HashMap<PathBuf, MarkdownFile>) -> Vec<String> {
    let mut faults = Vec::new();
    for (path, document) in documents {
        for link in &document.links {
            if let Err(fault) = follow(root, path, link, documents) {
                faults.push(format!("{}:{}: {fault}", path.display(), link.line));
            }
        }
    }
    faults.sort();
    faults
}

fn follow(
    root: &Path,
    from: &Path,
    link: &Link,
    documents: &HashMap<PathBuf, MarkdownFile>,
) -> Result<(), String> {
    let target = link.target.as_str();
    if target.contains("://") || target.starts_with("mailto:") {
        return Ok(());
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let to = if file.is_empty() { from.to_path_buf() } else { resolved(from, file)? };
    let metadata = fs::metadata(root.join(&to)).map_err(|_| format!("{target}: no such file"))?;
    if link.picture {
        if metadata.len() > MAX_BYTES {
            return Err(format!("{target}: {} bytes, more than {MAX_BYTES}", metadata.len()));
        }
        if to.extension().is_some_and(|e| e == "png") && is_one_colour(&picture(&root.join(&to))?) {
            return Err(format!("{target}: the picture has a single colour"));
        }
    }
    if anchor.is_empty() {
        return Ok(());
    }
    let anchors = match documents.get(&to) {
        Some(document) => document.anchors.clone(),
        None => {
            MarkdownFile::read(&fs::read_to_string(root.join(&to)).map_err(|e| format!("{target}: {e}"))?)
                .anchors
        }
    };
    if anchors.iter().any(|a| a == anchor) { Ok(()) } else { Err(format!("{target}: no such heading")) }
}

/// Returns the path of a link's target below the root.
fn resolved(from: &Path, file: &str) -> Result<PathBuf, String> {
    let mut path = from.parent().map(Path::to_path_buf).unwrap_or_default();
    for part in Path::new(file).components() {
        match part {
            Component::ParentDir if !path.pop() => return Err(format!("{file}: leaves the repository")),
            Component::ParentDir | Component::CurDir => {}
            Component::Normal(name) => path.push(name),
            _ => return Err(format!("{file}: not relative")),
        }
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::super::check::write_picture;
    use super::*;

    #[test]
    fn broken_links_and_pictures_are_found() {
        let root = tempfile::tempdir().unwrap();
        fs::create_dir(root.path().join("docs")).unwrap();
        fs::write(root.path().join("a.md"), "# One two").unwrap();
        write_picture(&root.path().join("black.png"), [2, 2], &[0; 12]);
        let text = "# Here\n[a](../a.md) [b](../a.md#one-two) [c](#here) [d](https://e.org/x#y)\n\
            [1](a.md) [2](../a.md#two) [3](#there) [4](../../a.md) ![5](../black.png) [6](/a.md)";
        fs::write(root.path().join("docs/d.md"), text).unwrap();
        let documents = HashMap::from([(PathBuf::from("docs/d.md"), MarkdownFile::read(text))]);
        let found = faults(root.path(), &documents);
        assert_eq!(found.len(), 6, "{found:#?}");
        assert!(found.iter().all(|f| f.starts_with("docs/d.md:3: ")), "{found:#?}");
    }
}
