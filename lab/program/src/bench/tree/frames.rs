//! World-aligned against light-aligned at equal voxel size, and trees with and without closed regions (Fig.
//! 3-3).

use adumbra::{Filter, Sun};
use adumbra_bake::Watch;
use adumbra_bake::{BakeOptions, Size};
use adumbra_papers::dag::build::{DagOptions, bake as bake_graph};
use adumbra_papers::dag::{DagLayout, DagQuery};
use adumbra_papers::tree::TreeAnswers;
use adumbra_papers::tree::nodes_by_size;
use adumbra_papers::tree::{Reduction, TreeOptions};
use adumbra_program::output::write_png;
use adumbra_truth::verify::{LightAnswers, Verification};

use super::results::{ClosedRow, FrameRow, FrameRows, Part};
use super::{BenchScene, Check, SUN, bake_quietly, tree_options, unfiltered};
use crate::args::BenchTree;
use adumbra_compare::Result;
use adumbra_compare::metrics::median;
use adumbra_html::page::Table;
use adumbra_program::format::{figure, megabytes, percent};

/// Depths at which the frames are compared.
const DEPTHS: [u32; 3] = [9, 10, 11];
/// Maximum number of timed runs, because whole bakes are slow.
const MAX_RUNS: usize = 3;
/// Depth of the comparison with and without closed regions.
const CLOSED_DEPTH: u32 = 10;
/// Depth of the pictures, and pixels per voxel along each axis.
const PICTURE: (u32, u32) = (8, 3);
/// Height of the layer that the pictures show, as a share of the scene's height.
const PICTURE_HEIGHT: f64 = 0.3;

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<FrameRows> {
    let (mut frames, mut closed) = (Vec::new(), Vec::new());
    for scene in scenes {
        let check = Check::new(&scene.scene, args.samples);
        for depth in DEPTHS {
            frames.extend(compare(args, scene, &check, depth)?);
        }
        for closed_regions in [false, true] {
            closed.push(closed_row(scene, closed_regions)?);
        }
        for (closed_regions, name) in [(false, "open"), (true, "closed")] {
            let options = TreeOptions { closed_regions, ..tree_options(PICTURE.0)? };
            let baked = bake_quietly(scene, &options)?;
            let bounds = scene.scene.bounds();
            let height = bounds.min[1] + PICTURE_HEIGHT * (bounds.max[1] - bounds.min[1]);
            let y = baked.space.to_tree([0.0, height, 0.0])[1] as u32;
            let path = args.output.join(format!("tree-nodes-{}-{name}.png", scene.name));
            write_png(&path, &nodes_by_size(&baked.tree, y, PICTURE.1))?;
        }
        adumbra_program::note!("{}: frames and closed regions", scene.name);
    }
    Ok(FrameRows { frames, closed_regions: closed })
}

fn compare(args: &BenchTree, scene: &BenchScene, check: &Check<'_>, depth: u32) -> Result<[FrameRow; 2]> {
    let sun = Sun::from_direction(SUN)?;
    let options = tree_options(depth)?;
    let mut seconds = Vec::new();
    let mut baked = bake_quietly(scene, &options)?;
    for _ in 0..args.runs.min(MAX_RUNS) {
        baked = bake_quietly(scene, &options)?;
        seconds.push(baked.report.seconds);
    }
    let world = check.run(&TreeAnswers::new(&baked.settings, sun, unfiltered(&baked, sun)?));
    let voxel_size = baked.space.voxel_size;
    let row = |frame: &str, seconds: Vec<f64>, bytes: u64, v: &Verification| FrameRow {
        scene: scene.name.clone(),
        depth,
        frame: frame.to_owned(),
        voxel_size,
        bytes,
        seconds: median(seconds),
        agreement: v.agreement,
        interior_agreement: v.interior_agreement,
        acne: v.acne,
        leak: v.leak,
    };
    let world = row("world", seconds, baked.tree.bytes(), &world);

    let bake = BakeOptions::new(sun, Size::VoxelSize(voxel_size));
    let options = DagOptions { bake, layout: DagLayout::Plain };
    let mut seconds = Vec::new();
    let mut light = bake_graph(&scene.scene, &options, Watch::none())?;
    for _ in 0..args.runs.min(MAX_RUNS) {
        light = bake_graph(&scene.scene, &options, Watch::none())?;
        seconds.push(light.report.seconds);
    }
    let file = light.file;
    let (filter, bias) = (Filter::Nearest, file.settings.bias);
    let query = DagQuery::new(&file.grid, file.body.leaf_masks(), bias, filter);
    let v = check.run(&LightAnswers::new(file.grid, file.settings, query, (filter, bias)));
    Ok([world, row("light", seconds, file.encoded_len(), &v)])
}

fn closed_row(scene: &BenchScene, closed_regions: bool) -> Result<ClosedRow> {
    let options = TreeOptions { closed_regions, reduction: Reduction::Sort, ..tree_options(CLOSED_DEPTH)? };
    let baked = bake_quietly(scene, &options)?;
    Ok(ClosedRow {
        scene: scene.name.clone(),
        depth: CLOSED_DEPTH,
        closed_regions,
        merged_bytes: 4 + 32 * baked.report.built_blocks,
        graph_bytes: baked.tree.bytes(),
    })
}

pub(super) fn markdown(part: &Part<FrameRows>) -> String {
    let threads = part.threads;
    let runs = part.runs.min(MAX_RUNS);
    let frames = Table::of(
        "",
        &part.rows.frames,
        &[
            ("scene", |r| r.scene.clone()),
            ("depth", |r| r.depth.to_string()),
            ("frame", |r| r.frame.clone()),
            ("voxel m", |r| figure(r.voxel_size, 4)),
            ("MB", |r| megabytes(r.bytes, 3)),
            ("s", |r| figure(r.seconds, 2)),
            ("agreement %", |r| percent(r.agreement, 3)),
            ("interior %", |r| percent(r.interior_agreement, 4)),
            ("acne %", |r| percent(r.acne, 3)),
            ("leak %", |r| percent(r.leak, 3)),
        ],
    );
    let head = ["scene", "merged without", "merged with", "%", "graph without", "graph with", "%"];
    let mut closed = Table::new("", &head);
    for pair in part.rows.closed_regions.chunks_exact(2) {
        let compared = |bytes: fn(&ClosedRow) -> u64| {
            let [without, with] = [&pair[0], &pair[1]].map(bytes);
            [megabytes(without, 3), megabytes(with, 3), percent(with as f64 / without as f64, 1)]
        };
        let scene = [pair[0].scene.clone()];
        closed.row(scene.into_iter().chain(compared(|r| r.merged_bytes)).chain(compared(|r| r.graph_bytes)));
    }
    format!(
        "\n## World-aligned against light-aligned\n\nEqual voxel size, default options. MB are of the tree's \
        words and of the light-aligned file. Seconds are of the whole bake, the median of {runs} runs after one \
        that is not timed; the two frames are timed one after the other. The light-aligned bake uses {threads} \
        threads; the world-aligned one uses {threads} for its depth image and one for its builder. Agreement \
        with rays is at {} points on surfaces.\n\n{}\n\
        ## Closed regions\n\nDepth {CLOSED_DEPTH}, world frame: MB of the merged tree and of the graph. The pictures `tree-nodes-*.png` show, \
        from above, a layer at {:.0} % of the scene's height at depth {}, one square per leaf: red for one \
        voxel, then orange, yellow, green and blue up to violet; dark if shadowed.\n\n{}",
        part.samples,
        frames.markdown(),
        100.0 * PICTURE_HEIGHT,
        PICTURE.0,
        closed.markdown()
    )
}
