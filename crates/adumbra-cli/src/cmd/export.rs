//! `adumbra export`: a shadow file as PNG pages of words.

use std::path::Path;

use adumbra::format::{AnyFile, TreeBody};
use adumbra::texture::Layout;
use adumbra::{Error, texture};
use serde_json::json;

use super::print_json;
use crate::args::Export;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{bytes_words, refuse_inputs, refuse_same};

pub(crate) fn run(args: &Export) -> Outcome {
    let refuse = |path: &Path| refuse_inputs("--texture", path, [("the shadow file itself", &*args.file)]);
    refuse(&args.texture)?;
    let parts = Parts::of(&args.file)?;
    let words = parts.words.len();
    let layout = Layout::new(words, parts.rest.len(), args.max_side)
        .map_err(|source| Error::WordTexture { path: args.texture.clone(), source })?;
    let pages: Vec<_> = (0..layout.pages).map(|page| texture::page_path(&args.texture, page)).collect();
    pages.iter().try_for_each(|page| refuse(page))?;
    refuse_same(pages.iter().map(|page| &**page))?;
    let written = texture::write(&args.texture, &parts.words, &parts.rest, args.max_side)?;
    let layout = written.layout;
    if args.json {
        print_json(&json!({
            "file": args.file.display().to_string(),
            "file_bytes": parts.file_bytes,
            "kind": parts.kind,
            "depth": parts.depth,
            "texture": args.texture.display().to_string(),
            "words": words,
            "pages": layout.pages,
            "width": layout.width,
            "rows": layout.rows,
            "texture_bytes": written.bytes,
        }));
    } else {
        say!(
            "{}: {words} words on {} of {} pixels a row, {}",
            args.texture.display(),
            if layout.pages == 1 { "a page".to_owned() } else { format!("{} pages", layout.pages) },
            layout.width,
            bytes_words(written.bytes)
        );
    }
    Ok(Code::Fine)
}

/// A file as a picture holds it.
struct Parts {
    kind: &'static str,
    /// Levels of the tree: 2^depth voxels a side.
    depth: u32,
    words: Vec<u32>,
    /// What a file of this kind is made of besides its words; its first eight bytes are the file's magic.
    rest: Vec<u8>,
    file_bytes: u64,
}

impl Parts {
    /// Each kind of shadow file has its arm here and one in `import`.
    fn of(path: &Path) -> Result<Self, Failure> {
        let file = AnyFile::read(path)?;
        let file_bytes = file.encoded_len();
        let (kind, tree, rest) = match file {
            AnyFile::Light(file) => {
                let (tree, rest) =
                    file.without_words().map_err(|source| Error::Words { path: path.to_owned(), source })?;
                ("light-aligned", tree, rest)
            }
            AnyFile::Tree(file) => match (file.without_words(), file.body) {
                (Some(rest), TreeBody::Words(tree)) => ("world-aligned", tree, rest),
                _ => {
                    return Err(Failure::BadInput(format!(
                        "{}: holds a symmetric tree, which has no words; bake it without --symmetry",
                        path.display()
                    )));
                }
            },
        };
        Ok(Self { kind, depth: tree.depth(), words: tree.into_words(), rest, file_bytes })
    }
}
