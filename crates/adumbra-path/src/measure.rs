//! The error of a path, moment by moment.

use std::sync::Arc;

use adumbra::{Filter, ShadowFile};
use adumbra::{PathSampler, SunPath};
use adumbra_truth::trace::Tracer;

use crate::error::Result;
use crate::place::wrong_percent;
use crate::visible::{VisiblePoint, seen, visible_points};

/// A moment of a path, compared with rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The moment.
    pub seconds: f64,
    /// Elevation of the sun.
    pub elevation_degrees: f64,
    /// Share of the visible points that face the sun whose answer differs from the rays, in percent.
    pub wrong_percent: f64,
    /// Share of wrong answers, in percent, in the files of the keys around, each at its own sun, interpolated
    /// by time.
    pub own_percent: f64,
}

/// The most recently read keys of a path, and their own errors.
struct Keys<'a> {
    path: &'a SunPath,
    read: Vec<(usize, Arc<ShadowFile>, f64)>,
    tracer: &'a Tracer<'a>,
    points: &'a [VisiblePoint],
}

impl Keys<'_> {
    fn get(&mut self, index: usize) -> Result<(Arc<ShadowFile>, f64)> {
        if let Some((_, file, own)) = self.read.iter().find(|(known, ..)| *known == index) {
            return Ok((Arc::clone(file), *own));
        }
        let file = Arc::new(self.path.key(index)?);
        let seen = seen(self.tracer, self.points, file.sun().towards());
        let own = wrong_percent(&seen, &file.sampler(Filter::Nearest));
        // Moments ascend, so only the two keys around are used again.
        if self.read.len() == 2 {
            self.read.remove(0);
        }
        self.read.push((index, Arc::clone(&file), own));
        Ok((file, own))
    }
}

/// Compares a path with rays at these moments, which ascend. Moments at which the path has no sun are
/// skipped.
///
/// Cost: reading each key once, and two rays per point and moment.
///
/// # Errors
/// Returns an error if a key cannot be read.
pub fn measure(
    path: &SunPath,
    tracer: &Tracer<'_>,
    count: usize,
    moments: impl IntoIterator<Item = f64>,
    mut on_moment: impl FnMut(&Moment),
) -> Result<Vec<Moment>> {
    let points = visible_points(tracer, count, 2);
    let mut keys = Keys { path, read: Vec::new(), tracer, points: &points };
    let times = path.key_seconds();
    let mut measured = Vec::new();
    for seconds in moments {
        let (Some(towards_sun), Some([near, far])) = (path.sun_at(seconds), path.keys_at(seconds)) else {
            continue;
        };
        // Get the earlier key first, so that it is not the one to be dropped.
        let (low, high) = (keys.get(near.min(far))?, keys.get(near.max(far))?);
        let (first, second) = if near <= far { (&low, &high) } else { (&high, &low) };
        let seen = seen(tracer, &points, towards_sun);
        let wrong = match PathSampler::new([&*first.0, &*second.0], towards_sun, Filter::Nearest) {
            Some(sampler) => wrong_percent(&seen, &sampler),
            None => 100.0,
        };
        let [from, to] = [times[near.min(far)], times[near.max(far)]];
        let share = if to > from { (seconds - from) / (to - from) } else { 0.0 };
        let moment = Moment {
            seconds,
            elevation_degrees: towards_sun[1].asin().to_degrees(),
            wrong_percent: wrong,
            own_percent: low.1 + share * (high.1 - low.1),
        };
        on_moment(&moment);
        measured.push(moment);
    }
    Ok(measured)
}
