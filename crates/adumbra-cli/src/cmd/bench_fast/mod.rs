//! `adumbra bench bake --suite fast`: what the fast bake and its files are held to, each bake a process of its own.

mod checks;
mod rows;
mod speed;
mod tables;

use std::path::Path;

use clap::ValueEnum;
use serde::Serialize;
use serde_json::Value;

use self::checks::Check;
use self::rows::{QUERY_OF, Row, rows};
use self::speed::Scan;
use super::child;
use crate::args::BenchBake;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, write_whole};

/// What `--only` calls the look-ups.
const QUERY: &str = "query";
/// What the bakes say their threads are, if none was made.
const NO_THREADS: u64 = 0;

/// All figures.
#[derive(Serialize)]
struct Document {
    command: String,
    threads: u64,
    samples: u64,
    checks: Vec<Check>,
    rows: Vec<Figures>,
    /// Look-ups of [`QUERY_OF`], of one core.
    query: Vec<Scan>,
}

/// One bake's figures.
#[derive(Serialize)]
struct Figures {
    name: String,
    scene: &'static str,
    resolution: u64,
    thickness_world: f64,
    /// Towards it.
    sun: [f64; 3],
    layout: Value,
    seconds: f64,
    peak_bytes: f64,
    file_bytes: f64,
    /// Texels that were looked at one by one, of all.
    drawn_share: f64,
    /// Of the points compared, by rays.
    shadowed_share: f64,
    interior_agreement: f64,
    /// Points that the agreement is over.
    interior: u64,
}

pub(super) fn run(args: &BenchBake) -> Outcome {
    let asked =
        |name: &str| args.only.is_empty() || args.only.iter().any(|part| name.contains(part.as_str()));
    let fits = |resolution: u64| args.max_n.is_none_or(|most| resolution <= most);
    let asked_rows: Vec<Row> =
        rows().into_iter().filter(|r| asked(&r.name()) && fits(r.resolution)).collect();
    let query = asked(QUERY) && fits(QUERY_OF.1);
    if asked_rows.is_empty() && !query {
        let names: Vec<String> = rows().iter().map(Row::name).collect();
        return Err(Failure::Usage(format!(
            "--only and --max-n leave no row of {}, {QUERY}",
            names.join(", ")
        )));
    }
    make_folder(&args.output)?;
    let mut document = Document {
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
    say!("{}", args.output.join("fast.md").display());
    let failed = document.checks.iter().any(|c| c.holds == Some(false));
    Ok(if failed { Code::CheckFailed } else { Code::Fine })
}

fn scene_file(args: &BenchBake, name: &str) -> std::path::PathBuf {
    args.scenes.join(format!("{name}.glb"))
}

/// The command that makes the tables again.
fn command(args: &BenchBake) -> String {
    let mut command = "adumbra bench bake --suite fast --scenes DIR".to_owned();
    for (option, value) in [
        ("--only", (!args.only.is_empty()).then(|| args.only.join(","))),
        ("--layout", layout(args)),
        ("--max-n", args.max_n.map(|n| n.to_string())),
        ("--samples", Some(args.samples.to_string())),
    ] {
        if let Some(value) = value {
            command.push_str(&format!(" {option} {value}"));
        }
    }
    command + " -o DIR"
}

fn layout(args: &BenchBake) -> Option<String> {
    args.layout.and_then(|l| l.to_possible_value()).map(|l| l.get_name().to_owned())
}

/// Bakes a row into `file` and compares it with rays.
fn bake(args: &BenchBake, row: &Row, file: &Path, document: &mut Document) -> Result<Figures, Failure> {
    let scene = scene_file(args, row.scene);
    let sun = row.sun.map(|c| c.to_string()).join(",");
    let (resolution, thickness) = (row.resolution.to_string(), row.thickness.to_string());
    let mut options = vec!["--sun", &sun, "--resolution", &resolution, "--thickness", &thickness];
    let (layout, memory) = (layout(args), row.max_memory_bytes().map(|bytes| bytes.to_string()));
    options.extend(memory.iter().flat_map(|bytes| ["--max-memory", bytes.as_str()]));
    options.extend(layout.iter().flat_map(|l| ["--layout", l.as_str()]));
    let said = child::bake_into(file, &scene, &options)?;
    let number = |key: &str| said[key].as_f64().unwrap_or(f64::NAN);
    eprintln!("{}: {:.2} s, {} bytes", row.name(), number("seconds"), number("file_bytes"));
    document.threads = said["threads"].as_u64().unwrap_or(NO_THREADS);
    let verified = child::verify(file, &scene, args.samples)?;
    let share = |key: &str| verified[key].as_f64().unwrap_or(f64::NAN);
    let side = |a: usize| said["size"][a].as_f64().unwrap_or(f64::NAN);
    Ok(Figures {
        name: row.name(),
        scene: row.scene,
        resolution: row.resolution,
        thickness_world: row.thickness,
        sun: row.sun,
        layout: said["layout"].clone(),
        seconds: number("seconds"),
        peak_bytes: number("peak_bytes"),
        file_bytes: number("file_bytes"),
        drawn_share: number("drawn_texels") / (side(0) * side(1)),
        shadowed_share: share("shadowed_share"),
        interior_agreement: share("interior_agreement"),
        interior: verified["interior"].as_u64().unwrap_or_default(),
    })
}

/// Writes what there is so far.
fn write(args: &BenchBake, document: &mut Document) -> Result<(), Failure> {
    document.checks = checks::all(document);
    write_whole(&args.output.join("fast.md"), tables::markdown(document).as_bytes())?;
    let json = serde_json::to_value(&*document).map_err(|e| Failure::BadInput(e.to_string()))?;
    write_whole(&args.output.join("fast.json"), format!("{json:#}\n").as_bytes())
}
