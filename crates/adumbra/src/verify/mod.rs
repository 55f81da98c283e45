//! A file's answers against rays.
//!
//! Random points on the scene's surfaces, or in its space, lifted by the look-up's bias, are asked of the file and of the
//! rays. Definitions, with a voxel's edge for a texel where the file is world-aligned:
//! - *Interior*: the point and eight neighbours, two texels away in the light's plane and moved along the light onto the
//!   point's tangent plane (in space: at its depth), all lifted alike, agree by rays.
//! - *Thin*: the nearest blocker on the surface point's sun ray is nearer than two voxels or than the file's bias at that slope.
//! - *Inside a solid*: the winding of closed components along the sun ray is not zero; nobody sees it, the file may say
//!   either, and it is counted apart.
//! - *Acne*: lit called shadowed. *Leak*: shadowed called lit.

mod answers;
mod points;

use rayon::prelude::*;

pub use answers::{Answers, LightAnswers, TreeAnswers};
pub use points::{Random, Sample, Solids, SurfaceSampler, VolumeSampler};

use crate::light::LightGrid;
use crate::query::receiver;
use crate::settings::MAX_SLOPE;
use crate::trace::{Ray, Tracer};

/// What to check.
#[derive(Clone, Copy, Debug)]
pub struct VerifyOptions {
    /// Points to ask.
    pub samples: u64,
    /// Seed of the points.
    pub seed: u64,
}

/// Counts of a verification; shares are of the samples that they name, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Verification {
    /// Points compared: n·l > 0.1, outside solids.
    pub samples: u64,
    /// Points drawn that face away from the sun or nearly so; not compared.
    pub facing_away: u64,
    /// Points drawn inside solids, where nobody sees and the file may say either; not compared.
    pub inside_solids: u64,
    /// Points drawn outside the box that `--bounds` gave; not compared.
    pub outside_bounds: u64,
    /// Share of the samples shadowed by rays.
    pub shadowed_share: f64,
    /// Share of all samples on which file and rays agree.
    pub agreement: f64,
    /// Share of interior, not thin samples on which they agree.
    pub interior_agreement: f64,
    /// Share of all samples that are interior (thin ones too).
    pub interior_share: f64,
    /// Share of all samples that are lit and called shadowed.
    pub acne: f64,
    /// Share of all samples that are shadowed and called lit.
    pub leak: f64,
    /// Thin samples.
    pub thin: u64,
    /// Thin samples on which they disagree.
    pub thin_wrong: u64,
    /// Interior, not thin samples that are lit and called shadowed.
    pub interior_acne: u64,
    /// Interior, not thin samples that are shadowed and called lit.
    pub interior_leak: u64,
    /// Interior, not thin samples.
    pub interior: u64,
}

#[derive(Clone, Copy, Default)]
struct Counts {
    samples: u64,
    facing_away: u64,
    inside_solids: u64,
    outside_bounds: u64,
    shadowed: u64,
    acne: u64,
    leak: u64,
    interior_all: u64,
    interior: u64,
    interior_acne: u64,
    interior_leak: u64,
    thin: u64,
    thin_wrong: u64,
}

/// Texels from a point to its neighbours.
const NEIGHBOUR_TEXELS: f64 = 2.0;
/// Points nearer to the terminator than this are counted apart.
pub const MIN_N_DOT_L: f64 = 0.1;
/// Points a batch; each batch has its own random numbers, so that the threads do not matter.
const BATCH: u64 = 4096;

/// A checker of one file against one scene.
pub struct Verifier<'a, A> {
    answers: &'a A,
    tracer: &'a Tracer<'a>,
    solids: &'a Solids,
}

/// The rays' side of one sample.
struct Place<'a> {
    grid: LightGrid,
    tracer: &'a Tracer<'a>,
    solids: &'a Solids,
}

impl<'a, A: Answers> Verifier<'a, A> {
    /// Compares `answers` with the rays of `tracer`, which must hold the scene that was baked, like `solids`.
    pub fn new(answers: &'a A, tracer: &'a Tracer<'a>, solids: &'a Solids) -> Self {
        Self { answers, tracer, solids }
    }

    /// Draws the points and compares. Cost: about 11 rays a point; runs on the current rayon pool.
    pub fn run(&self, sampler: &Sampler<'_>, options: &VerifyOptions) -> Verification {
        let batches = options.samples.div_ceil(BATCH);
        let counts = (0..batches)
            .into_par_iter()
            .map(|batch| {
                let count = BATCH.min(options.samples - batch * BATCH);
                let mut random = points::Random::new(options.seed, batch);
                let mut counts = Counts::default();
                for _ in 0..count {
                    let sample = match sampler {
                        Sampler::Surface(s) => s.sample(&mut random),
                        Sampler::Volume(s) => s.sample(&mut random),
                    };
                    self.compare(&sample, &mut counts);
                }
                counts
            })
            .reduce(Counts::default, Counts::add);
        counts.finish()
    }

    fn compare(&self, sample: &Sample, c: &mut Counts) {
        let answers = self.answers;
        if let Some(n) = sample.normal
            && crate::light::dot(n, answers.towards_sun()) <= MIN_N_DOT_L
        {
            c.facing_away += 1;
            return;
        }
        let grid = answers.grid_at(sample.p_world, sample.normal);
        let place = Place { grid, tracer: self.tracer, solids: self.solids };
        let voxel = grid.voxel_size;
        let surface_grid = grid.to_grid(sample.p_world);
        let r = receiver(&grid, &answers.bias(), sample.p_world, sample.normal);
        let lifted_world = grid.to_world(r.p_grid);
        if !answers.covers(lifted_world) {
            c.outside_bounds += 1;
            return;
        }
        if answers.insides_are_free() && place.inside_solid(lifted_world) {
            c.inside_solids += 1;
            return;
        }
        c.samples += 1;
        let truth = place.lit(r.p_grid);
        let answer = answers.visibility(sample.p_world, sample.normal) > 0.5;
        // The blocker nearest to the surface itself; a volume point's slope is its blocker's.
        let slope = (r.gradient[0].powi(2) + r.gradient[1].powi(2)).sqrt();
        let thin = place.nearest_blocker(surface_grid, sample.normal).is_some_and(|(distance, n_dot_l)| {
            let slope = if sample.normal.is_some() { slope } else { slope_of(n_dot_l) };
            distance / voxel < 2.0_f64.max(answers.baked_bias().along_light(slope))
        });
        let interior = place.is_interior(r.p_grid, r.gradient, truth);
        c.shadowed += u64::from(!truth);
        c.acne += u64::from(truth && !answer);
        c.leak += u64::from(!truth && answer);
        c.interior_all += u64::from(interior);
        c.thin += u64::from(thin);
        c.thin_wrong += u64::from(thin && truth != answer);
        if interior && !thin {
            c.interior += 1;
            c.interior_acne += u64::from(truth && !answer);
            c.interior_leak += u64::from(!truth && answer);
        }
    }
}

impl Place<'_> {
    fn is_interior(&self, p_grid: [f64; 3], gradient: [f64; 2], truth: bool) -> bool {
        (0..9).filter(|&i| i != 4).all(|i| {
            let offset = [i % 3 - 1, i / 3 - 1].map(|o| f64::from(o) * NEIGHBOUR_TEXELS);
            let z = p_grid[2] + gradient[0] * offset[0] + gradient[1] * offset[1];
            self.lit([p_grid[0] + offset[0], p_grid[1] + offset[1], z]) == truth
        })
    }

    fn lit(&self, p_grid: [f64; 3]) -> bool {
        let origin = self.grid.to_world(p_grid);
        !self.tracer.occluded(&Ray {
            origin,
            direction: self.grid.sun.towards(),
            t_min: 0.0,
            t_max: f64::INFINITY,
        })
    }

    /// Distance in world units and |n·l| of the first blocker above an unlifted point.
    fn nearest_blocker(&self, p_grid: [f64; 3], normal: Option<[f64; 3]>) -> Option<(f64, f64)> {
        let direction = self.grid.sun.towards();
        // A thousandth of a voxel off its own surface.
        let origin = self.grid.to_world([p_grid[0], p_grid[1], p_grid[2] - 1e-3]);
        let t_min = if normal.is_some() { 1e-3 * self.grid.voxel_size } else { 0.0 };
        let hit = self.tracer.nearest_blocker(&Ray { origin, direction, t_min, t_max: f64::INFINITY })?;
        Some((hit.t, crate::light::dot(hit.normal, direction).abs()))
    }

    /// The winding of solids above the point is not zero.
    fn inside_solid(&self, p_world: [f64; 3]) -> bool {
        let direction = self.grid.sun.towards();
        let ray = Ray { origin: p_world, direction, t_min: 0.0, t_max: f64::INFINITY };
        let mut winding = 0;
        self.tracer.for_each_hit(&ray, |hit| {
            if self.solids.contains(hit.instance, hit.triangle) {
                winding += if hit.front { -1 } else { 1 };
            }
        });
        winding != 0
    }
}

fn slope_of(n_dot_l: f64) -> f64 {
    let n = n_dot_l.clamp(1e-6, 1.0);
    ((1.0 - n * n).sqrt() / n).min(MAX_SLOPE)
}

/// Where the points come from.
pub enum Sampler<'s> {
    /// On surfaces.
    Surface(SurfaceSampler<'s>),
    /// In the grid's space.
    Volume(VolumeSampler),
}

impl Counts {
    fn add(self, o: Self) -> Self {
        Self {
            samples: self.samples + o.samples,
            facing_away: self.facing_away + o.facing_away,
            inside_solids: self.inside_solids + o.inside_solids,
            outside_bounds: self.outside_bounds + o.outside_bounds,
            shadowed: self.shadowed + o.shadowed,
            acne: self.acne + o.acne,
            leak: self.leak + o.leak,
            interior_all: self.interior_all + o.interior_all,
            interior: self.interior + o.interior,
            interior_acne: self.interior_acne + o.interior_acne,
            interior_leak: self.interior_leak + o.interior_leak,
            thin: self.thin + o.thin,
            thin_wrong: self.thin_wrong + o.thin_wrong,
        }
    }

    fn finish(&self) -> Verification {
        let share = |part: u64, whole: u64| if whole == 0 { 1.0 } else { part as f64 / whole as f64 };
        let none = |part: u64| if self.samples == 0 { 0.0 } else { part as f64 / self.samples as f64 };
        let wrong_inside = self.interior_acne + self.interior_leak;
        Verification {
            samples: self.samples,
            facing_away: self.facing_away,
            inside_solids: self.inside_solids,
            outside_bounds: self.outside_bounds,
            shadowed_share: none(self.shadowed),
            agreement: share(self.samples - self.acne - self.leak, self.samples),
            interior_agreement: share(self.interior - wrong_inside, self.interior),
            interior_share: share(self.interior_all, self.samples),
            acne: none(self.acne),
            leak: none(self.leak),
            thin: self.thin,
            thin_wrong: self.thin_wrong,
            interior_acne: self.interior_acne,
            interior_leak: self.interior_leak,
            interior: self.interior,
        }
    }
}
