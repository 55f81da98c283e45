//! `adumbra-lab bench bake`: the cost of a bake by scene, resolution and option.

use std::fmt::Write as _;

use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::make_folder;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DEFAULT_SUN, child, say_tables, write};
use crate::args::BenchBake;
use adumbra_compare::Result;
use adumbra_html::page::Table;
use adumbra_program::format::{figure, megabytes};

/// All results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct BakeResults {
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// Bakes with the default options, by resolution.
    resolutions: Vec<Row>,
    /// Bakes with each option, at one resolution.
    options: Vec<Row>,
}

/// One bake.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "BakeRow")]
struct Row {
    /// Name of the scene.
    scene: String,
    /// Voxels along the longer side of the grid.
    resolution: u64,
    /// Option that differs from the defaults.
    option: String,
    /// Edge of a voxel in world units.
    voxel_size: f64,
    /// Wall time in seconds, the median of the runs.
    seconds: f64,
    /// `None` if the system does not report it.
    peak_bytes: Option<u64>,
    /// Size of the file.
    file_bytes: u64,
    /// Bits of the file per texel of its grid.
    bits_per_texel: f64,
    /// Nodes of the file.
    nodes: u64,
    /// Leaf masks of the file.
    leaf_masks: u64,
    /// Size of a raw 32-bit shadow map of the same texels, divided by the file's size.
    times_smaller: f64,
}

/// The rows of the option table. Most differ from the first in one way, so that each effect is isolated.
const VARIANTS: [(&str, &[&str]); 7] = [
    ("ground assumed", &["--assume-ground", "yes"]),
    ("no closed regions", &["--assume-ground", "yes", "--no-closed-regions"]),
    ("no ground assumed", &["--assume-ground", "no"]),
    ("neither", &["--assume-ground", "no", "--no-closed-regions"]),
    ("thickness 0.1 m", &["--assume-ground", "yes", "--thickness", "0.1"]),
    ("thickness 0.3 m", &["--assume-ground", "yes", "--thickness", "0.3"]),
    ("static receivers", &["--assume-ground", "yes", "--receivers", "static"]),
];

pub(super) fn run(args: &BenchBake) -> Result<Code> {
    if !args.only.is_empty() || args.max_n.is_some() {
        return Err(Failure::Usage("--only and --max-n need --suite fast".to_owned()).into());
    }
    make_folder(&args.output)?;
    let mut sizes = Vec::new();
    let mut variants = Vec::new();
    for name in &args.names {
        for &resolution in &args.resolutions {
            sizes.push(bake_row(args, name, resolution, &VARIANTS[0])?);
        }
        for variant in &VARIANTS {
            variants.push(bake_row(args, name, args.variant_resolution, variant)?);
        }
    }
    let mut text = String::from("# Bake: seconds, memory and bytes\n\n");
    // Writing to a `String` never fails.
    let _ = writeln!(
        text,
        "Sun towards (0.5, 0.8, 0.35), {} threads, one process per row. `s` is wall time, including loading and \
        writing. `peak MB` is the process's peak resident memory. `× raw` is how many times smaller the file is \
        than a raw 32-bit shadow map with the same texels.\n\n## By resolution\n",
        rayon::current_num_threads()
    );
    text.push_str(&table(&sizes));
    let _ = writeln!(text, "\n## By option, at N = {}\n", args.variant_resolution);
    text.push_str(&table(&variants));
    let document = BakeResults { sun: DEFAULT_SUN, resolutions: sizes, options: variants };
    write(&args.output, "bake", &text, &document)?;
    say_tables(&args.output, "bake");
    Ok(Code::Fine)
}

fn bake_row(args: &BenchBake, name: &str, resolution: u64, variant: &(&str, &[&str])) -> Result<Row> {
    let resolution_words = resolution.to_string();
    let outside: &[&str] = if args.folder.allow_outside { &["--allow-outside"] } else { &[] };
    let options = [&["--resolution", &resolution_words], variant.1, outside].concat();
    let said = child::bake(&args.folder.scenes.join(name), &options)?;
    let number = |key: &str| said[key].as_f64().unwrap_or(f64::NAN);
    let whole = |key: &str| said[key].as_u64();
    let raw =
        said["size"][0].as_f64().unwrap_or(f64::NAN) * said["size"][1].as_f64().unwrap_or(f64::NAN) * 4.0;
    adumbra_program::note!(
        "{name} {resolution} {}: {:.2} s, {} bytes",
        variant.0,
        number("seconds"),
        number("file_bytes")
    );
    Ok(Row {
        scene: name.to_owned(),
        resolution,
        option: variant.0.to_owned(),
        voxel_size: number("voxel_size"),
        seconds: number("seconds"),
        peak_bytes: whole("peak_bytes"),
        file_bytes: whole("file_bytes").unwrap_or_default(),
        bits_per_texel: number("bits_per_texel"),
        nodes: whole("nodes").unwrap_or_default(),
        leaf_masks: whole("leaf_masks").unwrap_or_default(),
        times_smaller: raw / number("file_bytes"),
    })
}

fn table(rows: &[Row]) -> String {
    let table = Table::of(
        "",
        rows,
        &[
            ("scene", |r| r.scene.clone()),
            ("N", |r| r.resolution.to_string()),
            ("options", |r| r.option.clone()),
            ("s", |r| figure(r.seconds, 2)),
            ("peak MB", |r| megabytes(r.peak_bytes, 0)),
            ("file MB", |r| megabytes(r.file_bytes, 2)),
            ("bits/texel", |r| figure(r.bits_per_texel, 3)),
            ("nodes", |r| r.nodes.to_string()),
            ("leaf masks", |r| r.leaf_masks.to_string()),
            ("× raw", |r| figure(r.times_smaller, 0)),
        ],
    );
    table.markdown()
}
