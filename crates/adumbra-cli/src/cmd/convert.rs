//! `adumbra pack` and `adumbra unpack`: the same shadow file, coded or raw.

use std::fs;
use std::path::Path;

use adumbra::{AtRest, IoError};
use adumbra_files as files;
use adumbra_program::args::RunArgs;
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::output::{format_bytes, print_json};
use adumbra_program::{mirrors, say};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Convert;

/// A file that was stored in another way.
#[derive(Serialize, JsonSchema)]
pub(super) struct Converted {
    /// The shadow file that was read.
    file: String,
    /// The shadow file that was written.
    output: String,
    /// How it is stored now.
    #[schemars(with = "mirrors::AtRest")]
    at_rest: AtRest,
    /// Length of the file that was read, in bytes.
    bytes_before: u64,
    /// Length of the file that was written, in bytes.
    bytes: u64,
}

/// Writes a shadow file to `output`, stored in another way. Returns the bytes before and now.
pub(super) fn store(file: &Path, output: &Path, at_rest: AtRest, run: &RunArgs) -> Result<[u64; 2], Failure> {
    let bytes_before = fs::metadata(file).map_err(IoError::at("read", file))?.len();
    let found = run.memory_limit().read_to_store(file, at_rest)?;
    Ok([bytes_before, files::replace_file(output, |out| found.write_to(out, at_rest))?])
}

pub(crate) fn run(args: &Convert, at_rest: AtRest) -> Outcome {
    let output = args.output.as_deref().unwrap_or(&args.file);
    let [bytes_before, bytes] = store(&args.file, output, at_rest, &args.run)?;
    if args.run.json {
        print_json(&Converted {
            file: args.file.display().to_string(),
            output: output.display().to_string(),
            at_rest,
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
