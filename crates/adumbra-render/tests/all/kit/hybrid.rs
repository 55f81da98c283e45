//! Frames with hybrid maps, and checks of the maps' levels.

use adumbra_render::hybrid::HybridMap;
use adumbra_render::hybrid::twin::HybridTree;
use adumbra_render::{Prepared, Renderer, SceneOptions, Shot, TechniqueFiles, build};
use adumbra_scene::{Camera, Scene};

/// Width and height of these frames, pixels.
pub(crate) const SIZE: [u32; 2] = [160, 90];

/// Creates a renderer of a scene on [`super::gpu`].
pub(crate) fn renderer(scene: &Scene) -> Renderer {
    Renderer::new(super::gpu(), scene, SceneOptions::default()).unwrap()
}

/// Builds a technique that needs no baked file from its text.
pub(crate) fn prepare(renderer: &Renderer, name: &str) -> Prepared {
    let technique = build(renderer.gpu(), &name.parse().unwrap(), TechniqueFiles::default()).unwrap();
    renderer.prepare(technique).unwrap()
}

/// Returns the hybrid map of a technique that has one.
pub(crate) fn hybrid(technique: &Prepared) -> &HybridMap {
    technique.technique().hybrid().unwrap()
}

/// Returns shot number 0 under the test kit's sun.
pub(crate) fn shot(camera: Camera) -> Shot {
    Shot { camera, towards_sun: super::sun(), number: 0 }
}

/// Counts the finest texels that each level covers, one by one; finest level first.
pub(crate) fn level_counts(tree: &HybridTree) -> [u64; 4] {
    let side = i64::from(tree.start);
    let mut counts = [0; 4];
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        counts[tree.texel(x, y).1 as usize] += 1;
    }
    counts
}

/// Checks the tree's shares, which are derived from the blocks that did not merge, against a count of its
/// texels.
pub(crate) fn check_shares(tree: &HybridTree, what: &str) {
    let cells = f64::from(tree.start).powi(2);
    let (shares, counts) = (tree.shares(), level_counts(tree));
    for (level, (&share, &count)) in shares.iter().zip(&counts).enumerate() {
        // Both are whole numbers divided by a power of two, so they are exact.
        assert!((0.0..=1.0).contains(&share), "{what}, level {level}: {share}");
        assert_eq!(share, count as f64 / cells, "{what}, level {level}");
    }
}
