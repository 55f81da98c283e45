//! What is verified: anything that answers visibility queries, with the settings that a fair comparison needs.

use crate::verify::classes::Promises;
use adumbra::grid::{Frame, LightGrid, Sun};
use adumbra::query::{Query, Receiver};
use adumbra::{Bias, FileSettings};
use adumbra_tree::query::TreeQuery;
use adumbra_tree::{TreeSettings, Voxels};

/// Visibility answers to be compared with rays.
pub trait Answers: Sync {
    /// Visibility of a point, looked up with the look-up's own bias.
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32;

    /// Unit vector towards the sun.
    fn towards_sun(&self) -> [f64; 3];

    /// A light-aligned grid whose voxels have the size of those that answer this point.
    fn grid_at(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> LightGrid;

    /// The bias of the look-up, in texels of that grid.
    fn bias(&self) -> Bias;

    /// The bias for which the file was baked.
    fn baked_bias(&self) -> Bias;

    /// Whether the file promises an answer for a point, after the bias.
    fn covers(&self, p_world: [f64; 3]) -> bool;

    /// Whether the file may answer either way inside solids.
    fn insides_are_free(&self) -> bool;

    /// The points that a filtered look-up samples, in the grid's voxels. Empty for a single tap, or if the taps are not
    /// points of a plane.
    fn taps(&self, _receiver: &Receiver) -> Vec<[f64; 3]> {
        Vec::new()
    }

    /// What the file promises.
    fn promises(&self) -> Promises;
}

/// Answers of a light-aligned file.
pub struct LightAnswers<'a> {
    grid: &'a LightGrid,
    settings: &'a FileSettings,
    query: Query<'a>,
}

impl<'a> LightAnswers<'a> {
    /// Wraps `query`, which looks up a graph on `grid` that was baked with `settings`.
    pub fn new(grid: &'a LightGrid, settings: &'a FileSettings, query: Query<'a>) -> Self {
        Self { grid, settings, query }
    }
}

impl Answers for LightAnswers<'_> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.query.visibility(p_world, normal)
    }

    fn towards_sun(&self) -> [f64; 3] {
        self.grid.sun.towards()
    }

    fn grid_at(&self, _: [f64; 3], _: Option<[f64; 3]>) -> LightGrid {
        *self.grid
    }

    fn bias(&self) -> Bias {
        self.query.bias()
    }

    fn baked_bias(&self) -> Bias {
        self.settings.bias
    }

    fn covers(&self, p_world: [f64; 3]) -> bool {
        let p_grid = self.grid.to_grid(p_world);
        let inside = || p_grid.iter().zip(self.grid.size).all(|(c, n)| (0.0..f64::from(n)).contains(c));
        self.settings.bounds.is_none() || inside()
    }

    fn insides_are_free(&self) -> bool {
        self.settings.closed_regions
    }

    fn taps(&self, r: &Receiver) -> Vec<[f64; 3]> {
        let side = self.query.filter();
        if side == 1 {
            return Vec::new();
        }
        let reach = f64::from(side / 2);
        let corner = [0, 1].map(|a| r.p_grid[a].floor() + 0.5 - reach);
        let taps = (0..side * side).map(|i| [f64::from(i % side), f64::from(i / side)]);
        taps.map(|[i, j]| {
            let [x, y] = [corner[0] + i, corner[1] + j];
            [x, y, r.p_grid[2] + r.gradient[0] * (x - r.p_grid[0]) + r.gradient[1] * (y - r.p_grid[1])]
        })
        .collect()
    }

    fn promises(&self) -> Promises {
        if self.query.filter() == 1 { Promises::LIGHT } else { Promises::LIGHT_FILTERED }
    }
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
        Promises::TREE
    }
}

/// Answers with another visibility, or of another part of the world; all else stays as it is.
///
/// [`Answers::visibility`] and [`Answers::covers`] replace nothing.
pub struct Replaced<A, V, C> {
    /// The answers that all else is taken from.
    pub answers: A,
    /// Takes the place of [`Answers::visibility`].
    pub visibility: V,
    /// Takes the place of [`Answers::covers`].
    pub covers: C,
}

impl<A, V, C> Answers for Replaced<A, V, C>
where
    A: Answers,
    V: Fn(&A, [f64; 3], Option<[f64; 3]>) -> f32 + Sync,
    C: Fn(&A, [f64; 3]) -> bool + Sync,
{
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        (self.visibility)(&self.answers, p_world, normal)
    }

    fn towards_sun(&self) -> [f64; 3] {
        self.answers.towards_sun()
    }

    fn grid_at(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> LightGrid {
        self.answers.grid_at(p_world, normal)
    }

    fn bias(&self) -> Bias {
        self.answers.bias()
    }

    fn baked_bias(&self) -> Bias {
        self.answers.baked_bias()
    }

    fn covers(&self, p_world: [f64; 3]) -> bool {
        (self.covers)(&self.answers, p_world)
    }

    fn insides_are_free(&self) -> bool {
        self.answers.insides_are_free()
    }

    fn taps(&self, receiver: &Receiver) -> Vec<[f64; 3]> {
        self.answers.taps(receiver)
    }

    fn promises(&self) -> Promises {
        self.answers.promises()
    }
}
