//! The three builders compared with each other: the paper's Fig. 3-4.

use std::path::Path;

use adumbra_papers::tree::{TreeBuilder, TreeOptions};

use super::results::{BuilderRow, ByBuilder, Part};
use super::{
    BenchScene, FIRST_PRUNED_DEPTH, InTurn, build_in_turn, peak_bytes, scene_names, tree_options, yes_or_no,
};
use crate::args::BenchTree;
use adumbra_compare::Result;
use adumbra_html::page::Table;
use adumbra_html::plot::{Along, Legend, Panel, Series, write_svg};
use adumbra_program::format::{figure, megabytes};

const NAMES: [&str; 3] = ["recursive", "iterative", "pooled"];

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<Vec<BuilderRow>> {
    let mut rows = Vec::new();
    for scene in scenes {
        for &depth in &args.depths {
            let row = row(args, scene, depth)?;
            adumbra_program::note!("{} depth {depth}: {:.3?} s", scene.name, row.seconds.list());
            rows.push(row);
        }
    }
    Ok(rows)
}

fn row(args: &BenchTree, scene: &BenchScene, depth: u32) -> Result<BuilderRow> {
    let prune = depth >= FIRST_PRUNED_DEPTH;
    let base = TreeOptions { prune, ..tree_options(depth)? };
    let variants = TreeBuilder::ALL.map(|builder| TreeOptions { builder, ..base.clone() });
    let InTurn { seconds, agree, last } = build_in_turn(args, scene, &variants)?;
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
    let [recursive, iterative, pooled] = seconds;
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
    let table = Table::of(
        "",
        &part.rows,
        &[
            ("scene", |r| r.scene.clone()),
            ("depth", |r| r.depth.to_string()),
            ("voxels tested", |r| if r.pruned { "undecided only" } else { "all" }.to_owned()),
            ("recursive s", |r| figure(r.seconds.recursive, 3)),
            ("iterative s", |r| figure(r.seconds.iterative, 3)),
            ("pooled s", |r| figure(r.seconds.pooled, 3)),
            ("rank of recursive", |r| rank_of_recursive(r.seconds).to_owned()),
            ("pooled / iterative", |r| figure(r.seconds.pooled / r.seconds.iterative, 3)),
            ("peak MB", |r| r.peak_bytes.list().map(|bytes| megabytes(bytes, 0)).join(" / ")),
            ("same graph", |r| yes_or_no(r.agree).to_owned()),
        ],
    );
    format!(
        "\n## Builders\n\nSeconds to build and to reduce by hashing, on one thread, medians of {} runs in which \
        the builders take turns. Up to depth 10, every voxel is tested; from depth {FIRST_PRUNED_DEPTH}, cubes \
        that the min/max pyramid decides are skipped. `peak MB` is the peak resident memory of a process that \
        loads the scene, draws the depth image, builds the tree and writes it.\n\n{}",
        part.runs,
        table.markdown()
    )
}

fn rank_of_recursive(seconds: ByBuilder<f64>) -> &'static str {
    let [recursive, others @ ..] = seconds.list();
    match others.iter().filter(|other| **other < recursive).count() {
        0 => "first",
        1 => "second",
        _ => "last",
    }
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
    Ok(write_svg(&folder.join("tree-builders.svg"), &panels)?)
}
