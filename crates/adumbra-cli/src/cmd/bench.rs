//! `adumbra bench`: which table, and the tables of what a bake costs.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};

use super::child;
use crate::args::{Bench, BenchBake, BenchVerb, SuiteArg};
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, write_whole};

pub(crate) fn run(args: &Bench) -> Outcome {
    match &args.what {
        BenchVerb::Bake(a) if a.suite == SuiteArg::Fast => super::bench_fast::run(a),
        BenchVerb::Bake(a) => bake_tables(a),
        BenchVerb::Verify(a) => super::bench_verify::run(a),
        BenchVerb::Tree(a) => super::bench_tree::run(a),
        BenchVerb::Hrsm(a) => super::bench_hrsm::run(a),
        BenchVerb::Ao(a) => super::bench_ao::run(a),
        BenchVerb::Blur(a) => super::bench_blur::run(a),
        BenchVerb::Peers(a) => super::bench_peers::run(a),
        BenchVerb::Shadows(a) => super::bench_shadows::run(a),
    }
}

pub(super) const DEFAULT_SUN: [f64; 3] = [0.5, 0.8, 0.35];

/// The option table: each line changes the default in one way, so that its effect stands alone.
const VARIANTS: [(&str, &[&str]); 7] = [
    ("default: closed regions, ground assumed", &[]),
    ("no closed regions", &["--no-closed-regions"]),
    ("no ground assumed", &["--no-assume-ground"]),
    ("neither", &["--no-closed-regions", "--no-assume-ground"]),
    ("thickness 0.1 m", &["--thickness", "0.1"]),
    ("thickness 0.3 m", &["--thickness", "0.3"]),
    ("static receivers", &["--receivers", "static"]),
];

fn bake_tables(args: &BenchBake) -> Outcome {
    if !args.only.is_empty() || args.max_n.is_some() || args.layout.is_some() {
        return Err(Failure::Usage("--only, --max-n and --layout are for --suite fast".to_owned()));
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
    // Writing to a String does not fail.
    let _ = writeln!(
        text,
        "Sun towards (0.5, 0.8, 0.35), {} threads, a process a row. `s` is wall time, loading and writing included; \
        `peak MB` the process's largest resident size; `× raw` how many times smaller the file is than a raw 32-bit \
        shadow map of the same texels.\n\n## By resolution\n",
        rayon::current_num_threads()
    );
    text.push_str(&table(&sizes));
    let _ = writeln!(text, "\n## By option, at {}\n", args.variant_resolution);
    text.push_str(&table(&variants));
    let document = json!({"sun": DEFAULT_SUN, "resolutions": sizes, "options": variants});
    write_tables(&args.output, "bake", &text, &document)
}

fn bake_row(
    args: &BenchBake,
    name: &str,
    resolution: u64,
    variant: &(&str, &[&str]),
) -> Result<Value, Failure> {
    let resolution_words = resolution.to_string();
    let outside: &[&str] = if args.allow_outside { &["--allow-outside"] } else { &[] };
    let options = [&["--resolution", &resolution_words], variant.1, outside].concat();
    let said = child::bake(&args.scenes.join(name), &options)?;
    let number = |key: &str| said[key].as_f64().unwrap_or(f64::NAN);
    let raw =
        said["size"][0].as_f64().unwrap_or(f64::NAN) * said["size"][1].as_f64().unwrap_or(f64::NAN) * 4.0;
    eprintln!(
        "{name} {resolution} {}: {:.2} s, {} bytes",
        variant.0,
        number("seconds"),
        number("file_bytes")
    );
    Ok(json!({
        "scene": name,
        "resolution": resolution,
        "option": variant.0,
        "voxel_size": said["voxel_size"],
        "seconds": said["seconds"],
        "peak_bytes": said["peak_bytes"],
        "file_bytes": said["file_bytes"],
        "bits_per_texel": said["bits_per_texel"],
        "nodes": said["nodes"],
        "slabs": said["slabs"],
        "times_smaller": raw / number("file_bytes"),
    }))
}

fn table(rows: &[Value]) -> String {
    let mut text = String::from(
        "| scene | N | options | s | peak MB | file MB | bits/texel | nodes | slabs | × raw |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        let number = |key: &str| r[key].as_f64().unwrap_or(f64::NAN);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.2} | {:.0} | {:.2} | {:.3} | {} | {} | {:.0} |",
            r["scene"].as_str().unwrap_or_default(),
            r["resolution"],
            r["option"].as_str().unwrap_or_default(),
            number("seconds"),
            number("peak_bytes") / 1e6,
            number("file_bytes") / 1e6,
            number("bits_per_texel"),
            r["nodes"],
            r["slabs"],
            number("times_smaller"),
        );
    }
    text
}

pub(super) fn write_tables(folder: &Path, stem: &str, text: &str, document: &Value) -> Outcome {
    write_whole(&folder.join(format!("{stem}.md")), text.as_bytes())?;
    write_whole(&folder.join(format!("{stem}.json")), format!("{document:#}\n").as_bytes())?;
    say!("{}", folder.join(format!("{stem}.md")).display());
    Ok(Code::Fine)
}
