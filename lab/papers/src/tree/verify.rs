//! Adapts a tree to `adumbra_truth::verify`, which compares its answers with rays.

use adumbra::Bias;
use adumbra::grid::{Frame, LightGrid, Sun};
use adumbra_truth::verify::{Answers, Promises, VolumeSampler};

use crate::tree::query::TreeQuery;
use crate::tree::{TreeSettings, TreeSpace, Voxels};

/// Promises of a world-aligned tree. Its voxels do not follow the light, so edges are not required to be
/// accurate to a texel.
pub const TREE_PROMISES: Promises = Promises {
    interior: 0.999,
    ground: None,
    grazing: None,
    edge: None,
    edge_misplaced: None,
    narrow: None,
    narrow_misplaced: None,
};

/// Returns the sampler of points in a tree's cube.
pub fn volume_of(space: &TreeSpace) -> VolumeSampler {
    VolumeSampler::in_cube(space.p_min, space.voxel_size * f64::from(space.side_voxels()))
}

/// Answers of a world-aligned tree.
pub struct TreeAnswers<'a, T> {
    settings: &'a TreeSettings,
    query: TreeQuery<'a, T>,
    /// A grid along the light; its voxel size depends on the point.
    grid: LightGrid,
}

impl<'a, T: Voxels> TreeAnswers<'a, T> {
    /// Wraps `query`, which looks up a tree for `sun` that was baked with `settings`.
    pub fn new(settings: &'a TreeSettings, sun: Sun, query: TreeQuery<'a, T>) -> Self {
        let grid = LightGrid::new(sun, Frame::Light, 1.0, [0.0; 3], [u32::MAX; 3]);
        Self { settings, query, grid }
    }
}

impl<T: Voxels + Sync> Answers for TreeAnswers<'_, T> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.query.visibility(p_world, normal)
    }

    fn towards_sun(&self) -> [f64; 3] {
        self.grid.sun.towards()
    }

    fn grid_at(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> LightGrid {
        LightGrid { voxel_size: self.query.voxel_size_at(p_world, normal), ..self.grid }
    }

    fn bias(&self) -> Bias {
        self.query.bias()
    }

    fn baked_bias(&self) -> Bias {
        self.settings.bias
    }

    fn covers(&self, p_world: [f64; 3]) -> bool {
        let space = self.query.space();
        let inside = |c: &f64| (0.0..f64::from(space.side_voxels())).contains(c);
        self.settings.bounds.is_none() || space.to_tree(p_world).iter().all(inside)
    }

    fn insides_are_free(&self) -> bool {
        self.settings.closed_regions
    }

    fn promises(&self) -> Promises {
        TREE_PROMISES
    }
}
