//! `adumbra bench tree`: what the paper measured of its tree, and what each option beside it costs; tables as Markdown
//! and JSON, plots as SVG, pictures as PNG.

mod builders;
mod filters;
mod frames;
mod options;
mod reductions;

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use adumbra::Error;
use adumbra::bake::Size;
use adumbra::light::Sun;
use adumbra::scene::{GeneratedKind, LoadOptions, Scene, generate, write_glb};
use adumbra::trace::{TraceOptions, Tracer};
use adumbra::tree::{BakedTree, TreeOptions, bake_tree};
use adumbra::verify::{Answers, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions};
use serde_json::{Map, Value, json};

use super::{child, load_scene};
use crate::args::BenchTree;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, write_whole};

/// Seed of the scenes that are made.
const SEED: u64 = 1;
const SUN: [f64; 3] = [0.5, 0.8, 0.35];
/// From this depth on builders skip what the min/max pyramid decides.
const FIRST_PRUNED_DEPTH: u32 = 11;

/// A scene of the tables.
struct BenchScene {
    name: String,
    /// Where other processes find it.
    path: PathBuf,
    /// Whether it may read files outside its folder.
    allow_outside: bool,
    scene: Scene,
}

/// One part of the report: what it measures, and how that reads.
struct Section {
    /// Its name for `--only`, and its key in the JSON file.
    key: &'static str,
    measure: fn(&BenchTree, &[BenchScene]) -> Result<Value, Failure>,
    markdown: fn(&Value) -> String,
    /// Writes its plots into a folder.
    plots: fn(&Path, &Value) -> Result<(), Failure>,
}

const SECTIONS: [Section; 5] = [
    Section {
        key: "builders",
        measure: builders::measure,
        markdown: builders::markdown,
        plots: builders::plots,
    },
    Section {
        key: "reductions",
        measure: reductions::measure,
        markdown: reductions::markdown,
        plots: reductions::plots,
    },
    Section { key: "frames", measure: frames::measure, markdown: frames::markdown, plots: no_plots },
    Section { key: "options", measure: options::measure, markdown: options::markdown, plots: options::plots },
    Section { key: "filters", measure: filters::measure, markdown: filters::markdown, plots: no_plots },
];

pub(super) fn run(args: &BenchTree) -> Outcome {
    make_folder(&args.output)?;
    let made = tempfile::tempdir().map_err(Error::io("create", std::env::temp_dir()))?;
    let mut scenes = Vec::new();
    for name in &args.names {
        let kind = match name.as_str() {
            "primitives" => Some(GeneratedKind::Primitives),
            "landscape" => Some(GeneratedKind::Landscape),
            _ => None,
        };
        let path = match kind {
            Some(kind) => {
                let path = made.path().join(format!("{name}.glb"));
                write_glb(&generate(kind, SEED), &path)?;
                path
            }
            None => args.scenes.join(name),
        };
        let allow_outside = args.allow_outside;
        let load = LoadOptions { color_textures: true, allow_outside, ..LoadOptions::default() };
        let scene = load_scene(&path, &load)?;
        let name = name.rsplit_once('.').map_or(name.as_str(), |(stem, _)| stem).to_owned();
        scenes.push(BenchScene { name, path, allow_outside, scene });
    }
    let json_path = args.output.join("tree.json");
    // Sections that are not measured now keep what was measured before.
    let mut document = if args.only.is_empty() { Map::new() } else { earlier(&json_path)? };
    for section in SECTIONS {
        if !args.only.is_empty() && !args.only.iter().any(|key| key == section.key) {
            continue;
        }
        let measured = json!({
            "runs": args.runs, "samples": args.samples, "threads": rayon::current_num_threads(),
            "rows": (section.measure)(args, &scenes)?,
        });
        document.insert(section.key.to_owned(), measured);
        // What is measured stays, whatever happens to the next section.
        write_whole(&json_path, format!("{:#}\n", Value::Object(document.clone())).as_bytes())?;
        write_whole(&args.output.join("tree.md"), markdown(&document).as_bytes())?;
    }
    for section in SECTIONS {
        if let Some(part) = document.get(section.key) {
            (section.plots)(&args.output, part)?;
        }
    }
    say!("{}", args.output.join("tree.md").display());
    Ok(Code::Fine)
}

/// Scenes of a section's rows, in their order.
fn scene_names(part: &Value) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for row in rows_of(part) {
        let name = text_of(row, "scene");
        if names.last().is_none_or(|last| last != name) {
            names.push(name.to_owned());
        }
    }
    names
}

/// What an earlier run wrote; empty where there was none.
fn earlier(path: &Path) -> Result<Map<String, Value>, Failure> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Map::new()),
        Err(e) => return Err(Error::io("read", path)(e).into()),
    };
    serde_json::from_slice(&bytes).map_err(|e| {
        Failure::BadInput(format!("{}: not what an earlier run wrote ({e}); remove it", path.display()))
    })
}

fn markdown(document: &Map<String, Value>) -> String {
    let mut text = format!(
        "# The voxel tree, measured\n\nWorld-aligned trees, sun towards (0.5, 0.8, 0.35). `primitives` and `landscape` are made with seed \
        {SEED}. Depth n = 2^n voxels across the cube. 1 MB = 10^6 bytes.\n"
    );
    for section in SECTIONS {
        if let Some(part) = document.get(section.key) {
            text.push_str(&(section.markdown)(part));
        }
    }
    text
}

fn no_plots(_: &Path, _: &Value) -> Result<(), Failure> {
    Ok(())
}

fn number(row: &Value, path: &str) -> f64 {
    row.pointer(path).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

fn text_of<'v>(row: &'v Value, key: &str) -> &'v str {
    row[key].as_str().unwrap_or_default()
}

fn rows_of(part: &Value) -> &[Value] {
    part["rows"].as_array().map_or(&[], Vec::as_slice)
}

fn tree_options(depth: u32) -> Result<TreeOptions, Failure> {
    Ok(TreeOptions::new(Sun::from_direction(SUN)?, Size::Resolution(1 << depth)))
}

fn bake_quietly(scene: &BenchScene, options: &TreeOptions) -> Result<BakedTree, Failure> {
    Ok(bake_tree(&scene.scene, options, &|_| {}, &AtomicBool::new(false))?)
}

/// The middle one; of an even number the upper.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// What a bake in a process of its own says of itself.
fn bake_elsewhere(scene: &BenchScene, options: &[&str]) -> Result<Value, Failure> {
    let outside: &[&str] = if scene.allow_outside { &["--allow-outside"] } else { &[] };
    child::bake(&scene.path, &[&["--frame", "world"], options, outside].concat())
}

/// Answers against rays at points on a scene's surfaces.
struct Check<'a> {
    tracer: Tracer<'a>,
    solids: Solids,
    scene: &'a Scene,
    samples: u64,
}

impl<'a> Check<'a> {
    fn new(scene: &'a Scene, samples: u64) -> Self {
        let tracer = Tracer::build(scene, TraceOptions { ignore_alpha: false });
        Self { tracer, solids: Solids::of(scene), scene, samples }
    }

    fn run(&self, answers: &impl Answers) -> Verification {
        let surface = SurfaceSampler::new(self.scene, &self.solids, answers.towards_sun(), false);
        let options = VerifyOptions { samples: self.samples, seed: 1 };
        Verifier::new(answers, &self.tracer, &self.solids).run(&Sampler::Surface(surface), &options)
    }
}
