//! Scenes baked into trees, and comparisons with the CPU twins.

use adumbra::Sun;
use adumbra_bake::{Size, Watch};
use adumbra_papers::techniques::{Cubes, CubesOptions, CubesStore, PaperFiles};
use adumbra_papers::tree::query::{TreeQuery, Weights};
use adumbra_papers::tree::{Detail, TreeBody, TreeFile, TreeOptions, VoxelTree, bake_tree};
use adumbra_render::{Gpu, Result};
use adumbra_scene::Scene;

use crate::kit::SUN;
use crate::points::{float_points, hold_floats, points};

/// A scene with its tree.
pub(crate) struct BakedTree {
    pub(crate) scene: Scene,
    pub(crate) tree: TreeFile,
}

impl BakedTree {
    pub(crate) fn new(scene: Scene, side: u64) -> Self {
        Self::with_detail(scene, side, Detail::Uniform)
    }

    pub(crate) fn with_detail(scene: Scene, side: u64, detail: Detail) -> Self {
        let sun = Sun::from_direction(SUN).unwrap();
        let options = TreeOptions { detail, ..TreeOptions::new(sun, Size::Resolution(side)) };
        let tree = TreeFile::from(bake_tree(&scene, &options, Watch::none()).unwrap());
        Self { scene, tree }
    }

    /// Returns the tree file in the form that techniques read.
    pub(crate) fn files(&self) -> PaperFiles {
        PaperFiles { tree: Some(self.tree.clone()), ..PaperFiles::default() }
    }

    pub(crate) fn voxels(&self) -> &VoxelTree {
        match &self.tree.body {
            TreeBody::Words(tree) => tree,
            TreeBody::Symmetric(_) => unreachable!("made of words"),
        }
    }

    pub(crate) fn words(&self) -> &[u32] {
        self.voxels().words()
    }

    pub(crate) fn query(&self, (side, weights): (u32, Weights)) -> TreeQuery<'_, VoxelTree> {
        let t = &self.tree;
        TreeQuery::new(&t.space, &t.regions, &t.sun, self.voxels(), t.settings.bias, side, weights).unwrap()
    }
}

pub(crate) fn try_cubes(
    gpu: &Gpu,
    baked: &BakedTree,
    store: CubesStore,
    (filter, weights): (u32, Weights),
) -> Result<Cubes> {
    let bias = baked.tree.settings.bias;
    Cubes::new(gpu, &baked.tree, CubesOptions { bias, filter, weights, all_taps: false, store })
}

pub(crate) fn exact_cubes(
    gpu: &Gpu,
    baked: &BakedTree,
    store: CubesStore,
    kernel: (u32, Weights),
    count: usize,
) {
    let cubes = try_cubes(gpu, baked, store, kernel).unwrap();
    let query = baked.query(kernel);
    let receivers: Vec<_> =
        points(&baked.scene, count).into_iter().filter_map(|(p, n)| query.receiver(p, n)).collect();
    let found = cubes.lit_weights(gpu, &receivers).unwrap();
    let mut partly = 0;
    for (r, found) in receivers.iter().zip(&found) {
        let expected = query.lit_weights(r);
        // The quotients of whole numbers must be equal.
        assert!(
            found[1] > 0 && found[0] * expected[1] == expected[0] * found[1],
            "{kernel:?}: {r:?} {found:?} {expected:?}"
        );
        partly += usize::from(expected[0] > 0 && expected[0] < expected[1]);
    }
    assert!(found.len() * 2 > count && (kernel.0 == 1 || partly * 200 > count), "{partly} partly lit");
}

/// Compares answers at `count` points of the scene, as [`hold_floats`] does.
pub(crate) fn float_cubes(gpu: &Gpu, baked: &BakedTree, kernel: (u32, Weights), count: usize) {
    let (anchor, points) = float_points(&baked.scene, count);
    let mut cubes = try_cubes(gpu, baked, CubesStore::Words, kernel).unwrap();
    cubes.set_anchor(gpu, anchor).unwrap();
    let query = baked.query(kernel);
    let twin = |p, n| query.visibility(p, n);
    hold_floats(gpu, &cubes, (anchor, &points), twin, |p, n| query.voxel_size_at(p, n));
}
