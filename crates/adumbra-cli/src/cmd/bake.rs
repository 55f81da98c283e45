//! `adumbra bake`: scene in, shadow file out.

use std::sync::Arc;
use std::time::Instant;

use adumbra::Error;
use adumbra::bake::{self, Baked, BakedHierarchy, Options};
use adumbra::files;
use adumbra::format::{Layout, ShadowFile};
use serde_json::json;

use super::{GraphFigures, bake_tree, load_scene, print_json, with_threads};
use crate::args::Bake;
use crate::exit::{Code, Failure, Outcome};
use crate::output::bytes_words;
use crate::progress::{Reporter, Units};
use crate::{memory, signals};

pub(crate) fn run(args: &Bake) -> Outcome {
    let cancel = if args.dry_run {
        signals::end_when_interrupted();
        Arc::default()
    } else {
        signals::install()
    };
    let start = Instant::now();
    let output = args.output.clone().unwrap_or_else(|| args.scene.with_extension("adumbra"));
    let options = args.settings.options(args.load.ignore_alpha, &args.work)?;
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
        if output == args.scene {
            return Err(Failure::BadInput(format!(
                "{}: is the scene itself; name another file with -o",
                output.display()
            )));
        }
        files::check_output(&output)?;
    }
    with_threads(args.work.threads, || {
        let scene = load_scene(&args.scene, &args.load.load_options()?)?;
        if args.dry_run {
            return dry_run(args, &scene, &options);
        }
        if let Some(tree_options) = &tree_options {
            return bake_tree::run(args, &scene, tree_options, &output, start, &cancel);
        }
        let reporter = Reporter::new(args.progress, Units::TEXELS);
        let progress = |p| reporter.update(p);
        let (file, report) = match args.settings.layout() {
            Layout::Hierarchy => {
                let BakedHierarchy { grid, settings, hierarchy, report } =
                    bake::bake_hierarchy(&scene, &options, true, &progress, &cancel)?;
                (ShadowFile::hierarchy(grid, settings, hierarchy), report)
            }
            layout => {
                let Baked { grid, settings, dag, report } = bake::bake(&scene, &options, &progress, &cancel)?;
                (ShadowFile::of_dag(grid, settings, dag, layout).map_err(Error::from)?, report)
            }
        };
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
                "file_bytes": figures.file_bytes,
                "bits_per_texel": figures.bits_per_texel,
                "layout": file.body.layout(),
                "nodes": figures.composition.nodes,
                "slabs": figures.composition.slabs,
                "threads": report.threads,
                "tiles": report.tiles,
                "drawn_texels": report.drawn_texels,
                "resolution": settings.resolution,
                "size": file.grid.size,
                "voxel_size": grid.voxel_size,
                "triangles": settings.triangles,
            }));
        } else {
            say!(
                "{} -> {} ({}, {:.4} bits a texel) in {seconds:.1} s, peak memory {}",
                args.scene.display(),
                output.display(),
                bytes_words(figures.file_bytes),
                figures.bits_per_texel,
                bytes_words(peak)
            );
        }
        Ok(Code::Fine)
    })
}

/// Bytes of the packed layout, of one in the plain layout that is being forecast: from 0.3 to 0.46 on the scenes of `docs/layouts.md`.
const PACKED_SHARE: [f64; 2] = [0.25, 0.5];

fn dry_run(args: &Bake, scene: &adumbra::scene::Scene, options: &Options) -> Outcome {
    let e = bake::estimate(scene, options)?;
    let share = if args.settings.layout() == Layout::Packed { PACKED_SHARE } else { [1.0; 2] };
    let file_bytes: [u64; 2] = std::array::from_fn(|i| (e.file_bytes[i] as f64 * share[i]) as u64);
    if args.json {
        print_json(&json!({
            "tiles": e.tiles,
            "sampled_tiles": e.sampled_tiles,
            "seconds": e.seconds,
            "file_bytes": file_bytes,
            "memory_bytes": e.memory_bytes,
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
        eprintln!("warning: this will not fit --max-memory; lower --resolution or --threads");
    }
    Ok(Code::Fine)
}
