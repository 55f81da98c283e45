//! `adumbra bake`: bakes a scene into a shadow file.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use adumbra::Frame;
use adumbra_bake::{BakeCache, BakeOptions, BakeSummary};
use adumbra_files::{self as files, StagedFile};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::glance::{AtAGlance, look, warn_of_large_voxels};
use adumbra_program::memory::Share;
use adumbra_program::output::{format_bytes, print_json, refuse_read};
use adumbra_program::scene::{Omitted, load_scene_within, omitted};
use adumbra_program::sun::{ChosenSun, SunOrigin, warn_of_low_sun};
use adumbra_program::threads::with_threads;
use adumbra_program::{bounds, memory, mirrors, say};
use adumbra_scene::{Scene, write_shadow_name};
use adumbra_truth::glance::Glance;
use schemars::JsonSchema;
use serde::Serialize;

use super::bake_path::{self, BakedSunPath};
use super::bake_regions::{self, BakedRegions};
use super::baking::Baking;
use super::ground::DecidedGround;
use super::store::best_effort_cache;
use super::{bake_watch, bits_per_texel};
use crate::args::Bake;

/// What is printed with `--json`.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Printed {
    /// Of a bake.
    Baked(BakeResults),
    /// With `--regions`.
    Regions(BakedRegions),
    /// With `--sun-path` or `--suns`.
    SunPath(BakedSunPath),
    /// With `--dry-run`.
    Forecast(Forecast),
}

/// The result of a bake.
#[derive(Serialize, JsonSchema)]
pub(super) struct BakeResults {
    /// The shadow file that was written.
    file: String,
    /// Total wall time: loading, baking and writing.
    seconds: f64,
    /// Wall time of the bake alone.
    bake_seconds: f64,
    /// The largest resident size of the process. If the system does not report it, `accounted_bytes`.
    peak_bytes: u64,
    /// Memory that the bake counted for `--max-memory`. It is an upper estimate.
    accounted_bytes: u64,
    /// Bytes that were written to disk because of `--max-memory`. A byte that was written twice counts twice.
    spilled_bytes: u64,
    /// Length of the shadow file, in bytes.
    file_bytes: u64,
    /// Bits of the shadow file per texel of its grid.
    bits_per_texel: f64,
    /// Number of levels of detail.
    levels: u32,
    /// Number of threads that baked.
    threads: usize,
    /// Number of root blocks.
    root_blocks: usize,
    /// Number of root blocks that were taken from `--cache`.
    reused_root_blocks: usize,
    /// Number of texels that were processed one by one.
    drawn_texels: u64,
    /// How the grid lies in the world.
    #[schemars(with = "mirrors::Frame")]
    frame: Frame,
    /// Number of texels on the longest side of the scene as the sun sees it.
    resolution: u32,
    /// Number of voxels along x, y and z of the grid.
    size: [u32; 3],
    /// Edge of a voxel, world units.
    voxel_size: f64,
    /// Number of triangles that were baked. Instances are counted.
    triangles: u64,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// Where the sun comes from.
    sun_origin: SunOrigin,
    /// What the scene's file holds and the loader left out, each kind once.
    omissions: Vec<Omitted>,
    /// Whether `--bounds` were given and contain no part of the scene.
    empty_bounds: bool,
    /// Whether shadows below the last surface of a column are left out.
    assumes_ground: bool,
    /// What a person would see of the scene.
    glance: AtAGlance,
}

/// The forecast costs of a bake. Each pair is the least and the most.
#[derive(Serialize, JsonSchema)]
pub(super) struct Forecast {
    /// Number of root blocks of the whole bake.
    root_blocks: usize,
    /// Number of root blocks that were drawn for the forecast.
    sampled_root_blocks: usize,
    /// Wall time of the bake.
    seconds: [f64; 2],
    /// Length of the shadow file, in bytes.
    file_bytes: [u64; 2],
    /// Memory that the bake takes, in bytes.
    memory_bytes: [u64; 2],
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// Where the sun comes from.
    sun_origin: SunOrigin,
    /// What the scene's file holds and the loader left out, each kind once.
    omissions: Vec<Omitted>,
    /// Whether `--bounds` were given and contain no part of the scene.
    empty_bounds: bool,
    /// Whether shadows below the last surface of a column are left out.
    assumes_ground: bool,
    /// What a person would see of the scene.
    glance: AtAGlance,
}

pub(crate) fn run(args: &Bake) -> Outcome {
    if let Some(texels) = args.regions {
        let baked = bake_regions::run(args, texels)?;
        if args.run.json {
            print_json(&Printed::Regions(baked))?;
        }
        return Ok(Code::Fine);
    }
    if let Some(baked) = bake_path::run(args) {
        let baked = baked?;
        if args.run.json {
            print_json(&Printed::SunPath(baked))?;
        }
        return Ok(Code::Fine);
    }
    let start = Instant::now();
    let output = args.output.clone().unwrap_or_else(|| args.scene.with_extension("adumbra"));
    let shadow_name = check_arguments(args, &output)?;
    let cache = best_effort_cache(args.cache.as_deref())?;
    if args.watch {
        return bake_watch::run(args, &output, cache);
    }
    let cache = cache.map(|cache| Arc::new(cache) as Arc<dyn BakeCache>);
    with_threads(args.run.threads, || {
        let job = Job::new(args, &output)?;
        if args.dry_run {
            return job.forecast();
        }
        let summary = job.bake(&output, cache.as_ref())?;
        if let Some((gltf, name)) = args.link_in.as_ref().zip(shadow_name.as_ref()) {
            write_shadow_name(gltf, name, summary.grid.sun)?;
        }
        job.report(&output, &summary, start.elapsed().as_secs_f64())
    })?
}

/// Refuses wrong arguments before the scene is loaded. Returns the name of the shadow file for `--link-in`.
fn check_arguments(args: &Bake, output: &Path) -> Result<Option<String>, Failure> {
    args.settings.check()?;
    args.settings.sun.given_for(&args.scene, &args.load)?;
    let shadow_name = args.link_in.as_ref().map(|gltf| name_for(gltf, output)).transpose()?;
    if !args.dry_run {
        args.check_paths(output).map_err(|e| Failure::BadInput(e.to_string()))?;
        files::check_output(output)?;
    }
    Ok(shadow_name)
}

/// A loaded scene, and how it is to be baked.
struct Job<'a> {
    args: &'a Bake,
    scene: Scene,
    sun: ChosenSun,
    share: Share,
    options: BakeOptions,
    ground: DecidedGround,
    glance: Glance,
    /// Whether `--bounds` were given and contain no part of the scene.
    empty_bounds: bool,
}

impl<'a> Job<'a> {
    /// Loads the scene, and warns of what would make its shadows useless.
    fn new(args: &'a Bake, output: &Path) -> Result<Self, Failure> {
        let limit = args.run.memory_limit();
        let scene = load_scene_within(limit, &args.scene, &args.load.load_options()?)?;
        let sun = args.settings.sun.choose(&scene, &args.scene)?;
        warn_of_low_sun(&sun.sun);
        let share = limit.share(scene.memory_bytes());
        let mut options = args.settings.options(sun.sun, args.load.ignore_alpha).with(|o| {
            o.max_memory_bytes = share.bytes();
            o.spill_folder = Some(files::target_folder(output));
        });
        if !args.dry_run {
            refuse_read("--output", output).map_err(|e| Failure::BadInput(e.to_string()))?;
        }
        let empty_bounds = bounds::warn_if_empty(options.bounds.as_ref(), &scene, &args.scene);
        let ground = DecidedGround::of(&scene, &mut options);
        let glance = look(&scene, &args.scene, sun.sun, options.ignore_alpha);
        Ok(Self { args, scene, sun, share, options, ground, glance, empty_bounds })
    }

    /// Bakes the file, which replaces the one at `output` when it is complete.
    fn bake(&self, output: &Path, cache: Option<&Arc<dyn BakeCache>>) -> Result<BakeSummary, Failure> {
        let baking = Baking { args: self.args, scene: &self.scene, cache, share: &self.share };
        let (staged, summary) = baking.file(&self.options, output)?;
        StagedFile::place([staged])?;
        Ok(summary)
    }

    /// Prints what was baked.
    fn report(&self, output: &Path, summary: &BakeSummary, seconds: f64) -> Outcome {
        let Self { args, sun, ground, .. } = self;
        let BakeSummary { grid, report, bytes: file_bytes, .. } = summary;
        warn_of_large_voxels(&args.scene, &self.glance, grid.voxel_size);
        let peak_bytes = memory::peak_bytes().unwrap_or(report.accounted_bytes);
        if args.run.json {
            print_json(&Printed::Baked(self.results(output, summary, seconds, peak_bytes)))?;
            return Ok(Code::Fine);
        }
        say!(
            "{} -> {} ({} frame, {}, {:.4} bits per texel) in {seconds:.1} s, peak memory {}",
            args.scene.display(),
            output.display(),
            grid.frame.name(),
            format_bytes(*file_bytes),
            bits_per_texel(grid, *file_bytes),
            format_bytes(peak_bytes)
        );
        say!("  {sun}");
        say!("  {ground}");
        say!("  {}", AtAGlance::of(&self.glance));
        if let Some(cache) = &args.cache {
            let (reused, root_blocks) = (report.reused_root_blocks, report.root_blocks);
            say!("  {reused} of {root_blocks} root blocks from {}", cache.display());
        }
        Ok(Code::Fine)
    }

    fn results(&self, output: &Path, summary: &BakeSummary, seconds: f64, peak_bytes: u64) -> BakeResults {
        let BakeSummary { grid, settings, levels, bytes: file_bytes, report } = summary;
        BakeResults {
            file: output.display().to_string(),
            seconds,
            bake_seconds: report.seconds,
            peak_bytes,
            accounted_bytes: report.accounted_bytes,
            spilled_bytes: report.spilled_bytes,
            file_bytes: *file_bytes,
            bits_per_texel: bits_per_texel(grid, *file_bytes),
            levels: *levels,
            threads: report.threads,
            root_blocks: report.root_blocks,
            reused_root_blocks: report.reused_root_blocks,
            drawn_texels: report.drawn_texels,
            frame: grid.frame,
            resolution: settings.resolution,
            size: grid.size,
            voxel_size: grid.voxel_size,
            triangles: settings.triangles,
            sun: self.sun.sun.towards(),
            sun_origin: self.sun.origin.clone(),
            omissions: omitted(&self.scene),
            empty_bounds: self.empty_bounds,
            assumes_ground: self.ground.is_assumed,
            glance: AtAGlance::of(&self.glance),
        }
    }

    /// Prints what the bake would cost.
    fn forecast(&self) -> Outcome {
        let Self { args, scene, sun, ground, .. } = self;
        let e = adumbra_bake::Bake::with_options(scene, &self.options).estimate();
        let e = e.map_err(|error| self.share.whole(error.into()))?;
        let glance = AtAGlance::of(&self.glance);
        if args.run.json {
            print_json(&Printed::Forecast(Forecast {
                root_blocks: e.root_blocks,
                sampled_root_blocks: e.sampled_root_blocks,
                seconds: e.seconds,
                file_bytes: e.file_bytes,
                memory_bytes: e.memory_bytes,
                sun: sun.sun.towards(),
                sun_origin: sun.origin.clone(),
                omissions: omitted(scene),
                empty_bounds: self.empty_bounds,
                assumes_ground: ground.is_assumed,
                glance,
            }))?;
        } else {
            let range = |r: [u64; 2]| format!("{} to {}", format_bytes(r[0]), format_bytes(r[1]));
            say!(
                "{}: {} of {} root blocks drawn",
                args.scene.display(),
                e.sampled_root_blocks,
                e.root_blocks
            );
            say!("  time    {:.0} to {:.0} s", e.seconds[0], e.seconds[1]);
            say!("  memory  {}", range(e.memory_bytes));
            say!("  file    {}", range(e.file_bytes));
            say!("  {sun}");
            say!("  {ground}");
            say!("  {glance}");
            say!("  a lower --resolution, a larger --thickness or --receivers static makes the file smaller");
        }
        if self.options.max_memory_bytes.is_some_and(|limit| e.memory_bytes[0] > limit) {
            adumbra_program::note!(
                "warning: --max-memory is less than the bake needs: it will be slower, and keep the rest in temporary files"
            );
        }
        Ok(Code::Fine)
    }
}

/// Returns the name under which `gltf` refers to the shadow file `output`: its path from the folder of
/// `gltf`.
fn name_for(gltf: &Path, output: &Path) -> Result<String, Failure> {
    let usage = |what: String| Err(Failure::Usage(format!("--link-in {}: {what}", gltf.display())));
    let is_gltf = |e: &std::ffi::OsStr| ["glb", "gltf"].iter().any(|known| e.eq_ignore_ascii_case(known));
    if !gltf.extension().is_some_and(is_gltf) || !gltf.is_file() {
        return usage("give an existing .glb or .gltf file".to_owned());
    }
    let folder = |path: &Path| files::folder_of(path).canonicalize().ok();
    let below = folder(gltf).zip(folder(output)).and_then(|(of_gltf, of_output)| {
        let below = of_output.strip_prefix(&of_gltf).ok()?.join(output.file_name()?);
        let parts: Option<Vec<&str>> = below.iter().map(std::ffi::OsStr::to_str).collect();
        Some(parts?.join("/"))
    });
    match below {
        Some(name) => Ok(name),
        None => {
            usage(format!("{} must be in its folder or below, so that engines find it", output.display()))
        }
    }
}
