//! `adumbra-lab bench bake --suite fast`: requirements on the fast bake and its files.
//!
//! Each bake runs in a separate process.

mod checks;
mod rows;
mod speed;
mod tables;

use std::path::Path;

use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::make_folder;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::checks::Check;
use self::rows::{QUERY_OF, Row, rows};
use self::speed::Scan;
use super::child;
use crate::args::BenchBake;
use adumbra_compare::Result;

/// Name of the look-ups for `--only`.
const QUERY: &str = "query";
/// Number of threads recorded if no bake was made.
const NO_THREADS: u64 = 0;

/// All results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct FastResults {
    /// Command that measured.
    command: String,
    /// Threads.
    threads: u64,
    /// Points compared with rays.
    samples: u64,
    /// Requirements and their outcomes.
    checks: Vec<Check>,
    /// One row per measurement.
    rows: Vec<Figures>,
    /// Look-ups in the file of [`QUERY_OF`] on one core.
    query: Vec<Scan>,
}

/// One bake's results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "FastBake")]
pub(crate) struct Figures {
    /// Name.
    name: String,
    /// Name of the scene.
    scene: String,
    /// Voxels along the longer side of the grid.
    resolution: u64,
    /// Thickness of open surfaces in world units.
    thickness_world: f64,
    /// Direction towards the sun.
    sun: [f64; 3],
    /// Wall time in seconds, the median of the runs.
    seconds: f64,
    /// Largest resident size of the process.
    peak_bytes: f64,
    /// Size of the file.
    file_bytes: f64,
    /// Share of all texels that were examined one by one.
    drawn_share: f64,
    /// Share of the compared points that are shadowed according to rays.
    shadowed_share: f64,
    /// Agreement with rays of the points away from edges.
    interior_agreement: f64,
    /// Number of points that `interior_agreement` covers.
    interior: u64,
}

pub(super) fn run(args: &BenchBake) -> Result<Code> {
    let asked =
        |name: &str| args.only.is_empty() || args.only.iter().any(|part| name.contains(part.as_str()));
    let fits = |resolution: u64| args.max_n.is_none_or(|most| resolution <= most);
    let asked_rows: Vec<Row> =
        rows().into_iter().filter(|r| asked(&r.name()) && fits(r.resolution)).collect();
    let query = asked(QUERY) && fits(QUERY_OF.1);
    if asked_rows.is_empty() && !query {
        let names: Vec<String> = rows().iter().map(Row::name).collect();
        return Err(Failure::Usage(format!(
            "--only and --max-n match no row; the rows are {}, {QUERY}",
            names.join(", ")
        ))
        .into());
    }
    make_folder(&args.output)?;
    let mut document = FastResults {
        command: command(args),
        threads: NO_THREADS,
        samples: args.samples,
        checks: Vec::new(),
        rows: Vec::new(),
        query: Vec::new(),
    };
    let mut queried = None;
    for row in &asked_rows {
        let file = child::shadow_file()?;
        let figures = bake(args, row, file.path(), &mut document)?;
        document.rows.push(figures);
        if (row.scene, row.resolution) == QUERY_OF {
            queried = Some(file);
        }
        write(args, &mut document)?;
    }
    if query {
        let scene = scene_file(args, QUERY_OF.0);
        let file = match queried {
            Some(file) => file,
            None => {
                let file = child::shadow_file()?;
                let every = rows();
                let row = every.iter().find(|r| (r.scene, r.resolution) == QUERY_OF);
                bake(args, row.unwrap_or(&every[0]), file.path(), &mut document)?;
                file
            }
        };
        document.query = speed::measure(file.path(), &scene)?;
    }
    write(args, &mut document)?;
    super::say_tables(&args.output, "fast");
    let failed = document.checks.iter().any(|c| c.holds == Some(false));
    Ok(if failed { Code::CheckFailed } else { Code::Fine })
}

fn scene_file(args: &BenchBake, name: &str) -> std::path::PathBuf {
    args.folder.scenes.join(format!("{name}.glb"))
}

/// Returns the command that reproduces the tables.
fn command(args: &BenchBake) -> String {
    let mut command = "adumbra-lab bench bake --suite fast --scenes DIR".to_owned();
    for (option, value) in [
        ("--only", (!args.only.is_empty()).then(|| args.only.join(","))),
        ("--max-n", args.max_n.map(|n| n.to_string())),
        ("--samples", Some(args.samples.to_string())),
    ] {
        if let Some(value) = value {
            command.push_str(&format!(" {option} {value}"));
        }
    }
    command + " -o DIR"
}

/// Bakes a row into `file` and compares it with rays.
fn bake(args: &BenchBake, row: &Row, file: &Path, document: &mut FastResults) -> Result<Figures> {
    let scene = scene_file(args, row.scene);
    let sun = row.sun.map(|c| c.to_string()).join(",");
    let (resolution, thickness) = (row.resolution.to_string(), row.thickness.to_string());
    let mut options = vec!["--sun", &sun, "--resolution", &resolution, "--thickness", &thickness];
    let memory = row.max_memory_bytes().map(|bytes| bytes.to_string());
    options.extend(memory.iter().flat_map(|bytes| ["--max-memory", bytes.as_str()]));
    let said = child::bake_into(file, &scene, &options)?;
    let number = |key: &str| said[key].as_f64().unwrap_or(f64::NAN);
    adumbra_program::note!("{}: {:.2} s, {} bytes", row.name(), number("seconds"), number("file_bytes"));
    document.threads = said["threads"].as_u64().unwrap_or(NO_THREADS);
    let verified = child::verify(file, &scene, args.samples)?;
    let share = |key: &str| verified[key].as_f64().unwrap_or(f64::NAN);
    let side = |a: usize| said["size"][a].as_f64().unwrap_or(f64::NAN);
    Ok(Figures {
        name: row.name(),
        scene: row.scene.to_owned(),
        resolution: row.resolution,
        thickness_world: row.thickness,
        sun: row.sun,
        seconds: number("seconds"),
        peak_bytes: number("peak_bytes"),
        file_bytes: number("file_bytes"),
        drawn_share: number("drawn_texels") / (side(0) * side(1)),
        shadowed_share: share("shadowed_share"),
        interior_agreement: share("interior_agreement"),
        interior: verified["interior"].as_u64().unwrap_or_default(),
    })
}

/// Writes the results measured so far.
fn write(args: &BenchBake, document: &mut FastResults) -> Result<()> {
    document.checks = checks::all(document);
    super::write(&args.output, "fast", &tables::markdown(document), document)
}
