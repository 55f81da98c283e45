//! Upward merging and the two reductions: the paper's Fig. 3-2 and 3-5.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use adumbra::tree::{Builder, PreparedTree, Reduction, TreeOptions};
use serde_json::{Value, json};

use super::{BenchScene, bake_elsewhere, median, number, rows_of, scene_names, text_of, tree_options};
use crate::args::BenchTree;
use crate::exit::Failure;
use crate::plot::{Along, Legend, Panel, Series, write_svg};

const VARIANTS: [(&str, Reduction); 3] =
    [("sort", Reduction::Sort), ("hash", Reduction::Hash), ("tree-hash", Reduction::TreeHash)];

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
    let base = TreeOptions { builder: Builder::Recursive, ..tree_options(depth)? };
    let never = AtomicBool::new(false);
    let prepared = PreparedTree::new(&scene.scene, &base, &never)?;
    let mut seconds: [Vec<f64>; 3] = Default::default();
    let mut last = Vec::new();
    for _ in 0..args.runs {
        last.clear();
        for ((_, reduction), seconds) in VARIANTS.iter().zip(&mut seconds) {
            let baked =
                prepared.build(&TreeOptions { reduction: *reduction, ..base.clone() }, &|_| {}, &never)?;
            seconds.push(baked.report.build_seconds + baked.report.reduce_seconds);
            last.push(baked);
        }
    }
    let agree = last.windows(2).all(|w| w[0].tree == w[1].tree);
    let (sort, hash, tree_hash) = (&last[0].report, &last[1].report, &last[2].report);
    let resolution = (1_u64 << depth).to_string();
    let mut peaks = Vec::new();
    for (name, _) in VARIANTS {
        let options = ["--resolution", &resolution, "--builder", "recursive", "--reduction", name];
        peaks.push(bake_elsewhere(scene, &options)?["peak_bytes"].clone());
    }
    let [sort_seconds, hash_seconds, tree_hash_seconds] = seconds.map(median);
    // A complete tree: a word a node, the lowest level as bits of its parents.
    let complete_bytes = 4.0 * (8_f64.powi(depth as i32) - 1.0) / 7.0;
    Ok(json!({
        "scene": scene.name,
        "depth": depth,
        "agree": agree,
        "seconds": {"sort": sort_seconds, "hash": hash_seconds, "tree_hash": tree_hash_seconds},
        "held_bytes": {"sort": sort.held_bytes, "hash": hash.held_bytes, "tree_hash": tree_hash.held_bytes},
        "peak_bytes": {"sort": peaks[0], "hash": peaks[1], "tree_hash": peaks[2]},
        "collisions": tree_hash.collisions,
        "complete_bytes": complete_bytes,
        "merged_bytes": 4 + 32 * sort.built_blocks,
        "graph_bytes": last[0].tree.bytes(),
    }))
}

pub(super) fn markdown(part: &Value) -> String {
    let mut text = String::from(
        "\n## Upward merging and sharing\n\nMB of 32-bit words: the complete tree; equal children collapsed into their parent (Fig. 3-2); \
        equal subtrees stored once (Fig. 3-5). Each share is of the column before it.\n\n\
        | scene | depth | complete | merged | % | shared | % |\n|---|---|---|---|---|---|---|\n",
    );
    for r in rows_of(part) {
        let [complete, merged, graph] =
            ["/complete_bytes", "/merged_bytes", "/graph_bytes"].map(|k| number(r, k));
        let _ = writeln!(
            text,
            "| {} | {} | {:.1} | {:.3} | {:.3} | {:.3} | {:.1} |",
            text_of(r, "scene"),
            r["depth"],
            complete / 1e6,
            merged / 1e6,
            100.0 * merged / complete,
            graph / 1e6,
            100.0 * graph / merged
        );
    }
    let _ = write!(
        text,
        "\n## Sort against hash\n\nThe recursive builder, skipping what the pyramid decides, with each reduction: seconds of building, reducing \
        and numbering, medians of {} runs in which the reductions take turns. `held MB` is what tree, tables and keys take at most, without the depth image; `peak MB` the whole process. \
        Collisions are comparisons of different subtrees with one tree hash (3-5, 3-6). They lie in the formula: the weights along a \
        path are multiplied, so two voxels whose paths hold the same child numbers in another order weigh the same.\n\n\
        | scene | depth | sort s | hash s | hash / sort | tree hash s | sort held MB | hash held MB | sort peak MB | hash peak MB | collisions | same graph |\n\
        |---|---|---|---|---|---|---|---|---|---|---|---|\n",
        part["runs"]
    );
    for r in rows_of(part) {
        let (sort, hash) = (number(r, "/seconds/sort"), number(r, "/seconds/hash"));
        let _ = writeln!(
            text,
            "| {} | {} | {sort:.3} | {hash:.3} | {:.3} | {:.3} | {:.1} | {:.1} | {:.0} | {:.0} | {} | {} |",
            text_of(r, "scene"),
            r["depth"],
            hash / sort,
            number(r, "/seconds/tree_hash"),
            number(r, "/held_bytes/sort") / 1e6,
            number(r, "/held_bytes/hash") / 1e6,
            number(r, "/peak_bytes/sort") / 1e6,
            number(r, "/peak_bytes/hash") / 1e6,
            r["collisions"],
            if r["agree"] == true { "yes" } else { "NO" },
        );
    }
    text
}

pub(super) fn plots(folder: &Path, part: &Value) -> Result<(), Failure> {
    let scenes = scene_names(part);
    let ratio = |title: &str, y_label, logarithmic, legend, what: &str, whole: &str, scale: f64| Panel {
        title: title.to_owned(),
        along: Along::Numbers("depth"),
        y_label,
        logarithmic,
        legend,
        series: scenes
            .iter()
            .map(|scene| Series {
                name: scene.clone(),
                points: rows_of(part)
                    .iter()
                    .filter(|r| r["scene"] == *scene)
                    .map(|r| (number(r, "/depth"), scale * number(r, what) / number(r, whole)))
                    .collect(),
            })
            .collect(),
    };
    let merged = ("after upward merging (Fig. 3-2)", "% of the complete tree");
    let shared = ("after sharing by hash (Fig. 3-5)", "% of the merged tree");
    write_svg(
        &folder.join("tree-merging.svg"),
        &[
            ratio(merged.0, merged.1, true, Legend::UpperRight, "/merged_bytes", "/complete_bytes", 100.0),
            ratio(shared.0, shared.1, false, Legend::UpperRight, "/graph_bytes", "/merged_bytes", 100.0),
        ],
    )?;
    let label = "hash / sort";
    write_svg(
        &folder.join("tree-reductions.svg"),
        &[
            ratio(
                "hash against sort: seconds",
                label,
                false,
                Legend::LowerLeft,
                "/seconds/hash",
                "/seconds/sort",
                1.0,
            ),
            ratio(
                "hash against sort: bytes held",
                label,
                false,
                Legend::UpperRight,
                "/held_bytes/hash",
                "/held_bytes/sort",
                1.0,
            ),
        ],
    )
}
