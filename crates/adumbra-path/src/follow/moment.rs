//! Answers for a moving sun.

use std::sync::Arc;

use adumbra::query::MarchSlope;
use adumbra::{Filter, PathSampler, ShadowFile};

/// The answer for a sun.
#[derive(Clone, Debug)]
pub enum Followed {
    /// The sun is at or below the horizon: every point is in shadow.
    Night,
    /// No key is available yet. This happens only at the beginning.
    Waiting,
    /// Two keys answer.
    Moment(FollowedMoment),
}

/// Two keys, and the sun that they answer for.
#[derive(Clone, Debug)]
pub struct FollowedMoment {
    /// The key to march in first, and the other key. Both may be the same.
    pub keys: [Arc<ShadowFile>; 2],
    /// Unit vector towards the sun for which they answer: the frame's sun, or the first key's while the sun
    /// has jumped too far away for a march.
    pub towards_sun: [f64; 3],
    /// How often the keys have changed: anything derived from them stays valid while this is the same.
    pub changes: u64,
    /// How many times coarser than requested the coarser key is: 1 or 8.
    pub coarser: u64,
}

impl FollowedMoment {
    /// Returns look-ups with this filter.
    pub fn sampler(&self, filter: Filter) -> PathSampler {
        let keys = self.keys.each_ref().map(|key| &**key);
        let own = || PathSampler::new([keys[0]; 2], keys[0].sun().towards(), filter);
        let sampler = PathSampler::new(keys, self.towards_sun, filter).or_else(own);
        sampler.expect("a march along a key's own sun is always possible")
    }
}

/// The keys that were shown last.
#[derive(Default)]
pub(super) struct Shown {
    keys: Option<[Arc<ShadowFile>; 2]>,
    changes: u64,
}

impl Shown {
    /// Returns a moment of these keys.
    pub(super) fn moment(
        &mut self,
        keys: [Arc<ShadowFile>; 2],
        towards_sun: [f64; 3],
        coarser: u64,
    ) -> FollowedMoment {
        let is_same = |shown: &[Arc<ShadowFile>; 2]| {
            Arc::ptr_eq(&shown[0], &keys[0]) && Arc::ptr_eq(&shown[1], &keys[1])
        };
        if !self.keys.as_ref().is_some_and(is_same) {
            self.changes += 1;
            self.keys = Some(keys.clone());
        }
        let is_in_reach = keys.iter().all(|key| MarchSlope::new(&key.grid, towards_sun).is_some());
        let towards_sun = if is_in_reach { towards_sun } else { keys[0].sun().towards() };
        FollowedMoment { keys, towards_sun, changes: self.changes, coarser }
    }
}
