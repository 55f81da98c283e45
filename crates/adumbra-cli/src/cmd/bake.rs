//! `adumbra bake`: scene in, shadow file out.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adumbra::Error;
use adumbra::bake::{self, Baked, BakedBoth, BakedHierarchy, BakedPacked, Options, Progress, Report};
use adumbra::dag::packed::PackError;
use adumbra::files;
use adumbra::format::{Layout, LightBody, ShadowFile};
use adumbra::scene::{Bounds, Scene};
use serde_json::{Value, json};

use super::{GraphFigures, bake_tree, bounds, load_scene, print_json, with_threads};
use crate::args::Bake;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{SCENE, bytes_words, refuse_inputs, refuse_read};
use crate::progress::{Reporter, Units};
use crate::{memory, signals};

/// Below this elevation level ground nears the steepest plane that look-ups follow.
const LOWEST_SUN_DEGREES: f64 = 1.0;

pub(crate) fn run(args: &Bake) -> Outcome {
    let cancel = if args.dry_run {
        signals::end_when_interrupted();
        Arc::default()
    } else {
        signals::install()
    };
    let start = Instant::now();
    let bad_input = |e: Failure| Failure::BadInput(e.to_string());
    let output = args.output.clone().unwrap_or_else(|| args.scene.with_extension("adumbra"));
    let mut options = args.settings.options(args.load.ignore_alpha, &args.work)?;
    // The system's folder may be memory; where the file goes there is a disk.
    options.spill_folder =
        Some(files::folder_of(&files::target_of(&output).unwrap_or_else(|_| output.clone())));
    let tree_options = match args.settings.is_tree()? {
        true if args.dry_run => {
            return Err(Failure::Usage(
                "--dry-run forecasts --frame light only; a draft of a tree takes seconds".to_owned(),
            ));
        }
        true => Some(args.settings.tree_options(args.load.ignore_alpha, &args.work)?),
        false => None,
    };
    if !args.dry_run {
        refuse_inputs("--output", &output, [(SCENE, &*args.scene)]).map_err(bad_input)?;
        files::check_output(&output)?;
    }
    if options.sun.elevation_degrees() < LOWEST_SUN_DEGREES {
        eprintln!(
            "warning: the sun is {:.2}° above the horizon; below {LOWEST_SUN_DEGREES}° level ground is steeper to the light than look-ups follow exactly: check the file with verify",
            options.sun.elevation_degrees()
        );
    }
    with_threads(args.work.threads, || {
        let scene = load_scene(&args.scene, &args.load.load_options(args.work.max_memory)?)?;
        if !args.dry_run {
            refuse_read("--output", &output).map_err(bad_input)?;
        }
        // Bounds that are no box are refused later, with their range.
        let empty_bounds =
            options.bounds.is_some_and(|b| bounds::is_box(&b) && !bounds::hold_geometry(&b, &scene));
        if empty_bounds {
            let Bounds { min, max } = scene.bounds();
            eprintln!(
                "warning: --bounds hold no part of {}, which reaches from {min:?} to {max:?}; check the box's place and unit",
                args.scene.display()
            );
        }
        if args.dry_run {
            return dry_run(args, &scene, &options, empty_bounds);
        }
        if let Some(tree_options) = &tree_options {
            return bake_tree::run(args, &scene, tree_options, empty_bounds, (&output, start), &cancel);
        }
        let reporter = Reporter::new(args.progress, Units::TEXELS);
        let progress = |p| reporter.update(p);
        let layout = args.settings.layout();
        let Built { file, report, candidate_bytes } = build(&scene, &options, layout, &progress, &cancel)?;
        let (grid, settings) = (file.grid, file.settings);
        let file_bytes = file.write(&output)?;
        let figures = GraphFigures::of(&file, file_bytes)?;
        let seconds = start.elapsed().as_secs_f64();
        let peak = memory::peak_bytes().unwrap_or(report.accounted_bytes);
        if args.json {
            print_json(&json!({
                "file": output.display().to_string(),
                "seconds": seconds,
                "bake_seconds": report.seconds,
                "peak_bytes": peak,
                "accounted_bytes": report.accounted_bytes,
                "spilled_bytes": report.spilled_bytes,
                "file_bytes": figures.file_bytes,
                "bits_per_texel": figures.bits_per_texel,
                "layout": file.body.layout(),
                "candidate_bytes": candidate_bytes,
                "nodes": figures.composition.nodes,
                "slabs": figures.composition.slabs,
                "threads": report.threads,
                "tiles": report.tiles,
                "drawn_texels": report.drawn_texels,
                "resolution": settings.resolution,
                "size": file.grid.size,
                "voxel_size": grid.voxel_size,
                "triangles": settings.triangles,
                "empty_bounds": empty_bounds,
            }));
        } else {
            say!(
                "{} -> {} ({}, {}, {:.4} bits a texel) in {seconds:.1} s, peak memory {}",
                args.scene.display(),
                output.display(),
                file.body.layout().name(),
                bytes_words(figures.file_bytes),
                figures.bits_per_texel,
                bytes_words(peak)
            );
        }
        Ok(Code::Fine)
    })
}

/// A file that is ready to be written.
struct Built {
    file: ShadowFile,
    report: Report,
    /// Bytes by layout where the smaller was asked for; a layout that cannot hold the voxels has none.
    candidate_bytes: Option<Value>,
}

/// Bakes in the layout, or in the smaller one if none is given.
fn build(
    scene: &Scene,
    options: &Options,
    layout: Option<Layout>,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<Built, Failure> {
    let (file, report, candidate_bytes) = match layout {
        Some(Layout::Hierarchy) => {
            let BakedHierarchy { grid, settings, hierarchy, report } =
                bake::bake_hierarchy(scene, options, true, progress, cancel)?;
            (ShadowFile::hierarchy(grid, settings, hierarchy), report, None)
        }
        Some(Layout::Packed) => {
            let BakedPacked { grid, settings, packed, report } =
                bake::bake_packed(scene, options, progress, cancel)?;
            (ShadowFile { grid, settings, body: LightBody::Packed(packed) }, report, None)
        }
        Some(layout) => {
            let Baked { grid, settings, dag, report } = bake::bake(scene, options, progress, cancel)?;
            (ShadowFile::of_dag(grid, settings, dag, layout).map_err(Error::from)?, report, None)
        }
        None => {
            let BakedBoth { grid, settings, dag, hierarchy, report } =
                bake::bake_both(scene, options, progress, cancel)?;
            let hierarchy = ShadowFile::hierarchy(grid, settings, hierarchy);
            // A graph that has no packed form leaves the other.
            let packed = match ShadowFile::of_dag(grid, settings, dag, Layout::Packed) {
                Ok(file) => Some(file),
                Err(PackError::TooLarge { .. } | PackError::NotMonotone { .. }) => None,
                Err(fault) => return Err(Error::from(fault).into()),
            };
            let bytes = json!({
                "packed": packed.as_ref().map(ShadowFile::encoded_len),
                "hierarchy": hierarchy.encoded_len(),
            });
            let smaller = packed.filter(|packed| packed.encoded_len() < hierarchy.encoded_len());
            (smaller.unwrap_or(hierarchy), report, Some(bytes))
        }
    };
    Ok(Built { file, report, candidate_bytes })
}

/// Bytes of a layout, of those of the plain one, which is forecast: 0.3 to 0.46 on the scenes of `docs/layouts.md`, 0.14 to
/// 0.36 on those of `docs/layouts-hierarchy.md`.
fn share_of_plain(layout: Option<Layout>) -> [f64; 2] {
    match layout {
        Some(Layout::Plain) => [1.0; 2],
        Some(Layout::Packed) => [0.25, 0.5],
        Some(Layout::Hierarchy) | None => [0.1, 0.4],
    }
}

fn dry_run(args: &Bake, scene: &Scene, options: &Options, empty_bounds: bool) -> Outcome {
    let e = bake::estimate(scene, options)?;
    let share = share_of_plain(args.settings.layout());
    let file_bytes: [u64; 2] = std::array::from_fn(|i| (e.file_bytes[i] as f64 * share[i]) as u64);
    if args.json {
        print_json(&json!({
            "tiles": e.tiles,
            "sampled_tiles": e.sampled_tiles,
            "seconds": e.seconds,
            "file_bytes": file_bytes,
            "memory_bytes": e.memory_bytes,
            "empty_bounds": empty_bounds,
        }));
    } else {
        let range = |r: [u64; 2]| format!("{} to {}", bytes_words(r[0]), bytes_words(r[1]));
        say!("{}: {} of {} tiles drawn", args.scene.display(), e.sampled_tiles, e.tiles);
        say!("  time    {:.0} to {:.0} s", e.seconds[0], e.seconds[1]);
        say!("  memory  {}", range(e.memory_bytes));
        say!("  file    {}", range(file_bytes));
        say!("  a lower --resolution, --thickness or --receivers static make the file smaller");
    }
    if options.max_memory_bytes.is_some_and(|limit| e.memory_bytes[0] > limit) {
        eprintln!(
            "warning: --max-memory is less: the bake will be slower, and keep the rest in temporary files"
        );
    }
    Ok(Code::Fine)
}
