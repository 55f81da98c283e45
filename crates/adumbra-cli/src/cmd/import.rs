//! `adumbra import`: PNG pages of words back into the shadow file that they were exported from.

use adumbra::format::tree::TREE_MAGIC;
use adumbra::format::{MAGIC, ShadowFile, TreeFile};
use adumbra::{Error, texture};
use serde_json::json;

use super::print_json;
use crate::args::Import;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{bytes_words, refuse_inputs};

pub(crate) fn run(args: &Import) -> Outcome {
    let path = &args.texture;
    let pages = (0..).map(|page| texture::page_path(path, page)).take_while(|page| page.exists());
    for page in pages {
        refuse_inputs("--output", &args.output, [("the picture itself", &*page)])?;
    }
    let (words, rest) = texture::read(path)?;
    let count = words.len();
    // Each kind of shadow file is known by its magic and has its arm here.
    let (kind, file_bytes) = match rest.first_chunk::<8>() {
        Some(&MAGIC) => {
            let file = ShadowFile::with_words(&rest, words)
                .map_err(|source| Error::Words { path: path.clone(), source })?;
            ("light-aligned", file.write(&args.output)?)
        }
        Some(&TREE_MAGIC) => {
            let file = TreeFile::with_words(&rest, &words)
                .map_err(|source| Error::Format { path: path.clone(), source })?;
            ("world-aligned", file.write(&args.output)?)
        }
        _ => {
            let start = rest[..rest.len().min(8)].escape_ascii();
            return Err(Failure::BadInput(format!(
                "{:?}: its words are of a kind of file that begins with \"{start}\", which this program does not \
                know; import it with the program that exported it",
                path.display().to_string()
            )));
        }
    };
    if args.json {
        print_json(&json!({
            "file": args.output.display().to_string(),
            "file_bytes": file_bytes,
            "kind": kind,
            "texture": path.display().to_string(),
            "words": count,
        }));
    } else {
        say!("{}: {} from {count} words", args.output.display(), bytes_words(file_bytes));
    }
    Ok(Code::Fine)
}
