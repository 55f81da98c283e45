//! `adumbra-lab bench tree`: the paper's measurements of its tree, and the cost of each option added to it.
//!
//! Tables are written as Markdown and JSON, plots as SVG, pictures as PNG.

mod builders;
mod filters;
mod frames;
mod options;
mod reductions;
mod results;

use adumbra::IoError;
use adumbra_bake::Watch;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use self::results::Part;
pub(crate) use self::results::{FrameRow, OptionRow, ReductionRow, TreeResults};
use adumbra::Sun;
use adumbra_bake::Size;
use adumbra_files::{TEXT_BYTES, read_whole};
use adumbra_papers::tree::query::{TreeQuery, Weights};
use adumbra_papers::tree::{BakedTree, PreparedTree, TreeOptions, VoxelTree, bake_tree};
use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::make_folder;
use adumbra_program::scene::load_scene;
use adumbra_scene::{GeneratedKind, LoadOptions, Scene, generate, write_glb};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{
    Answers, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions,
};
use serde_json::Value;

use super::{child, say_tables, write};
use crate::args::BenchTree;
use adumbra_compare::Result;
use adumbra_compare::metrics::median;

/// Seed of the generated scenes.
const SEED: u64 = 1;
const SUN: [f64; 3] = [0.5, 0.8, 0.35];
/// Smallest depth at which builders skip the cubes that the min/max pyramid decides.
const FIRST_PRUNED_DEPTH: u32 = 11;

/// A scene of the tables.
struct BenchScene {
    name: String,
    /// Path that other processes load it from.
    path: PathBuf,
    /// Whether it may read files outside its folder.
    allow_outside: bool,
    scene: Scene,
}

pub(super) fn run(args: &BenchTree) -> Result<Code> {
    make_folder(&args.output)?;
    let made = tempfile::tempdir().map_err(IoError::at("create", std::env::temp_dir()))?;
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
            None => args.folder.scenes.join(name),
        };
        let allow_outside = args.folder.allow_outside;
        let load = LoadOptions { color_textures: true, allow_outside, ..LoadOptions::default() };
        let scene = load_scene(&path, &load)?;
        let name = name.rsplit_once('.').map_or(name.as_str(), |(stem, _)| stem).to_owned();
        scenes.push(BenchScene { name, path, allow_outside, scene });
    }
    // Sections that this run does not measure keep their earlier results.
    let mut document =
        if args.only.is_empty() { TreeResults::default() } else { earlier(&args.output.join("tree.json"))? };
    document.measure(args, &scenes, "builders", builders::measure, |d| &mut d.builders)?;
    document.measure(args, &scenes, "reductions", reductions::measure, |d| &mut d.reductions)?;
    document.measure(args, &scenes, "frames", frames::measure, |d| &mut d.frames)?;
    document.measure(args, &scenes, "options", options::measure, |d| &mut d.options)?;
    document.measure(args, &scenes, "filters", filters::measure, |d| &mut d.filters)?;
    say_tables(&args.output, "tree");
    Ok(Code::Fine)
}

impl TreeResults {
    /// Measures a section if the arguments ask for it.
    ///
    /// Results are saved after every section, so that a failure loses only the section in progress.
    fn measure<R>(
        &mut self,
        args: &BenchTree,
        scenes: &[BenchScene],
        key: &str,
        rows: fn(&BenchTree, &[BenchScene]) -> Result<R>,
        section: fn(&mut Self) -> &mut Option<Part<R>>,
    ) -> Result<()> {
        if !args.only.is_empty() && args.only.iter().all(|only| only != key) {
            return Ok(());
        }
        let rows = rows(args, scenes)?;
        let (runs, samples, threads) = (args.runs, args.samples, rayon::current_num_threads());
        *section(self) = Some(Part { runs, samples, threads, rows });
        save(args, self)
    }
}

/// Writes tables, figures and plots of the sections measured so far.
fn save(args: &BenchTree, document: &TreeResults) -> Result<()> {
    write(&args.output, "tree", &markdown(document), document)?;
    if let Some(part) = &document.builders {
        builders::plots(&args.output, &part.rows)?;
    }
    if let Some(part) = &document.reductions {
        reductions::plots(&args.output, &part.rows)?;
    }
    if let Some(part) = &document.options {
        options::plots(&args.output, &part.rows)?;
    }
    Ok(())
}

/// Returns the scene names of a section's rows, in order and without adjacent repeats.
fn scene_names<'r>(rows: impl Iterator<Item = &'r String>) -> Vec<String> {
    let mut names: Vec<String> = rows.cloned().collect();
    names.dedup();
    names
}

/// Reads the results of an earlier run. Returns an empty document if there is no such file.
fn earlier(path: &Path) -> Result<TreeResults> {
    let bytes = match read_whole(path, TEXT_BYTES) {
        Ok(bytes) => bytes,
        Err(e) if e.source.kind() == ErrorKind::NotFound => return Ok(TreeResults::default()),
        Err(e) => return Err(e.into()),
    };
    let other = |e| {
        Failure::BadInput(format!(
            "{}: cannot be read as the results of an earlier run ({e}); remove it",
            path.display()
        ))
    };
    Ok(serde_json::from_slice(&bytes).map_err(other)?)
}

fn markdown(document: &TreeResults) -> String {
    let parts = [
        document.builders.as_ref().map(builders::markdown),
        document.reductions.as_ref().map(reductions::markdown),
        document.frames.as_ref().map(frames::markdown),
        document.options.as_ref().map(options::markdown),
        document.filters.as_ref().map(filters::markdown),
    ];
    let parts: String = parts.into_iter().flatten().collect();
    format!(
        "# The voxel tree, measured\n\nWorld-aligned trees, sun towards (0.5, 0.8, 0.35). `primitives` and \
        `landscape` are generated with seed {SEED}. Depth n means 2^n voxels along each side of the cube. 1 MB = 10^6 bytes.\n{parts}"
    )
}

fn tree_options(depth: u32) -> Result<TreeOptions> {
    Ok(TreeOptions::new(Sun::from_direction(SUN)?, Size::Resolution(1 << depth)))
}

fn bake_quietly(scene: &BenchScene, options: &TreeOptions) -> Result<BakedTree> {
    Ok(bake_tree(&scene.scene, options, Watch::none())?)
}

/// Returns look-ups of a tree with its own bias and without a filter.
fn unfiltered(baked: &BakedTree, sun: Sun) -> Result<TreeQuery<'_, VoxelTree>> {
    let (space, regions, tree) = (&baked.space, &baked.regions, &baked.tree);
    Ok(TreeQuery::new(space, regions, &sun, tree, baked.settings.bias, 1, Weights::Mean)?)
}

/// Three variants of a tree's options, built in turn.
struct InTurn {
    /// Seconds to build and to reduce, the medians of the runs.
    seconds: [f64; 3],
    /// Whether the last run made equal trees.
    agree: bool,
    /// The trees of the last run.
    last: Vec<BakedTree>,
}

/// Builds trees of a scene with each of three options that draw the same depth image.
fn build_in_turn(args: &BenchTree, scene: &BenchScene, variants: &[TreeOptions; 3]) -> Result<InTurn> {
    let never = AtomicBool::new(false);
    let prepared = PreparedTree::new(&scene.scene, &variants[0], &never)?;
    let mut seconds: [Vec<f64>; 3] = Default::default();
    let mut last = Vec::new();
    for _ in 0..args.runs {
        last.clear();
        for (options, seconds) in variants.iter().zip(&mut seconds) {
            let baked = prepared.build(options, Watch::none())?;
            seconds.push(baked.report.build_seconds + baked.report.reduce_seconds);
            last.push(baked);
        }
    }
    let agree = last.windows(2).all(|w| w[0].tree == w[1].tree);
    Ok(InTurn { seconds: seconds.map(median), agree, last })
}

fn yes_or_no(agree: bool) -> &'static str {
    if agree { "yes" } else { "NO" }
}

/// Returns the largest resident size of a bake in a separate process, or `None` if the system does not report
/// it.
fn peak_bytes(scene: &BenchScene, options: &[&str]) -> Result<Option<u64>> {
    let outside: &[&str] = if scene.allow_outside { &["--allow-outside"] } else { &[] };
    let said: Value = child::bake_tree(&scene.path, &[options, outside].concat())?;
    Ok(said["peak_bytes"].as_u64())
}

/// Compares answers with rays at points on a scene's surfaces.
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
