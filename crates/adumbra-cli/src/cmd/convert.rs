//! `adumbra convert`: the same shadow file, coded or raw.

use std::fs;

use adumbra::{Encoding, IoError};
use adumbra_files as files;
use adumbra_program::exit::{Code, Outcome};
use adumbra_program::output::{format_bytes, print_json};
use adumbra_program::{mirrors, say};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Convert;

/// A file that was converted.
#[derive(Serialize, JsonSchema)]
pub(super) struct Converted {
    /// The shadow file that was read.
    file: String,
    /// The shadow file that was written.
    output: String,
    /// How it is stored now.
    #[schemars(with = "mirrors::Encoding")]
    encoding: Encoding,
    /// Length of the file that was read, in bytes.
    bytes_before: u64,
    /// Length of the file that was written, in bytes.
    bytes: u64,
}

pub(crate) fn run(args: &Convert) -> Outcome {
    let (file, output) = (&*args.file, args.output.as_deref().unwrap_or(&args.file));
    let encoding = args.encoding.into();
    let bytes_before = fs::metadata(file).map_err(IoError::at("read", file))?.len();
    let found = args.run.memory_limit().read_to_store(file, encoding)?;
    let bytes = files::replace_file(output, |out| found.write_to(out, encoding))?;
    if args.run.json {
        print_json(&Converted {
            file: args.file.display().to_string(),
            output: output.display().to_string(),
            encoding,
            bytes_before,
            bytes,
        })?;
    } else {
        say!(
            "{} -> {}: {} -> {}",
            args.file.display(),
            output.display(),
            format_bytes(bytes_before),
            format_bytes(bytes)
        );
    }
    Ok(Code::Fine)
}
