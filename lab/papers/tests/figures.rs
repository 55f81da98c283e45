//! Sizes and speeds of graphs and quadtrees, for the documents.

use std::time::Instant;

use adumbra::layout::depths::DepthTree;
use adumbra::query::{FixedReceiver, Receiver};
use adumbra::{Bias, Filter, ShadowFile, Sun};
use adumbra_bake::structure::{BuiltStructure, DepthsSink, build};
use adumbra_bake::{BakeOptions, Size, Watch};
use adumbra_papers::dag::DagQuery;
use adumbra_papers::dag::build::GraphSink;
use adumbra_scene::{LoadOptions, load};

/// Prints the figures of docs/layouts-depths.md, with `ADUMBRA_FULL=1`. `ADUMBRA_SCENES` names the scenes,
/// `ADUMBRA_RESOLUTION` sets the resolution.
#[test]
#[ignore = "slow: real scenes"]
fn shared_print_sizes_and_speeds_of_depths() {
    if !adumbra_testing::full() {
        return;
    }
    let asked = |name, default: &str| std::env::var(name).unwrap_or_else(|_| default.to_owned());
    let resolution = asked("ADUMBRA_RESOLUTION", "8192").parse().expect("a resolution");
    for name in asked("ADUMBRA_SCENES", "box-city-5k,kaykit_city_21,alpine-2,jacksboro,delft").split(',') {
        let Some(scenes) = adumbra_testing::shared("scenes") else { return };
        let path = adumbra_testing::scene_file(&scenes, name);
        let scene = load(&path, &LoadOptions::default()).expect("a good scene");
        let towards = if name == "jacksboro" { [-0.77, 0.105, -0.63] } else { [0.5, 0.8, 0.35] };
        let sun = Sun::from_direction(towards).expect("above the horizon");
        let options = BakeOptions::new(sun, Size::Resolution(resolution)).with(|o| o.thickness_world = 0.1);
        let BuiltStructure { grid, settings, made: dag, .. } =
            build(&scene, &options, Watch::none(), GraphSink::new).expect("a good bake");
        let graph_bytes = 4 * (dag.top.len() + dag.nodes.len()) + 8 * dag.leaf_masks.len();
        let [plain, merged] = [false, true].map(|merged| {
            let sink = |size, level| DepthsSink::in_memory(size, level, merged);
            let pages = build(&scene, &options, Watch::none(), sink).expect("a good bake").made;
            pages.tree().expect("room for all words")
        });
        let receivers = receivers(&merged);
        let query = DagQuery::new(&grid, &dag, Bias::default(), Filter::Box9);
        let of_graph = millions_per_second(&receivers, |r| query.lit_taps(r));
        let (plain_bytes, merged_bytes, census) = (plain.bytes(), merged.bytes(), merged.census());
        let file = ShadowFile::new(grid, settings, merged);
        let sampler = file.sampler(Filter::Box9);
        let of_merged = millions_per_second(&receivers, |r| sampler.lit_taps(r));
        println!(
            "{name} {resolution}: graph {graph_bytes} bytes, {of_graph:.2} M points/s; plain {plain_bytes} bytes; merged {merged_bytes} bytes, {of_merged:.2} M points/s; {census:?}",
        );
    }
}

/// Returns points in scan order, on and behind the first surfaces.
fn receivers(depths: &DepthTree) -> Vec<FixedReceiver> {
    let size = depths.size();
    let mut receivers = Vec::new();
    for j in (0..size[1]).step_by(4) {
        for i in (0..size[0]).step_by(4) {
            let z = depths.value(i, j).min(size[2]);
            let p_grid = [f64::from(i) + 0.5, f64::from(j) + 0.5, f64::from(z) + f64::from((i ^ j) & 63)];
            receivers.push(FixedReceiver::new(&Receiver { p_grid, gradient: [0.3, -0.2] }, size));
        }
    }
    receivers
}

/// Millions of look-ups per second on one thread.
fn millions_per_second(receivers: &[FixedReceiver], lit_taps: impl Fn(&FixedReceiver) -> u32) -> f64 {
    let start = Instant::now();
    let lit: u64 = receivers.iter().map(|r| u64::from(lit_taps(r))).sum();
    assert!(lit > 0);
    receivers.len() as f64 / 1e6 / start.elapsed().as_secs_f64()
}
