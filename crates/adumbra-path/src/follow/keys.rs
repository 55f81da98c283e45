//! The keys that a follower has: which answer at a sun, and which is to be baked next.

use super::motion::{Motion, angle};

/// How many times coarser the stages of a key are than what was asked for.
pub(super) const STAGES: [u64; 2] = [8, 1];
/// The last stage.
const FINEST: usize = STAGES.len() - 1;
/// How far apart keys may be where bakes are slow.
const MOST_APART_DEGREES: f64 = 16.0;
/// A key serves suns at least so far from it.
const LEAST_REACH_DEGREES: f64 = 4.0;
/// A key serves suns so many gaps from it.
const REACH_GAPS: f64 = 1.5;
/// A key of the sun itself: nothing is gained by another one.
const SAME_DEGREES: f64 = 0.1;
/// How long before it rises a sun's first key is begun, in seconds.
const DAWN_SECONDS: f64 = 60.0;
/// A bake may take so many times as long as is expected.
const SLACK: f64 = 1.5;
/// How many times as long as the stage before it a stage is expected to take that was not baked yet. A bake of a large city takes
/// as long at any resolution; where it does not, the first bake tells.
const GROWTH: f64 = 1.5;
/// Keys that are so many reaches away, or are to be baked there, are given up.
const FAR_REACHES: f64 = 2.5;

/// A key: a sun, and what was baked for it.
#[derive(Clone, Debug)]
pub(super) struct Key<F> {
    pub(super) towards: [f64; 3],
    /// Index in [`STAGES`].
    pub(super) stage: usize,
    /// The middle of what was baked.
    pub(super) focus: [f64; 3],
    pub(super) file: F,
}

/// A bake to begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Job {
    pub(super) towards: [f64; 3],
    /// Index in [`STAGES`].
    pub(super) stage: usize,
    /// The middle of what is to be baked.
    pub(super) focus: [f64; 3],
}

/// The keys around a sun, and how long the bake of each stage took last.
#[derive(Clone, Debug)]
pub(super) struct Keys<F> {
    keys: Vec<Key<F>>,
    seconds: [f64; STAGES.len()],
    /// Sine of the least elevation of a key.
    lowest: f64,
    /// Where keys are needed.
    focus: [f64; 3],
    /// How far from a key's focus it is of use; infinite if all of the scene is baked.
    span_world: f64,
}

/// Returns how far apart keys are at an elevation, in degrees: about as far as keys that were placed by their error.
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
    /// Returns no keys. None will be lower than this elevation, and each is of use so far around its focus.
    pub(super) fn new(lowest_degrees: f64, span_world: f64) -> Self {
        let seconds = [f64::INFINITY; STAGES.len()];
        let lowest = lowest_degrees.to_radians().sin();
        Self { keys: Vec::new(), seconds, lowest, focus: [0.0; 3], span_world }
    }

    /// Says where keys are needed.
    pub(super) fn set_focus(&mut self, focus: [f64; 3]) {
        self.focus = focus;
    }

    /// Whether a key is of use where keys are needed.
    fn is_here(&self, focus: [f64; 3]) -> bool {
        let [x, _, z] = std::array::from_fn(|a| focus[a] - self.focus[a]);
        x.hypot(z) <= self.span_world
    }

    /// Adds a key whose bake took so long.
    pub(super) fn insert(&mut self, key: Key<F>, seconds: f64) {
        self.seconds[key.stage] = seconds;
        self.keys.retain(|old| angle(old.towards, key.towards) > 1e-9);
        self.keys.push(key);
    }

    /// Gives up keys that the sun has left: all but the one before it, and two after it. The nearest one always stays.
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

    /// Returns the keys that answer at a sun: the one that is asked first, and the other one. `None` if there is none.
    ///
    /// The finer one is first, then the one with the higher sun, unless the other is more than four times nearer.
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

    /// Returns the keys before and after the sun: those that are of use here, or else any.
    fn pair(&self, sun: [f64; 3], motion: &Motion) -> [Option<usize>; 2] {
        let here = [self.behind(sun, motion), self.ahead(sun, motion)];
        if here.iter().any(Option::is_some) {
            return here;
        }
        let anywhere = |is_ahead: bool| self.nearest_of(sun, motion, |_, along| (along > 0.0) == is_ahead);
        [anywhere(false), anywhere(true)]
    }

    /// Returns the bake that is needed most for a sun that is here and moves like this.
    pub(super) fn next_job(&self, sun: [f64; 3], motion: &Motion) -> Option<Job> {
        let sun = if sun[1] > 0.0 { sun } else { self.dawn(sun, motion)? };
        let (behind, ahead) = (self.behind(sun, motion), self.ahead(sun, motion));
        let Some(now) = behind.or(ahead) else { return Some(self.job(sun, None, 0.0)) };
        let (gap, speed) = (self.gap(sun, motion).to_radians(), motion.speed());
        if speed == 0.0 {
            return self.job_of_a_standing_sun(sun, [behind, ahead], gap);
        }
        // A key that the sun has just passed is worth another bake, one that it leaves behind is not.
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
        // A bake that ends after the sun has passed its key is of no use: the key after it is.
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

    /// Whether the result of a job would be of use.
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

    /// Returns the bake of a key that is an angle after another one, in radians. `None` if there is one: the sun sets.
    fn job_beyond(&self, from: [f64; 3], beyond: f64, sun: [f64; 3], motion: &Motion) -> Option<Job> {
        let towards = self.raised(motion.after(from, beyond));
        let here = self.keys.iter().filter(|key| self.is_here(key.focus));
        let is_new =
            here.map(|key| angle(key.towards, towards)).all(|apart| apart > SAME_DEGREES.to_radians());
        // It is needed when the sun is half way to it from the key before, or from where it is.
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

    /// Returns how long a bake is expected to take: as long as the last one of the stage, or as its like is known to grow.
    fn expected_seconds(&self, stage: usize) -> f64 {
        let known = (0..=stage).rev().find(|&coarser| self.seconds[coarser].is_finite());
        known.map_or(f64::INFINITY, |known| self.seconds[known] * GROWTH.powi((stage - known) as i32))
    }

    /// Returns how far apart keys are here, in degrees: farther than they should be if bakes are too slow.
    fn gap(&self, sun: [f64; 3], motion: &Motion) -> f64 {
        let wanted = gap_degrees(sun[1].clamp(-1.0, 1.0).asin().to_degrees());
        let bake = self.expected_seconds(FINEST);
        let affordable = if bake.is_finite() { (SLACK * bake * motion.speed()).to_degrees() } else { 0.0 };
        wanted.max(affordable).min(MOST_APART_DEGREES)
    }

    /// Returns how far from a key a sun may be, in radians.
    fn reach(&self, sun: [f64; 3], motion: &Motion) -> f64 {
        (REACH_GAPS * self.gap(sun, motion)).max(LEAST_REACH_DEGREES).to_radians()
    }

    /// Returns the nearest key that the sun has passed, or that it stands at.
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

    /// Returns where a sun that is below the horizon will rise, if it does soon.
    fn dawn(&self, sun: [f64; 3], motion: &Motion) -> Option<[f64; 3]> {
        let most = (motion.speed() * DAWN_SECONDS).min(MOST_APART_DEGREES.to_radians());
        (1..=64).map(|i| motion.after(sun, most * f64::from(i) / 64.0)).find(|towards| towards[1] > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sun that rises in the east, stands 60° high at noon and sets in the west.
    fn sun(degrees: f64) -> [f64; 3] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [cos, sin * 60f64.to_radians().sin(), sin * 60f64.to_radians().cos()]
    }

    /// Plays suns, by time in seconds, with bakes of so many seconds at the finest stage. Calls `see` with each frame.
    fn play(
        seconds: f64,
        bake_seconds: f64,
        at: impl Fn(f64) -> f64,
        see: impl FnMut(f64, Option<[&Key<()>; 2]>),
    ) -> Keys<()> {
        walk(0.0, seconds, bake_seconds, at, see)
    }

    /// The same for a camera that walks so far each second, where a key is of use within 100 m of its focus.
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
    fn gaps_are_those_of_paths() {
        for (elevation, gap) in [(-3.0, 1.0), (10.0, 1.0), (13.0, 1.5), (22.0, 3.0), (40.0, 8.0), (90.0, 8.0)]
        {
            assert_eq!(gap_degrees(elevation), gap, "{elevation}");
        }
    }

    #[test]
    fn a_steady_sun_is_always_between_two_fine_keys() {
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
    fn keys_are_farther_apart_where_bakes_are_slow() {
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
    fn keys_go_with_a_camera_that_walks() {
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
    fn a_jump_is_answered_coarsely_and_then_finely() {
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
    fn a_sun_that_stops_between_two_keys_keeps_both() {
        let at = |seconds: f64| 40.0 + 0.125 * seconds.min(100.0);
        play(140.0, 4.0, at, |now, around| {
            if now > 100.0 {
                let [a, b] = around.unwrap();
                assert!(angle(a.towards, b.towards) > 0.01 && a.stage + b.stage == 2 * FINEST, "{now}");
            }
        });
    }

    #[test]
    fn the_first_key_is_there_before_the_sun_rises_and_none_is_below_the_lowest() {
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
    fn a_sun_that_is_dragged_never_lacks_a_key() {
        // Back and forth, faster than any bake but the coarsest.
        let at = |seconds: f64| 90.0 + 60.0 * (0.7 * seconds).sin();
        play(40.0, 4.0, at, |now, around| assert!(around.is_some() || now < 0.1, "{now}"));
    }
}
