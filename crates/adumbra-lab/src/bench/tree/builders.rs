//! The three builders compared with each other: the paper's Fig. 3-4.

use adumbra_bake::Watch;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use adumbra_tree::{Builder, PreparedTree, TreeOptions};

use super::document::{BuilderRow, ByBuilder, Part};
use super::{BenchScene, FIRST_PRUNED_DEPTH, median, peak_bytes, scene_names, tree_options};
use crate::Result;
use crate::args::BenchTree;
use crate::plot::{Along, Legend, Panel, Series, write_svg};

const NAMES: [&str; 3] = ["recursive", "iterative", "pooled"];

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<Vec<BuilderRow>> {
    let mut rows = Vec::new();
    for scene in scenes {
        for &depth in &args.depths {
            let row = row(args, scene, depth)?;
            eprintln!("{} depth {depth}: {:.3?} s", scene.name, row.seconds.list());
            rows.push(row);
        }
    }
    Ok(rows)
}

fn row(args: &BenchTree, scene: &BenchScene, depth: u32) -> Result<BuilderRow> {
    let prune = depth >= FIRST_PRUNED_DEPTH;
    let base = TreeOptions { prune, ..tree_options(depth)? };
    let never = AtomicBool::new(false);
    let prepared = PreparedTree::new(&scene.scene, &base, &never)?;
    let mut seconds: [Vec<f64>; 3] = Default::default();
    let mut last = Vec::new();
    for _ in 0..args.runs {
        last.clear();
        for (builder, seconds) in Builder::ALL.into_iter().zip(&mut seconds) {
            let baked = prepared.build(&TreeOptions { builder, ..base.clone() }, Watch::none())?;
            seconds.push(baked.report.build_seconds + baked.report.reduce_seconds);
            last.push(baked);
        }
    }
    let agree = last.windows(2).all(|w| w[0].tree == w[1].tree);
    let report = last[0].report;
    let resolution = (1_u64 << depth).to_string();
    let mut peaks = [None; 3];
    for (builder, peak) in NAMES.into_iter().zip(&mut peaks) {
        let mut options = vec!["--resolution", &resolution, "--builder", builder];
        if !prune {
            options.push("--exhaustive");
        }
        *peak = peak_bytes(scene, &options)?;
    }
    let [recursive, iterative, pooled] = seconds.map(median);
    let seconds = ByBuilder { recursive, iterative, pooled };
    let [recursive, iterative, pooled] = peaks;
    Ok(BuilderRow {
        scene: scene.name.clone(),
        depth,
        pruned: prune,
        agree,
        seconds,
        peak_bytes: ByBuilder { recursive, iterative, pooled },
        image_seconds: report.image_seconds,
        image_bytes: report.image_bytes,
    })
}

pub(super) fn markdown(part: &Part<Vec<BuilderRow>>) -> String {
    let mut text = format!(
        "\n## Builders\n\nSeconds to build and to reduce by hashing, on one thread, medians of {} runs in which \
        the builders take turns. Up to depth 10, every voxel is tested; from depth {FIRST_PRUNED_DEPTH}, cubes \
        that the min/max pyramid decides are skipped. `peak MB` is the peak resident memory of a process that \
        loads the scene, draws the depth image, builds the tree and writes it.\n\n\
        | scene | depth | voxels tested | recursive s | iterative s | pooled s | rank of recursive | pooled / iterative | peak MB | same graph |\n\
        |---|---|---|---|---|---|---|---|---|---|\n",
        part.runs
    );
    for r in &part.rows {
        let s = r.seconds.list();
        let place = match 1 + s[1..].iter().filter(|other| **other < s[0]).count() {
            1 => "first",
            2 => "second",
            _ => "last",
        };
        let peaks = r.peak_bytes.list();
        let peaks =
            peaks.map(|bytes| bytes.map_or_else(|| "–".to_owned(), |b| format!("{:.0}", b as f64 / 1e6)));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.3} | {:.3} | {:.3} | {place} | {:.3} | {} | {} |",
            r.scene,
            r.depth,
            if r.pruned { "undecided only" } else { "all" },
            s[0],
            s[1],
            s[2],
            s[2] / s[1],
            peaks.join(" / "),
            if r.agree { "yes" } else { "NO" },
        );
    }
    text
}

/// Plots seconds at the smallest depth, as in the figure, and pooled by recursive seconds at every depth.
pub(super) fn plots(folder: &Path, rows: &[BuilderRow]) -> Result<()> {
    let scenes = scene_names(rows.iter().map(|r| &r.scene));
    let depth = rows.iter().map(|r| r.depth).min().unwrap_or_default();
    let at_depth = |builder: usize| Series {
        name: NAMES[builder].to_owned(),
        points: scenes
            .iter()
            .enumerate()
            .filter_map(|(i, scene)| {
                let row = rows.iter().find(|r| r.scene == *scene && r.depth == depth)?;
                Some((i as f64, row.seconds.list()[builder]))
            })
            .collect(),
    };
    let share = |scene: &String| Series {
        name: scene.clone(),
        points: rows
            .iter()
            .filter(|r| r.scene == *scene)
            .map(|r| (f64::from(r.depth), r.seconds.pooled / r.seconds.recursive))
            .collect(),
    };
    let panels = [
        Panel {
            title: format!("three builders at depth {depth} (Fig. 3-4)"),
            along: Along::Names(scenes.clone()),
            y_label: "seconds",
            logarithmic: false,
            legend: Legend::UpperRight,
            series: [0, 1, 2].map(at_depth).into(),
        },
        Panel {
            title: "pooled against recursive".to_owned(),
            along: Along::Numbers("depth"),
            y_label: "pooled / recursive",
            logarithmic: false,
            legend: Legend::LowerLeft,
            series: scenes.iter().map(share).collect(),
        },
    ];
    write_svg(&folder.join("tree-builders.svg"), &panels)
}
