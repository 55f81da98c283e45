//! Small valid files that declare huge grids. Look-ups in them work, but conversion to another layout is
//! refused. If any work were proportional to the declared size, the tests would time out.

use adumbra::layout::depths::leaf::LeafHead;
use adumbra::layout::depths::page::PAGE_LEVEL;
use adumbra::layout::depths::{DepthTree, LEAF_LEVEL, NODE_LEVELS, TreeBuilder};
use adumbra::{Bias, Encoding, FileSettings, Filter, PointVisibility, ShadowFile};
use adumbra_papers::dag::build::convert::{depths_of, graph_of, graph_of_depths, unpack};
use adumbra_papers::dag::packed::{PackedDag, PackedError};
use adumbra_papers::dag::plain::{Dag, LIT};
use adumbra_papers::dag::{DagBody, DagFile, DagFileError, DagQuery, LeafMasks, TooLarge};
use adumbra_papers::tree::{LightTreeError, WordsError, words_of};
use adumbra_testing::{Leaf, PageParts, TreeParts, from_leaves, overhead_grid, settings_for};

/// Encodes a file and reads it back, so that only files that the reader accepts are tested.
fn file(body: DagBody) -> DagFile {
    let grid = overhead_grid([0.0, 8.0, 0.0], body.space().0);
    let settings = FileSettings { resolution: 8, ..settings_for(&grid) };
    let mut bytes = Vec::new();
    DagFile { grid, settings, body }.write_to(&mut bytes).unwrap();
    assert!(bytes.len() < 100_000, "{} bytes", bytes.len());
    DagFile::from_bytes(&bytes).unwrap()
}

/// A lit page, in a grid of 2^32 - 1 voxels along the light.
fn tall_depths() -> ShadowFile {
    let size = [256, 256, u32::MAX];
    let tree = TreeBuilder::new(size, Vec::new()).finish().unwrap();
    let grid = overhead_grid([0.0, 8.0, 0.0], size);
    let settings = FileSettings { resolution: 8, ..settings_for(&grid) };
    let bytes = ShadowFile::new(grid, settings, tree).to_bytes(Encoding::Raw).unwrap();
    assert!(bytes.len() < 1_000, "{} bytes", bytes.len());
    ShadowFile::from_bytes(&bytes).unwrap()
}

fn tall_packed() -> DagFile {
    let size = [64, 64, u32::MAX];
    let depth = u32::MAX.div_ceil(8);
    // No pool has a node, and no column has a root cube that is not lit.
    let mut top = vec![0; 19];
    top.extend([0, depth].repeat(64));
    top.push(0);
    let (units, leaf_masks) = (vec![], vec![]);
    file(DagBody::Packed(PackedDag { size, root_level: 3, top_dims: [8, 8, depth], top, units, leaf_masks }))
}

#[test]
fn small_files_of_tall_grids_allow_look_ups_but_no_conversion() {
    let (packed, depths) = (tall_packed(), tall_depths());
    let query = DagQuery::new(&packed.grid, packed.body.leaf_masks(), Bias::default(), Filter::Box9);
    let sampler = depths.sampler(Filter::Box9);
    for look_ups in [&query as &dyn PointVisibility, &sampler] {
        assert_eq!(look_ups.visibility([30.0, -1e9, 30.0], Some([0.0, 1.0, 0.0])), 1.0);
    }
    let Err(DagFileError::TooLarge(of_packed)) = graph_of(&packed.body).map(|_| ()) else {
        panic!("the graph is made")
    };
    let of_depths = graph_of_depths(&depths.tree).unwrap_err();
    for limit in [of_packed, of_depths] {
        assert_eq!((limit.count, limit.what), (u32::MAX.into(), "voxels along the light"));
        let message = limit.to_string();
        assert!(
            message.contains("look up in the file as it is") && message.contains("4294967295"),
            "{message}"
        );
    }
    let error = words_of(&packed).unwrap_err();
    assert!(matches!(error, WordsError::Light(LightTreeError::TooDeep { .. })), "{error}");
}

#[test]
fn top_grid_with_too_many_root_cubes_is_rejected() {
    let DagBody::Packed(mut packed) = tall_packed().body else { panic!("another layout") };
    let depth = 1 << 20;
    (packed.size[2], packed.top_dims[2]) = (8 * depth, depth);
    packed.top[20..147].iter_mut().step_by(2).for_each(|z0| *z0 = depth);
    assert_eq!(packed.validate(), Ok(()));
    let Err(PackedError::TooLarge(limit)) = unpack(&packed) else { panic!("made") };
    assert_eq!(limit, TooLarge { what: "root cubes", count: 64 << 20, limit: 1 << 24 });
    // A sixteenth of the limit is accepted.
    let depth = 1 << 14;
    (packed.size[2], packed.top_dims[2]) = (8 * depth, depth);
    packed.top[20..147].iter_mut().step_by(2).for_each(|z0| *z0 = depth);
    let dag = unpack(&packed).unwrap();
    assert_eq!((dag.top.len(), dag.validate()), (1 << 20, Ok(())));
    assert!(dag.top.iter().all(|&root| root == LIT));
}

/// Returns pages that share one shape of 64 x 64 leaves. All of them are the same leaf, which has 64 depths.
fn one_shape([across, down]: [u32; 2], base: impl Fn(u32) -> u32) -> DepthTree {
    let leaf = Leaf { width: 1, differences: vec![3; 63], ranks: (0..64).collect(), ..Leaf::default() };
    let of_leaf = from_leaves(&[leaf], 1, 0, 1 << 20).unwrap();
    let length = LeafHead::new(of_leaf.shapes().half(0)).length();
    let mut halves: Vec<u16> = (0..length).map(|at| of_leaf.shapes().half(at) as u16).collect();
    let mut root = 0;
    for _ in (LEAF_LEVEL..PAGE_LEVEL).step_by(NODE_LEVELS as usize) {
        let below = std::mem::replace(&mut root, halves.len() as u16);
        // Sixteen times the shape below, with the same base.
        halves.extend([0xffff, 0, 0]);
        halves.extend([below; 16]);
    }
    let common =
        halves.chunks(2).map(|h| u32::from(h[0]) | u32::from(*h.get(1).unwrap_or(&0)) << 16).collect();
    let page = |i| PageParts { root: root.into(), base: base(i), words: Vec::new() };
    let size = [across << PAGE_LEVEL, down << PAGE_LEVEL, 512];
    TreeParts { size, common, pages: (0..across * down).map(page).collect() }.tree().unwrap()
}

#[test]
fn shared_shapes_are_converted_once() {
    // If each page were converted separately, there would be 2 million leaves of 64 depths.
    let found = one_shape([64, 8], |i| 100 * (i & 1));
    let dag = graph_of_depths(&found).unwrap();
    assert_eq!(dag.validate(), Ok(()));
    for at in 0..2000_u32 {
        let [i, j] = [at.wrapping_mul(2_654_435_761) % found.size()[0], at * 2 % found.size()[1]];
        for k in [50, 100, 150, 200, 250, 300] {
            assert_eq!(dag.voxel(i, j, k), k < found.value(i, j), "{i} {j} {k}");
        }
    }
}

#[test]
fn shape_shared_at_too_many_depths_is_rejected() {
    let found = one_shape([64, 64], |i| i);
    let limit = graph_of_depths(&found).unwrap_err();
    // The leaves of each page, and its nodes of levels 5, 7 and 9.
    let count = (4096 + 256 + 16 + 1) << 12;
    assert_eq!(limit, TooLarge { what: "shapes", count, limit: 1 << 24 });
}

#[test]
fn grid_of_too_many_columns_has_no_depths() {
    let dag = Dag {
        size: [1 << 20, 1 << 20, 8],
        root_level: 20,
        top_dims: [1; 3],
        top: vec![LIT],
        nodes: vec![],
        leaf_masks: vec![],
    };
    file(DagBody::Plain(dag.clone()));
    let refused = depths_of(&dag, dag.root_level).unwrap_err();
    assert!(refused.to_string().contains("17179869184 blocks of 8 x 8 columns"), "{refused}");
}
