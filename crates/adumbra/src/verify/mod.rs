//! A file's answers against rays.
//!
//! Random points on the scene's surfaces, uniform by area, or in its space, lifted by the look-up's bias, are asked of the file and
//! of the rays. Every point that the sun can shine on is compared; what is not is counted: faces turned away, points inside
//! solids, which nobody sees, and points outside the file's bounds. Each compared point has a [`Class`], which rays alone decide:
//!
//! - The *neighbours* of a point are eight at one texel and eight at two texels in the light's plane, moved along the light onto the
//!   point's tangent plane (in space: at its depth), all lifted alike. A texel is a voxel's edge where the file is world-aligned.
//! - *Acne*: lit called shadowed. *Leak*: shadowed called lit. *Misplaced*: wrong, and neither a ray from the
//!   centre of the point's texel nor half of those spread over it give the answer: more than the grid's resolution went wrong.
//! - With a filter of K × K texels, the file's value is compared with the mean of K × K rays, one from the centre of each tap, on
//!   the receiver's plane. The taps count as neighbours.
//!
//! What a file promises of each class: [`Promises`].

mod answers;
mod classes;
mod place;
mod points;

use rayon::prelude::*;

pub use answers::{Answers, LightAnswers, TreeAnswers};
pub use classes::{Class, ClassResult, MIN_JUDGED_POINTS, Promises};
pub use points::{Random, Sample, Solids, SurfaceSampler, VolumeSampler};

use crate::query::receiver;
use crate::trace::Tracer;
use classes::{ClassCounts, DIFFERENCE_STEPS};
use place::Place;

/// What to check.
#[derive(Clone, Copy, Debug)]
pub struct VerifyOptions {
    /// Points to ask.
    pub samples: u64,
    /// Seed of the points.
    pub seed: u64,
}

/// Counts of a verification; shares are of the samples, 0 to 1.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verification {
    /// Points compared.
    pub samples: u64,
    /// Points drawn that face away from the sun; not compared.
    pub facing_away: u64,
    /// Points drawn inside solids, where nobody sees and the file may say either; not compared.
    pub inside_solids: u64,
    /// Points drawn outside the box that `--bounds` gave; not compared.
    pub outside_bounds: u64,
    /// Share of the samples shadowed by rays.
    pub shadowed_share: f64,
    /// One less the mean difference from the rays; without a filter the share of right answers.
    pub agreement: f64,
    /// The same of [`Class::Interior`]; 1 where it has no points.
    pub interior_agreement: f64,
    /// Share of the samples that are [`Class::Interior`].
    pub interior_share: f64,
    /// Share of the samples that are answered darker than the rays say by more than half.
    pub acne: f64,
    /// Share of the samples that are answered lighter than the rays say by more than half.
    pub leak: f64,
    /// Every class, in the order of [`Class::ALL`].
    pub classes: Vec<ClassResult>,
}

impl Verification {
    /// The result of one class.
    pub fn class(&self, class: Class) -> &ClassResult {
        let place = Class::ALL.iter().position(|c| *c == class).unwrap_or_default();
        &self.classes[place]
    }

    /// Whether there are points enough to judge the file by: in [`Class::Interior`], or under a low sun in [`Class::Grazing`].
    pub fn is_judged(&self) -> bool {
        [Class::Interior, Class::Grazing].iter().any(|class| self.class(*class).judged)
    }

    /// Whether the file is judged and every class keeps its promise.
    pub fn holds(&self) -> bool {
        self.is_judged() && self.classes.iter().all(|c| c.holds)
    }
}

#[derive(Clone, Copy, Default)]
struct Counts {
    facing_away: u64,
    inside_solids: u64,
    outside_bounds: u64,
    shadowed: u64,
    /// In the order of [`Class::ALL`].
    classes: [ClassCounts; Class::ALL.len()],
}

/// Texels from a point to its inner and its outer neighbours.
const NEIGHBOUR_TEXELS: [f64; 2] = [1.0, 2.0];
/// Points nearer to the terminator than this are a class of their own.
pub const MIN_N_DOT_L: f64 = 0.1;
/// Points a batch; each batch has its own random numbers, so that the threads do not matter.
const BATCH: u64 = 4096;

/// A checker of one file against one scene.
pub struct Verifier<'a, A> {
    answers: &'a A,
    tracer: &'a Tracer<'a>,
    solids: &'a Solids,
    promises: Promises,
}

impl<'a, A: Answers> Verifier<'a, A> {
    /// Compares `answers` with the rays of `tracer`, which must hold the scene that was baked, like `solids`.
    pub fn new(answers: &'a A, tracer: &'a Tracer<'a>, solids: &'a Solids) -> Self {
        Self { answers, tracer, solids, promises: answers.promises() }
    }

    /// Another agreement to hold the interior to.
    #[must_use]
    pub fn with_interior_promise(self, least_agreement: f64) -> Self {
        Self { promises: Promises { interior: least_agreement, ..self.promises }, ..self }
    }

    /// Draws the points and compares. Cost: about 20 rays for each point, and one more for each tap of a filter; runs on the current rayon pool.
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
        counts.finish(&self.promises)
    }

    fn compare(&self, sample: &Sample, c: &mut Counts) {
        let answers = self.answers;
        if sample.normal.is_some_and(|n| !(crate::light::dot(n, answers.towards_sun()) > 0.0)) {
            c.facing_away += 1;
            return;
        }
        let grid = answers.grid_at(sample.p_world, sample.normal);
        let place = Place {
            grid,
            tracer: self.tracer,
            solids: self.solids,
            p_world: sample.p_world,
            normal: sample.normal,
            receiver: receiver(&grid, &answers.bias(), sample.p_world, sample.normal),
        };
        if !answers.covers(grid.to_world(place.receiver.p_grid)) {
            c.outside_bounds += 1;
            return;
        }
        if answers.insides_are_free() && place.is_inside_solid() {
            c.inside_solids += 1;
            return;
        }
        let truth = place.truth();
        c.shadowed += u64::from(!truth);
        let value = f64::from(answers.visibility(sample.p_world, sample.normal));
        let taps = answers.taps(&place.receiver);
        let own = f64::from(u8::from(truth));
        let expected = if taps.is_empty() { own } else { place.mean_lit(&taps) };
        let class = match place.class(truth, &answers.baked_bias()) {
            // A filter's taps are neighbours too.
            Class::Interior | Class::Grazing if expected != own => Class::Edge,
            class => class,
        };
        // What is no visibility is wrong, whatever the rays say.
        let value = if (0.0..=1.0).contains(&value) { value } else { 1.0 - own };
        // A tree's filter has no taps to compare, and is judged at one half.
        let value = if taps.is_empty() { f64::from(u8::from(value > 0.5)) } else { value };
        let counts = &mut c.classes[Class::ALL.iter().position(|a| *a == class).unwrap_or_default()];
        counts.points += 1;
        counts.difference_steps += ((value - expected).abs() * DIFFERENCE_STEPS).round() as u64;
        counts.acne += u64::from(value < expected - 0.5);
        counts.leak += u64::from(value > expected + 0.5);
        if taps.is_empty() && (value - expected).abs() > 0.5 {
            counts.misplaced += u64::from(!place.is_answer_of_its_texel(value > 0.5));
        }
    }
}

/// Where the points come from.
pub enum Sampler<'s> {
    /// On surfaces.
    Surface(SurfaceSampler<'s>),
    /// In the grid's space.
    Volume(VolumeSampler),
}

impl Counts {
    fn add(mut self, o: Self) -> Self {
        self.facing_away += o.facing_away;
        self.inside_solids += o.inside_solids;
        self.outside_bounds += o.outside_bounds;
        self.shadowed += o.shadowed;
        for (counts, more) in self.classes.iter_mut().zip(&o.classes) {
            counts.add(more);
        }
        self
    }

    fn finish(&self, promises: &Promises) -> Verification {
        let mut all = ClassCounts::default();
        self.classes.iter().for_each(|c| all.add(c));
        let share = |part: u64| if all.points == 0 { 0.0 } else { part as f64 / all.points as f64 };
        let classes: Vec<ClassResult> = Class::ALL
            .iter()
            .zip(&self.classes)
            .map(|(class, counts)| counts.finish(*class, promises))
            .collect();
        let interior = classes[0];
        Verification {
            samples: all.points,
            facing_away: self.facing_away,
            inside_solids: self.inside_solids,
            outside_bounds: self.outside_bounds,
            shadowed_share: share(self.shadowed),
            agreement: all.finish(Class::Thin, promises).agreement,
            interior_agreement: interior.agreement,
            interior_share: share(interior.points),
            acne: share(all.acne),
            leak: share(all.leak),
            classes,
        }
    }
}
