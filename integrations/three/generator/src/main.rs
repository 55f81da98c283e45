//! Writes the look-ups of web pages, and the expected values of the package's tests. `cargo xtask
//! shaders-web` runs it.

use std::fs;
use std::path::Path;
use std::process::ExitCode;

use adumbra_three_generator::Generated;

fn main() -> ExitCode {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    match run(&package) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn run(package: &Path) -> Result<(), String> {
    let golden = adumbra_three_generator::golden(&package.join("../../test_vectors"))?;
    write(&package.join("tests/golden"), &golden)?;
    write(&package.join("src/generated"), &adumbra_three_generator::generate()?)
}

fn write(folder: &Path, files: &[Generated]) -> Result<(), String> {
    let at = |e: std::io::Error| format!("{}: {e}", folder.display());
    fs::create_dir_all(folder).map_err(at)?;
    for file in files {
        fs::write(folder.join(&file.name), &file.text).map_err(at)?;
        println!("{}: {} bytes", file.name, file.text.len());
    }
    Ok(())
}
