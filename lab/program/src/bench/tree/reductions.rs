//! Upward merging, and reduction by sorting and by hashing: the paper's Fig. 3-2 and 3-5.

use std::path::Path;

use adumbra_papers::tree::{Reduction, TreeBuilder, TreeOptions};

use super::results::{ByReduction, Part, ReductionRow};
use super::{BenchScene, InTurn, build_in_turn, peak_bytes, scene_names, tree_options, yes_or_no};
use crate::args::BenchTree;
use adumbra_compare::Result;
use adumbra_html::page::Table;
use adumbra_html::plot::{Along, Legend, Panel, Series, write_svg};
use adumbra_program::format::{figure, megabytes, percent};

const VARIANTS: [(&str, Reduction); 3] =
    [("sort", Reduction::Sort), ("hash", Reduction::Hash), ("tree-hash", Reduction::TreeHash)];

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<Vec<ReductionRow>> {
    let mut rows = Vec::new();
    for scene in scenes {
        for &depth in &args.depths {
            let row = row(args, scene, depth)?;
            let ByReduction { sort, hash, tree_hash } = row.seconds;
            adumbra_program::note!("{} depth {depth}: {sort:.3}, {hash:.3}, {tree_hash:.3} s", scene.name);
            rows.push(row);
        }
    }
    Ok(rows)
}

fn row(args: &BenchTree, scene: &BenchScene, depth: u32) -> Result<ReductionRow> {
    let base = TreeOptions { builder: TreeBuilder::Recursive, ..tree_options(depth)? };
    let variants = VARIANTS.map(|(_, reduction)| TreeOptions { reduction, ..base.clone() });
    let InTurn { seconds, agree, last } = build_in_turn(args, scene, &variants)?;
    let (sort, hash, tree_hash) = (&last[0].report, &last[1].report, &last[2].report);
    let resolution = (1_u64 << depth).to_string();
    let mut peaks = [None; 3];
    for ((name, _), peak) in VARIANTS.into_iter().zip(&mut peaks) {
        let options = ["--resolution", &resolution, "--builder", "recursive", "--reduction", name];
        *peak = peak_bytes(scene, &options)?;
    }
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
    let sizes = Table::of(
        "",
        &part.rows,
        &[
            ("scene", |r| r.scene.clone()),
            ("depth", |r| r.depth.to_string()),
            ("complete", |r| figure(r.complete_bytes / 1e6, 1)),
            ("merged", |r| megabytes(r.merged_bytes, 3)),
            ("%", |r| percent(r.merged_share(), 3)),
            ("shared", |r| megabytes(r.graph_bytes, 3)),
            ("%", |r| percent(r.shared_share(), 1)),
        ],
    );
    let costs = Table::of(
        "",
        &part.rows,
        &[
            ("scene", |r| r.scene.clone()),
            ("depth", |r| r.depth.to_string()),
            ("sort s", |r| figure(r.seconds.sort, 3)),
            ("hash s", |r| figure(r.seconds.hash, 3)),
            ("hash / sort", |r| figure(r.seconds.hash / r.seconds.sort, 3)),
            ("tree hash s", |r| figure(r.seconds.tree_hash, 3)),
            ("sort held MB", |r| megabytes(r.held_bytes.sort, 1)),
            ("hash held MB", |r| megabytes(r.held_bytes.hash, 1)),
            ("sort peak MB", |r| megabytes(r.peak_bytes.sort, 0)),
            ("hash peak MB", |r| megabytes(r.peak_bytes.hash, 0)),
            ("collisions", |r| r.collisions.map_or_else(|| "–".to_owned(), |n| n.to_string())),
            ("same graph", |r| yes_or_no(r.agree).to_owned()),
        ],
    );
    format!(
        "\n## Upward merging and sharing\n\nMB of 32-bit words: the complete tree; merged, with equal children \
        collapsed into their parent (Fig. 3-2); shared, with equal subtrees stored only once (Fig. 3-5). Each % \
        is relative to the size before it.\n\n{}\n\
        ## Sort against hash\n\nThe recursive builder, which skips the cubes that the pyramid decides, with \
        each reduction: seconds to build, reduce and number the nodes, medians of {} runs in which the \
        reductions take turns. `held MB` is the peak size of tree, tables and keys together, without the depth \
        image; `peak MB` is the peak resident memory of the whole process. Collisions are comparisons of \
        different subtrees with the same tree hash (3-5, 3-6). They follow from the formula: it multiplies the \
        weights along a path, so two voxels whose paths hold the same child numbers in a different order have \
        the same weight.\n\n{}",
        sizes.markdown(),
        part.runs,
        costs.markdown()
    )
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
    )?;
    Ok(())
}
