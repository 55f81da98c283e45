//! `adumbra-lab tree export`: writes a tree file, or the tree of a graph file, as PNG pages of words.

use std::path::Path;

use adumbra::IoError;
use adumbra_papers::dag::DagFile;
use adumbra_papers::tree::texture::{Layout, page_path, write};
use adumbra_papers::tree::{Error, TreeBody, TreeFile, words_of};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::output::{format_bytes, print_json, refuse_inputs, refuse_same};
use adumbra_program::say;
use adumbra_program::threads::with_threads;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::TreeExport;

/// The PNG pages that were written.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Exported {
    /// The file that was read.
    file: String,
    /// Length of the file, in bytes.
    file_bytes: u64,
    /// `light-aligned`, a graph, or `world-aligned`, a tree.
    kind: &'static str,
    /// Levels of the tree. It has 2^depth voxels along each side.
    depth: u32,
    /// Path of page 0. Every other page has its number before the extension.
    texture: String,
    /// Number of 32-bit words. Word i is pixel `i mod (width · rows)` of page `i / (width · rows)`.
    words: usize,
    /// Number of pages.
    pages: u32,
    /// Pixels per row.
    width: u32,
    /// Rows of words of every page but the last. A row with a signature follows them.
    rows: u32,
    /// Bytes of all pages.
    texture_bytes: u64,
}

pub(super) fn run(args: &TreeExport) -> Outcome {
    with_threads(args.run.threads, || export(args, &args.texture))?
}

fn export(args: &TreeExport, texture: &Path) -> Outcome {
    let refuse = |path: &Path| refuse_inputs("--texture", path, [("the shadow file itself", &*args.file)]);
    refuse(texture)?;
    // The file's bytes, and the decoded file.
    let bytes = std::fs::metadata(&args.file).map_err(IoError::at("read", &args.file))?.len();
    args.run.check_memory("the shadow file", 0, 2 * bytes)?;
    let parts = PictureContent::of(&args.file)?;
    let words = parts.words.len();
    // The words, and the pages that contain them.
    let held = (4 * words + parts.rest.len()) as u64;
    args.run.check_memory("the words and their pages", held, 2 * held)?;
    let layout = Layout::new(words, parts.rest.len(), args.max_side)
        .map_err(|source| Error::WordTexture { path: texture.to_owned(), source })?;
    let pages: Vec<_> = (0..layout.pages).map(|page| page_path(texture, page)).collect();
    pages.iter().try_for_each(|page| refuse(page))?;
    refuse_same(pages.iter().map(|page| &**page))?;
    let written = write(texture, &parts.words, &parts.rest, args.max_side)?;
    let layout = written.layout;
    if args.run.json {
        print_json(&Exported {
            file: args.file.display().to_string(),
            file_bytes: parts.file_bytes,
            kind: parts.kind,
            depth: parts.depth,
            texture: texture.display().to_string(),
            words,
            pages: layout.pages,
            width: layout.width,
            rows: layout.rows,
            texture_bytes: written.bytes,
        })?;
    } else {
        say!(
            "{}: {words} words on {} of {} pixels per row, {}",
            texture.display(),
            if layout.pages == 1 { "1 page".to_owned() } else { format!("{} pages", layout.pages) },
            layout.width,
            format_bytes(written.bytes)
        );
    }
    Ok(Code::Fine)
}

/// The parts of a file that a picture stores.
struct PictureContent {
    kind: &'static str,
    /// Levels of the tree: 2^depth voxels along each side.
    depth: u32,
    words: Vec<u32>,
    /// The file without its words. The first eight bytes are the file's magic.
    rest: Vec<u8>,
    file_bytes: u64,
}

impl PictureContent {
    fn of(path: &Path) -> Result<Self, Failure> {
        if DagFile::is_one(path)? {
            let file = DagFile::read(path)?;
            let file_bytes = file.encoded_len();
            let (tree, rest) =
                words_of(&file).map_err(|source| Error::Words { path: path.to_owned(), source })?;
            let (depth, words) = (tree.depth(), tree.into_words());
            return Ok(Self { kind: "light-aligned", depth, words, rest, file_bytes });
        }
        let file = TreeFile::read(path)?;
        let file_bytes = file.encoded_len();
        match (file.without_words(), file.body) {
            (Some(rest), TreeBody::Words(tree)) => {
                let (depth, words) = (tree.depth(), tree.into_words());
                Ok(Self { kind: "world-aligned", depth, words, rest, file_bytes })
            }
            _ => Err(Failure::BadInput(format!(
                "{}: holds a symmetric tree, which has no words; bake it without --symmetry",
                path.display()
            ))),
        }
    }
}
