//! The steps whose instructions are counted, on one thread, on a scene generated from a seed.
//!
//! A step is either a function here that is never inlined, or one of the library that these call.

use std::hint::black_box;

use adumbra::layout::LeafMasks;
use adumbra::layout::depths::DepthTree;
use adumbra::layout::packed::PackedDag;
use adumbra::layout::plain::Dag;
use adumbra::{Bias, Cursor, LightBody, LightGrid, Query, ShadowFile, Sun};
use adumbra_bake::{BakeOptions, Error, LayoutChoice, Size, Watch, bake, pack};
use adumbra_scene::{GeneratedKind, Scene, generate};

/// The displayed name of a step, and two strings that identify the symbols of its functions: one that they contain, and
/// one that they end with.
pub(super) struct Step {
    pub(super) name: &'static str,
    pub(super) symbol: [&'static str; 2],
}

const fn step(name: &'static str, symbol: [&'static str; 2]) -> Step {
    Step { name, symbol }
}

/// All steps. Those of the library are counted over both bakes.
pub(super) const STEPS: [Step; 15] = [
    step("bake into the graph", ["count::steps", "bake_graph"]),
    step("bake into depths", ["count::steps", "bake_depths"]),
    step("surfaces of the root blocks", ["fast::gather", "gather"]),
    step("descent of the root blocks", ["fast::descent", "build_root"]),
    step("bounds of blocks", ["fast::classify", "classify"]),
    step("columns of leaves", ["fast::leaf", "leaf_columns"]),
    step("graph: leaf masks", ["runs::GraphSink", "::leaf"]),
    step("graph: join", ["runs::GraphSink", "::join"]),
    step("depths: leaves", ["depths::DepthsSink", "::leaf"]),
    step("packed: encode", ["count::steps", "packed_encode"]),
    step("plain: look-up", ["count::steps", "plain_leaf_masks"]),
    step("packed: look-up", ["count::steps", "packed_leaf_masks"]),
    step("packed: cursor, 9 x 9 in rows", ["count::steps", "cursor_rows"]),
    step("depths: value", ["count::steps", "depths_values"]),
    step("depths: look-up", ["count::steps", "depths_leaf_masks"]),
];

const RESOLUTION: u64 = 1024;
/// Number of look-ups of each kind.
const LOOK_UPS: u32 = 20_000;

/// Runs every step once.
///
/// # Errors
/// Returns the error of the step that fails.
pub(super) fn run() -> Result<(), Box<dyn std::error::Error>> {
    let scene = generate(GeneratedKind::City, 1);
    let sun = Sun::from_direction([-0.45, 0.75, -0.35])?;
    let options = BakeOptions { thickness_world: 0.1, ..BakeOptions::new(sun, Size::Resolution(RESOLUTION)) };
    // Runs on a thread of the pool, so that work that it distributes comes back to it and is counted under the step.
    rayon::ThreadPoolBuilder::new().num_threads(1).build()?.install(|| -> Result<(), Error> {
        let graph = bake_graph(&scene, &options)?;
        let depths = bake_depths(&scene, &options)?;
        let (LightBody::Plain(dag), LightBody::Depths(depths)) = (&graph.body, &depths.body) else {
            unreachable!("the layouts are those requested")
        };
        let packed = packed_encode(dag)?;
        black_box(plain_leaf_masks(dag));
        black_box(packed_leaf_masks(&packed));
        black_box(depths_leaf_masks(depths));
        black_box(depths_values(depths));
        black_box(cursor_rows(&graph.grid, &packed)?);
        Ok(())
    })?;
    Ok(())
}

#[inline(never)]
fn bake_graph(scene: &Scene, options: &BakeOptions) -> Result<ShadowFile, Error> {
    let options = BakeOptions { layout: LayoutChoice::Plain, ..options.clone() };
    Ok(bake(scene, &options, Watch::none())?.file)
}

#[inline(never)]
fn bake_depths(scene: &Scene, options: &BakeOptions) -> Result<ShadowFile, Error> {
    let options = BakeOptions { layout: LayoutChoice::Depths, ..options.clone() };
    Ok(bake(scene, &options, Watch::none())?.file)
}

#[inline(never)]
fn packed_encode(dag: &Dag) -> Result<PackedDag, Error> {
    Ok(pack(dag)?)
}

#[inline(never)]
fn plain_leaf_masks(dag: &Dag) -> u64 {
    voxels(dag.size).map(|[i, j, k]| dag.look_up(i, j, k)).fold(0, u64::wrapping_add)
}

#[inline(never)]
fn packed_leaf_masks(packed: &PackedDag) -> u64 {
    voxels(packed.size).map(|[i, j, k]| packed.look_up(i, j, k)).fold(0, u64::wrapping_add)
}

#[inline(never)]
fn depths_leaf_masks(depths: &DepthTree) -> u64 {
    voxels(depths.size).map(|[i, j, k]| depths.look_up(i, j, k)).fold(0, u64::wrapping_add)
}

#[inline(never)]
fn depths_values(depths: &DepthTree) -> u64 {
    voxels(depths.size).map(|[i, j, _]| u64::from(depths.value(i, j))).fold(0, u64::wrapping_add)
}

/// Looks up points one texel apart, on a horizontal plane through the middle of the grid.
#[inline(never)]
fn cursor_rows(grid: &LightGrid, leaf_masks: &dyn LeafMasks) -> Result<f64, Error> {
    let mut cursor = Cursor::new(Query::new(grid, leaf_masks, Bias::default(), 9)?);
    let middle = grid.to_world(grid.size.map(|n| 0.5 * f64::from(n)));
    let across = 200;
    let place = |n: u32| f64::from(n) * grid.voxel_size;
    let points = (0..LOOK_UPS).map(|n| {
        [middle[0] + place(n % across) - 0.5 * place(across), middle[1], middle[2] + place(n / across)]
    });
    Ok(points.map(|p| f64::from(cursor.visibility(p, Some([0.0, 1.0, 0.0])))).sum())
}

/// Returns pseudo-random voxels.
fn voxels(size: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    const ODD: [u32; 3] = [0x9e37_79b9, 0x85eb_ca6b, 0xc2b2_ae35];
    let place =
        move |n: u32, a: usize| ((u64::from(n.wrapping_mul(ODD[a])) * u64::from(size[a])) >> 32) as u32;
    (0..LOOK_UPS).map(move |n| std::array::from_fn(|a| place(n, a)))
}
