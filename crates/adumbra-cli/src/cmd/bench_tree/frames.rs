//! World-aligned against light-aligned at equal voxels; with and without closed regions (Fig. 3-3).

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use adumbra::bake::{self, Options, Size};
use adumbra::format::ShadowFile;
use adumbra::light::Sun;
use adumbra::picture::nodes_by_size;
use adumbra::query::{Query, TreeQuery, Weights};
use adumbra::tree::{Reduction, TreeOptions};
use adumbra::verify::{LightAnswers, TreeAnswers, Verification};
use serde_json::{Value, json};

use super::{BenchScene, Check, SUN, bake_quietly, median, number, text_of, tree_options};
use crate::args::BenchTree;
use crate::exit::Failure;
use crate::output::write_png;

/// Depths at which the frames are compared.
const DEPTHS: [u32; 3] = [9, 10, 11];
/// Whole bakes take long: no more of them are timed.
const MOST_RUNS: usize = 3;
/// Depth of the comparison with and without closed regions.
const CLOSED_DEPTH: u32 = 10;
/// Depth of the pictures, and pixels a voxel.
const PICTURE: (u32, u32) = (8, 3);
/// The layer that they show, as a share of the scene's height.
const PICTURE_HEIGHT: f64 = 0.3;

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<Value, Failure> {
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
        eprintln!("{}: frames and closed regions", scene.name);
    }
    Ok(json!({"frames": frames, "closed_regions": closed}))
}

fn compare(
    args: &BenchTree,
    scene: &BenchScene,
    check: &Check<'_>,
    depth: u32,
) -> Result<[Value; 2], Failure> {
    let sun = Sun::from_direction(SUN)?;
    let options = tree_options(depth)?;
    let mut seconds = Vec::new();
    let mut baked = bake_quietly(scene, &options)?;
    for _ in 0..args.runs.min(MOST_RUNS) {
        baked = bake_quietly(scene, &options)?;
        seconds.push(baked.report.seconds);
    }
    let bias = baked.settings.bias;
    let query = TreeQuery::new(&baked.space, &baked.regions, &sun, &baked.tree, bias, 1, Weights::Mean)?;
    let world = check.run(&TreeAnswers::new(&baked.settings, sun, query));
    let voxel_size = baked.space.voxel_size;
    let row = |frame: &str, seconds: Vec<f64>, bytes: u64, v: &Verification| {
        json!({
            "scene": scene.name, "depth": depth, "frame": frame, "voxel_size": voxel_size, "bytes": bytes,
            "seconds": median(seconds), "agreement": v.agreement, "interior_agreement": v.interior_agreement,
            "acne": v.acne, "leak": v.leak,
        })
    };
    let world = row("world", seconds, baked.tree.bytes(), &world);

    let options = Options::new(sun, Size::VoxelSize(voxel_size));
    let mut seconds = Vec::new();
    let mut light = bake::bake(&scene.scene, &options, &|_| {}, &AtomicBool::new(false))?;
    for _ in 0..args.runs.min(MOST_RUNS) {
        light = bake::bake(&scene.scene, &options, &|_| {}, &AtomicBool::new(false))?;
        seconds.push(light.report.seconds);
    }
    let file = ShadowFile::plain(light.grid, light.settings, light.dag);
    let query = Query::new(&file.grid, file.slabs(), file.settings.bias, 1)?;
    let v = check.run(&LightAnswers::new(&file.grid, &file.settings, query));
    Ok([world, row("light", seconds, file.encoded_len(), &v)])
}

fn closed_row(scene: &BenchScene, closed_regions: bool) -> Result<Value, Failure> {
    let options = TreeOptions { closed_regions, reduction: Reduction::Sort, ..tree_options(CLOSED_DEPTH)? };
    let baked = bake_quietly(scene, &options)?;
    Ok(json!({
        "scene": scene.name, "depth": CLOSED_DEPTH, "closed_regions": closed_regions,
        "merged_bytes": 4 + 32 * baked.report.built_blocks, "graph_bytes": baked.tree.bytes(),
    }))
}

pub(super) fn markdown(part: &Value) -> String {
    let list = |key: &str| part["rows"][key].as_array().cloned().unwrap_or_default();
    let (frames, closed) = (list("frames"), list("closed_regions"));
    let threads = &part["threads"];
    let runs = part["runs"].as_u64().map_or(MOST_RUNS, |runs| (runs as usize).min(MOST_RUNS));
    let mut text = format!(
        "\n## World-aligned against light-aligned\n\nEqual voxels. The tree as words, the light-aligned bake as its file, both with their \
        defaults. Seconds of the whole bake, the median of {runs} after one that is not timed, one frame after the other: the light-aligned bake on \
        {threads} threads, the world-aligned one with its depth image on {threads} and its builder on one. Agreement with rays at {} points on \
        surfaces.\n\n\
        | scene | depth | frame | voxel m | MB | s | agreement % | interior % | acne % | leak % |\n|---|---|---|---|---|---|---|---|---|---|\n",
        part["samples"]
    );
    for r in &frames {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.4} | {:.3} | {:.2} | {:.3} | {:.4} | {:.3} | {:.3} |",
            text_of(r, "scene"),
            r["depth"],
            text_of(r, "frame"),
            number(r, "/voxel_size"),
            number(r, "/bytes") / 1e6,
            number(r, "/seconds"),
            100.0 * number(r, "/agreement"),
            100.0 * number(r, "/interior_agreement"),
            100.0 * number(r, "/acne"),
            100.0 * number(r, "/leak"),
        );
    }
    let _ = write!(
        text,
        "\n## Closed regions\n\nDepth {CLOSED_DEPTH}, world frame: MB of the merged tree and of the graph. The pictures `tree-nodes-*.png` show a layer \
        at {:.0} % of the scene's height from above at depth {}, a square a leaf: red one voxel, then orange, yellow, green, blue to violet; \
        dark where shadowed.\n\n\
        | scene | merged without | merged with | % | graph without | graph with | % |\n|---|---|---|---|---|---|---|\n",
        100.0 * PICTURE_HEIGHT,
        PICTURE.0
    );
    for pair in closed.chunks_exact(2) {
        let (without, with) = (&pair[0], &pair[1]);
        let both = |path: &str| (number(without, path) / 1e6, number(with, path) / 1e6);
        let (merged, graph) = (both("/merged_bytes"), both("/graph_bytes"));
        let _ = writeln!(
            text,
            "| {} | {:.3} | {:.3} | {:.1} | {:.3} | {:.3} | {:.1} |",
            text_of(without, "scene"),
            merged.0,
            merged.1,
            100.0 * merged.1 / merged.0,
            graph.0,
            graph.1,
            100.0 * graph.1 / graph.0
        );
    }
    text
}
