//! `adumbra-lab tree import`: turns PNG pages of words back into the file that they were exported from.

use adumbra_files::replace_file;
use adumbra_papers::dag::DAG_MAGIC;
use adumbra_papers::tree::{Error, TREE_MAGIC, TreeFile, file_of_words, texture};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::output::{format_bytes, print_json, refuse_inputs};
use adumbra_program::say;
use adumbra_program::threads::with_threads;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::TreeImport;

/// The PNG pages that were read.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Imported {
    /// The file that was written.
    file: String,
    /// Length of the file, in bytes.
    file_bytes: u64,
    /// `light-aligned`, a graph, or `world-aligned`, a tree.
    kind: &'static str,
    /// Path of page 0. Every other page has its number before the extension.
    texture: String,
    /// Number of 32-bit words.
    words: usize,
}

pub(super) fn run(args: &TreeImport) -> Outcome {
    with_threads(args.run.threads, || import(args))?
}

fn import(args: &TreeImport) -> Outcome {
    let path = &args.texture;
    let pages = (0..).map(|page| texture::page_path(path, page)).take_while(|page| page.exists());
    for page in pages {
        refuse_inputs("--output", &args.output, [("the picture itself", &*page)])?;
    }
    let (words, rest) = texture::read(path)?;
    let count = words.len();
    // The words, and the file that they become.
    let bytes = (4 * count + rest.len()) as u64;
    args.run.check_memory("the words and their file", bytes, 2 * bytes)?;
    let (kind, file_bytes) = match rest.first_chunk::<8>() {
        Some(&DAG_MAGIC) => {
            let file =
                file_of_words(&rest, words).map_err(|source| Error::Words { path: path.clone(), source })?;
            ("light-aligned", replace_file(&args.output, |out| file.write_to(out))?)
        }
        Some(&TREE_MAGIC) => {
            let file = TreeFile::with_words(&rest, &words)
                .map_err(|source| Error::Format { path: path.clone(), source: Box::new(source) })?;
            ("world-aligned", replace_file(&args.output, |out| file.write_to(out))?)
        }
        _ => {
            let start = rest[..rest.len().min(8)].escape_ascii();
            return Err(Failure::BadInput(format!(
                "{:?}: its words belong to a kind of file that begins with \"{start}\", which this program \
                does not support; import it with the program that exported it",
                path.display().to_string()
            )));
        }
    };
    if args.run.json {
        print_json(&Imported {
            file: args.output.display().to_string(),
            file_bytes,
            kind,
            texture: path.display().to_string(),
            words: count,
        })?;
    } else {
        say!("{}: {} from {count} words", args.output.display(), format_bytes(file_bytes));
    }
    Ok(Code::Fine)
}
