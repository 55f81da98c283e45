//! A day of suns, traced from points.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use adumbra::grid::vec3::dot;
use adumbra_bake::{Progress, Watch};
use adumbra_solar::SunStep;
use adumbra_truth::trace::Tracer;
use rayon::prelude::*;

use super::spans::{Block, Hours};
use crate::error::{Error, Result};
use crate::points::Receiver;

/// Number of points that one thread takes at a time.
const BLOCK: usize = 1024;

/// How a day is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DayOptions {
    /// Angle between key suns, degrees, 0 to 180. With 0 every step is a key, and nothing can be missed.
    pub key_degrees: f64,
}

impl Default for DayOptions {
    /// Keys 2° apart, about 8 minutes.
    fn default() -> Self {
        Self { key_degrees: 2.0 }
    }
}

/// The suns of a day, and marks for the key suns.
#[derive(Clone, Debug)]
pub struct SunDay {
    /// Times of the steps, and of the end of the last, seconds after 1970.
    times: Vec<f64>,
    /// Unit vectors towards the suns of the steps; zero below the horizon.
    towards: Vec<[f64; 3]>,
    /// Ranges of steps whose suns are above the horizon.
    up: Vec<Range<u32>>,
    is_key: Vec<bool>,
}

impl SunDay {
    /// Prepares the suns of a day. Each step lasts until the next one, so the last step is only an end.
    ///
    /// # Errors
    /// Returns [`Error::NoSpan`] if there are fewer than two steps or if their times do not ascend, and
    /// [`Error::Range`] if the angle between keys is out of range.
    pub fn new(steps: &[SunStep], options: DayOptions) -> Result<Self> {
        let key_degrees = options.key_degrees;
        if !(0.0..=180.0).contains(&key_degrees) {
            let expected = "0 to 180 degrees";
            return Err(Error::Range { field: "angle between key suns", value: key_degrees, expected });
        }
        let ascending = steps.windows(2).all(|w| w[0].unix_seconds < w[1].unix_seconds);
        let Some((_, lasting)) = steps.split_last().filter(|(_, rest)| !rest.is_empty() && ascending) else {
            return Err(Error::NoSpan { steps: steps.len() });
        };
        let towards: Vec<[f64; 3]> =
            lasting.iter().map(|step| step.sun.map_or([0.0; 3], |sun| sun.towards())).collect();
        let up = runs(0..lasting.len() as u32, |step| i8::from(lasting[step as usize].sun.is_some()));
        let is_key = keys(&towards, key_degrees);
        let times = steps.iter().map(|step| step.unix_seconds).collect();
        Ok(Self { times, towards, up: up.map(|(run, _)| run).collect(), is_key })
    }

    /// Number of steps, whether their suns are up or not.
    pub fn len(&self) -> usize {
        self.towards.len()
    }

    /// Whether there is no step. Always false.
    pub fn is_empty(&self) -> bool {
        self.towards.is_empty()
    }

    /// Time for which the sun is above the horizon, in seconds.
    pub fn sun_seconds(&self) -> f64 {
        self.up.iter().map(|run| self.times[run.end as usize] - self.times[run.start as usize]).sum()
    }

    /// Finds for each point the steps at which it sees the sun, on the current rayon pool. Progress counts
    /// blocks of points. Cost: for a day of ten hours by the minute, 40 to 90 rays a point, some 0.4 µs each.
    ///
    /// # Errors
    /// Returns [`Error::Interrupted`] if `watch` asks for it.
    pub fn hours(&self, tracer: &Tracer<'_>, receivers: &[Receiver], watch: Watch<'_>) -> Result<Hours> {
        let total = receivers.len().div_ceil(BLOCK);
        let (done, bytes) = (AtomicUsize::new(0), AtomicU64::new(0));
        let block = |points: &[Receiver]| {
            if watch.cancel.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            let mut block = Block::default();
            points.iter().for_each(|point| self.trace(tracer, point, &mut block));
            let size = 4 * (block.edges.len() + block.counts.len()) as u64;
            (watch.progress)(Progress {
                done: done.fetch_add(1, Ordering::Relaxed) + 1,
                total,
                texels_per_unit: BLOCK as u64,
                result_bytes: bytes.fetch_add(size, Ordering::Relaxed) + size,
            });
            Ok(block)
        };
        let blocks = receivers.par_chunks(BLOCK).map(block).collect::<Result<Vec<_>>>()?;
        Ok(Hours::new(self.times.clone(), &blocks))
    }

    /// Adds the spans of a point to a block.
    fn trace(&self, tracer: &Tracer<'_>, point: &Receiver, block: &mut Block) {
        let first = block.edges.len();
        for up in &self.up {
            for (run, side) in runs(up.clone(), |step| point.side(self.towards[step as usize])) {
                let origin = point.origin(side);
                let mut rays = 0;
                let mut lit = |step: u32| {
                    rays += 1;
                    tracer.sun_visible(origin, self.towards[step as usize])
                };
                self.trace_run(run, &mut lit, |span| block.push(first, span));
                block.rays += rays;
            }
        }
        block.counts.push((block.edges.len() - first) as u32);
    }

    /// Finds the spans of a run of steps in which `lit` holds. Its ends are keys too.
    fn trace_run(&self, run: Range<u32>, lit: &mut impl FnMut(u32) -> bool, mut push: impl FnMut([u32; 2])) {
        let last = run.end - 1;
        let (mut key, mut is_lit, mut began) = (run.start, lit(run.start), run.start);
        for next in run.start + 1..run.end {
            if !self.is_key[next as usize] && next != last {
                continue;
            }
            let next_is_lit = lit(next);
            if next_is_lit != is_lit {
                let change = bisect(key, next, |step| lit(step) == is_lit);
                if is_lit {
                    push([began, change]);
                }
                (is_lit, began) = (next_is_lit, change);
            }
            key = next;
        }
        if is_lit {
            push([began, run.end]);
        }
    }
}

/// Returns the first step after `low` that is not `alike`. `high` must not be `alike`.
fn bisect(mut low: u32, mut high: u32, mut alike: impl FnMut(u32) -> bool) -> u32 {
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if alike(middle) { low = middle } else { high = middle }
    }
    high
}

/// The runs of steps with the same side, without runs of side 0.
fn runs(steps: Range<u32>, side: impl Fn(u32) -> i8) -> impl Iterator<Item = (Range<u32>, i8)> {
    let mut from = steps.start;
    std::iter::from_fn(move || {
        while from < steps.end {
            let (start, of) = (from, side(from));
            from += 1;
            while from < steps.end && side(from) == of {
                from += 1;
            }
            if of != 0 {
                return Some((start..from, of));
            }
        }
        None
    })
}

/// Marks the key suns: the last sun before each that is farther than `degrees` from the previous key.
fn keys(towards: &[[f64; 3]], degrees: f64) -> Vec<bool> {
    let least_cosine = libm::cos(degrees.to_radians());
    let mut is_key = vec![degrees == 0.0; towards.len()];
    let mut key = 0;
    for next in 1..towards.len() {
        if dot(towards[key], towards[next]) < least_cosine && next - 1 > key {
            key = next - 1;
        }
        is_key[key] = true;
    }
    is_key
}

#[cfg(test)]
mod tests;
