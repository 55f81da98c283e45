//! `adumbra-lab dag bake`: bakes a scene into a graph.

use std::time::Instant;

use adumbra_bake::Watch;
use adumbra_files::{check_output, replace_file};
use adumbra_papers::dag::DagLayout;
use adumbra_papers::dag::build::bake;
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::memory::Guard;
use adumbra_program::output::{SCENE, format_bytes, print_json, refuse_inputs, refuse_read};
use adumbra_program::progress::{Reporter, Units};
use adumbra_program::scene::load_scene_within;
use adumbra_program::sun::{SunOrigin, warn_of_low_sun};
use adumbra_program::threads::with_threads;
use adumbra_program::{bounds, memory, say};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::DagBake;
use crate::mirrors;

/// The result of a bake of a graph.
#[derive(Serialize, JsonSchema)]
pub(crate) struct DagBaked {
    /// The graph file that was written.
    file: String,
    /// Total wall time: loading, baking and writing.
    seconds: f64,
    /// Wall time of the bake alone.
    bake_seconds: f64,
    /// The largest resident size of the process. If the system does not report it, what the bake counted.
    peak_bytes: u64,
    /// Length of the graph file, in bytes.
    file_bytes: u64,
    /// How the file stores the graph.
    #[schemars(with = "mirrors::DagLayout")]
    layout: DagLayout,
    /// Number of triangles that were baked. Instances are counted.
    triangles: u64,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// Where the sun comes from.
    sun_origin: SunOrigin,
}

pub(super) fn run(args: &DagBake) -> Outcome {
    let start = Instant::now();
    let bad_input = |e: Failure| Failure::BadInput(e.to_string());
    let output = args.output.clone().unwrap_or_else(|| args.scene.with_extension("adumdag"));
    // Refuse an invalid sun before loading the scene.
    args.sun.given_for(&args.scene, &args.load)?;
    refuse_inputs("--output", &output, [(SCENE, &*args.scene)]).map_err(bad_input)?;
    check_output(&output)?;
    with_threads(args.run.threads, || {
        let limit = args.run.memory_limit();
        let scene = load_scene_within(limit, &args.scene, &args.load.load_options()?)?;
        let sun = args.sun.choose(&scene, &args.scene)?;
        warn_of_low_sun(&sun.sun);
        let share = limit.share(scene.memory_bytes());
        let options = args.options(sun.sun, share.bytes());
        refuse_read("--output", &output).map_err(bad_input)?;
        bounds::warn_if_empty(options.bake.bounds.as_ref(), &scene, &args.scene);
        let guard = Guard::new(limit);
        let reporter = Reporter::new(args.progress, Units::TEXELS);
        let progress = |p| {
            guard.look();
            reporter.update(p);
        };
        let baked = bake(&scene, &options, Watch::new(&progress, guard.cancel()));
        let baked = guard.end("the bake", &share, baked)?;
        let file_bytes = replace_file(&output, |out| baked.file.write_to(out))?;
        let seconds = start.elapsed().as_secs_f64();
        let peak = memory::peak_bytes().unwrap_or(baked.report.accounted_bytes);
        if args.run.json {
            print_json(&DagBaked {
                file: output.display().to_string(),
                seconds,
                bake_seconds: baked.report.seconds,
                peak_bytes: peak,
                file_bytes,
                layout: options.layout,
                triangles: baked.file.settings.triangles,
                sun: sun.sun.towards(),
                sun_origin: sun.origin,
            })?;
        } else {
            say!(
                "{} -> {} ({} graph, {} frame, {}) in {seconds:.1} s, peak memory {}",
                args.scene.display(),
                output.display(),
                options.layout.name(),
                baked.file.grid.frame.name(),
                format_bytes(file_bytes),
                format_bytes(peak)
            );
            say!("  {sun}");
        }
        Ok(Code::Fine)
    })?
}
