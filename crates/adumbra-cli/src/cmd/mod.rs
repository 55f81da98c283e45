//! One file a verb.

mod bake;
mod bake_tree;
mod baked;
mod bench;
mod bench_ao;
mod bench_blur;
mod bench_fast;
mod bench_hrsm;
mod bench_peers;
mod bench_shadows;
mod bench_tree;
mod bench_verify;
mod bounds;
mod child;
mod compare;
mod demo;
mod export;
mod generate;
mod import;
mod info;
mod inspect;
mod lookup;
mod query;
mod render;
mod report;
mod verify;
mod view;

use std::path::Path;

use adumbra::dag::Composition;
use adumbra::format::{FormatError, ShadowFile};
use adumbra::scene::{self, LoadOptions, Scene};

use crate::args::{Args, Verb};
use crate::exit::{Failure, Outcome};
use crate::output::note_scene;
use crate::signals;

pub(crate) fn run(args: Args) -> Outcome {
    if !matches!(args.verb, Verb::Bake(_) | Verb::Demo(_) | Verb::Report(_)) {
        signals::end_when_interrupted();
    }
    match args.verb {
        Verb::Generate(a) => generate::run(&a),
        Verb::Inspect(a) => inspect::run(&a),
        Verb::Bake(a) => bake::run(&a),
        Verb::Info(a) => info::run(&a),
        Verb::Verify(a) => verify::run(&a),
        Verb::Query(a) => query::run(&a),
        Verb::Export(a) => export::run(&a),
        Verb::Import(a) => import::run(&a),
        Verb::Render(a) => render::run(&a),
        Verb::View(a) => view::run(&a),
        Verb::Compare(a) => compare::run(&a),
        Verb::Bench(a) => bench::run(&a),
        Verb::Demo(a) => demo::run(&a),
        Verb::Report(a) => report::run(&a),
    }
}

/// Loads a scene and says on stderr what the loader noticed.
fn load_scene(path: &Path, options: &LoadOptions) -> Result<Scene, Failure> {
    let scene = scene::load(path, options)?;
    let notes = &scene.notes;
    note_scene(path, notes);
    for warning in &notes.warnings {
        eprintln!("warning: {}: {warning}", path.display());
    }
    if notes.degenerate_triangles > 0 {
        eprintln!("warning: {}: {} degenerate triangles skipped", path.display(), notes.degenerate_triangles);
    }
    if notes.untriangulated_polygons > 0 {
        eprintln!(
            "warning: {}: {} polygons could not be triangulated properly: they cross themselves, are far from flat or have more than 16384 corners; triangulate them in the \
            program that made them",
            path.display(),
            notes.untriangulated_polygons
        );
    }
    if notes.blended_materials > 0 {
        eprintln!(
            "note: {}: {} blended materials cast where alpha >= 0.5",
            path.display(),
            notes.blended_materials
        );
    }
    if notes.movers_left_out > 0 {
        eprintln!(
            "note: {}: {} animated instances are left out: they move; --include-animated takes them in their first pose",
            path.display(),
            notes.movers_left_out
        );
    }
    Ok(scene)
}

/// Runs `work` on a pool of this many threads.
fn with_threads<T: Send>(
    threads: Option<u16>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let Some(threads) = threads else { return work() };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.into())
        .build()
        .map_err(|e| Failure::Usage(format!("cannot start {threads} threads: {e}")))?;
    pool.install(work)
}

/// Figures of a graph that `bake` and `info` share.
struct GraphFigures {
    file_bytes: u64,
    bits_per_texel: f64,
    composition: Composition,
}

impl GraphFigures {
    /// `file_bytes` is its length, as it was read or written.
    fn of(file: &ShadowFile, file_bytes: u64) -> Result<Self, Failure> {
        let texels = f64::from(file.grid.size[0]) * f64::from(file.grid.size[1]);
        let invalid = |e: FormatError| Failure::BadInput(e.to_string());
        Ok(Self {
            file_bytes,
            bits_per_texel: file_bytes as f64 * 8.0 / texels,
            composition: file.body.composition().map_err(invalid)?,
        })
    }
}

fn print_json(value: &serde_json::Value) {
    say!("{value:#}");
}
