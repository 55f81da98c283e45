//! `adumbra bench tree`: what the paper measured of its tree, and what each option beside it costs; tables as Markdown
//! and JSON, plots as SVG, pictures as PNG.

mod builders;
mod filters;
mod frames;
mod options;

use std::path::PathBuf;
use std::process::{Command, Stdio};

use adumbra::Error;
use adumbra::bake::Size;
use adumbra::light::Sun;
use adumbra::scene::{GeneratedKind, LoadOptions, Scene, generate, write_glb};
use adumbra::trace::{TraceOptions, Tracer};
use adumbra::tree::TreeOptions;
use adumbra::verify::{Answers, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions};
use serde_json::{Value, json};

use super::load_scene;
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
    scene: Scene,
}

/// One part of the report.
struct Section {
    markdown: String,
    key: &'static str,
    rows: Value,
}

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
        let scene = load_scene(&path, &LoadOptions { color_textures: true, ..LoadOptions::default() })?;
        let name = name.rsplit_once('.').map_or(name.as_str(), |(stem, _)| stem).to_owned();
        scenes.push(BenchScene { name, path, scene });
    }
    let mut text = format!(
        "# The voxel tree, measured\n\nWorld-aligned trees, sun towards (0.5, 0.8, 0.35), medians of {} runs that take turns, one \
        thread but for the depth image. `primitives` and `landscape` are made with seed {SEED}. Depth n = 2^n voxels across the cube. \
        Up to depth 10 builders test every voxel; from depth {FIRST_PRUNED_DEPTH} they skip cubes that the min/max pyramid decides. \
        1 MB = 10^6 bytes.\n",
        args.runs
    );
    let mut document = json!({ "sun": SUN, "seed": SEED, "runs": args.runs });
    let sections = [builders::measure, frames::measure, options::measure, filters::measure];
    for measure in sections {
        let section = measure(args, &scenes)?;
        text.push_str(&section.markdown);
        document[section.key] = section.rows;
        // What is measured stays, whatever happens to the next section.
        write_whole(&args.output.join("tree.md"), text.as_bytes())?;
        write_whole(&args.output.join("tree.json"), format!("{document:#}\n").as_bytes())?;
    }
    say!("{}", args.output.join("tree.md").display());
    Ok(Code::Fine)
}

fn tree_options(depth: u32) -> Result<TreeOptions, Failure> {
    Ok(TreeOptions::new(Sun::from_direction(SUN)?, Size::Resolution(1 << depth)))
}

/// The middle one; of an even number the upper.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// What a bake in a process of its own says of itself.
fn bake_elsewhere(scene: &BenchScene, options: &[&str]) -> Result<Value, Failure> {
    let program = std::env::current_exe().map_err(Error::io("find", "this program"))?;
    let file = tempfile::Builder::new()
        .suffix(".adumbra")
        .tempfile()
        .map_err(Error::io("create", std::env::temp_dir()))?;
    let mut command = Command::new(&program);
    command.arg("bake").arg(&scene.path).arg("-o").arg(file.path());
    command.args(["--sun", "0.5,0.8,0.35", "--progress", "none", "--json", "--frame", "world"]).args(options);
    let output = command.stderr(Stdio::inherit()).output().map_err(Error::io("run", &program))?;
    if !output.status.success() {
        let what = format!("the bake of {} failed: {}", scene.path.display(), output.status);
        return Err(Failure::BadInput(what));
    }
    serde_json::from_slice(&output.stdout).map_err(|e| Failure::BadInput(e.to_string()))
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
