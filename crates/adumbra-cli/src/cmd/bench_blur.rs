//! `adumbra bench blur`: what the screen-space blur costs by samples, passes and weights, and what it spoils.

use std::fmt::Write as _;

use adumbra::camera::Camera;
use adumbra::light::Sun;
use adumbra::scene::{GeneratedKind, generate};
use adumbra_render::frame::frame;
use adumbra_render::readback::read_floats;
use adumbra_render::screen_blur::twin::{Surfaces, bleeding};
use adumbra_render::{Answer, Baked, Gpu, Renderer, SceneOptions, Shot, Stage, build};
use serde_json::{Value, json};

use super::print_json;
use crate::args::BenchBlur;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, write_whole};
use crate::plot::{Along, Legend, Panel, Series, write_svg};

/// Name, technique and parameters; samples follow.
const TWO_PASSES: [(&str, &str); 6] = [
    ("weights in the shader", "blur:weights=shader"),
    ("weights once", "blur"),
    ("pairs", "blur:pairs=on"),
    ("half size", "blur:half=on"),
    ("half size, pairs", "blur:half=on:pairs=on"),
    ("within surfaces", "blur-bilateral"),
];
const ONE_PASS: [(&str, &str); 3] = [
    ("weights in the shader", "blur:passes=1:weights=shader"),
    ("weights once", "blur:passes=1"),
    ("within surfaces", "blur-bilateral:passes=1"),
];
/// What is drawn to count what it spoils.
const SPOILS: [(&str, &str); 6] = [
    ("blur", "blur"),
    ("dilated by 1", "blur-dilate:radius=1"),
    ("dilated by 2", "blur-dilate:radius=2"),
    ("dilated by 4", "blur-dilate:radius=4"),
    ("within surfaces", "blur-bilateral"),
    ("within surfaces, half size", "blur-bilateral:half=on"),
];
const SPOIL_SAMPLES: u32 = 32;
const SCENE_SEED: u64 = 1;

struct Bench<'a> {
    args: &'a BenchBlur,
    renderer: Renderer,
    shot: Shot,
}

pub(super) fn run(args: &BenchBlur) -> Outcome {
    make_folder(&args.output)?;
    let gpu = Gpu::request(&args.device.gpu_options())?;
    let device = gpu.name();
    let scene = generate(GeneratedKind::Primitives, SCENE_SEED);
    let towards_sun = Sun::from_direction([0.5, 0.8, 0.35])?.towards();
    let [width, height] = args.size;
    let camera = Camera { width, height, ..Camera::overview(&scene.bounds(), 45.0) };
    let renderer = Renderer::new(gpu, &scene, SceneOptions::default())?;
    let mut bench = Bench { args, renderer, shot: Shot { camera, towards_sun, number: 0 } };
    let (two, wall_time) = bench.costs(&TWO_PASSES)?;
    let (one, _) = bench.costs(&ONE_PASS)?;
    let spoils = bench.spoils()?;
    let document = json!({
        "device": device, "size": args.size, "runs": args.runs, "wall_time": wall_time, "two_passes": two, "one_pass": one,
        "spoils": spoils,
    });
    let path = args.output.join("blur.md");
    write_whole(&path, bench.markdown(&document).as_bytes())?;
    write_whole(&args.output.join("blur.json"), format!("{document:#}\n").as_bytes())?;
    let panels = [("Two passes", "two_passes"), ("One pass", "one_pass")].map(|(title, key)| Panel {
        title: title.to_owned(),
        along: Along::Numbers("samples"),
        y_label: "ms",
        logarithmic: true,
        legend: Legend::LowerLeft,
        series: series(&document[key]),
    });
    write_svg(&args.output.join("blur.svg"), &panels)?;
    if args.json {
        print_json(&document);
    } else {
        say!("{}", path.display());
    }
    Ok(Code::Fine)
}

impl Bench<'_> {
    /// Median milliseconds by variant and samples, and whether they are wall times.
    fn costs(&mut self, variants: &[(&str, &str)]) -> Result<(Vec<Value>, bool), Failure> {
        let mut rows = Vec::new();
        let mut wall_time = false;
        for (name, technique) in variants {
            let mut milliseconds = Vec::new();
            for samples in &self.args.samples {
                let spec = format!("{technique}:samples={samples}").parse()?;
                let built = build(self.renderer.gpu(), &spec, Baked::default())?;
                let mut prepared = self.renderer.prepare(built)?;
                let mut times = Vec::new();
                // The first frame makes what later ones keep.
                for run in 0..=self.args.runs {
                    let drawn = self.renderer.draw(&self.shot, &mut prepared, Answer::Visibility)?;
                    wall_time = drawn.wall_time;
                    if run > 0 {
                        times.push(drawn.of(Stage::Screen));
                    }
                }
                times.sort_by(f64::total_cmp);
                milliseconds.push(times[times.len() / 2]);
                eprintln!("{spec}: {:.2} ms", times[times.len() / 2]);
            }
            rows.push(json!({
                "name": name, "technique": technique, "samples": self.args.samples, "milliseconds": milliseconds,
            }));
        }
        Ok((rows, wall_time))
    }

    /// Pixels that a blur changes across silhouettes.
    fn spoils(&mut self) -> Result<Vec<Value>, Failure> {
        let mut rows = Vec::new();
        for (name, technique) in SPOILS {
            let spec = format!("{technique}:samples={SPOIL_SAMPLES}").parse()?;
            let built = build(self.renderer.gpu(), &spec, Baked::default())?;
            let mut prepared = self.renderer.prepare(built)?;
            self.renderer.draw(&self.shot, &mut prepared, Answer::Visibility)?;
            let blurred = self.renderer.read_factor(&prepared)?;
            let Some(targets) = self.renderer.targets() else { continue };
            let gpu = self.renderer.gpu();
            let factor = read_floats(gpu, &targets.factor.texture, 0, 0)?;
            let depth = read_floats(gpu, &targets.depth.texture, 0, 0)?;
            let normal = self.renderer.read_surface(&self.shot)?.normal;
            let frame = frame(&self.shot.camera, &self.renderer.bounds(), self.shot.towards_sun, 0);
            let surfaces = Surfaces { frame, depth: &depth, normal: &normal };
            let found = bleeding(&factor, &blurred, &surfaces, SPOIL_SAMPLES / 2 + 4);
            rows.push(json!({
                "name": name, "technique": technique, "samples": SPOIL_SAMPLES, "halo": found.halo, "gap": found.gap,
                "largest": found.largest,
            }));
        }
        Ok(rows)
    }

    fn markdown(&self, document: &Value) -> String {
        let mut text = String::from("# Screen-space blur\n\n");
        let clock = if document["wall_time"] == true { "wall times" } else { "GPU timestamps" };
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "{}, {} × {} pixels, the blur's own passes, median of {} ({clock}). Two passes cost as many samples as a line has, one \
             pass their square; weights computed in the shader cost an exponential a sample. Made by `adumbra bench blur --size \
             {}x{} --runs {} -o docs/bench`.\n\n![Milliseconds by samples](blur.svg)",
            document["device"].as_str().unwrap_or_default(),
            self.args.size[0],
            self.args.size[1],
            self.args.runs,
            self.args.size[0],
            self.args.size[1],
            self.args.runs,
        );
        for (title, key) in [("Two passes", "two_passes"), ("One pass", "one_pass")] {
            let head: Vec<String> = self.args.samples.iter().map(u32::to_string).collect();
            let _ =
                write!(text, "\n## {title}, milliseconds by samples\n\n| | {} |\n|---|", head.join(" | "));
            text += &"---|".repeat(head.len());
            text.push('\n');
            for row in document[key].as_array().into_iter().flatten() {
                let cells = row["milliseconds"].as_array().into_iter().flatten();
                let cells: Vec<String> =
                    cells.map(|m| format!("{:.2}", m.as_f64().unwrap_or(f64::NAN))).collect();
                let name = row["name"].as_str().unwrap_or_default();
                let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
            }
        }
        let _ = write!(
            text,
            "\n## What it spoils\n\nPixels that {SPOIL_SAMPLES} samples change by more than 0.02 though nothing on their own surface \
             within reach differs: lit ones are a halo about shadows behind or before them, shadowed ones a gap between an object \
             and its shadow.\n\n| | halo | gap | largest change |\n|---|---|---|---|\n"
        );
        for row in document["spoils"].as_array().into_iter().flatten() {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {:.3} |",
                row["name"].as_str().unwrap_or_default(),
                row["halo"],
                row["gap"],
                row["largest"].as_f64().unwrap_or(f64::NAN)
            );
        }
        text
    }
}

fn series(rows: &Value) -> Vec<Series> {
    let numbers =
        |v: &Value| -> Vec<f64> { v.as_array().into_iter().flatten().filter_map(Value::as_f64).collect() };
    let rows = rows.as_array().into_iter().flatten();
    rows.map(|row| Series {
        name: row["name"].as_str().unwrap_or_default().to_owned(),
        points: numbers(&row["samples"]).into_iter().zip(numbers(&row["milliseconds"])).collect(),
    })
    .collect()
}
