//! `adumbra bench`: tables of what a bake costs and how right it is.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use adumbra::bake::{self, Options, Size};
use adumbra::light::Sun;
use adumbra::query::Query;
use adumbra::scene::LoadOptions;
use adumbra::trace::{TraceOptions, Tracer};
use adumbra::verify::{
    LightAnswers, Sampler, Solids, SurfaceSampler, Verifier, VerifyOptions, VolumeSampler,
};
use serde_json::{Value, json};

use super::{child, load_scene};
use crate::args::{Bench, BenchBake, BenchVerb, BenchVerify, SuiteArg};
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, write_whole};

const DEFAULT_SUN: [f64; 3] = [0.5, 0.8, 0.35];

pub(crate) fn run(args: &Bench) -> Outcome {
    match &args.what {
        BenchVerb::Bake(a) if a.suite == SuiteArg::Fast => super::bench_fast::run(a),
        BenchVerb::Bake(a) => bake_tables(a),
        BenchVerb::Verify(a) => verify_table(a),
        BenchVerb::Tree(a) => super::bench_tree::run(a),
        BenchVerb::Hrsm(a) => super::bench_hrsm::run(a),
        BenchVerb::Ao(a) => super::bench_ao::run(a),
        BenchVerb::Blur(a) => super::bench_blur::run(a),
        BenchVerb::Peers(a) => super::bench_peers::run(a),
        BenchVerb::Shadows(a) => super::bench_shadows::run(a),
    }
}

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

/// The suns of the verification table: the default, overhead, low and nearly level.
fn suns() -> Result<[(&'static str, Sun); 4], Failure> {
    Ok([
        ("(0.5, 0.8, 0.35)", Sun::from_direction(DEFAULT_SUN)?),
        ("elevation 90°", Sun::from_angles(55.0, 90.0)?),
        ("elevation 10°", Sun::from_angles(55.0, 10.0)?),
        ("elevation 3°", Sun::from_angles(55.0, 3.0)?),
    ])
}

/// What `verify` demands of the interior.
const MIN_INTERIOR_AGREEMENT: f64 = 0.999;
const MIN_INTERIOR_SHARE: f64 = 0.7;

fn verify_table(args: &BenchVerify) -> Outcome {
    make_folder(&args.output)?;
    let mut rows = Vec::new();
    let mut all_hold = true;
    for name in &args.names {
        let load = LoadOptions { allow_outside: args.allow_outside, ..LoadOptions::default() };
        let scene = load_scene(&args.scenes.join(name), &load)?;
        let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: false });
        let solids = Solids::of(&scene);
        for (sun_name, sun) in suns()? {
            let options = Options {
                assume_ground: !args.volume,
                ..Options::new(sun, Size::Resolution(args.resolution))
            };
            let baked = bake::bake(&scene, &options, &|_| {}, &AtomicBool::new(false))?;
            let sampler = if args.volume {
                Sampler::Volume(VolumeSampler::new(&baked.grid))
            } else {
                Sampler::Surface(SurfaceSampler::new(&scene, &solids, sun.towards(), false))
            };
            let query = Query::new(&baked.grid, &baked.dag, baked.settings.bias, 1)?;
            let answers = LightAnswers::new(&baked.grid, &baked.settings, query);
            let options = VerifyOptions { samples: args.samples, seed: 1 };
            let v = Verifier::new(&answers, &tracer, &solids).run(&sampler, &options);
            let holds = v.interior_agreement >= MIN_INTERIOR_AGREEMENT
                && (args.volume || v.interior_share >= MIN_INTERIOR_SHARE);
            all_hold &= holds;
            eprintln!(
                "{name} {sun_name}: interior {:.5}, share {:.3}",
                v.interior_agreement, v.interior_share
            );
            let figures = serde_json::to_value(v).map_err(|e| Failure::BadInput(e.to_string()))?;
            rows.push(json!({"scene": name, "sun": sun_name, "holds": holds, "figures": figures}));
        }
    }
    let stem = if args.volume { "verify-volume" } else { "verify" };
    let mut text = format!(
        "# Agreement with rays{}\n\nN = {}, {} points a row. Interior and thin as `adumbra::verify` defines them; shares in %.\n\n\
        | scene | sun | agreement | interior agreement | interior share | acne | leak | thin | thin wrong | holds |\n|---|---|---|---|---|---|---|---|---|---|\n",
        if args.volume { ", points in free space" } else { "" },
        args.resolution,
        args.samples
    );
    for r in &rows {
        let f = &r["figures"];
        let percent = |key: &str| 100.0 * f[key].as_f64().unwrap_or(f64::NAN);
        let _ = writeln!(
            text,
            "| {} | {} | {:.3} | {:.4} | {:.1} | {:.3} | {:.3} | {} | {} | {} |",
            r["scene"].as_str().unwrap_or_default(),
            r["sun"].as_str().unwrap_or_default(),
            percent("agreement"),
            percent("interior_agreement"),
            percent("interior_share"),
            percent("acne"),
            percent("leak"),
            f["thin"],
            f["thin_wrong"],
            if r["holds"] == true { "yes" } else { "no" },
        );
    }
    write_tables(&args.output, stem, &text, &json!({"resolution": args.resolution, "rows": rows}))?;
    Ok(if all_hold { Code::Fine } else { Code::CheckFailed })
}

fn write_tables(folder: &Path, stem: &str, text: &str, document: &Value) -> Outcome {
    write_whole(&folder.join(format!("{stem}.md")), text.as_bytes())?;
    write_whole(&folder.join(format!("{stem}.json")), format!("{document:#}\n").as_bytes())?;
    say!("{}", folder.join(format!("{stem}.md")).display());
    Ok(Code::Fine)
}
