//! The three builders against each other: the paper's Fig. 3-4.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use adumbra::tree::{Builder, PreparedTree, TreeOptions};
use serde_json::{Value, json};

use super::{
    BenchScene, FIRST_PRUNED_DEPTH, bake_elsewhere, median, number, rows_of, scene_names, text_of,
    tree_options,
};
use crate::args::BenchTree;
use crate::exit::Failure;
use crate::plot::{Along, Legend, Panel, Series, write_svg};

const NAMES: [&str; 3] = ["recursive", "iterative", "pooled"];

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<Value, Failure> {
    let mut rows = Vec::new();
    for scene in scenes {
        for &depth in &args.depths {
            let row = row(args, scene, depth)?;
            eprintln!("{} depth {depth}: {}", scene.name, row["seconds"]);
            rows.push(row);
        }
    }
    Ok(Value::Array(rows))
}

fn row(args: &BenchTree, scene: &BenchScene, depth: u32) -> Result<Value, Failure> {
    let prune = depth >= FIRST_PRUNED_DEPTH;
    let base = TreeOptions { prune, ..tree_options(depth)? };
    let never = AtomicBool::new(false);
    let prepared = PreparedTree::new(&scene.scene, &base, &never)?;
    let mut seconds: [Vec<f64>; 3] = Default::default();
    let mut last = Vec::new();
    for _ in 0..args.runs {
        last.clear();
        for (builder, seconds) in Builder::ALL.into_iter().zip(&mut seconds) {
            let baked = prepared.build(&TreeOptions { builder, ..base.clone() }, &|_| {}, &never)?;
            seconds.push(baked.report.build_seconds + baked.report.reduce_seconds);
            last.push(baked);
        }
    }
    let agree = last.windows(2).all(|w| w[0].tree == w[1].tree);
    let report = last[0].report;
    let resolution = (1_u64 << depth).to_string();
    let mut peaks = Vec::new();
    for builder in NAMES {
        let mut options = vec!["--resolution", &resolution, "--builder", builder];
        if !prune {
            options.push("--exhaustive");
        }
        peaks.push(bake_elsewhere(scene, &options)?["peak_bytes"].clone());
    }
    let [recursive, iterative, pooled] = seconds.map(median);
    Ok(json!({
        "scene": scene.name,
        "depth": depth,
        "pruned": prune,
        "agree": agree,
        "seconds": {"recursive": recursive, "iterative": iterative, "pooled": pooled},
        "peak_bytes": {"recursive": peaks[0], "iterative": peaks[1], "pooled": peaks[2]},
        "image_seconds": report.image_seconds,
        "image_bytes": report.image_bytes,
    }))
}

pub(super) fn markdown(part: &Value) -> String {
    let mut text = format!(
        "\n## Builders\n\nSeconds to build and reduce by hash, one thread, medians of {} runs in which the builders take turns. Up to depth 10 every voxel is tested; from depth \
        {FIRST_PRUNED_DEPTH} cubes that the min/max pyramid decides are skipped. `peak MB` is the largest resident size of a process that loads \
        the scene, draws the depth image, builds and writes.\n\n\
        | scene | depth | voxels tested | recursive s | iterative s | pooled s | recursion is | pooled / iterative | peak MB | same graph |\n\
        |---|---|---|---|---|---|---|---|---|---|\n",
        part["runs"]
    );
    for r in rows_of(part) {
        let s = NAMES.map(|b| number(r, &format!("/seconds/{b}")));
        let place = match 1 + s[1..].iter().filter(|other| **other < s[0]).count() {
            1 => "first",
            2 => "second",
            _ => "last",
        };
        let peaks = NAMES.map(|b| format!("{:.0}", number(r, &format!("/peak_bytes/{b}")) / 1e6));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.3} | {:.3} | {:.3} | {place} | {:.3} | {} | {} |",
            text_of(r, "scene"),
            r["depth"],
            if r["pruned"] == true { "where undecided" } else { "all" },
            s[0],
            s[1],
            s[2],
            s[2] / s[1],
            peaks.join(" / "),
            if r["agree"] == true { "yes" } else { "NO" },
        );
    }
    text
}

/// Seconds at the smallest depth, as in the figure, and at every depth as a share of recursion's.
pub(super) fn plots(folder: &Path, part: &Value) -> Result<(), Failure> {
    let scenes = scene_names(part);
    let depth = rows_of(part).iter().map(|r| number(r, "/depth")).fold(f64::INFINITY, f64::min);
    let at_depth = |builder: &str| Series {
        name: builder.to_owned(),
        points: scenes
            .iter()
            .enumerate()
            .filter_map(|(i, scene)| {
                let row =
                    rows_of(part).iter().find(|r| r["scene"] == *scene && number(r, "/depth") == depth)?;
                Some((i as f64, number(row, &format!("/seconds/{builder}"))))
            })
            .collect(),
    };
    let share = |scene: &String| Series {
        name: scene.clone(),
        points: rows_of(part)
            .iter()
            .filter(|r| r["scene"] == *scene)
            .map(|r| (number(r, "/depth"), number(r, "/seconds/pooled") / number(r, "/seconds/recursive")))
            .collect(),
    };
    let panels = [
        Panel {
            title: format!("three builders at depth {depth} (Fig. 3-4)"),
            along: Along::Names(scenes.clone()),
            y_label: "seconds",
            logarithmic: false,
            legend: Legend::UpperRight,
            series: NAMES.map(at_depth).into(),
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
