//! The steps whose instructions are counted, on one thread, on a scene made from a seed.
//!
//! A step is either a function here, never inlined, or one of the library's, which are met on the way.

use std::hint::black_box;
use std::sync::atomic::AtomicBool;

use adumbra::Error;
use adumbra::bake::{self, Baked, BakedHierarchy, Options, Size};
use adumbra::dag::packed::PackedDag;
use adumbra::dag::{Dag, Slabs};
use adumbra::hierarchy::Hierarchy;
use adumbra::light::{LightGrid, Sun};
use adumbra::query::{Cursor, Query};
use adumbra::scene::{GeneratedKind, Scene, generate};
use adumbra::settings::Bias;

/// A name for people, and what the symbols of the functions behind it contain.
pub(super) struct Step {
    pub(super) name: &'static str,
    pub(super) symbol: [&'static str; 2],
}

const fn step(name: &'static str, symbol: [&'static str; 2]) -> Step {
    Step { name, symbol }
}

/// Every step. Those of the library are counted over both bakes.
pub(super) const STEPS: [Step; 15] = [
    step("bake into the graph", ["count::steps", "bake_graph"]),
    step("bake into the hierarchy", ["count::steps", "bake_hierarchy"]),
    step("surfaces of the root blocks", ["bake::gather", "gather"]),
    step("descent of the root blocks", ["bake::descent", "build_root"]),
    step("bounds of blocks", ["bake::judge", "judge"]),
    step("columns of leaves", ["bake::leaf", "leaf_columns"]),
    step("graph: slabs of leaves", ["graph_sink::GraphSink", "::leaf"]),
    step("graph: join", ["graph_sink::GraphSink", "::join"]),
    step("hierarchy: leaves", ["hierarchy::sink::HierarchySink", "::leaf"]),
    step("packed: encode", ["count::steps", "packed_encode"]),
    step("plain: slab look-up", ["count::steps", "plain_slabs"]),
    step("packed: slab look-up", ["count::steps", "packed_slabs"]),
    step("packed: cursor, 9 x 9 in rows", ["count::steps", "cursor_rows"]),
    step("hierarchy: value", ["count::steps", "hierarchy_values"]),
    step("hierarchy: slab look-up", ["count::steps", "hierarchy_slabs"]),
];

const RESOLUTION: u64 = 1024;
/// Of each kind.
const LOOK_UPS: u32 = 20_000;

/// Takes every step once.
///
/// # Errors
/// Whatever fails.
pub(super) fn run() -> Result<(), Box<dyn std::error::Error>> {
    let scene = generate(GeneratedKind::City, 1);
    let sun = Sun::from_direction([-0.45, 0.75, -0.35])?;
    let options = Options { thickness_world: 0.1, ..Options::new(sun, Size::Resolution(RESOLUTION)) };
    // On a thread of the pool, so that what it hands out comes back to it and is counted under the step.
    rayon::ThreadPoolBuilder::new().num_threads(1).build()?.install(|| -> Result<(), adumbra::Error> {
        let graph = bake_graph(&scene, &options)?;
        let BakedHierarchy { hierarchy, .. } = bake_hierarchy(&scene, &options)?;
        let packed = packed_encode(&graph.dag)?;
        black_box(plain_slabs(&graph.dag));
        black_box(packed_slabs(&packed));
        black_box(hierarchy_slabs(&hierarchy));
        black_box(hierarchy_values(&hierarchy));
        black_box(cursor_rows(&graph.grid, &packed)?);
        Ok(())
    })?;
    Ok(())
}

#[inline(never)]
fn bake_graph(scene: &Scene, options: &Options) -> Result<Baked, Error> {
    bake::bake(scene, options, &|_| {}, &AtomicBool::new(false))
}

#[inline(never)]
fn bake_hierarchy(scene: &Scene, options: &Options) -> Result<BakedHierarchy, Error> {
    bake::bake_hierarchy(scene, options, true, &|_| {}, &AtomicBool::new(false))
}

#[inline(never)]
fn packed_encode(dag: &Dag) -> Result<PackedDag, Error> {
    Ok(PackedDag::of_dag(dag)?)
}

#[inline(never)]
fn plain_slabs(dag: &Dag) -> u64 {
    voxels(dag.size).map(|[i, j, k]| dag.slab(i, j, k)).fold(0, u64::wrapping_add)
}

#[inline(never)]
fn packed_slabs(packed: &PackedDag) -> u64 {
    voxels(packed.size).map(|[i, j, k]| packed.slab(i, j, k)).fold(0, u64::wrapping_add)
}

#[inline(never)]
fn hierarchy_slabs(hierarchy: &Hierarchy) -> u64 {
    voxels(hierarchy.size).map(|[i, j, k]| hierarchy.slab(i, j, k)).fold(0, u64::wrapping_add)
}

#[inline(never)]
fn hierarchy_values(hierarchy: &Hierarchy) -> u64 {
    voxels(hierarchy.size).map(|[i, j, _]| u64::from(hierarchy.value(i, j))).fold(0, u64::wrapping_add)
}

/// Points a texel apart on a level through the middle of the grid.
#[inline(never)]
fn cursor_rows(grid: &LightGrid, slabs: &dyn Slabs) -> Result<f64, Error> {
    let mut cursor = Cursor::new(Query::new(grid, slabs, Bias::default(), 9)?);
    let middle = grid.to_world(grid.size.map(|n| 0.5 * f64::from(n)));
    let across = 200;
    let place = |n: u32| f64::from(n) * grid.voxel_size;
    let points = (0..LOOK_UPS).map(|n| {
        [middle[0] + place(n % across) - 0.5 * place(across), middle[1], middle[2] + place(n / across)]
    });
    Ok(points.map(|p| f64::from(cursor.visibility(p, Some([0.0, 1.0, 0.0])))).sum())
}

/// Voxels here and there.
fn voxels(size: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    const ODD: [u32; 3] = [0x9e37_79b9, 0x85eb_ca6b, 0xc2b2_ae35];
    let place =
        move |n: u32, a: usize| ((u64::from(n.wrapping_mul(ODD[a])) * u64::from(size[a])) >> 32) as u32;
    (0..LOOK_UPS).map(move |n| std::array::from_fn(|a| place(n, a)))
}
