//! The development tasks that bake: `vectors` and `count [--bless]`. `cargo xtask` runs them. They are in a
//! separate program, so that `cargo xtask test` need not build the crates that bake before it begins.

mod broken;
#[allow(
    unreachable_pub,
    reason = "a link to a file of adumbra-testing, which a program cannot depend on and be packaged"
)]
mod by_hand;
mod count;
mod tree_vectors;
mod vectors;
mod voxels;

use std::env;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new("."));
    let outcome = match words.as_slice() {
        ["vectors"] => vectors::run(root),
        ["count", options @ ..] => count::run(root, options),
        _ => Err("usage: cargo xtask vectors, cargo xtask count [--bless]".into()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
