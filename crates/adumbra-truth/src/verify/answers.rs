//! The subject of a verification: anything that answers visibility queries, with the settings that a fair
//! comparison needs.

use crate::verify::classes::Promises;
use adumbra::grid::LightGrid;
use adumbra::query::Receiver;
use adumbra::{Bias, FileSettings, Filter, PointVisibility, Receivers, Sampler, ShadowFile};

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

    /// The promise of a file that answers points below the scene's last surfaces; `None` if it promises
    /// nothing there.
    fn below(&self) -> Option<Below> {
        None
    }

    /// The points that a filtered look-up samples, in the grid's voxels. Empty for a single tap, or if the
    /// taps are not points of a plane.
    fn taps(&self, _receiver: &Receiver) -> Vec<[f64; 3]> {
        Vec::new()
    }

    /// What the file promises.
    fn promises(&self) -> Promises;
}

/// How points below the scene's last surfaces are answered.
#[derive(Clone, Copy, Debug)]
pub struct Below {
    /// The grid that answers them.
    pub grid: LightGrid,
    /// How far below an open surface its shadow may begin, voxels along the light. The bias at the surface's
    /// slope replaces it if that is larger.
    pub thickness_voxels: f64,
}

/// Answers of a look-up over a light-aligned grid.
pub struct LightAnswers<Q> {
    grid: LightGrid,
    settings: FileSettings,
    look_up: Q,
    filter: Filter,
    bias: Bias,
}

impl LightAnswers<Sampler> {
    /// Wraps a file's look-ups.
    pub fn of(file: &ShadowFile, sampler: Sampler) -> Self {
        let (filter, bias) = (sampler.filter(), sampler.bias());
        Self::new(file.grid, file.settings, sampler, (filter, bias))
    }
}

impl<Q: PointVisibility> LightAnswers<Q> {
    /// Wraps `look_up`, whose voxels are those of `grid` and were baked with `settings`, and which has this
    /// filter and bias.
    pub fn new(grid: LightGrid, settings: FileSettings, look_up: Q, (filter, bias): (Filter, Bias)) -> Self {
        Self { grid, settings, look_up, filter, bias }
    }
}

impl<Q: PointVisibility> Answers for LightAnswers<Q> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.look_up.visibility(p_world, normal)
    }

    fn towards_sun(&self) -> [f64; 3] {
        self.grid.sun.towards()
    }

    fn grid_at(&self, _: [f64; 3], _: Option<[f64; 3]>) -> LightGrid {
        self.grid
    }

    fn bias(&self) -> Bias {
        self.bias
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

    fn below(&self) -> Option<Below> {
        let FileSettings { assume_ground, receivers, thickness_world, .. } = self.settings;
        let thickness_voxels = thickness_world / self.grid.voxel_along_light();
        let is_answered = !assume_ground && receivers == Receivers::All;
        is_answered.then_some(Below { grid: self.grid, thickness_voxels })
    }

    fn taps(&self, r: &Receiver) -> Vec<[f64; 3]> {
        if self.filter == Filter::Nearest {
            return Vec::new();
        }
        let side = self.filter.width();
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
        if self.filter == Filter::Nearest { Promises::LIGHT } else { Promises::LIGHT_FILTERED }
    }
}

/// Answers with a replaced visibility or coverage. Everything else is unchanged.
///
/// Passing [`Answers::visibility`] or [`Answers::covers`] itself replaces nothing.
pub struct Replaced<A, V, C> {
    /// The original answers.
    pub answers: A,
    /// Replaces [`Answers::visibility`].
    pub visibility: V,
    /// Replaces [`Answers::covers`].
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

    fn below(&self) -> Option<Below> {
        self.answers.below()
    }

    fn taps(&self, receiver: &Receiver) -> Vec<[f64; 3]> {
        self.answers.taps(receiver)
    }

    fn promises(&self) -> Promises {
        self.answers.promises()
    }
}
