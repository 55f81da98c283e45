//! `adumbra plan`: writes the parts of a bake to a plan.

use std::io::Write;
use std::path::{Path, PathBuf, absolute};

use adumbra::IoError;
use adumbra_bake::BakePlan;
use adumbra_files::{check_output, replace_file};
use adumbra_program::bounds;
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::glance::{AtAGlance, look, warn_of_large_voxels};
use adumbra_program::output::{SCENE, print_json, refuse_inputs, refuse_read, refuse_same};
use adumbra_program::say;
use adumbra_program::scene::load_scene_within;
use adumbra_program::start::program_file;
use adumbra_program::sun::{SunOrigin, warn_of_low_sun};
use adumbra_program::threads::with_threads;
use schemars::JsonSchema;
use serde::Serialize;

use super::export::Job;
use super::plan_file::{PlanFile, cache_of};
use crate::args::{ExportFormat, Plan};
use crate::cmd::ground::DecidedGround;
use crate::cmd::store::url_of;

/// What is printed with `--json`.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Planned {
    /// The plan that was written.
    plan: String,
    /// The job that was written, with `--export`.
    job: Option<String>,
    /// Number of parts.
    parts: usize,
    /// Number of levels of detail.
    levels: u32,
    /// Estimated work of all parts, in units that only the plan's own parts share.
    cost: u64,
    /// That of the most costly part.
    largest_cost: u64,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// Where the sun comes from.
    sun_origin: SunOrigin,
    /// Whether shadows below the last surface of a column are left out.
    assumes_ground: bool,
    /// What a person would see of the scene.
    glance: AtAGlance,
}

pub(crate) fn run(args: &Plan) -> Outcome {
    let bad_input = |e: Failure| Failure::BadInput(e.to_string());
    let output = args.output.clone().unwrap_or_else(|| args.scene.with_extension("plan.json"));
    args.settings.check()?;
    args.settings.sun.given_for(&args.scene, &args.load)?;
    let cache = cache_of(args.cache.as_ref(), &output);
    let edits = args.load.edit().map(|path| ("the edits", &**path));
    let inputs = || [(SCENE, &*args.scene), ("the cache", &*cache)].into_iter().chain(edits);
    let shadow_file = args.shadow_file.as_deref().map(|path| ("--shadow-file", path));
    for (option, path) in [("--output", &*output)].into_iter().chain(shadow_file) {
        refuse_inputs(option, path, inputs()).map_err(bad_input)?;
    }
    refuse_same([&*output].into_iter().chain(args.shadow_file.as_deref())).map_err(bad_input)?;
    check_output(&output)?;
    with_threads(args.run.threads, || {
        let limit = args.run.memory_limit();
        let scene = load_scene_within(limit, &args.scene, &args.load.load_options()?)?;
        let sun = args.settings.sun.choose(&scene, &args.scene)?;
        warn_of_low_sun(&sun.sun);
        let share = limit.share(scene.memory_bytes());
        let mut options = args
            .settings
            .options(sun.sun, args.load.ignore_alpha)
            .with(|o| o.max_memory_bytes = share.bytes());
        refuse_read("--output", &output).map_err(bad_input)?;
        bounds::warn_if_empty(options.bounds.as_ref(), &scene, &args.scene);
        let ground = DecidedGround::of(&scene, &mut options);
        let glance = look(&scene, &args.scene, sun.sun, options.ignore_alpha);
        let plan = BakePlan::new(&scene, &options).map_err(|error| share.whole(error.into()))?;
        if let Some(grid) = plan.grids().first() {
            warn_of_large_voxels(&args.scene, &glance, grid.voxel_size);
        }
        let file = PlanFile { scene: whole(&args.scene)?, load: args.load.anywhere()?, plan };
        let text = serde_json::to_vec(&file)
            .map_err(|error| Failure::BadInput(format!("{}: {error}", output.display())))?;
        replace_file(&output, |out| out.write_all(&text).map(|()| text.len() as u64))?;
        let parts = file.plan.parts();
        let cost = parts.iter().map(|part| part.cost()).sum();
        let levels = file.plan.grids().len() as u32;
        let job = args.export.map(|format| export(args, &output, format)).transpose()?;
        if args.run.json {
            print_json(&Planned {
                plan: output.display().to_string(),
                job: job.map(|job| job.display().to_string()),
                parts: parts.len(),
                levels,
                cost,
                largest_cost: parts.first().map_or(0, |part| part.cost()),
                sun: sun.sun.towards(),
                sun_origin: sun.origin,
                assumes_ground: ground.is_assumed,
                glance: AtAGlance::of(&glance),
            })?;
        } else {
            let (scene, plan) = (args.scene.display(), output.display());
            say!("{scene} -> {plan}: {} parts of {levels} levels", parts.len());
            say!("  {sun}");
            say!("  {ground}");
            say!("  {}", AtAGlance::of(&glance));
            if let Some(job) = job {
                say!("  {}", job.display());
            }
        }
        Ok(Code::Fine)
    })?
}

/// Writes the job of a plan.
fn export(args: &Plan, output: &Path, format: ExportFormat) -> Result<PathBuf, Failure> {
    let program = program_file().map_err(IoError::at("find", "the program"))?;
    let shadow_file = args.shadow_file.clone().unwrap_or_else(|| args.scene.with_extension("adumbra"));
    let cache = cache_of(args.cache.as_ref(), output);
    let cache = if url_of(&cache).is_some() { cache } else { whole(&cache)? };
    let job = Job {
        format,
        program: &program,
        plan: &whole(output)?,
        cache: &cache,
        shadow_file: &whole(&shadow_file)?,
        shards: args.shards,
        threads: args.run.threads,
    };
    job.write()
}

/// Returns a path that means the same in any folder.
fn whole(path: &Path) -> Result<PathBuf, Failure> {
    Ok(absolute(path).map_err(IoError::at("find", path))?)
}
