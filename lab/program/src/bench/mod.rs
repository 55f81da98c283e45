//! The benchmarks, one module each: measurements, checks, tables and pictures.
//!
//! A benchmark writes `NAME.md` and `NAME.json` into the output folder, with its plots and pictures next to
//! them.

pub(crate) mod ao;
pub(crate) mod bake;
pub(crate) mod blur;
mod child;
pub(crate) mod fast;
pub(crate) mod gpu;
pub(crate) mod hrsm;
pub(crate) mod lookup;
pub(crate) mod peers;
mod shadows;
pub(crate) mod stream;
pub(crate) mod tree;
pub(crate) mod verify;

use std::path::Path;

use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::{write_png, write_whole};
use adumbra_program::say;
use adumbra_truth::picture::Picture;
use serde::Serialize;

use crate::args::{BenchVerb, SuiteArg};
use adumbra_compare::Result;

/// Direction towards the sun, for the tables with a single sun.
const DEFAULT_SUN: [f64; 3] = [0.5, 0.8, 0.35];

/// Runs one benchmark.
///
/// # Errors
///
/// Returns an error if an input cannot be read, an output cannot be written, or the device fails.
pub fn run(what: &BenchVerb) -> Result<Code> {
    match what {
        BenchVerb::Bake(a) if a.suite == SuiteArg::Fast => fast::run(a),
        BenchVerb::Bake(a) => bake::run(a),
        BenchVerb::Verify(a) => verify::run(a),
        BenchVerb::Tree(a) => tree::run(a),
        BenchVerb::Hrsm(a) => hrsm::run(a),
        BenchVerb::Ao(a) => ao::run(a),
        BenchVerb::Blur(a) => blur::run(a),
        BenchVerb::Lookup(a) => lookup::run(a),
        BenchVerb::Gpu(a) => gpu::run(a),
        BenchVerb::Peers(a) => peers::run(a),
        BenchVerb::Shadows(a) => shadows::run(a),
        BenchVerb::Stream(a) => stream::run(a),
    }
}

/// Writes a benchmark's tables and figures as far as they have been measured.
fn write(folder: &Path, name: &str, markdown: &str, figures: &impl Serialize) -> Result<()> {
    let json = serde_json::to_value(figures).map_err(|e| Failure::BadInput(e.to_string()))?;
    write_whole(&folder.join(format!("{name}.md")), markdown.as_bytes())?;
    write_whole(&folder.join(format!("{name}.json")), format!("{json:#}\n").as_bytes())?;
    Ok(())
}

/// Writes a sheet of pictures into a benchmark's folder as `NAME.png`, and adds its file and caption to
/// `sheets`.
fn keep_sheet(
    folder: &Path,
    sheets: &mut Vec<[String; 2]>,
    name: &str,
    caption: String,
    sheet: &Picture,
) -> Result<()> {
    let file = format!("{name}.png");
    write_png(&folder.join(&file), sheet)?;
    sheets.push([file, caption]);
    Ok(())
}

/// Prints the path of the tables.
fn say_tables(folder: &Path, name: &str) {
    say!("{}", folder.join(format!("{name}.md")).display());
}

#[cfg(test)]
mod tests {
    use serde::de::DeserializeOwned;
    use serde_json::Value;

    use super::*;
    use adumbra_compare::report::Report;

    /// Reads an excerpt of a result file as its type and checks that it survives a round trip unchanged.
    fn read<T: DeserializeOwned + Serialize>(name: &str) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recorded").join(name);
        let text = std::fs::read_to_string(path).unwrap();
        let results: T = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
        let known: Value = serde_json::from_str(&text).unwrap();
        assert!(serde_json::to_value(&results).unwrap() == known, "{name} is read and written as it was");
    }

    #[test]
    fn recorded_results_round_trip_through_their_types() {
        read::<ao::AoResults>("ao.json");
        read::<bake::BakeResults>("bake.json");
        read::<blur::BlurResults>("blur.json");
        read::<fast::FastResults>("fast.json");
        read::<hrsm::HybridResults>("hrsm.json");
        read::<lookup::LookUpResults>("lookup.json");
        read::<peers::PeerResults>("peers.json");
        read::<Vec<Report>>("shadows.json");
        read::<tree::TreeResults>("tree.json");
        read::<verify::VerifyResults>("verify.json");
    }
}
