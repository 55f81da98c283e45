//! Upward merging, and reduction by sorting and by hashing: the paper's Fig. 3-2 and 3-5.

use adumbra_bake::Watch;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use adumbra_tree::{Builder, PreparedTree, Reduction, TreeOptions};

use super::document::{ByReduction, Part, ReductionRow};
use super::{BenchScene, median, peak_bytes, scene_names, tree_options};
use crate::Result;
use crate::args::BenchTree;
use crate::plot::{Along, Legend, Panel, Series, write_svg};

const VARIANTS: [(&str, Reduction); 3] =
    [("sort", Reduction::Sort), ("hash", Reduction::Hash), ("tree-hash", Reduction::TreeHash)];

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<Vec<ReductionRow>> {
    let mut rows = Vec::new();
    for scene in scenes {
        for &depth in &args.depths {
            let row = row(args, scene, depth)?;
            let ByReduction { sort, hash, tree_hash } = row.seconds;
            eprintln!("{} depth {depth}: {sort:.3}, {hash:.3}, {tree_hash:.3} s", scene.name);
            rows.push(row);
        }
    }
    Ok(rows)
}

fn row(args: &BenchTree, scene: &BenchScene, depth: u32) -> Result<ReductionRow> {
    let base = TreeOptions { builder: Builder::Recursive, ..tree_options(depth)? };
    let never = AtomicBool::new(false);
    let prepared = PreparedTree::new(&scene.scene, &base, &never)?;
    let mut seconds: [Vec<f64>; 3] = Default::default();
    let mut last = Vec::new();
    for _ in 0..args.runs {
        last.clear();
        for ((_, reduction), seconds) in VARIANTS.iter().zip(&mut seconds) {
            let baked =
                prepared.build(&TreeOptions { reduction: *reduction, ..base.clone() }, Watch::none())?;
            seconds.push(baked.report.build_seconds + baked.report.reduce_seconds);
            last.push(baked);
        }
    }
    let agree = last.windows(2).all(|w| w[0].tree == w[1].tree);
    let (sort, hash, tree_hash) = (&last[0].report, &last[1].report, &last[2].report);
    let resolution = (1_u64 << depth).to_string();
    let mut peaks = [None; 3];
    for ((name, _), peak) in VARIANTS.into_iter().zip(&mut peaks) {
        let options = ["--resolution", &resolution, "--builder", "recursive", "--reduction", name];
        *peak = peak_bytes(scene, &options)?;
    }
    let seconds = seconds.map(median);
    let seconds = ByReduction { sort: seconds[0], hash: seconds[1], tree_hash: seconds[2] };
    // A complete tree has one 32-bit word per node; the lowest level is stored as bits in its parents.
    let complete_bytes = 4.0 * (8_f64.powi(depth as i32) - 1.0) / 7.0;
    Ok(ReductionRow {
        scene: scene.name.clone(),
        depth,
        agree,
        seconds,
        held_bytes: ByReduction {
            sort: sort.held_bytes,
            hash: hash.held_bytes,
            tree_hash: tree_hash.held_bytes,
        },
        peak_bytes: ByReduction { sort: peaks[0], hash: peaks[1], tree_hash: peaks[2] },
        collisions: tree_hash.collisions,
        complete_bytes,
        merged_bytes: 4 + 32 * sort.built_blocks,
        graph_bytes: last[0].tree.bytes(),
    })
}

pub(super) fn markdown(part: &Part<Vec<ReductionRow>>) -> String {
    let mut text = String::from(
        "\n## Upward merging and sharing\n\nMB of 32-bit words: the complete tree; merged, with equal children \
        collapsed into their parent (Fig. 3-2); shared, with equal subtrees stored only once (Fig. 3-5). Each % \
        is relative to the size before it.\n\n\
        | scene | depth | complete | merged | % | shared | % |\n|---|---|---|---|---|---|---|\n",
    );
    for r in &part.rows {
        let _ = writeln!(
            text,
            "| {} | {} | {:.1} | {:.3} | {:.3} | {:.3} | {:.1} |",
            r.scene,
            r.depth,
            r.complete_bytes / 1e6,
            r.merged_bytes as f64 / 1e6,
            100.0 * r.merged_share(),
            r.graph_bytes as f64 / 1e6,
            100.0 * r.shared_share()
        );
    }
    let _ = write!(
        text,
        "\n## Sort against hash\n\nThe recursive builder, which skips the cubes that the pyramid decides, with \
        each reduction: seconds to build, reduce and number the nodes, medians of {} runs in which the \
        reductions take turns. `held MB` is the peak size of tree, tables and keys together, without the depth \
        image; `peak MB` is the peak resident memory of the whole process. Collisions are comparisons of \
        different subtrees with the same tree hash (3-5, 3-6). They follow from the formula: it multiplies the \
        weights along a path, so two voxels whose paths hold the same child numbers in a different order have \
        the same weight.\n\n\
        | scene | depth | sort s | hash s | hash / sort | tree hash s | sort held MB | hash held MB | sort peak MB | hash peak MB | collisions | same graph |\n\
        |---|---|---|---|---|---|---|---|---|---|---|---|\n",
        part.runs
    );
    for r in &part.rows {
        let ByReduction { sort, hash, tree_hash } = r.seconds;
        let held = |bytes: u64| bytes as f64 / 1e6;
        let peak =
            |bytes: Option<u64>| bytes.map_or_else(|| "–".to_owned(), |b| format!("{:.0}", b as f64 / 1e6));
        let _ = writeln!(
            text,
            "| {} | {} | {sort:.3} | {hash:.3} | {:.3} | {tree_hash:.3} | {:.1} | {:.1} | {} | {} | {} | {} |",
            r.scene,
            r.depth,
            hash / sort,
            held(r.held_bytes.sort),
            held(r.held_bytes.hash),
            peak(r.peak_bytes.sort),
            peak(r.peak_bytes.hash),
            r.collisions.map_or_else(|| "–".to_owned(), |n| n.to_string()),
            if r.agree { "yes" } else { "NO" },
        );
    }
    text
}

pub(super) fn plots(folder: &Path, rows: &[ReductionRow]) -> Result<()> {
    let scenes = scene_names(rows.iter().map(|r| &r.scene));
    let ratio = |title: &str, y_label, logarithmic, legend, of: fn(&ReductionRow) -> f64| Panel {
        title: title.to_owned(),
        along: Along::Numbers("depth"),
        y_label,
        logarithmic,
        legend,
        series: scenes
            .iter()
            .map(|scene| Series {
                name: scene.clone(),
                points: rows
                    .iter()
                    .filter(|r| r.scene == *scene)
                    .map(|r| (f64::from(r.depth), of(r)))
                    .collect(),
            })
            .collect(),
    };
    let merged = ("after upward merging (Fig. 3-2)", "% of the complete tree");
    let shared = ("after sharing by hash (Fig. 3-5)", "% of the merged tree");
    write_svg(
        &folder.join("tree-merging.svg"),
        &[
            ratio(merged.0, merged.1, true, Legend::UpperRight, |r| 100.0 * r.merged_share()),
            ratio(shared.0, shared.1, false, Legend::UpperRight, |r| 100.0 * r.shared_share()),
        ],
    )?;
    let label = "hash / sort";
    write_svg(
        &folder.join("tree-reductions.svg"),
        &[
            ratio("hash against sort: seconds", label, false, Legend::LowerLeft, |r| {
                r.seconds.hash / r.seconds.sort
            }),
            ratio("hash against sort: bytes held", label, false, Legend::UpperRight, |r| {
                r.held_bytes.hash as f64 / r.held_bytes.sort as f64
            }),
        ],
    )
}
