//! The sun's arcs, traced from points.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use adumbra::grid::vec3::dot;
use adumbra_bake::{Progress, Watch};
use adumbra_solar::{ARC_STEP_SECONDS, SunArc};
use adumbra_truth::trace::{Cover, Fan, Tracer};
use rayon::prelude::*;

use super::spans::Hours;
use crate::error::{Error, Result};
use crate::points::{Facing, Receiver};

/// Number of points that one thread takes at a time.
const BLOCK: usize = 1024;
/// Longest time of a fan, seconds: shorter ones take more traversals, longer ones wider ones.
const FAN_SECONDS: f64 = 1920.0;
/// Time between looks at alpha masks, seconds.
const MASK_SECONDS: f64 = 1.0;

/// The suns of a day, or of several, that are traced from points.
#[derive(Clone, Debug)]
pub struct Suns {
    parts: Vec<Part>,
}

impl Suns {
    /// Takes the arcs of a sun, see [`sun_arcs`](adumbra_solar::sun_arcs), in the order of their times.
    pub fn new(arcs: &[SunArc]) -> Self {
        let chords = (FAN_SECONDS / ARC_STEP_SECONDS) as usize;
        let mask_step = MASK_SECONDS / ARC_STEP_SECONDS;
        let parts = arcs.iter().flat_map(|arc| {
            let last = arc.times.len().saturating_sub(1);
            (0..last).step_by(chords).map(move |begin| {
                let knots = begin..(begin + chords).min(last) + 1;
                let fan = Fan::new(arc.towards[knots.clone()].to_vec(), mask_step);
                Part { times: arc.times[knots].to_vec(), fan }
            })
        });
        Self { parts: parts.collect() }
    }

    /// Time for which the sun is up, in seconds.
    pub fn seconds(&self) -> f64 {
        self.parts.iter().map(|part| part.time(part.chords() as f64) - part.times[0]).sum()
    }

    /// Finds for each point the spans of time in which it sees the centre of the sun, to a tenth of a
    /// second, on the current rayon pool. Progress counts blocks of points. Cost: a fan of rays for each
    /// half hour.
    ///
    /// # Errors
    /// Returns [`Error::Interrupted`] if `watch` asks for it.
    pub fn hours(&self, tracer: &Tracer<'_>, receivers: &[Receiver], watch: Watch<'_>) -> Result<Hours> {
        let total = receivers.len().div_ceil(BLOCK);
        let (done, bytes) = (AtomicUsize::new(0), AtomicU64::new(0));
        let block = |points: &[Receiver]| {
            let mut room = Room::default();
            let mut hours = Hours::default();
            for point in points {
                if watch.cancel.load(Ordering::Relaxed) {
                    return Err(Error::Interrupted);
                }
                self.parts.iter().for_each(|part| part.trace(tracer, point, &mut room));
                hours.push(room.lit.drain(..));
            }
            (watch.progress)(Progress {
                done: done.fetch_add(1, Ordering::Relaxed) + 1,
                total,
                texels_per_unit: BLOCK as u64,
                result_bytes: bytes.fetch_add(hours.bytes(), Ordering::Relaxed) + hours.bytes(),
            });
            Ok(hours)
        };
        let blocks = receivers.par_chunks(BLOCK).map(block).collect::<Result<Vec<_>>>()?;
        let mut all = Hours::default();
        blocks.iter().for_each(|block| all.append(block));
        Ok(all)
    }
}

/// Space that is used again for each point.
#[derive(Default)]
struct Room {
    cover: Cover,
    lit: Vec<[f64; 2]>,
}

/// Part of an arc.
#[derive(Clone, Debug)]
struct Part {
    /// Times of the fan's knots.
    times: Vec<f64>,
    fan: Fan,
}

impl Part {
    fn trace(&self, tracer: &Tracer<'_>, point: &Receiver, room: &mut Room) {
        let sides: &[f64] = if matches!(point.facing, Facing::Both(_)) { &[1.0, -1.0] } else { &[1.0] };
        let first = room.lit.len();
        for &side in sides {
            room.cover.clear();
            if point.normal().is_some_and(|normal| self.hide_back(normal, side, &mut room.cover)) {
                continue;
            }
            tracer.hide(point.origin(side), &self.fan, &mut room.cover);
            let mut begin = 0.0;
            for &[hidden, end] in room.cover.spans() {
                if begin < hidden {
                    room.lit.push([self.time(begin), self.time(hidden)]);
                }
                begin = end;
            }
            if begin < self.chords() as f64 {
                room.lit.push([self.time(begin), self.time(self.chords() as f64)]);
            }
        }
        if sides.len() > 1 {
            room.lit[first..].sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        }
    }

    /// Hides where the sun is behind a surface, seen from its front (side 1) or its back (side -1). Returns
    /// whether that is everywhere.
    fn hide_back(&self, normal: [f64; 3], side: f64, cover: &mut Cover) -> bool {
        let cosine = |knot: [f64; 3]| side * dot(normal, knot);
        let knots = self.fan.knots();
        let slack = self.fan.bend() * (normal[0].abs() + normal[1].abs() + normal[2].abs()) + 1e-12;
        let ends = [cosine(knots[0]), cosine(knots[self.chords()])];
        if ends.iter().all(|&cosine| cosine < -slack) {
            return true;
        }
        if ends.iter().all(|&cosine| cosine > slack) {
            return false;
        }
        for (chord, pair) in knots.windows(2).enumerate() {
            let pair = [cosine(pair[0]), cosine(pair[1])];
            let start = chord as f64;
            let crossing = start + pair[0] / (pair[0] - pair[1]);
            match (pair[0] > 0.0, pair[1] > 0.0) {
                (true, true) => {}
                (true, false) => cover.add([crossing, start + 1.0]),
                (false, true) => cover.add([start, crossing]),
                (false, false) => cover.add([start, start + 1.0]),
            }
        }
        false
    }

    fn chords(&self) -> usize {
        self.times.len() - 1
    }

    /// The time of a place along the chords.
    fn time(&self, place: f64) -> f64 {
        let chord = (place as usize).min(self.chords() - 1);
        let u = place - chord as f64;
        self.times[chord] + u * (self.times[chord + 1] - self.times[chord])
    }
}

#[cfg(test)]
mod tests;
