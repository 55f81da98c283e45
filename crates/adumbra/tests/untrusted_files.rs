//! Small valid files that declare huge grids: they are answered as they are, and refused where another layout of them is asked for.

mod hierarchy_support;

use std::time::{Duration, Instant};

use adumbra::dag::packed::{PackedDag, PackedError};
use adumbra::dag::{Dag, LIT, TooLarge};
use adumbra::format::{FormatError, Layout, LightBody, ShadowFile, WordsError};
use adumbra::hierarchy::{Hierarchy, NEVER, UNIFORM};
use adumbra::light::{LightGrid, Sun};
use adumbra::query::Query;
use adumbra::settings::{Bias, Receivers, Settings};
use adumbra::tree::LightTreeError;
use hierarchy_support::{Leaf, of_leaves};

/// A file, by way of its bytes: what a reader accepts.
fn file(body: LightBody) -> ShadowFile {
    let size = body.slabs().size();
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
    let grid = LightGrid { sun, voxel_size: 1.0, origin: [0.0, 8.0, 0.0], axes, size };
    let settings = Settings {
        resolution: 8,
        thickness_world: 0.0,
        assume_ground: true,
        closed_regions: true,
        ignore_alpha: false,
        receivers: Receivers::All,
        switch_within_voxels: 8,
        bounds: None,
        bias: Bias::default(),
        triangles: 12,
        instances: 1,
    };
    let mut bytes = Vec::new();
    ShadowFile { grid, settings, body }.write_to(&mut bytes).unwrap();
    assert!(bytes.len() < 100_000, "{} bytes", bytes.len());
    ShadowFile::from_bytes(&bytes).unwrap()
}

/// 64 roots that are lit, in a grid of 2^32 - 1 voxels along the light.
fn tall_hierarchy() -> ShadowFile {
    let top = vec![[UNIFORM, NEVER]; 64];
    let size = [256, 256, u32::MAX];
    let hierarchy = Hierarchy { size, root_level: 5, top_dims: [8, 8], top, wide: vec![], code: vec![] };
    file(LightBody::Hierarchy(hierarchy))
}

fn tall_packed() -> ShadowFile {
    let size = [64, 64, u32::MAX];
    let depth = u32::MAX.div_ceil(8);
    // No pool has a node, and no column a root cube that is not lit.
    let mut top = vec![0; 19];
    top.extend([0, depth].repeat(64));
    top.push(0);
    let (units, slabs) = (vec![], vec![]);
    file(LightBody::Packed(PackedDag { size, root_level: 3, top_dims: [8, 8, depth], top, units, slabs }))
}

/// Runs what must end soon.
fn soon<T>(work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let found = work();
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    found
}

#[test]
fn small_files_of_tall_grids_are_looked_up_in_but_not_converted() {
    for file in [tall_hierarchy(), tall_packed()] {
        let name = file.body.layout();
        let query = Query::new(&file.grid, file.slabs(), Bias::default(), 9).unwrap();
        assert_eq!(query.visibility([30.0, -1e9, 30.0], Some([0.0, 1.0, 0.0])), 1.0, "{name:?}");
        let Err(FormatError::TooLarge(limit)) = soon(|| file.graph().map(|_| ())) else {
            panic!("{name:?}: the graph is made")
        };
        assert_eq!((limit.count, limit.what), (u32::MAX.into(), "voxels along the light"));
        let message = limit.to_string();
        assert!(
            message.contains("look up in the file as it is") && message.contains("4294967295"),
            "{message}"
        );
        let error = soon(|| file.without_words()).unwrap_err();
        assert!(matches!(error, WordsError::Light(LightTreeError::TooDeep { .. })), "{name:?}: {error}");
    }
}

#[test]
fn top_grid_of_too_many_root_cubes_is_refused() {
    let LightBody::Packed(mut packed) = tall_packed().body else { panic!("another layout") };
    let depth = 1 << 20;
    (packed.size[2], packed.top_dims[2]) = (8 * depth, depth);
    packed.top[20..147].iter_mut().step_by(2).for_each(|z0| *z0 = depth);
    assert_eq!(packed.validate(), Ok(()));
    let Err(PackedError::TooLarge(limit)) = soon(|| packed.to_dag()) else { panic!("made") };
    assert_eq!(limit, TooLarge { what: "root cubes", count: 64 << 20, limit: 1 << 24 });
    // A quarter of the roots is what may be made.
    let depth = 1 << 14;
    (packed.size[2], packed.top_dims[2]) = (8 * depth, depth);
    packed.top[20..147].iter_mut().step_by(2).for_each(|z0| *z0 = depth);
    let dag = soon(|| packed.to_dag()).unwrap();
    assert_eq!((dag.top.len(), dag.validate()), (1 << 20, Ok(())));
    assert!(dag.top.iter().all(|&root| root == LIT));
}

/// Roots that are one shape of 16 leaves, each with many depths.
fn one_shape(roots: u32, base: impl Fn(u32) -> u32) -> Hierarchy {
    let leaf = Leaf { width: 1, differences: vec![3; 63], ranks: (0..64).collect(), ..Leaf::default() };
    let mut found = of_leaves(&vec![leaf; 16], 4, 0, 1 << 20);
    let shape = found.top[0][0];
    found.top = (0..roots).map(|i| [shape, base(i)]).collect();
    found.top_dims = [1 << 10, roots >> 10];
    found.size = [32 << 10, 32 * (roots >> 10), 512];
    assert_eq!(found.validate(), Ok(()));
    found
}

#[test]
fn shapes_that_are_shared_are_converted_once() {
    // As if no root were shared it would be 2 million leaves of 64 depths.
    let found = one_shape(1 << 17, |i| 100 * (i & 1));
    let dag = soon(|| found.to_dag()).unwrap();
    assert_eq!(dag.validate(), Ok(()));
    for at in 0..2000_u32 {
        let [i, j] = [at.wrapping_mul(2_654_435_761) % found.size[0], at * 2 % found.size[1]];
        for k in [50, 100, 150, 200, 250, 300] {
            assert_eq!(dag.voxel(i, j, k), k < found.value(i, j), "{i} {j} {k}");
        }
    }
}

#[test]
fn shape_that_is_shared_at_too_many_depths_is_refused() {
    let found = one_shape(1 << 20, |i| i);
    let limit = soon(|| found.to_dag()).unwrap_err();
    assert_eq!(limit, TooLarge { what: "shapes", count: 17 << 20, limit: 1 << 24 });
}

#[test]
fn grid_of_too_many_columns_has_no_hierarchy() {
    let dag = Dag {
        size: [1 << 20, 1 << 20, 8],
        root_level: 20,
        top_dims: [1; 3],
        top: vec![LIT],
        nodes: vec![],
        slabs: vec![],
    };
    let plain = file(LightBody::Plain(dag.clone()));
    let refused =
        soon(|| ShadowFile::of_dag(plain.grid, plain.settings, dag, Layout::Hierarchy)).unwrap_err();
    assert!(refused.to_string().contains("17179869184 blocks of 8 x 8 columns"), "{refused}");
}
