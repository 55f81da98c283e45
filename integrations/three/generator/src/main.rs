//! Writes the look-ups of web pages. `cargo xtask shaders-web` runs it.

use std::fs;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    match write(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../src/generated")) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn write(folder: &Path) -> Result<(), String> {
    let at = |e: std::io::Error| format!("{}: {e}", folder.display());
    fs::create_dir_all(folder).map_err(at)?;
    for file in adumbra_three_generator::generate()? {
        fs::write(folder.join(&file.name), &file.text).map_err(at)?;
        println!("{}: {} bytes", file.name, file.text.len());
    }
    Ok(())
}
