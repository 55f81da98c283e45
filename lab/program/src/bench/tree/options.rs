//! Every option compared with the plain tree: bytes, seconds, changed voxels, nanoseconds per look-up.

use adumbra_bake::Watch;
use std::hint::black_box;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adumbra::Sun;
use adumbra_papers::tree::attribute::AttributeIndex;
use adumbra_papers::tree::lossy::merge_similar;
use adumbra_papers::tree::symmetric::SymmetricTree;
use adumbra_papers::tree::{BakedTree, PreparedTree};
use adumbra_scene::random::Random;
use adumbra_truth::verify::{Solids, SurfaceSampler};

use super::results::{OptionRow, Part};
use super::{BenchScene, SUN, scene_names, tree_options, unfiltered};
use crate::args::BenchTree;
use adumbra_compare::Result;
use adumbra_compare::metrics::median;
use adumbra_html::page::Table;
use adumbra_html::plot::{Along, Legend, Panel, Series, write_svg};
use adumbra_program::format::{figure, megabytes, percent};

/// Depth of the trees.
const DEPTH: u32 = 11;
/// Shares of border voxels that lossy merging may change.
const LOSSY_SHARES: [f64; 4] = [0.001, 0.005, 0.01, 0.05];
/// Number of look-ups timed together.
const LOOKUPS: usize = 500_000;

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<Vec<OptionRow>> {
    let mut rows = Vec::new();
    for scene in scenes {
        rows.extend(scene_rows(args, scene)?);
        adumbra_program::note!("{}: options", scene.name);
    }
    Ok(rows)
}

fn scene_rows(args: &BenchTree, scene: &BenchScene) -> Result<Vec<OptionRow>> {
    let options = tree_options(DEPTH)?;
    let never = AtomicBool::new(false);
    let prepared = PreparedTree::new(&scene.scene, &options, &never)?;
    let baked = prepared.build(&options, Watch::none())?;
    let voxels = surface_voxels(scene, &baked)?;
    let tree = &baked.tree;
    let timer = Timer { voxels: &voxels, runs: args.runs };
    let plain = tree.bytes();
    let row =
        |option: String, bytes: u64, seconds: f64, changed: Option<[u64; 2]>, nanoseconds: f64| OptionRow {
            scene: scene.name.clone(),
            depth: DEPTH,
            option,
            bytes,
            times_plain: bytes as f64 / plain as f64,
            seconds,
            changed_voxels: changed.map(|c| c[0]),
            leaf_voxels: changed.map(|c| c[1]),
            nanoseconds,
        };
    let mut rows = vec![row(
        "plain words".to_owned(),
        plain,
        baked.report.build_seconds + baked.report.reduce_seconds,
        None,
        timer.nanoseconds(|v| u32::from(tree.voxel(v))),
    )];
    for (mirrors, name) in [(false, "variable-width pointers"), (true, "mirrors and variable-width pointers")]
    {
        let start = Instant::now();
        let symmetric = SymmetricTree::of(tree, mirrors)?;
        let seconds = start.elapsed().as_secs_f64();
        let nanoseconds = timer.nanoseconds(|v| u32::from(symmetric.voxel(v)));
        rows.push(row(name.to_owned(), symmetric.bytes().len() as u64, seconds, None, nanoseconds));
    }
    for share in LOSSY_SHARES {
        let start = Instant::now();
        let merged = merge_similar(tree, share)?;
        let seconds = start.elapsed().as_secs_f64();
        let changed = Some([merged.change.changed_voxels, merged.change.leaf_voxels]);
        let nanoseconds = timer.nanoseconds(|v| u32::from(merged.tree.voxel(v)));
        let percent = 100.0 * share;
        rows.push(row(format!("lossy {percent} %"), merged.tree.bytes(), seconds, changed, nanoseconds));
        if share == 0.005 {
            let start = Instant::now();
            let symmetric = SymmetricTree::of(&merged.tree, true)?;
            let seconds = seconds + start.elapsed().as_secs_f64();
            let bytes = symmetric.bytes().len() as u64;
            let nanoseconds = timer.nanoseconds(|v| u32::from(symmetric.voxel(v)));
            rows.push(row(format!("lossy {percent} %, then mirrors"), bytes, seconds, changed, nanoseconds));
        }
    }
    let start = Instant::now();
    let index = AttributeIndex::of(tree)?;
    let values = prepared.penumbra(tree)?;
    let seconds = start.elapsed().as_secs_f64();
    let nanoseconds = timer.nanoseconds(|v| {
        u32::from(tree.voxel(v)) + index.locate(tree, v).map_or(0, |i| u32::from(values[i as usize]))
    });
    let bytes = plain + values.len() as u64;
    rows.push(row("one penumbra byte per border voxel".to_owned(), bytes, seconds, None, nanoseconds));
    Ok(rows)
}

/// Returns the voxels that look-ups at random points on the scene's surfaces read.
fn surface_voxels(scene: &BenchScene, baked: &BakedTree) -> Result<Vec<[u32; 3]>> {
    let sun = Sun::from_direction(SUN)?;
    let solids = Solids::of(&scene.scene);
    let sampler = SurfaceSampler::new(&scene.scene, &solids, sun.towards(), false);
    let query = unfiltered(baked, sun)?;
    let mut random = Random::new(1, 0);
    let mut voxels = Vec::with_capacity(LOOKUPS);
    while voxels.len() < LOOKUPS {
        let sample = sampler.sample(&mut random);
        voxels.extend(query.voxel_at(sample.p_world, sample.normal));
    }
    Ok(voxels)
}

struct Timer<'a> {
    voxels: &'a [[u32; 3]],
    runs: usize,
}

impl Timer<'_> {
    /// Returns the time per look-up, the median over the runs.
    fn nanoseconds(&self, look_up: impl Fn([u32; 3]) -> u32) -> f64 {
        let runs = (0..self.runs).map(|_| {
            let start = Instant::now();
            let sum: u32 = self.voxels.iter().map(|v| look_up(*v)).sum();
            black_box(sum);
            start.elapsed().as_secs_f64() * 1e9 / self.voxels.len() as f64
        });
        median(runs.collect())
    }
}

pub(super) fn markdown(part: &Part<Vec<OptionRow>>) -> String {
    let table = Table::of(
        "",
        &part.rows,
        &[
            ("scene", |r| r.scene.clone()),
            ("option", |r| r.option.clone()),
            ("MB", |r| megabytes(r.bytes, 3)),
            ("× plain", |r| figure(r.times_plain, 3)),
            ("s", |r| figure(r.seconds, 2)),
            ("changed", |r| r.changed().map_or(0, |[changed, _]| changed).to_string()),
            ("of border voxels %", |r| match r.changed() {
                Some([changed, all]) => percent(changed as f64 / all.max(1) as f64, 4),
                None => "0".to_owned(),
            }),
            ("ns", |r| figure(r.nanoseconds, 0)),
        ],
    );
    format!(
        "\n## Options\n\nDepth {DEPTH}, world frame. Seconds are those that the option adds to the plain tree's, \
        timed once. `changed` counts the voxels that differ from the plain tree; its % is of the voxels at \
        shadow borders (cells of leaves of eight). `ns` is nanoseconds per look-up of one voxel, at {LOOKUPS} \
        random points on the scene's surfaces, on one thread, medians of {} runs, one after the other. The \
        penumbra row includes the look-up of the byte.\n\n{}",
        part.runs,
        table.markdown()
    )
}

impl OptionRow {
    /// Returns the changed voxels and the voxels at shadow borders, if the option changes any.
    fn changed(&self) -> Option<[u64; 2]> {
        Some([self.changed_voxels?, self.leaf_voxels?])
    }
}

pub(super) fn plots(folder: &Path, rows: &[OptionRow]) -> Result<()> {
    let scenes = scene_names(rows.iter().map(|r| &r.scene));
    let shown = [
        ("plain words", "plain"),
        ("variable-width pointers", "widths"),
        ("mirrors and variable-width pointers", "mirrors"),
        ("lossy 0.5 %", "lossy 0.5%"),
        ("lossy 0.5 %, then mirrors", "both"),
    ];
    let series = |of: fn(&OptionRow) -> f64| {
        scenes
            .iter()
            .map(|scene| Series {
                name: scene.clone(),
                points: shown
                    .iter()
                    .enumerate()
                    .filter_map(|(i, (option, _))| {
                        let row = rows.iter().find(|r| r.scene == *scene && r.option == *option)?;
                        Some((i as f64, of(row)))
                    })
                    .collect(),
            })
            .collect()
    };
    let names = || Along::Names(shown.iter().map(|(_, short)| (*short).to_owned()).collect());
    let panel = |title: &str, y_label, of: fn(&OptionRow) -> f64| Panel {
        title: title.to_owned(),
        along: names(),
        y_label,
        logarithmic: false,
        legend: Legend::UpperRight,
        series: series(of),
    };
    write_svg(
        &folder.join("tree-options.svg"),
        &[
            panel("bytes by option", "× plain words", |r| r.times_plain),
            panel("cost of a look-up", "nanoseconds", |r| r.nanoseconds),
        ],
    )?;
    Ok(())
}
