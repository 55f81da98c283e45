//! The keys of a follower: the keys that answer for a sun, and the next key to bake.

use super::motion::{Motion, angle};

/// For each stage of a key, how many times coarser its voxels are than requested.
pub(super) const STAGES: [u64; 2] = [8, 1];
/// The last stage.
const FINEST: usize = STAGES.len() - 1;
/// Largest angle between keys where bakes are slow.
const MOST_APART_DEGREES: f64 = 16.0;
/// A key serves suns at least up to this angle from it.
const LEAST_REACH_DEGREES: f64 = 4.0;
/// A key serves suns up to this many gaps from it.
const REACH_GAPS: f64 = 1.5;
/// A key this near to the sun counts as the sun's own: another bake gains nothing.
const SAME_DEGREES: f64 = 0.1;
/// Time before a sunrise at which the first key is begun, in seconds.
const DAWN_SECONDS: f64 = 60.0;
/// A bake may take this many times the expected time.
const SLACK: f64 = 1.5;
/// Expected time of a stage that has not been baked yet, relative to the stage before it. A bake of a large
/// city takes equally long at any resolution. Otherwise, the first bake of the stage shows its time.
const GROWTH: f64 = 1.5;
/// Keys and bakes that are this many reaches away are dropped.
const FAR_REACHES: f64 = 2.5;

/// A key: a sun, and its baked file.
#[derive(Clone, Debug)]
pub(super) struct Key<F> {
    pub(super) towards: [f64; 3],
    /// Index in [`STAGES`].
    pub(super) stage: usize,
    /// The middle of the baked area.
    pub(super) focus: [f64; 3],
    pub(super) file: F,
}

/// A bake to begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Job {
    pub(super) towards: [f64; 3],
    /// Index in [`STAGES`].
    pub(super) stage: usize,
    /// The middle of the area to bake.
    pub(super) focus: [f64; 3],
}

/// The keys around a sun, and the time of the last bake of each stage.
#[derive(Clone, Debug)]
pub(super) struct Keys<F> {
    keys: Vec<Key<F>>,
    seconds: [f64; STAGES.len()],
    /// Sine of the least elevation of a key.
    lowest: f64,
    /// Where keys are needed.
    focus: [f64; 3],
    /// Distance from a key's focus within which the key is useful; infinite if the whole scene is baked.
    span_world: f64,
}

/// Returns the angle between keys at an elevation, in degrees: about that between keys that are placed by
/// their error.
fn gap_degrees(elevation_degrees: f64) -> f64 {
    const TABLE: [[f64; 2]; 4] = [[10.0, 1.0], [16.0, 2.0], [28.0, 4.0], [40.0, 8.0]];
    let after = TABLE.partition_point(|[elevation, _]| *elevation < elevation_degrees);
    match (after.checked_sub(1).map(|before| TABLE[before]), TABLE.get(after)) {
        (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (elevation_degrees - a[0]) / (b[0] - a[0]),
        (None, _) => TABLE[0][1],
        (Some(last), None) => last[1],
    }
}

impl<F: Clone> Keys<F> {
    /// Starts without keys. No key will be lower than this elevation, and each is useful within `span_world`
    /// of its focus.
    pub(super) fn new(lowest_degrees: f64, span_world: f64) -> Self {
        let seconds = [f64::INFINITY; STAGES.len()];
        let lowest = lowest_degrees.to_radians().sin();
        Self { keys: Vec::new(), seconds, lowest, focus: [0.0; 3], span_world }
    }

    /// Sets the place where keys are needed.
    pub(super) fn set_focus(&mut self, focus: [f64; 3]) {
        self.focus = focus;
    }

    /// Whether a key with this focus is useful at the place where keys are needed.
    fn is_here(&self, focus: [f64; 3]) -> bool {
        let [x, _, z] = std::array::from_fn(|a| focus[a] - self.focus[a]);
        x.hypot(z) <= self.span_world
    }

    /// Adds a key whose bake took `seconds`.
    pub(super) fn insert(&mut self, key: Key<F>, seconds: f64) {
        self.seconds[key.stage] = seconds;
        self.keys.retain(|old| angle(old.towards, key.towards) > 1e-9);
        self.keys.push(key);
    }

    /// Drops keys that the sun has left behind. Keeps the key before the sun, two keys ahead of it, and
    /// always the nearest key.
    pub(super) fn tidy(&mut self, sun: [f64; 3], motion: &Motion) {
        let here = self.keys.iter().filter(|key| self.is_here(key.focus));
        let mut ahead: Vec<f64> = here.map(|key| motion.along(sun, key.towards)).collect();
        ahead.retain(|along| *along > 0.0);
        ahead.sort_by(f64::total_cmp);
        let last_ahead = ahead.get(1).or(ahead.last()).copied().unwrap_or(0.0);
        let far = FAR_REACHES * self.reach(sun, motion);
        let [a, b] = self.pair(sun, motion);
        let used = [a, b, self.nearest(sun)];
        let is_next = |key: &Key<F>| {
            let along = motion.along(sun, key.towards);
            self.is_here(key.focus) && along > 0.0 && along <= last_ahead && angle(key.towards, sun) <= far
        };
        let stays: Vec<bool> =
            self.keys.iter().enumerate().map(|(i, key)| used.contains(&Some(i)) || is_next(key)).collect();
        let mut stays = stays.into_iter();
        self.keys.retain(|_| stays.next().unwrap_or(true));
    }

    /// Returns the two keys that answer for a sun: the key to march in first, then the other. `None` if there
    /// are no keys.
    ///
    /// The finer key is first. If both are equally fine, the key with the higher sun is first, unless the
    /// other is more than four times nearer.
    pub(super) fn around(&self, sun: [f64; 3], motion: &Motion) -> Option<[&Key<F>; 2]> {
        let (a, b) = match self.pair(sun, motion).map(|key| key.map(|i| &self.keys[i])).into() {
            (Some(a), Some(b)) => (a, b),
            (Some(key), None) | (None, Some(key)) => (key, key),
            (None, None) => {
                let key = &self.keys[self.nearest(sun)?];
                (key, key)
            }
        };
        let factors = if a.towards[1] >= b.towards[1] { [1.0, 4.0] } else { [4.0, 1.0] };
        let is_nearer = factors[0] * angle(a.towards, sun) <= factors[1] * angle(b.towards, sun);
        let is_first = a.stage > b.stage || (a.stage == b.stage && is_nearer);
        Some(if is_first { [a, b] } else { [b, a] })
    }

    /// Returns the keys before and after the sun: the useful ones here, or any keys if none is useful here.
    fn pair(&self, sun: [f64; 3], motion: &Motion) -> [Option<usize>; 2] {
        let here = [self.behind(sun, motion), self.ahead(sun, motion)];
        if here.iter().any(Option::is_some) {
            return here;
        }
        let anywhere = |is_ahead: bool| self.nearest_of(sun, motion, |_, along| (along > 0.0) == is_ahead);
        [anywhere(false), anywhere(true)]
    }

    /// Returns the most urgent bake for this sun and its motion.
    pub(super) fn next_job(&self, sun: [f64; 3], motion: &Motion) -> Option<Job> {
        let sun = if sun[1] > 0.0 { sun } else { self.dawn(sun, motion)? };
        let (behind, ahead) = (self.behind(sun, motion), self.ahead(sun, motion));
        let Some(now) = behind.or(ahead) else { return Some(self.job(sun, None, 0.0)) };
        let (gap, speed) = (self.gap(sun, motion).to_radians(), motion.speed());
        if speed == 0.0 {
            return self.job_of_a_standing_sun(sun, [behind, ahead], gap);
        }
        // Refining a key that the sun has just passed is worth a bake. Refining one that the sun leaves
        // behind is not.
        let in_use = |key: usize| (0.5 * gap - self.distance(key, sun)) / speed;
        if let Some(job) = behind.and_then(|key| self.refinement(key, in_use(key))) {
            return Some(job);
        }
        let Some(ahead) = ahead else {
            let from = self.keys[now].towards;
            let beyond = gap.max(motion.along(from, sun) + 0.25 * gap);
            return self
                .job_beyond(from, beyond, sun, motion)
                .or_else(|| self.refinement(now, f64::INFINITY));
        };
        let towards = self.keys[ahead].towards;
        // A bake that ends after the sun has passed its key is useless. Bake the key after it.
        let left = motion.along(sun, towards) / speed;
        let is_soon = SLACK * self.expected_seconds(FINEST) <= left;
        if is_soon && let Some(job) = self.refinement(ahead, f64::INFINITY) {
            return Some(job);
        }
        let is_next = |key: &usize| {
            let Key { towards: next, focus, .. } = self.keys[*key];
            motion.along(towards, next) > 0.0 && self.is_here(focus)
        };
        match (0..self.keys.len()).find(is_next) {
            Some(next) => self.refinement(next, f64::INFINITY),
            None => self.job_beyond(towards, gap, sun, motion),
        }
    }

    /// Whether the result of a job would be useful.
    pub(super) fn wants(&self, job: &Job, sun: [f64; 3], motion: &Motion) -> bool {
        let sun = if sun[1] > 0.0 { sun } else { self.dawn(sun, motion).unwrap_or(sun) };
        self.is_here(job.focus) && angle(sun, job.towards) <= FAR_REACHES * self.reach(sun, motion)
    }

    fn job_of_a_standing_sun(&self, sun: [f64; 3], around: [Option<usize>; 2], gap: f64) -> Option<Job> {
        let sun = self.raised(sun);
        if let [Some(a), Some(b)] = around.map(|key| key.map(|key| &self.keys[key])) {
            let is_close = angle(a.towards, b.towards) <= REACH_GAPS * gap;
            if is_close && a.stage == FINEST && b.stage == FINEST {
                return None;
            }
        }
        let is_own = |key: &usize| self.distance(*key, sun) <= SAME_DEGREES.to_radians();
        match around.into_iter().flatten().find(is_own) {
            Some(key) => self.refinement(key, f64::INFINITY),
            None => Some(self.job(sun, None, f64::INFINITY)),
        }
    }

    /// Returns the bake of a key at an angle beyond another one, in radians. `None` if a key is already
    /// there, which happens when the sun sets.
    fn job_beyond(&self, from: [f64; 3], beyond: f64, sun: [f64; 3], motion: &Motion) -> Option<Job> {
        let towards = self.raised(motion.after(from, beyond));
        let here = self.keys.iter().filter(|key| self.is_here(key.focus));
        let is_new =
            here.map(|key| angle(key.towards, towards)).all(|apart| apart > SAME_DEGREES.to_radians());
        // The key is needed when the sun is half way to it, from the key before it or from its present
        // position.
        let begin = motion.along(sun, from).max(0.0);
        let half_way = 0.5 * (begin + motion.along(sun, towards).max(0.0));
        is_new.then(|| self.job(towards, None, half_way / motion.speed()))
    }

    /// Returns the next bake of a key that is not at its finest stage, if it is expected to be done in time.
    fn refinement(&self, key: usize, within_seconds: f64) -> Option<Job> {
        let Key { towards, stage, .. } = self.keys[key];
        if stage == FINEST {
            return None;
        }
        let job = self.job(towards, Some(stage), within_seconds);
        (within_seconds == f64::INFINITY || SLACK * self.expected_seconds(job.stage) <= within_seconds)
            .then_some(job)
    }

    /// Returns the finest bake that is expected to end in time, or else the next one after a stage.
    fn job(&self, towards: [f64; 3], after: Option<usize>, within_seconds: f64) -> Job {
        let least = after.map_or(0, |stage| stage + 1);
        let fits = |stage: &usize| {
            let seconds = self.expected_seconds(*stage);
            seconds.is_finite() && SLACK * seconds <= within_seconds
        };
        let stage = (least..=FINEST).rev().find(fits).unwrap_or(least);
        Job { towards: self.raised(towards), stage, focus: self.focus }
    }

    /// Returns the expected time of a bake: that of the last bake of the stage, or an estimate from a coarser
    /// stage.
    fn expected_seconds(&self, stage: usize) -> f64 {
        let known = (0..=stage).rev().find(|&coarser| self.seconds[coarser].is_finite());
        known.map_or(f64::INFINITY, |known| self.seconds[known] * GROWTH.powi((stage - known) as i32))
    }

    /// Returns the angle between keys here, in degrees. It is larger than desired if bakes are too slow.
    fn gap(&self, sun: [f64; 3], motion: &Motion) -> f64 {
        let wanted = gap_degrees(sun[1].clamp(-1.0, 1.0).asin().to_degrees());
        let bake = self.expected_seconds(FINEST);
        let affordable = if bake.is_finite() { (SLACK * bake * motion.speed()).to_degrees() } else { 0.0 };
        wanted.max(affordable).min(MOST_APART_DEGREES)
    }

    /// Returns the largest angle between a key and a sun that it serves, in radians.
    fn reach(&self, sun: [f64; 3], motion: &Motion) -> f64 {
        (REACH_GAPS * self.gap(sun, motion)).max(LEAST_REACH_DEGREES).to_radians()
    }

    /// Returns the nearest key that the sun has passed, or is at.
    fn behind(&self, sun: [f64; 3], motion: &Motion) -> Option<usize> {
        self.nearest_of(sun, motion, |key, along| along <= 0.0 && self.is_here(key.focus))
    }

    /// Returns the nearest key that the sun has yet to reach.
    fn ahead(&self, sun: [f64; 3], motion: &Motion) -> Option<usize> {
        self.nearest_of(sun, motion, |key, along| along > 0.0 && self.is_here(key.focus))
    }

    fn nearest_of(
        &self,
        sun: [f64; 3],
        motion: &Motion,
        is_there: impl Fn(&Key<F>, f64) -> bool,
    ) -> Option<usize> {
        let reach = self.reach(sun, motion);
        let near = (0..self.keys.len()).filter(|&i| {
            let Key { towards, .. } = self.keys[i];
            is_there(&self.keys[i], motion.along(sun, towards)) && angle(towards, sun) <= reach
        });
        near.min_by(|&i, &j| self.distance(i, sun).total_cmp(&self.distance(j, sun)))
    }

    fn nearest(&self, sun: [f64; 3]) -> Option<usize> {
        (0..self.keys.len()).min_by(|&i, &j| self.distance(i, sun).total_cmp(&self.distance(j, sun)))
    }

    fn distance(&self, key: usize, sun: [f64; 3]) -> f64 {
        angle(self.keys[key].towards, sun)
    }

    /// Returns a direction that is high enough for a key.
    fn raised(&self, towards: [f64; 3]) -> [f64; 3] {
        if towards[1] >= self.lowest {
            return towards;
        }
        let across = towards[0].hypot(towards[2]).max(1e-12);
        let factor = (1.0 - self.lowest * self.lowest).sqrt() / across;
        [towards[0] * factor, self.lowest, towards[2] * factor]
    }

    /// Returns the position at which a sun below the horizon will rise, if it rises soon.
    fn dawn(&self, sun: [f64; 3], motion: &Motion) -> Option<[f64; 3]> {
        let most = (motion.speed() * DAWN_SECONDS).min(MOST_APART_DEGREES.to_radians());
        (1..=64).map(|i| motion.after(sun, most * f64::from(i) / 64.0)).find(|towards| towards[1] > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sun that rises in the east, is 60° high at noon, and sets in the west.
    fn sun(degrees: f64) -> [f64; 3] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [cos, sin * 60f64.to_radians().sin(), sin * 60f64.to_radians().cos()]
    }

    /// Runs the keys for suns given by time, with finest bakes that take `bake_seconds`. Calls `see` with
    /// each frame.
    fn play(
        seconds: f64,
        bake_seconds: f64,
        at: impl Fn(f64) -> f64,
        see: impl FnMut(f64, Option<[&Key<()>; 2]>),
    ) -> Keys<()> {
        walk(0.0, seconds, bake_seconds, at, see)
    }

    /// Does the same as [`play`], with a camera that walks `walk` world units per second. A key is useful
    /// within 100 world units of its focus.
    fn walk(
        walk: f64,
        seconds: f64,
        bake_seconds: f64,
        at: impl Fn(f64) -> f64,
        mut see: impl FnMut(f64, Option<[&Key<()>; 2]>),
    ) -> Keys<()> {
        let mut keys = Keys::new(3.0, 100.0);
        let mut motion = Motion::default();
        let mut running: Option<(Job, f64)> = None;
        for frame in 0..(seconds * 20.0) as usize {
            let now = frame as f64 / 20.0;
            let towards = sun(at(now));
            keys.set_focus([walk * now, 0.0, 0.0]);
            motion.see(now, towards);
            if let Some((job, since)) = running {
                let lasts = bake_seconds / (STAGES[job.stage] as f64).powi(2);
                if now - since >= lasts {
                    let Job { towards, stage, focus } = job;
                    keys.insert(Key { towards, stage, focus, file: () }, lasts);
                    running = None;
                }
            }
            keys.tidy(towards, &motion);
            running = running.or_else(|| keys.next_job(towards, &motion).map(|job| (job, now)));
            see(now, keys.around(towards, &motion));
            assert!(keys.keys.len() <= 4, "{:?}", keys.keys);
        }
        keys
    }

    #[test]
    fn gap_by_elevation_matches_table() {
        for (elevation, gap) in [(-3.0, 1.0), (10.0, 1.0), (13.0, 1.5), (22.0, 3.0), (40.0, 8.0), (90.0, 8.0)]
        {
            assert_eq!(gap_degrees(elevation), gap, "{elevation}");
        }
    }

    #[test]
    fn steady_sun_is_always_between_two_finest_keys() {
        // A day of 48 minutes: 7.5° per minute.
        let at = |seconds: f64| 20.0 + 0.125 * seconds;
        play(1000.0, 4.0, at, |now, around| {
            if now < 0.1 {
                return;
            }
            let [a, b] = around.expect("a key from the beginning on");
            if now > 15.0 {
                assert!(a.stage == FINEST && b.stage == FINEST, "{now}: {a:?} {b:?}");
                let (apart, elevation) =
                    (angle(a.towards, b.towards).to_degrees(), sun(at(now))[1].asin().to_degrees());
                assert!(
                    apart > 0.1 && apart < 1.6 * gap_degrees(elevation + 2.0),
                    "{now}: {apart} at {elevation}"
                );
            }
        });
    }

    #[test]
    fn slow_bakes_space_keys_farther_apart() {
        let at = |seconds: f64| 5.0 + 0.125 * seconds;
        let (mut widest, mut fine, mut frames) = (0f64, 0, 0);
        play(200.0, 20.0, at, |now, around| {
            let Some([a, b]) = around.filter(|_| now > 90.0) else { return };
            assert_eq!(a.stage, FINEST, "{now}: the finer one is asked first");
            fine += u32::from(b.stage == FINEST);
            frames += 1;
            widest = widest.max(angle(a.towards, b.towards).to_degrees());
        });
        assert!(widest > 3.0 && widest < 10.0, "{widest}");
        assert!(4 * fine > 3 * frames, "{fine} of {frames}");
    }

    #[test]
    fn keys_follow_a_walking_camera() {
        let at = |seconds: f64| 50.0 + 0.125 * seconds;
        let (mut far, mut frames) = (0, 0);
        walk(2.0, 240.0, 4.0, at, |now, around| {
            let Some([a, b]) = around else { return assert!(now < 0.1) };
            let distance = |key: &Key<()>| (key.focus[0] - 2.0 * now).abs();
            let away = distance(a).max(distance(b));
            assert!(away < 120.0, "{now}: {away}");
            far += u32::from(away > 100.0);
            frames += 1;
        });
        assert!(50 * far < frames, "{far} of {frames} frames use keys of where the camera was");
    }

    #[test]
    fn jump_gets_a_coarse_key_first_and_then_a_fine_one() {
        let at = |seconds: f64| if seconds < 30.0 { 30.0 } else { 110.0 };
        let mut stages = Vec::new();
        let keys = play(60.0, 4.0, at, |now, around| {
            let Some([a, _]) = around else { return assert!(now < 0.1) };
            let is_here = angle(a.towards, sun(at(now))) < 0.01;
            assert!(is_here || (30.0..30.1).contains(&now), "{now}");
            if now >= 30.1 && stages.last() != Some(&a.stage) {
                stages.push(a.stage);
            }
        });
        assert_eq!(stages, [0, 1], "a bake of four seconds is soon done where nothing hurries");
        assert_eq!(keys.keys.len(), 1);
    }

    #[test]
    fn sun_that_stops_between_two_keys_keeps_both() {
        let at = |seconds: f64| 40.0 + 0.125 * seconds.min(100.0);
        play(140.0, 4.0, at, |now, around| {
            if now > 100.0 {
                let [a, b] = around.unwrap();
                assert!(angle(a.towards, b.towards) > 0.01 && a.stage + b.stage == 2 * FINEST, "{now}");
            }
        });
    }

    #[test]
    fn first_key_is_ready_at_sunrise_and_no_key_is_too_low() {
        let at = |seconds: f64| -10.0 + 0.125 * seconds;
        let keys = play(100.0, 4.0, at, |now, around| {
            assert!(around.is_none() || now > 15.0, "no bake in the night");
            if now > 79.0 {
                let [a, b] = around.expect("a key at sunrise");
                assert!(a.stage == FINEST || b.stage == FINEST);
            }
        });
        assert!(keys.keys.iter().all(|key| key.towards[1] >= 3f64.to_radians().sin() - 1e-12));
        // At night nothing is baked.
        let keys = play(100.0, 4.0, |seconds| 190.0 + 0.125 * seconds, |_, around| assert!(around.is_none()));
        assert!(keys.keys.is_empty());
    }

    #[test]
    fn dragged_sun_always_has_a_key() {
        // Back and forth, faster than any bake but the coarsest.
        let at = |seconds: f64| 90.0 + 60.0 * (0.7 * seconds).sin();
        play(40.0, 4.0, at, |now, around| assert!(around.is_some() || now < 0.1, "{now}"));
    }
}
