//! The steps whose instructions are counted, on one thread, on a scene generated from a seed.
//!
//! A step is either a function here that is never inlined, or a library function called by one.

use std::error::Error;
use std::hint::black_box;
use std::sync::Arc;

use adumbra::layout::depths::DepthTree;
use adumbra::{Bias, Encoding, Filter, FormatError, LightGrid, PointVisibility, Sampler, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size, Watch};
use adumbra_papers::dag::build::{self, DagOptions, pack};
use adumbra_papers::dag::packed::PackedDag;
use adumbra_papers::dag::plain::Dag;
use adumbra_papers::dag::{self, DagBody, DagFile, DagLayout, DagQuery};
use adumbra_scene::{GeneratedKind, Mesh, Scene, generate};
use adumbra_testing::{add_box, scene_of};

/// The displayed name of a step, and two strings that identify the symbols of its functions: a substring and
/// a suffix.
pub(super) struct HotStep {
    pub(super) name: &'static str,
    pub(super) symbol: [&'static str; 2],
}

const fn step(name: &'static str, symbol: [&'static str; 2]) -> HotStep {
    HotStep { name, symbol }
}

/// All steps: those of the product, then three of the papers' graphs. Library functions are counted over all
/// bakes.
pub(super) const STEPS: [HotStep; 18] = [
    step("bake", ["count::steps", "bake_depths"]),
    step("surfaces of the root blocks", ["fast::gather", "gather"]),
    step("descent of the root blocks", ["fast::descent", "build_root"]),
    step("bounds of blocks", ["fast::classify", "classify"]),
    step("columns of leaves", ["fast::leaf", "leaf_columns"]),
    step("leaves", ["depths::DepthsSink", "::leaf"]),
    step("link the pages", ["link::Pages", "::link"]),
    step("encode a file", ["count::steps", "encode_coded"]),
    step("decode a file", ["count::steps", "decode_coded"]),
    step("read a raw file", ["count::steps", "read_raw"]),
    step("depth of a column", ["count::steps", "depths_values"]),
    step("look-ups of 9 x 9 in rows", ["count::steps", "depths_rows"]),
    step("1,000 boxes in one another", ["count::steps", "bake_1000_boxes"]),
    step("2,000 boxes in one another", ["count::steps", "bake_2000_boxes"]),
    step("4,000 boxes in one another", ["count::steps", "bake_4000_boxes"]),
    step("graph: bake", ["count::steps", "bake_graph"]),
    step("graph: pack", ["count::steps", "packed_encode"]),
    step("graph: look-ups of 9 x 9 in rows", ["count::steps", "packed_rows"]),
];

const RESOLUTION: u64 = 1024;
/// Resolution of the bakes of nested boxes.
const BOXES_RESOLUTION: u64 = 8;
/// Number of look-ups of each kind.
const LOOK_UPS: u32 = 20_000;

/// Runs every step once, on the only thread of a pool, so that work handed to the pool is counted under the
/// step.
///
/// # Errors
/// Returns the error of the step that fails.
pub(super) fn run() -> Result<(), Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(run_steps).map_err(|error| -> Box<dyn Error> { error })
}

fn run_steps() -> Result<(), Box<dyn Error + Send + Sync>> {
    let scene = generate(GeneratedKind::City, 1);
    let sun = Sun::from_direction([-0.45, 0.75, -0.35])?;
    let options = BakeOptions::new(sun, Size::Resolution(RESOLUTION)).with(|o| o.thickness_world = 0.1);
    let graph = bake_graph(&scene, &options)?;
    let file = bake_depths(&scene, &options)?;
    let points = rows(&graph.grid);
    let DagBody::Plain(dag) = &graph.body else { unreachable!("the layout is the one requested") };
    let packed = packed_encode(dag)?;
    let coded = encode_coded(&file)?;
    black_box(decode_coded(&coded)?);
    black_box(read_raw(&file.to_bytes(Encoding::Raw)?)?);
    black_box(depths_values(&file.tree));
    let graph = DagQuery::new(&graph.grid, &packed, Bias::default(), Filter::Box9);
    black_box(packed_rows(&points, &graph));
    black_box(depths_rows(&points, &file.sampler(Filter::Box9)));
    for bake in [bake_1000_boxes, bake_2000_boxes, bake_4000_boxes] {
        black_box(bake(sun)?);
    }
    Ok(())
}

#[inline(never)]
fn bake_graph(scene: &Scene, options: &BakeOptions) -> Result<DagFile, dag::Error> {
    let options = DagOptions { bake: options.clone(), layout: DagLayout::Plain };
    Ok(build::bake(scene, &options, Watch::none())?.file)
}

#[inline(never)]
fn bake_depths(scene: &Scene, options: &BakeOptions) -> Result<ShadowFile, adumbra_bake::Error> {
    Bake::with_options(scene, options).in_memory()
}

#[inline(never)]
fn bake_1000_boxes(sun: Sun) -> Result<ShadowFile, adumbra_bake::Error> {
    bake_boxes(1000, sun)
}

#[inline(never)]
fn bake_2000_boxes(sun: Sun) -> Result<ShadowFile, adumbra_bake::Error> {
    bake_boxes(2000, sun)
}

#[inline(never)]
fn bake_4000_boxes(sun: Sun) -> Result<ShadowFile, adumbra_bake::Error> {
    bake_boxes(4000, sun)
}

/// Bakes nested boxes, so that rays pass through many solids. The time may grow linearly with the number of
/// boxes, but not with its square.
fn bake_boxes(count: u16, sun: Sun) -> Result<ShadowFile, adumbra_bake::Error> {
    let mut boxes = Mesh::default();
    for inner in 0..count {
        let inset = 0.9 * f32::from(inner) / f32::from(count);
        add_box(&mut boxes, [inset; 3], [2.0 - inset; 3]);
    }
    let options = BakeOptions::new(sun, Size::Resolution(BOXES_RESOLUTION));
    Bake::with_options(&scene_of(vec![boxes]), &options).in_memory()
}

#[inline(never)]
fn packed_encode(dag: &Dag) -> Result<PackedDag, dag::Error> {
    Ok(pack(dag)?)
}

#[inline(never)]
fn encode_coded(file: &ShadowFile) -> Result<Vec<u8>, FormatError> {
    file.to_bytes(Encoding::Coded)
}

#[inline(never)]
fn decode_coded(bytes: &[u8]) -> Result<ShadowFile, FormatError> {
    ShadowFile::from_bytes(bytes)
}

/// Returns the tree, because a function equal to [`decode_coded`] would be merged with it.
#[inline(never)]
fn read_raw(bytes: &[u8]) -> Result<Arc<DepthTree>, FormatError> {
    Ok(ShadowFile::from_bytes(bytes)?.tree)
}

#[inline(never)]
fn depths_values(depths: &DepthTree) -> u64 {
    voxels(depths.size()).map(|[i, j, _]| u64::from(depths.value(i, j))).fold(0, u64::wrapping_add)
}

#[inline(never)]
fn packed_rows(points: &[[f64; 3]], graph: &DagQuery<'_>) -> f64 {
    look_up_level(points, graph)
}

#[inline(never)]
fn depths_rows(points: &[[f64; 3]], sampler: &Sampler) -> f64 {
    look_up_level(points, sampler)
}

fn look_up_level(points: &[[f64; 3]], look_up: &impl PointVisibility) -> f64 {
    let normals = vec![[0.0, 1.0, 0.0]; points.len()];
    look_up.visibilities(points, Some(&normals)).into_iter().map(f64::from).sum()
}

/// Returns points one texel apart, on a horizontal plane through the middle of the grid.
fn rows(grid: &LightGrid) -> Vec<[f64; 3]> {
    let middle = grid.to_world(grid.size.map(|n| 0.5 * f64::from(n)));
    let across = 200;
    let place = |n: u32| f64::from(n) * grid.voxel_size;
    let point =
        |n| [middle[0] + place(n % across) - 0.5 * place(across), middle[1], middle[2] + place(n / across)];
    (0..LOOK_UPS).map(point).collect()
}

/// Returns pseudo-random voxels.
fn voxels(size: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    const ODD: [u32; 3] = [0x9e37_79b9, 0x85eb_ca6b, 0xc2b2_ae35];
    let place =
        move |n: u32, a: usize| ((u64::from(n.wrapping_mul(ODD[a])) * u64::from(size[a])) >> 32) as u32;
    (0..LOOK_UPS).map(move |n| std::array::from_fn(|a| place(n, a)))
}
