//! Compares a file's answers with ray tracing.
//!
//! Random points are drawn on the scene's surfaces, uniformly by area, or in its space. They are lifted by
//! the look-up's bias, and both the file and the rays answer them. So are points on level ground just below
//! the scene, if the file promises answers there: an app may draw such a ground. Every point that the sun can
//! shine on is compared. The points that are not compared are counted: faces turned away from the sun, points
//! inside solids, which cannot be seen, and points outside the file's bounds. Each compared point has a
//! [`Class`], which depends on rays alone:
//!
//! - The *neighbours* of a point are eight at one texel and eight at two texels in the light's plane, and the
//!   centre of its texel, which look-ups sample. They are moved along the light onto the point's tangent
//!   plane (for points in space, to the point's depth), and lifted in the same way. In a world-aligned file,
//!   which samples no centres, a texel is the side of a voxel, and its centre is one more neighbour.
//! - *Acne*: a lit point answered as shadowed. *Leak*: a shadowed point answered as lit. *Misplaced*: a wrong
//!   answer that a ray from the centre of the point's texel does not give either, so the resolution of the
//!   grid does not explain it.
//! - With a filter of K × K texels, the file's value is compared with the mean of K × K rays, one from the
//!   centre of each tap, on the receiver's plane. The taps count as neighbours.
//!
//! [`Promises`] states what a file promises for each class.

mod answers;
mod classes;
mod points;
mod sample;

use std::sync::atomic::{AtomicBool, Ordering};

use adumbra_scene::random::Random;
use adumbra_scene::{Scene, topology};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use answers::{Answers, Below, LightAnswers, Replaced};
pub use classes::{Class, ClassResult, MIN_CHECKED_POINTS, Promises};
pub use points::{GroundSampler, Sample, Solids, SurfaceSampler, VolumeSampler};

use crate::trace::Tracer;
use adumbra::query::receiver;
use classes::{ClassCounts, DIFFERENCE_STEPS};
use sample::TracedSample;

/// Options of a verification.
#[derive(Clone, Copy, Debug)]
pub struct VerifyOptions {
    /// Number of points to draw.
    pub samples: u64,
    /// Seed of the random points.
    pub seed: u64,
}

/// Result of a verification; shares are fractions of the samples, 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verification {
    /// Number of points compared.
    pub samples: u64,
    /// Number of points drawn that face away from the sun; not compared.
    pub facing_away: u64,
    /// Number of points drawn inside solids, which cannot be seen and where the file may answer either way;
    /// not compared.
    pub inside_solids: u64,
    /// Number of points drawn outside the bounds given to the bake; not compared.
    pub outside_bounds: u64,
    /// Share of the samples that are shadowed according to rays.
    pub shadowed_share: f64,
    /// One minus the mean difference from the rays; without a filter, the share of correct answers.
    pub agreement: f64,
    /// `agreement` of [`Class::Interior`] alone; 1 if it has no points.
    pub interior_agreement: f64,
    /// Share of the samples that are [`Class::Interior`].
    pub interior_share: f64,
    /// Share of the samples whose answer is darker than the rays' value by more than half.
    pub acne: f64,
    /// Share of the samples whose answer is lighter than the rays' value by more than half.
    pub leak: f64,
    /// Results of all classes, in the order of [`Class::ALL`].
    pub classes: Vec<ClassResult>,
}

impl Verification {
    /// The result of one class.
    pub fn class(&self, class: Class) -> &ClassResult {
        let place = Class::ALL.iter().position(|c| *c == class).unwrap_or_default();
        &self.classes[place]
    }

    /// Whether there are enough points to check the file: in [`Class::Interior`], or under a low sun in
    /// [`Class::Grazing`].
    pub fn is_checked(&self) -> bool {
        [Class::Interior, Class::Grazing].iter().any(|class| self.class(*class).checked)
    }

    /// Whether the file is checked and every class keeps its promises.
    pub fn holds(&self) -> bool {
        self.is_checked() && self.classes.iter().all(|c| c.holds)
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

/// Distances from a point to its inner and outer neighbours, texels.
const NEIGHBOUR_TEXELS: [f64; 2] = [1.0, 2.0];
/// Points with n·l at most this are close to the terminator, and form a separate class.
pub const MIN_N_DOT_L: f64 = 0.1;
/// Points per batch. Each batch has its own random numbers, so the result does not depend on the threads.
const BATCH: u64 = 4096;
/// Number of points on surfaces, or in space, for each point on ground just below the scene.
pub const SURFACE_POINTS_PER_GROUND_POINT: u64 = 8;

/// Returns the approximate peak memory of a comparison in bytes, in addition to the scene and the file: the
/// tracer, the solids, the sampler, and the memory to build them.
pub fn building_bytes(scene: &Scene) -> u64 {
    let topology = scene.meshes.iter().map(topology::working_bytes).max().unwrap_or_default();
    let stored: u64 = scene.meshes.iter().map(|mesh| mesh.triangles.len() as u64).sum();
    Tracer::building_bytes(scene).max(Tracer::kept_bytes(scene) + topology + stored * SAMPLER_BYTES)
}

/// Bytes of the solids and the sampler for each stored triangle, while the sums of areas grow.
const SAMPLER_BYTES: u64 = 1 + 24;

/// Compares one file with one scene.
pub struct Verifier<'a, A> {
    answers: &'a A,
    tracer: &'a Tracer<'a>,
    solids: &'a Solids,
    ground: Option<GroundSampler>,
    promises: Promises,
    cancel: Option<&'a AtomicBool>,
}

impl<'a, A: Answers> Verifier<'a, A> {
    /// Prepares a comparison of `answers` with rays of `tracer`. Both `tracer` and `solids` must be built
    /// from the scene that was baked.
    pub fn new(answers: &'a A, tracer: &'a Tracer<'a>, solids: &'a Solids) -> Self {
        let promises = Promises { ground: None, ..answers.promises() };
        Self { answers, tracer, solids, ground: None, promises, cancel: None }
    }

    /// Stops the comparison within a batch of 4096 points of each thread once `cancel` is set. The result is
    /// then that of the points so far.
    #[must_use]
    pub fn with_cancel(self, cancel: &'a AtomicBool) -> Self {
        Self { cancel: Some(cancel), ..self }
    }

    /// Compares points on ground just below the scene too, one for every [`SURFACE_POINTS_PER_GROUND_POINT`]
    /// others, if the file promises answers there.
    #[must_use]
    pub fn with_ground(self) -> Self {
        let ground = self.answers.below().map(|below| GroundSampler::new(self.tracer.scene(), below));
        let promised = self.answers.promises().ground.filter(|_| ground.is_some());
        Self { ground, promises: Promises { ground: promised, ..self.promises }, ..self }
    }

    /// Replaces the least agreement required of the interior.
    #[must_use]
    pub fn with_interior_promise(self, least_agreement: f64) -> Self {
        Self { promises: Promises { interior: least_agreement, ..self.promises }, ..self }
    }

    /// Draws the points and compares them. Runs on the current rayon pool. Cost: about 20 rays per point, and
    /// one more per tap of a filter.
    pub fn run(&self, sampler: &Sampler<'_>, options: &VerifyOptions) -> Verification {
        let counts = self.count(options.seed, options.samples, |random, counts| {
            let sample = match sampler {
                Sampler::Surface(s) => s.sample(random),
                Sampler::Volume(s) => s.sample(random),
            };
            self.compare(&sample, None, counts);
        });
        let ground_points =
            self.ground.as_ref().map_or(0, |_| options.samples / SURFACE_POINTS_PER_GROUND_POINT);
        let on_ground = self.count(options.seed, ground_points, |random, counts| {
            if let Some(ground) = &self.ground {
                self.compare(&ground.sample(random), Some(ground.thickness_voxels()), counts);
            }
        });
        counts.add(&on_ground).finish(&self.promises)
    }

    /// Counts points in batches.
    fn count(&self, seed: u64, points: u64, one: impl Fn(&mut Random, &mut Counts) + Sync) -> Counts {
        let of_batch = |batch: u64| {
            let mut random = Random::for_batch(seed, batch);
            let mut counts = Counts::default();
            if self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
                return counts;
            }
            (0..BATCH.min(points - batch * BATCH)).for_each(|_| one(&mut random, &mut counts));
            counts
        };
        let batches = (0..points.div_ceil(BATCH)).into_par_iter();
        batches.map(of_batch).reduce(Counts::default, |one, other| one.add(&other))
    }

    /// `thickness_voxels` is that of [`Below`], for points on ground below the scene.
    fn compare(&self, sample: &Sample, thickness_voxels: Option<f64>, c: &mut Counts) {
        let answers = self.answers;
        if sample.normal.is_some_and(|n| !(adumbra::grid::vec3::dot(n, answers.towards_sun()) > 0.0)) {
            c.facing_away += 1;
            return;
        }
        let grid = answers.grid_at(sample.p_world, sample.normal);
        let sample = TracedSample {
            grid,
            tracer: self.tracer,
            solids: self.solids,
            p_world: sample.p_world,
            normal: sample.normal,
            receiver: receiver(&grid, &answers.bias(), sample.p_world, sample.normal),
            thickness_voxels,
        };
        if !answers.covers(grid.to_world(sample.receiver.p_grid)) {
            c.outside_bounds += 1;
            return;
        }
        if answers.insides_are_free() && sample.is_inside_solid() {
            c.inside_solids += 1;
            return;
        }
        let truth = sample.truth();
        c.shadowed += u64::from(!truth);
        let value = f64::from(answers.visibility(sample.p_world, sample.normal));
        let taps = answers.taps(&sample.receiver);
        let own = f64::from(u8::from(truth));
        let expected = if taps.is_empty() { own } else { sample.mean_lit(&taps) };
        let class = match sample.class(truth, &answers.baked_bias()) {
            // The taps of a filter count as neighbours too.
            Class::Interior | Class::Grazing if expected != own => Class::Edge,
            Class::Interior | Class::Grazing if thickness_voxels.is_some() => Class::Ground,
            class => class,
        };
        // A value outside 0 to 1 is wrong, whatever the rays say.
        let value = if (0.0..=1.0).contains(&value) { value } else { 1.0 - own };
        // A tree's filter has no taps to compare with, so its value is thresholded at one half.
        let value = if taps.is_empty() { f64::from(u8::from(value > 0.5)) } else { value };
        let counts = &mut c.classes[Class::ALL.iter().position(|a| *a == class).unwrap_or_default()];
        counts.points += 1;
        counts.difference_steps += ((value - expected).abs() * DIFFERENCE_STEPS).round() as u64;
        counts.acne += u64::from(value < expected - 0.5);
        counts.leak += u64::from(value > expected + 0.5);
        if taps.is_empty() && (value - expected).abs() > 0.5 {
            counts.misplaced += u64::from(!sample.is_answer_of_its_texel(value > 0.5));
        }
    }
}

/// The source of the random points.
pub enum Sampler<'s> {
    /// Points on surfaces.
    Surface(SurfaceSampler<'s>),
    /// Points in the volume of the grid.
    Volume(VolumeSampler),
}

impl Counts {
    fn add(mut self, o: &Self) -> Self {
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
