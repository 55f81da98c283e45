//! Builders, upward merging, and the two reductions: the paper's Fig. 3-2, 3-4 and 3-5.

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use adumbra::tree::{Builder, PreparedTree, Reduction, TreeOptions};
use serde_json::{Value, json};

use super::{BenchScene, FIRST_PRUNED_DEPTH, Section, bake_elsewhere, median, tree_options};
use crate::args::BenchTree;
use crate::exit::Failure;
use crate::plot::{Along, Panel, Series, write_svg};

/// What takes turns: name, builder, reduction.
const VARIANTS: [(&str, Builder, Reduction); 4] = [
    ("recursive", Builder::Recursive, Reduction::Hash),
    ("iterative", Builder::Iterative, Reduction::Hash),
    ("pooled", Builder::Pooled, Reduction::Hash),
    ("sort", Builder::Recursive, Reduction::Sort),
];

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<Section, Failure> {
    let mut rows = Vec::new();
    for scene in scenes {
        for &depth in &args.depths {
            let row = row(args, scene, depth)?;
            eprintln!("{} depth {depth}: {}", scene.name, row["seconds"]);
            rows.push(row);
        }
    }
    plots(args, scenes, &rows)?;
    Ok(Section { markdown: markdown(&rows), key: "builders", rows: Value::Array(rows) })
}

fn row(args: &BenchTree, scene: &BenchScene, depth: u32) -> Result<Value, Failure> {
    let prune = depth >= FIRST_PRUNED_DEPTH;
    let base = TreeOptions { prune, ..tree_options(depth)? };
    let prepared = PreparedTree::new(&scene.scene, &base)?;
    let never = AtomicBool::new(false);
    let build =
        |builder, reduction| prepared.build(&TreeOptions { builder, reduction, ..base.clone() }, &never);
    let mut seconds: [Vec<f64>; 4] = Default::default();
    let mut last = Vec::new();
    for _ in 0..args.runs {
        last.clear();
        for ((_, builder, reduction), seconds) in VARIANTS.iter().zip(&mut seconds) {
            let baked = build(*builder, *reduction)?;
            seconds.push(baked.report.build_seconds + baked.report.reduce_seconds);
            last.push(baked);
        }
    }
    let agree = last.windows(2).all(|w| w[0].tree == w[1].tree);
    let (hash, sort) = (&last[0], &last[3]);
    let tree_hash = build(Builder::Recursive, Reduction::TreeHash)?;
    let report = tree_hash.report;
    let medians: Vec<f64> = seconds.into_iter().map(median).collect();
    let mut peaks = Vec::new();
    for (_, builder, reduction) in VARIANTS {
        let resolution = (1_u64 << depth).to_string();
        let (builder, reduction) = (json!(builder), json!(reduction));
        let (builder, reduction) = (builder.as_str().unwrap_or(""), reduction.as_str().unwrap_or(""));
        let mut options = vec!["--resolution", &resolution, "--builder", builder, "--reduction", reduction];
        if !prune {
            options.push("--exhaustive");
        }
        peaks.push(bake_elsewhere(scene, &options)?["peak_bytes"].clone());
    }
    // A complete tree: a word a node, the lowest level as bits of its parents.
    let complete_bytes = 4.0 * (8_f64.powi(depth as i32) - 1.0) / 7.0;
    Ok(json!({
        "scene": scene.name,
        "depth": depth,
        "pruned": prune,
        "agree": agree && tree_hash.tree == hash.tree,
        "seconds": {"recursive": medians[0], "iterative": medians[1], "pooled": medians[2], "sort": medians[3],
            "tree_hash_once": report.build_seconds + report.reduce_seconds},
        "peak_bytes": {"recursive": peaks[0], "iterative": peaks[1], "pooled": peaks[2], "sort": peaks[3]},
        "held_bytes": {"hash": hash.report.tree_bytes, "sort": sort.report.tree_bytes},
        "collisions": report.collisions,
        "complete_bytes": complete_bytes,
        "merged_bytes": 4 + 32 * sort.report.built_blocks,
        "graph_bytes": hash.tree.bytes(),
        "image_seconds": hash.report.image_seconds,
        "image_bytes": hash.report.image_bytes,
    }))
}

fn number(row: &Value, path: &str) -> f64 {
    row.pointer(path).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

fn markdown(rows: &[Value]) -> String {
    let mut text = String::from(
        "\n## Builders\n\nSeconds to build and reduce by hash; `peak MB` is the largest resident size of a process that loads the scene, \
        draws the depth image, builds and writes.\n\n\
        | scene | depth | voxels tested | recursive s | iterative s | pooled s | recursion is | peak MB | same graph |\n\
        |---|---|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        let s = ["recursive", "iterative", "pooled"].map(|b| number(r, &format!("/seconds/{b}")));
        let place = match 1 + s[1..].iter().filter(|other| **other < s[0]).count() {
            1 => "first",
            2 => "second",
            _ => "last",
        };
        let peaks = ["recursive", "iterative", "pooled"]
            .map(|b| format!("{:.0}", number(r, &format!("/peak_bytes/{b}")) / 1e6));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.3} | {:.3} | {:.3} | {place} | {} | {} |",
            r["scene"].as_str().unwrap_or(""),
            r["depth"],
            if r["pruned"] == true { "where undecided" } else { "all" },
            s[0],
            s[1],
            s[2],
            peaks.join(" / "),
            if r["agree"] == true { "yes" } else { "NO" },
        );
    }
    text.push_str(
        "\n## Upward merging and sharing\n\nMB of 32-bit words: the complete tree; equal children collapsed into their parent (Fig. 3-2); \
        equal subtrees stored once (Fig. 3-5). Each share is of the column before it.\n\n\
        | scene | depth | complete | merged | % | shared | % |\n|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        let [complete, merged, graph] =
            ["/complete_bytes", "/merged_bytes", "/graph_bytes"].map(|k| number(r, k));
        let _ = writeln!(
            text,
            "| {} | {} | {:.1} | {:.3} | {:.3} | {:.3} | {:.1} |",
            r["scene"].as_str().unwrap_or(""),
            r["depth"],
            complete / 1e6,
            merged / 1e6,
            100.0 * merged / complete,
            graph / 1e6,
            100.0 * graph / merged
        );
    }
    text.push_str(
        "\n## Sort against hash\n\nThe recursive builder with each reduction; `held MB` is what tree, tables and keys take at most, \
        without the depth image. The tree hash (3-5, 3-6) was run once; its collisions are comparisons of different subtrees with one \
        hash. They are the formula's own: along a path the weights are multiplied, so two voxels whose paths hold the same child \
        numbers in another order weigh the same.\n\n\
        | scene | depth | sort s | hash s | hash / sort | tree hash s | sort held MB | hash held MB | sort peak MB | hash peak MB | collisions |\n\
        |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        let (sort, hash) = (number(r, "/seconds/sort"), number(r, "/seconds/recursive"));
        let _ = writeln!(
            text,
            "| {} | {} | {sort:.3} | {hash:.3} | {:.2} | {:.3} | {:.1} | {:.1} | {:.0} | {:.0} | {} |",
            r["scene"].as_str().unwrap_or(""),
            r["depth"],
            hash / sort,
            number(r, "/seconds/tree_hash_once"),
            number(r, "/held_bytes/sort") / 1e6,
            number(r, "/held_bytes/hash") / 1e6,
            number(r, "/peak_bytes/sort") / 1e6,
            number(r, "/peak_bytes/recursive") / 1e6,
            r["collisions"],
        );
    }
    text
}

fn plots(args: &BenchTree, scenes: &[BenchScene], rows: &[Value]) -> Result<(), Failure> {
    let series = |name: &str, scene: &str, y: &dyn Fn(&Value) -> f64| Series {
        name: name.to_owned(),
        points: rows
            .iter()
            .filter(|r| r["scene"] == scene)
            .map(|r| (r["depth"].as_f64().unwrap_or(f64::NAN), y(r)))
            .collect(),
    };
    let panel = |title: String, y_label, logarithmic, series| Panel {
        title,
        along: Along::Numbers("depth"),
        y_label,
        logarithmic,
        series,
    };
    let builders = |s: &BenchScene| {
        let lines = ["recursive", "iterative", "pooled"]
            .map(|b| series(b, &s.name, &|r| number(r, &format!("/seconds/{b}"))));
        panel(format!("{}: three builders", s.name), "seconds", true, lines.into())
    };
    let panels: Vec<_> = scenes.iter().map(builders).collect();
    write_svg(&args.output.join("tree-builders.svg"), &panels)?;
    let by_scene = |y: &dyn Fn(&Value) -> f64| scenes.iter().map(|s| series(&s.name, &s.name, y)).collect();
    let ratio =
        |part: &'static str, whole: &'static str| move |r: &Value| 100.0 * number(r, part) / number(r, whole);
    let merging = by_scene(&ratio("/merged_bytes", "/complete_bytes"));
    let sharing = by_scene(&ratio("/graph_bytes", "/merged_bytes"));
    write_svg(
        &args.output.join("tree-merging.svg"),
        &[
            panel("after upward merging (Fig. 3-2)".to_owned(), "% of the complete tree", true, merging),
            panel("after sharing by hash (Fig. 3-5)".to_owned(), "% of the merged tree", false, sharing),
        ],
    )?;
    let time = by_scene(&|r| number(r, "/seconds/recursive") / number(r, "/seconds/sort"));
    let held = by_scene(&|r| number(r, "/held_bytes/hash") / number(r, "/held_bytes/sort"));
    write_svg(
        &args.output.join("tree-reductions.svg"),
        &[
            panel("hash against sort: time".to_owned(), "hash / sort", false, time),
            panel("hash against sort: bytes held".to_owned(), "hash / sort", false, held),
        ],
    )
}
