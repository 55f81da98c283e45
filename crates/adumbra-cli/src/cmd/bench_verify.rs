//! `adumbra bench verify`: files of several scenes under several suns, against rays.

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use adumbra::bake::{self, Options, Size};
use adumbra::dag::Slabs;
use adumbra::light::Sun;
use adumbra::query::Query;
use adumbra::scene::LoadOptions;
use adumbra::trace::{TraceOptions, Tracer};
use adumbra::verify::{
    Class, LightAnswers, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions,
    VolumeSampler,
};
use serde_json::{Value, json};

use super::bench::{DEFAULT_SUN, write_tables};
use super::load_scene;
use crate::args::BenchVerify;
use crate::exit::{Code, Failure, Outcome};
use crate::output::make_folder;

/// Degrees above the horizon of the other suns: overhead to nearly level.
const ELEVATIONS_DEGREES: [f64; 6] = [90.0, 60.0, 10.0, 5.0, 3.0, 2.0];
/// Where the other suns stand, degrees clockwise from -Z.
const AZIMUTH_DEGREES: f64 = 55.0;

fn suns() -> Result<Vec<(String, Sun)>, Failure> {
    let mut suns = vec![("(0.5, 0.8, 0.35)".to_owned(), Sun::from_direction(DEFAULT_SUN)?)];
    for elevation in ELEVATIONS_DEGREES {
        suns.push((format!("elevation {elevation}°"), Sun::from_angles(AZIMUTH_DEGREES, elevation)?));
    }
    Ok(suns)
}

pub(super) fn run(args: &BenchVerify) -> Outcome {
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
            let baked = bake::bake_both(&scene, &options, &|_| {}, &AtomicBool::new(false))?;
            let sampler = if args.volume {
                Sampler::Volume(VolumeSampler::new(&baked.grid))
            } else {
                Sampler::Surface(SurfaceSampler::new(&scene, &solids, sun.towards(), false))
            };
            let layouts: [(&str, &dyn Slabs); 2] = [("packed", &baked.dag), ("hierarchy", &baked.hierarchy)];
            for (layout, slabs) in layouts {
                for &filter in &args.filter {
                    let query = Query::new(&baked.grid, slabs, baked.settings.bias, filter)?;
                    let answers = LightAnswers::new(&baked.grid, &baked.settings, query);
                    let options = VerifyOptions { samples: args.samples, seed: 1 };
                    let v = Verifier::new(&answers, &tracer, &solids).run(&sampler, &options);
                    all_hold &= v.holds();
                    let figures = figures(&v)?;
                    eprintln!(
                        "{name} {sun_name} {layout} K = {filter}: interior {:.5}, grazing {:.5}{}",
                        v.interior_agreement,
                        v.class(Class::Grazing).agreement,
                        if v.holds() { "" } else { ", a promise is missed" }
                    );
                    rows.push(json!({
                        "scene": name, "sun": sun_name, "layout": layout, "filter": filter, "holds": v.holds(),
                        "figures": figures,
                    }));
                }
            }
        }
    }
    let stem = if args.volume { "verify-volume" } else { "verify" };
    let text = table(args, &rows);
    write_tables(&args.output, stem, &text, &json!({"resolution": args.resolution, "rows": rows}))?;
    Ok(if all_hold { Code::Fine } else { Code::CheckFailed })
}

fn figures(v: &Verification) -> Result<Value, Failure> {
    serde_json::to_value(v).map_err(|e| Failure::BadInput(e.to_string()))
}

fn table(args: &BenchVerify, rows: &[Value]) -> String {
    let mut text = format!(
        "# Agreement with rays{}\n\nN = {}, {} points drawn for each row. Classes as `adumbra::verify` defines them. Agreement in % of the points of \
        a class (with a filter of K × K texels: 100 less the mean difference from the rays' own mean), behind it the share of compared points \
        in the class; of edges and narrow features the share that is wrong by more than a texel.\n\n\
        | scene | sun | layout | K | all | interior | grazing | edge: misplaced | narrow: misplaced | thin | edge-on | acne | leak | holds |\n\
        |---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        if args.volume { ", points in free space" } else { "" },
        args.resolution,
        args.samples
    );
    for r in rows {
        let f = &r["figures"];
        let samples = f["samples"].as_f64().unwrap_or(f64::NAN);
        let percent = |key: &str| 100.0 * f[key].as_f64().unwrap_or(f64::NAN);
        let class = |class: Class| {
            let all = f["classes"].as_array().map_or(&[] as &[Value], Vec::as_slice);
            all.iter().find(|c| c["class"] == class.name()).cloned().unwrap_or_default()
        };
        let points = |c: &Value| c["points"].as_f64().unwrap_or_default();
        let agreement = |of: Class| {
            let c = class(of);
            let share = 100.0 * points(&c) / samples;
            if points(&c) == 0.0 {
                return "–".to_owned();
            }
            format!("{:.4} ({share:.1})", 100.0 * c["agreement"].as_f64().unwrap_or(f64::NAN))
        };
        let misplaced = |of: Class| {
            let c = class(of);
            let share = 100.0 * points(&c) / samples;
            if points(&c) == 0.0 || r["filter"] != 1 {
                return "–".to_owned();
            }
            format!("{:.3} ({share:.1})", 100.0 * c["misplaced"].as_f64().unwrap_or(f64::NAN) / points(&c))
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.3} | {} | {} | {} | {} | {} | {} | {:.3} | {:.3} | {} |",
            r["scene"].as_str().unwrap_or_default(),
            r["sun"].as_str().unwrap_or_default(),
            r["layout"].as_str().unwrap_or_default(),
            r["filter"],
            percent("agreement"),
            agreement(Class::Interior),
            agreement(Class::Grazing),
            misplaced(Class::Edge),
            misplaced(Class::Narrow),
            agreement(Class::Thin),
            agreement(Class::EdgeOn),
            percent("acne"),
            percent("leak"),
            if r["holds"] == true { "yes" } else { "no" },
        );
    }
    text
}
