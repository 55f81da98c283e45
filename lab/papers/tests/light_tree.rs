//! Converts the light-aligned graph to a tree and back: the voxels are the same after one conversion, the
//! words after both.

use std::time::Instant;

use adumbra::{FormatError, Sun};
use adumbra_bake::{BakeOptions, Size, Watch};
use adumbra_papers::dag::build::convert::{body_in, graph_of};
use adumbra_papers::dag::build::store::{NodeState, NodeStore};
use adumbra_papers::dag::build::{DagOptions, bake};
use adumbra_papers::dag::plain::{Dag, LIT};
use adumbra_papers::dag::roots::top_dims;
use adumbra_papers::dag::{DAG_HEADER_BYTES, DagFile, DagLayout, LeafMasks};
use adumbra_papers::tree::{
    LightTreeError, VoxelTree, Word, WordsError, dag_of_tree, file_of_words, tree_depth, words_of,
};
use adumbra_scene::{GeneratedKind, LoadOptions, Scene, generate, load};
use proptest::prelude::*;

/// Builds the graph of a function of voxels, evaluated outside `size` too.
fn dag_of(size: [u32; 3], root_level: u32, lit: &dyn Fn([u32; 3]) -> bool) -> Dag {
    fn node(
        store: &mut NodeStore,
        corner: [u32; 3],
        level: u32,
        lit: &dyn Fn([u32; 3]) -> bool,
    ) -> NodeState {
        let [x, y, z] = corner;
        if level == 3 {
            let leaf_masks = std::array::from_fn(|k| {
                let bit = |b: u32| u64::from(lit([x + b % 8, y + b / 8, z + k as u32])) << b;
                store.leaf_mask((0..64).map(bit).sum())
            });
            return store.cube(&leaf_masks);
        }
        let half = 1 << (level - 1);
        let children = std::array::from_fn(|c| {
            let c = c as u32;
            let corner = [x + half * (c >> 2), y + half * (c >> 1 & 1), z + half * (c & 1)];
            node(store, corner, level - 1, lit)
        });
        store.inner(&children)
    }
    let mut store = NodeStore::default();
    let dims = top_dims(size, root_level);
    let mut top = Vec::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                top.push(node(&mut store, [x, y, z].map(|c| c << root_level), root_level, lit));
            }
        }
    }
    store.finish(size, root_level, dims, &top)
}

/// Converts to a tree and back. The tree must also pass the check for untrusted words.
fn there_and_back(dag: &Dag) -> VoxelTree {
    let tree = VoxelTree::from_dag(dag).unwrap();
    assert_eq!(VoxelTree::from_words(tree.depth(), tree.words().to_vec()).as_ref(), Ok(&tree));
    let back = dag_of_tree(&tree, dag.size, dag.root_level).unwrap();
    assert!(back == *dag, "{} words of nodes became {}", dag.nodes.len(), back.nodes.len());
    tree
}

fn assert_same_voxels(dag: &Dag, tree: &VoxelTree) {
    let side = tree.side().min(64);
    for z in 0..side {
        for y in 0..side {
            for x in 0..side {
                assert_eq!(tree.voxel([x, y, z]), dag.voxel(x, y, z), "({x}, {y}, {z})");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn light_tree_round_trip_of_random_columns(
        size in [1_u32..50, 1_u32..50, 1_u32..60],
        root_level in 3_u32..6,
        coarse in 0_u32..4,
        heights in prop::collection::vec(0_u32..64, 64),
        floating in any::<bool>(),
    ) {
        // Stepped columns, lit before a depth and shadowed behind it. Some float and are lit again farther
        // behind.
        let lit = |[x, y, z]: [u32; 3]| {
            let depth = heights[((x >> coarse) * 7 + (y >> coarse) * 3) as usize % 64];
            z < depth || floating && z > depth + 9
        };
        let dag = dag_of(size, root_level, &lit);
        prop_assert!(dag.validate().is_ok());
        let tree = there_and_back(&dag);
        assert_same_voxels(&dag, &tree);
    }

    #[test]
    fn light_tree_round_trip_of_noise(seed in any::<u64>(), size in 1_u32..40, share in 0_u64..256) {
        let mix = |v: u64| (v ^ v >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let lit = |[x, y, z]: [u32; 3]| {
            mix(mix(seed ^ u64::from(x << 20 | y << 10 | z))) >> 40 & 255 < share
        };
        let dag = dag_of([size, 20, 9], 4, &lit);
        let tree = there_and_back(&dag);
        assert_same_voxels(&dag, &tree);
    }
}

#[test]
fn light_tree_uses_one_shape_at_many_levels() {
    // Nested octants use the same block at every level; z halves are leaf masks at level 3.
    let nested = |[x, y, z]: [u32; 3]| {
        let deepest = [x, y, z].into_iter().max().unwrap();
        deepest > 0 && x >> deepest.ilog2() & 1 == 1
    };
    let halves = |[_, _, z]: [u32; 3]| z & 4 == 0 || z >= 32;
    for lit in [&nested as &dyn Fn([u32; 3]) -> bool, &halves] {
        for root_level in 3..=6 {
            let dag = dag_of([64, 64, 64], root_level, lit);
            let tree = there_and_back(&dag);
            assert_same_voxels(&dag, &tree);
        }
    }
}

#[test]
fn light_tree_round_trip_of_uniform_grids_and_of_one_voxel() {
    for answer in [false, true] {
        let dag = dag_of([24, 8, 8], 3, &|_| answer);
        let tree = there_and_back(&dag);
        assert_same_voxels(&dag, &tree);
        assert_eq!(tree.words().len() == 1, answer, "what is outside the grid is lit");
    }
    let dag = dag_of([9, 9, 9], 3, &|v| v != [8, 8, 8]);
    assert_same_voxels(&dag, &there_and_back(&dag));
}

#[test]
fn light_tree_rejects_sizes_beyond_its_limits() {
    assert_eq!(tree_depth([1 << 15, 1, 1], 10), Ok(15));
    let size = [1, 1, (1 << 15) + 1];
    assert_eq!(tree_depth(size, 10), Err(LightTreeError::TooDeep { size, depth: 16 }));
    assert_eq!(tree_depth([8; 3], 2), Err(LightTreeError::RootLevel { root_level: 2 }));
    let tree = VoxelTree::from_words(15, vec![0x8000_0001]).unwrap();
    assert_eq!(
        dag_of_tree(&tree, [1 << 15; 3], 3),
        Err(LightTreeError::TooManyRoots { roots: 1 << 36 }),
        "nothing is allocated for it"
    );
    let wrong = LightTreeError::WrongDepth { depth: 15, size: [8; 3], expected: 3 };
    assert_eq!(dag_of_tree(&tree, [8; 3], 3), Err(wrong));
    let uniform = Dag { top_dims: [1, 1, 2], top: vec![LIT; 2], ..dag_of([8; 3], 3, &|_| true) };
    let deep = Dag { size: [8, 8, (1 << 15) + 1], root_level: 15, ..uniform };
    assert!(matches!(VoxelTree::from_dag(&deep), Err(LightTreeError::TooDeep { .. })));
    let broken = Dag { top: vec![7], ..dag_of([8; 3], 3, &|_| true) };
    assert!(matches!(VoxelTree::from_dag(&broken), Err(LightTreeError::Graph(_))));
}

#[test]
fn light_tree_words_and_header_restore_the_same_file() {
    let scene = generate(GeneratedKind::Primitives, 1);
    for layout in [DagLayout::Plain, DagLayout::Packed] {
        let file = baked(&scene, 256, layout);
        let name = layout.name();
        let mut bytes = Vec::new();
        file.write_to(&mut bytes).unwrap();
        let (tree, rest) = words_of(&file).unwrap();
        assert_eq!(rest, bytes[..DAG_HEADER_BYTES]);
        let words = tree.into_words();
        let mut back = Vec::new();
        file_of_words(&rest, words.clone()).unwrap().write_to(&mut back).unwrap();
        assert!(back == bytes, "{name}");

        let longer = [&rest[..], &[0]].concat();
        let error = file_of_words(&longer, words.clone()).unwrap_err();
        assert!(matches!(error, WordsError::Format(FormatError::TrailingBytes { .. })), "{error}");
        for length in [0, 8, 383] {
            let error = file_of_words(&rest[..length], words.clone()).unwrap_err();
            assert!(matches!(error, WordsError::Format(_)), "{error}");
        }
        let error = file_of_words(&rest, words[..words.len() - 1].to_vec()).unwrap_err();
        assert!(matches!(error, WordsError::Tree(_)), "{error}");
        let lit = vec![Word::LIT.0];
        let error = file_of_words(&rest, lit).unwrap_err();
        assert!(matches!(error, WordsError::Differs { .. }), "{name}: {error}");
    }
}

#[test]
fn light_tree_export_rejects_unmerged_graph() {
    let mut file = baked(&generate(GeneratedKind::Cornell, 1), 16, DagLayout::Plain);
    let mut dag = dag_of([16, 8, 8], 3, &|[x, y, _]| x % 8 > y % 8);
    assert_eq!((dag.top[0], dag.top[1]), (0, 0));
    // The second root gets a separate node with the same children. This is valid, but the tree converts back
    // to a different file.
    let node = dag.nodes.clone();
    dag.top[1] = node.len() as u32;
    dag.nodes.extend(&node);
    file.grid.size = dag.size;
    assert!(dag.validate().is_ok());
    for layout in [DagLayout::Plain, DagLayout::Packed] {
        file.body = body_in(layout, dag.clone()).unwrap();
        let error = words_of(&file).unwrap_err();
        assert!(matches!(error, WordsError::NotCanonical { .. }), "{error}");
    }
}

fn baked(scene: &Scene, resolution: u64, layout: DagLayout) -> DagFile {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = DagOptions { bake: BakeOptions::new(sun, Size::Resolution(resolution)), layout };
    bake(scene, &options, Watch::none()).unwrap().file
}

fn bake_at(scene: &Scene, resolution: u64) -> Dag {
    graph_of(&baked(scene, resolution, DagLayout::Plain).body).unwrap().into_owned()
}

#[test]
fn light_tree_round_trip_of_generated_scenes() {
    for kind in [GeneratedKind::City, GeneratedKind::Spheres] {
        let dag = bake_at(&generate(kind, 3), 512);
        assert_same_voxels(&dag, &there_and_back(&dag));
    }
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_light_tree_round_trip_of_a_real_scene() {
    let Some(scenes) = adumbra_testing::shared("scenes") else { return };
    let dag = bake_at(&load(&scenes.join("kaykit_city_21.glb"), &LoadOptions::default()).unwrap(), 2048);
    let begun = Instant::now();
    let tree = there_and_back(&dag);
    eprintln!(
        "{} words of nodes, {} of the tree, {:?}",
        dag.nodes.len(),
        tree.words().len(),
        begun.elapsed()
    );
    // Cells of a lattice whose steps share no factor with the sizes of the nodes.
    for i in 0..1_000_000_u64 {
        let xyz = [7919, 104_729, 15_485_863].map(|p: u64| (i * p % u64::from(tree.side())) as u32);
        assert_eq!(tree.voxel(xyz), dag.voxel(xyz[0], xyz[1], xyz[2]), "{xyz:?}");
    }
}
