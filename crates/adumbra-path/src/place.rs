//! Places key suns along a path: as far apart as the error half way between two of them allows.

use adumbra::{Filter, PointVisibility, ShadowFile};
use adumbra::{PathSampler, SunStep};
use rayon::prelude::*;

use crate::error::Result;
use crate::options::PathOptions;
use crate::visible::VisiblePoint;

/// The largest angle between two keys, even if the error is small.
const MAX_APART_DEGREES: f64 = 16.0;
/// The smallest angle, even if the error is large. With large voxels, even a short march may be worse than a
/// file of that very sun by more than the allowed error.
const MIN_APART_DEGREES: f64 = 1.0;
/// The first distance that is tried.
const FIRST_APART_DEGREES: f64 = 4.0;
/// Largest number of bakes for a key.
const MOST_TRIES: u32 = 6;
/// The share of the allowed error to aim at, so that most gaps are good at the first try.
const AIM: f64 = 0.7;

/// Errors half way between two keys, in percent of the visible points that face the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapError {
    /// The step half way, by its index.
    pub middle: usize,
    /// Points whose answer between the keys differs from the rays.
    pub wrong_percent: f64,
    /// Points whose answer in a file of that very sun differs from the rays: the mean of both keys.
    pub own_percent: f64,
}

impl GapError {
    fn excess(&self) -> f64 {
        self.wrong_percent - self.own_percent
    }
}

/// The inputs for placing keys.
pub(crate) trait Probe: Sync {
    /// Bakes a key.
    fn bake(&self, towards_sun: [f64; 3]) -> Result<ShadowFile>;

    /// Returns the points that face a sun, each with whether rays find it lit.
    fn seen(&self, towards_sun: [f64; 3]) -> Vec<(VisiblePoint, bool)>;
}

/// A step that is, or may become, a key.
pub(crate) struct Candidate {
    pub(crate) step: usize,
    pub(crate) file: ShadowFile,
    own_percent: f64,
}

/// Places keys.
pub(crate) struct Placer<'a> {
    pub(crate) probe: &'a dyn Probe,
    pub(crate) steps: &'a [SunStep],
    pub(crate) options: &'a PathOptions,
}

impl Placer<'_> {
    /// Places keys from one step to another, both included. Calls `placed` with each key and the error of the
    /// gap before it.
    pub(crate) fn place(
        &self,
        [first, last]: [usize; 2],
        mut placed: impl FnMut(&Candidate, Option<GapError>) -> Result<()>,
    ) -> Result<()> {
        let mut key = self.candidate(first)?;
        placed(&key, None)?;
        let mut guess = steps_within(self.steps, first, last, FIRST_APART_DEGREES);
        while key.step < last {
            let (next, gap) = self.next_key(&key, last, guess)?;
            let steps = next.step - key.step;
            guess = if self.is_allowed(gap) { self.better_gap(steps, gap) } else { steps };
            placed(&next, gap)?;
            key = next;
        }
        Ok(())
    }

    /// Returns the key after `key`, and the error of the gap between them. If even the shortest gap exceeds
    /// the allowed error, the result is the longest gap whose error exceeds the shortest gap's by at most the
    /// allowed error.
    fn next_key(&self, key: &Candidate, last: usize, guess: usize) -> Result<(Candidate, Option<GapError>)> {
        let [nearest, farthest] = [MIN_APART_DEGREES, MAX_APART_DEGREES]
            .map(|degrees| steps_within(self.steps, key.step, last, degrees));
        let mut good: Option<(Candidate, Option<GapError>)> = None;
        let mut too_long: Vec<(Candidate, Option<GapError>)> = Vec::new();
        let mut gap = guess.clamp(nearest, farthest);
        let mut tries = 0;
        loop {
            tries += 1;
            let candidate = self.candidate(key.step + gap)?;
            let error = self.error(key, &candidate);
            let better = self.better_gap(gap, error).clamp(nearest, farthest);
            if self.is_allowed(error) {
                // Another bake is not worth it for a gap less than a third longer.
                if tries >= MOST_TRIES || 3 * better < 4 * gap {
                    return Ok((candidate, error));
                }
                good = Some((candidate, error));
                gap = better;
            } else if let Some(good) = good {
                return Ok(good);
            } else if gap == nearest {
                return self.longest_as_good(key, (candidate, error), too_long, farthest);
            } else {
                too_long.push((candidate, error));
                gap = if tries >= MOST_TRIES { nearest } else { better.min(gap - 1) };
            }
        }
    }

    /// Returns the longest gap whose error exceeds that of the shortest gap, which has too many errors, by at
    /// most the allowed error. Chooses among the gaps that were tried. If none was tried, it tries twice the
    /// shortest gap, and so on.
    fn longest_as_good(
        &self,
        key: &Candidate,
        shortest: (Candidate, Option<GapError>),
        tried: Vec<(Candidate, Option<GapError>)>,
        farthest: usize,
    ) -> Result<(Candidate, Option<GapError>)> {
        let excess = |error: Option<GapError>| error.map_or(0.0, |error| error.excess());
        let enough = excess(shortest.1) + self.options.error_percent;
        if !tried.is_empty() {
            let longest = tried.into_iter().find(|(_, error)| excess(*error) <= enough);
            return Ok(longest.unwrap_or(shortest));
        }
        let mut longest = shortest;
        loop {
            let gap = 2 * (longest.0.step - key.step);
            if gap > farthest {
                return Ok(longest);
            }
            let candidate = self.candidate(key.step + gap)?;
            let error = self.error(key, &candidate);
            if excess(error) > enough {
                return Ok(longest);
            }
            longest = (candidate, error);
        }
    }

    fn is_allowed(&self, error: Option<GapError>) -> bool {
        error.is_none_or(|error| error.excess() <= self.options.error_percent)
    }

    /// Returns the gap that should have the allowed error. Errors grow with the square of the gap.
    fn better_gap(&self, gap: usize, error: Option<GapError>) -> usize {
        let excess = error.map_or(0.0, |error| error.excess().max(0.0));
        let ratio = (AIM * self.options.error_percent / excess.max(1e-9)).sqrt().clamp(0.4, 2.0);
        ((gap as f64 * ratio) as usize).max(1)
    }

    /// Returns the error half way between two steps; `None` if there is no step between them.
    fn error(&self, a: &Candidate, b: &Candidate) -> Option<GapError> {
        if b.step - a.step < 2 {
            return None;
        }
        let middle = a.step.midpoint(b.step);
        let towards_sun = self.steps[middle].towards_sun;
        // Use the order that `SunPath::keys_at` returns half way.
        let is_higher = |one: &Candidate, other: &Candidate| {
            self.steps[one.step].towards_sun[1] >= self.steps[other.step].towards_sun[1]
        };
        let files = if is_higher(a, b) { [&a.file, &b.file] } else { [&b.file, &a.file] };
        let wrong = match PathSampler::new(files, towards_sun, Filter::Nearest) {
            Some(sampler) => {
                let sampler = if self.options.quick { sampler.quick() } else { sampler };
                wrong_percent(&self.probe.seen(towards_sun), &sampler)
            }
            None => 100.0,
        };
        let own_percent = 0.5 * (a.own_percent + b.own_percent);
        Some(GapError { middle, wrong_percent: wrong, own_percent })
    }

    fn candidate(&self, step: usize) -> Result<Candidate> {
        let towards_sun = self.steps[step].towards_sun;
        let file = self.probe.bake(towards_sun)?;
        let own_percent = wrong_percent(&self.probe.seen(towards_sun), &file.sampler(Filter::Nearest));
        Ok(Candidate { step, file, own_percent })
    }
}

/// Returns the number of steps after step `first` for which the sun stays within an angle of it, at least 1,
/// and not beyond `last`.
pub(crate) fn steps_within(steps: &[SunStep], first: usize, last: usize, degrees: f64) -> usize {
    let from = steps[first].towards_sun;
    let cosine = degrees.to_radians().cos();
    let is_within = |step: &SunStep| {
        let to = step.towards_sun;
        from[0] * to[0] + from[1] * to[1] + from[2] * to[2] >= cosine
    };
    let within = steps[first + 1..=last].iter().take_while(|step| is_within(step)).count();
    within.clamp(1, (last - first).max(1))
}

/// Returns the share of points, in percent, whose answer differs from the rays.
pub(crate) fn wrong_percent(seen: &[(VisiblePoint, bool)], answers: &dyn PointVisibility) -> f64 {
    if seen.is_empty() {
        return 0.0;
    }
    let is_wrong = |(point, lit): &&(VisiblePoint, bool)| {
        (answers.visibility(point.p_world, Some(point.normal)) > 0.5) != *lit
    };
    100.0 * seen.par_iter().filter(is_wrong).count() as f64 / seen.len() as f64
}
