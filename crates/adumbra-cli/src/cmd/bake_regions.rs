//! `adumbra bake --regions`: bakes a world into a file for each of its regions, and writes a manifest.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use adumbra::regions::Regions;
use adumbra::{Frame, Region};
use adumbra_bake::{BakeCache, RegionPlan};
use adumbra_files::{StagedFile, check_output};
use adumbra_program::exit::Failure;
use adumbra_program::glance::{AtAGlance, look, warn_of_large_voxels};
use adumbra_program::output::{format_bytes, make_folder, refuse_read, write_whole};
use adumbra_program::scene::{Omitted, load_scene_within, omitted};
use adumbra_program::sun::{SunOrigin, warn_of_low_sun};
use adumbra_program::threads::with_threads;
use adumbra_program::{memory, mirrors, say};
use schemars::JsonSchema;
use serde::Serialize;

use super::baking::Baking;
use super::ground::DecidedGround;
use super::store::best_effort_cache;
use crate::args::{Bake, Shard};

/// The result of `bake --regions`.
#[derive(Serialize, JsonSchema)]
pub(super) struct BakedRegions {
    /// The manifest that was written.
    manifest: String,
    /// The regions that were baked, in this order: those of the share, if one was asked for.
    regions: Vec<BakedRegion>,
    /// Number of regions of the world.
    world_regions: usize,
    /// Bytes of the files that were written, without the manifest.
    file_bytes: u64,
    /// Total wall time: loading, baking and writing.
    seconds: f64,
    /// The largest resident size of the process, in bytes. 0 if the system does not report it.
    peak_bytes: u64,
    /// Number of threads that baked.
    threads: usize,
    /// How the grids lie in the world.
    #[schemars(with = "mirrors::Frame")]
    frame: Frame,
    /// Texels a side of a region.
    region_texels: u32,
    /// Edge of a voxel, world units.
    voxel_size: f64,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// Where the sun comes from.
    sun_origin: SunOrigin,
    /// What the scene's file holds and the loader left out, each kind once.
    omissions: Vec<Omitted>,
    /// Whether shadows below the last surface of a column are left out.
    assumes_ground: bool,
    /// What a person would see of the scene.
    glance: AtAGlance,
}

/// A region that was baked.
#[derive(Serialize, JsonSchema)]
pub(super) struct BakedRegion {
    /// Number along the grid's x.
    x: i32,
    /// Number along the grid's y.
    y: i32,
    /// The shadow file that was written.
    file: String,
    /// Its length in bytes.
    file_bytes: u64,
    /// Wall time of its bake.
    seconds: f64,
    /// Number of root blocks.
    root_blocks: usize,
    /// Number of root blocks that were taken from `--cache`.
    reused_root_blocks: usize,
}

/// Bakes regions of `texels` texels a side, and prints a summary unless the result is to be printed as JSON.
pub(super) fn run(args: &Bake, texels: u32) -> Result<BakedRegions, Failure> {
    let start = Instant::now();
    let bad_input = |e: Failure| Failure::BadInput(e.to_string());
    let manifest = args.output.clone().unwrap_or_else(|| args.scene.with_extension("regions.json"));
    args.settings.check()?;
    args.settings.sun.given_for(&args.scene, &args.load)?;
    Region::check_texels(texels)?;
    args.check_paths(&manifest).map_err(bad_input)?;
    check_output(&manifest)?;
    let names = Names::beside(&manifest)?;
    let cache = best_effort_cache(args.cache.as_deref())?.map(|cache| Arc::new(cache) as Arc<dyn BakeCache>);
    with_threads(args.run.threads, || {
        let limit = args.run.memory_limit();
        let scene = load_scene_within(limit, &args.scene, &args.load.load_options()?)?;
        let sun = args.settings.sun.choose(&scene, &args.scene)?;
        warn_of_low_sun(&sun.sun);
        refuse_read("--output", &manifest).map_err(bad_input)?;
        let share = limit.share(scene.memory_bytes());
        let mut options = args.settings.options(sun.sun, args.load.ignore_alpha).with(|o| {
            o.max_memory_bytes = share.bytes();
            o.spill_folder = Some(names.folder.clone());
        });
        let ground = DecidedGround::of(&scene, &mut options);
        let glance = look(&scene, &args.scene, sun.sun, options.ignore_alpha);
        let plan = RegionPlan::new(&scene, &options, texels).map_err(|error| share.whole(error.into()))?;
        warn_of_large_voxels(&args.scene, &glance, plan.voxel_size());
        make_folder(&names.folder)?;
        let Shard { index, count } = args.shard.unwrap_or(Shard { index: 0, count: 1 });
        let due = plan.shard(index, count);
        let baking = Baking { args, scene: &scene, cache: cache.as_ref(), share: &share };
        let mut done = Vec::with_capacity(due.len());
        for (number, &region) in due.iter().enumerate() {
            let path = names.folder.join(names.file_of(region));
            refuse_read("--output", &path).map_err(bad_input)?;
            let (staged, written) = baking.file(&plan.options(region), &path)?;
            StagedFile::place([staged])?;
            let Region { x, y, .. } = region;
            if !args.run.json {
                let (at, of, size) = (number + 1, due.len(), format_bytes(written.bytes));
                say!("region ({x}, {y}), {at} of {of}: {size} in {:.1} s", written.report.seconds);
            }
            done.push(BakedRegion {
                x,
                y,
                file: path.display().to_string(),
                file_bytes: written.bytes,
                seconds: written.report.seconds,
                root_blocks: written.report.root_blocks,
                reused_root_blocks: written.report.reused_root_blocks,
            });
        }
        let files = plan.regions().map(|region| (region, names.path_of(region)));
        let regions = Regions::new(sun.sun, plan.frame(), plan.voxel_size(), texels, files)
            .map_err(|what| Failure::BadInput(format!("{}: {what}", manifest.display())))?;
        write_whole(&manifest, regions.to_json().as_bytes())?;
        let result = BakedRegions {
            manifest: manifest.display().to_string(),
            file_bytes: done.iter().map(|region| region.file_bytes).sum(),
            regions: done,
            world_regions: plan.regions().len(),
            seconds: start.elapsed().as_secs_f64(),
            peak_bytes: memory::peak_bytes().unwrap_or_default(),
            threads: rayon::current_num_threads(),
            frame: plan.frame(),
            region_texels: texels,
            voxel_size: plan.voxel_size(),
            sun: sun.sun.towards(),
            sun_origin: sun.origin.clone(),
            omissions: omitted(&scene),
            assumes_ground: ground.is_assumed,
            glance: AtAGlance::of(&glance),
        };
        if !args.run.json {
            say!(
                "{} -> {} ({} frame, {} of {} regions, {}) in {:.1} s, peak memory {}",
                args.scene.display(),
                result.manifest,
                result.frame.name(),
                result.regions.len(),
                result.world_regions,
                format_bytes(result.file_bytes),
                result.seconds,
                format_bytes(result.peak_bytes)
            );
            say!("  {sun}");
            say!("  {ground}");
            say!("  {}", result.glance);
        }
        Ok(result)
    })?
}

/// Names of the regions' files: `x3_y-2.adumbra` in a folder beside the manifest.
struct Names {
    folder: PathBuf,
    folder_name: String,
}

impl Names {
    fn beside(manifest: &Path) -> Result<Self, Failure> {
        let stem = manifest.file_stem().and_then(|stem| stem.to_str()).map(|stem| {
            // For `city.regions.json` too, the folder is `city.regions`.
            stem.strip_suffix(".regions").unwrap_or(stem)
        });
        let is_json = manifest.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
        match stem {
            Some(stem) if is_json => {
                let folder_name = format!("{stem}.regions");
                Ok(Self { folder: manifest.with_file_name(&folder_name), folder_name })
            }
            _ => Err(Failure::Usage(format!(
                "--output {}: with --regions it is a manifest; give a name that ends in .json",
                manifest.display()
            ))),
        }
    }

    fn file_of(&self, Region { x, y, .. }: Region) -> String {
        format!("x{x}_y{y}.adumbra")
    }

    fn path_of(&self, region: Region) -> String {
        format!("{}/{}", self.folder_name, self.file_of(region))
    }
}
