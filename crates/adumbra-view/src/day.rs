//! A day that a view plays: its clock, and the keys around its sun. Keys are baked ahead of the sun, or read
//! from a path file.

use std::sync::Arc;
use std::time::Instant;

use adumbra::{ShadowFile, Sun, SunPath, SunStep};
use adumbra_bake::{BakeOptions, Size};
use adumbra_path::{FollowOptions, Followed, PathReader, SunFollower};
use adumbra_program::moment::clock;
use adumbra_render::voxel::MovingLight;

use crate::event::{Event, EventSender};
use crate::loaded_scene::LoadedScene;
use crate::settings::Settings;

/// Largest number of bytes of a key that a frame uploads.
const UPLOAD_BYTES: usize = 1 << 20;
/// Seconds of a whole day.
const DAY_SECONDS: f64 = 86_400.0;

/// A day to play.
#[derive(Clone, Debug)]
pub struct DayOptions {
    /// Positions of the sun, step by step.
    pub steps: Vec<SunStep>,
    /// How far the local clock is ahead of UTC; `None` if the suns were listed without a place.
    pub utc_offset_seconds: Option<i32>,
    /// Playing time of 24 hours in seconds.
    pub length_seconds: f64,
    /// The text of the day, for the command line that reproduces a view; `None` for the day of a path file.
    pub text: Option<String>,
    /// If set, keys cover only the part of the scene within this distance of the camera along x and z, world
    /// units.
    pub near_world: Option<f64>,
    /// The hour by the local clock at which the day begins. `None` means the hour of the first sun.
    pub hour: Option<f64>,
}

impl DayOptions {
    /// Default playing time of 24 hours in seconds: 48 minutes.
    pub const LENGTH_SECONDS: f64 = 2880.0;
}

/// A day in progress.
pub(crate) struct Day {
    /// The steps whose sun is above the horizon.
    steps: Vec<SunStep>,
    /// Times of the last of these steps before each night and of the first step after it.
    nights: Vec<[f64; 2]>,
    utc_offset_seconds: Option<i32>,
    length_seconds: f64,
    near_world: Option<f64>,
    seconds: f64,
    keys: Keys,
    light: Option<Arc<MovingLight>>,
    changes: u64,
    coarser: u64,
    /// The error that ended the stream of keys.
    fault: Option<String>,
    is_stopped: bool,
    began: Instant,
}

/// The source of the keys.
enum Keys {
    /// No keys yet.
    None,
    /// Keys are baked for the scene with this number at this resolution.
    Baked { follower: Box<SunFollower>, scene: u64, resolution: u64 },
    /// Keys are read from a path file.
    Read(Box<PathReader>),
}

/// The action that a frame must take.
pub(crate) enum Change {
    /// Nothing.
    None,
    /// Draw.
    Redraw,
    /// Use the light for the first time.
    Begin(Arc<MovingLight>),
}

impl Day {
    /// Begins a day with its first sun. `None` if the sun is never above the horizon.
    pub(crate) fn new(options: &DayOptions) -> Option<Self> {
        let is_lit = |step: &&SunStep| Sun::from_direction(step.towards_sun).is_ok();
        let steps: Vec<SunStep> = options.steps.iter().filter(is_lit).copied().collect();
        let runs = options.steps.split(|step| !is_lit(&step)).filter(|run| !run.is_empty());
        let runs: Vec<[f64; 2]> = runs.map(|run| [run[0].seconds, run[run.len() - 1].seconds]).collect();
        let nights = runs.windows(2).map(|runs| [runs[0][1], runs[1][0]]).collect();
        let first = steps.first()?;
        let mut day = Self {
            seconds: first.seconds,
            steps,
            nights,
            utc_offset_seconds: options.utc_offset_seconds,
            length_seconds: options.length_seconds,
            near_world: options.near_world,
            keys: Keys::None,
            light: None,
            changes: 0,
            coarser: 1,
            fault: None,
            is_stopped: false,
            began: Instant::now(),
        };
        if let Some(hour) = options.hour {
            day.set(day.at_hour(hour));
        }
        Some(day)
    }

    /// Plays the keys of a path file.
    ///
    /// # Errors
    /// Returns an error if no thread can be started.
    pub(crate) fn read(&mut self, path: SunPath, sender: EventSender) -> adumbra_path::Result<()> {
        let reader = PathReader::start(path, move || sender.send(Event::Key))?;
        self.keys = Keys::Read(Box::new(reader));
        Ok(())
    }

    /// Advances the clock by seconds of the view. After its last sun, the day begins again.
    pub(crate) fn advance(&mut self, seconds: f64) {
        let [first, last] = self.span();
        let next = self.seconds + seconds * DAY_SECONDS / self.length_seconds;
        self.set(if next > last { first } else { next });
    }

    /// Sets the clock, in the day's seconds. Skips nights.
    pub(crate) fn set(&mut self, seconds: f64) {
        let [first, last] = self.span();
        let night = self.nights.iter().find(|[dusk, dawn]| *dusk < seconds && seconds < *dawn);
        self.seconds = night.map_or(seconds, |[_, dawn]| *dawn).clamp(first, last);
    }

    /// The clock, in the day's seconds.
    pub(crate) fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The first and last time of the day, in seconds.
    pub(crate) fn span(&self) -> [f64; 2] {
        [0, self.steps.len() - 1].map(|step| self.steps[step].seconds)
    }

    /// Formats a time as the local clock shows it, or in seconds.
    pub(crate) fn shown(&self, seconds: f64) -> String {
        clock(seconds, self.utc_offset_seconds.unwrap_or(0), self.utc_offset_seconds.is_some())
    }

    /// Returns the time in seconds at which the clock shows an hour of the first date.
    pub(crate) fn at_hour(&self, hour: f64) -> f64 {
        let offset = f64::from(self.utc_offset_seconds.unwrap_or(0));
        let midnight = ((self.span()[0] + offset) / DAY_SECONDS).floor() * DAY_SECONDS - offset;
        midnight + 3600.0 * hour
    }

    /// The hour by the local clock.
    pub(crate) fn hour(&self) -> f64 {
        (self.seconds - self.at_hour(0.0)) / 3600.0
    }

    /// The sun at the clock's time.
    pub(crate) fn sun(&self) -> Sun {
        let after = self.steps.partition_point(|step| step.seconds < self.seconds).min(self.steps.len() - 1);
        let (a, b) = (self.steps[after.saturating_sub(1)], self.steps[after]);
        let share =
            if b.seconds > a.seconds { (self.seconds - a.seconds) / (b.seconds - a.seconds) } else { 1.0 };
        // Steps are a minute apart. Over such a short arc, interpolating along the chord is accurate.
        let towards = std::array::from_fn(|i| {
            a.towards_sun[i] + share.clamp(0.0, 1.0) * (b.towards_sun[i] - a.towards_sun[i])
        });
        Sun::from_direction(towards)
            .unwrap_or_else(|_| Sun::from_direction(b.towards_sun).expect("it was checked"))
    }

    /// Updates the keys around the sun of the settings. Call it in each tick.
    pub(crate) fn follow(
        &mut self,
        settings: &Settings,
        scene: &Arc<LoadedScene>,
        max_memory_bytes: Option<u64>,
        sender: &EventSender,
    ) -> Change {
        if self.is_stopped {
            return Change::None;
        }
        let towards = settings.sun.towards();
        if let Keys::Baked { scene: of, resolution, .. } = &self.keys
            && (*of != scene.number || *resolution != settings.resolution)
        {
            (self.keys, self.light) = (Keys::None, None);
        }
        if let Keys::None = self.keys {
            let size = Size::Resolution(settings.resolution);
            let bake = BakeOptions::new(settings.sun, size).with(|o| {
                o.ignore_alpha = scene.ignore_alpha;
                o.max_memory_bytes = max_memory_bytes;
            });
            let sender = sender.clone();
            let options = FollowOptions { near_world: self.near_world, ..FollowOptions::new(bake) };
            let started = SunFollower::start(scene.still.clone(), options, move || sender.send(Event::Key));
            match started {
                Ok(follower) => {
                    let (scene, resolution) = (scene.number, settings.resolution);
                    self.keys = Keys::Baked { follower: Box::new(follower), scene, resolution };
                }
                Err(error) => self.stop(&error),
            }
        }
        let (followed, fault) = match &mut self.keys {
            Keys::None => return Change::None,
            Keys::Baked { follower, .. } => {
                follower.set_focus(settings.camera.eye);
                (follower.follow(self.began.elapsed().as_secs_f64(), towards), follower.take_fault())
            }
            Keys::Read(reader) => (reader.follow(self.seconds), reader.take_fault()),
        };
        if let Some(error) = fault {
            self.stop(&error);
        }
        let Followed::Moment(moment) = followed else { return Change::None };
        self.coarser = moment.coarser;
        let keys: [&ShadowFile; 2] = [&moment.keys[0], &moment.keys[1]];
        let Some(light) = &self.light else {
            let light = Arc::new(MovingLight::new(keys, moment.towards_sun, UPLOAD_BYTES));
            self.light = Some(Arc::clone(&light));
            return Change::Begin(light);
        };
        light.set(keys, moment.towards_sun);
        let is_other = std::mem::replace(&mut self.changes, moment.changes) != moment.changes;
        if is_other { Change::Redraw } else { Change::None }
    }

    fn stop(&mut self, error: &adumbra_path::Error) {
        self.fault = Some(error.to_string());
        self.is_stopped = true;
    }

    /// Whether the keys come from a path file, which has no keys for a sun that is set by hand.
    pub(crate) fn is_read(&self) -> bool {
        matches!(self.keys, Keys::Read(_))
    }

    /// Whether a key is being baked or read.
    pub(crate) fn is_busy(&self) -> bool {
        match &self.keys {
            Keys::None => true,
            Keys::Baked { follower, .. } => follower.is_baking(),
            Keys::Read(reader) => reader.is_reading(),
        }
    }

    /// Returns the error that ended the stream of keys, once.
    pub(crate) fn take_fault(&mut self) -> Option<String> {
        self.fault.take()
    }

    /// Describes the source of the keys in one line.
    pub(crate) fn line(&self) -> String {
        match (&self.keys, self.coarser) {
            (Keys::Read(_), _) => "keys are read from a path file".to_owned(),
            (_, 1) => "keys are baked ahead of the sun".to_owned(),
            (_, coarser) => format!("keys are {coarser} times coarser until finer ones are baked"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clock_skips_nights_and_wraps_at_the_end() {
        // Two days with night at every hour from 19 to 6.
        let step = |hour: u32| {
            let (sin, cos) = (15.0 * f64::from(hour) - 90.5).to_radians().sin_cos();
            SunStep { seconds: 3600.0 * f64::from(hour), towards_sun: [cos, sin, 0.0] }
        };
        let options = DayOptions {
            steps: (0..48).map(step).collect(),
            utc_offset_seconds: Some(0),
            length_seconds: 86_400.0,
            text: None,
            near_world: None,
            hour: Some(17.0),
        };
        let mut day = Day::new(&options).unwrap();
        assert_eq!((day.hour(), day.span()), (17.0, [7.0, 42.0].map(|hour| 3600.0 * hour)));
        for (advanced, hour) in
            [(1800.0, 17.5), (3600.0, 31.0), (3600.0, 32.0), (36_000.0, 42.0), (60.0, 7.0)]
        {
            day.advance(advanced);
            assert_eq!(day.hour(), hour);
            assert!(day.sun().towards()[1] > 0.0);
        }
        day.set(day.at_hour(12.5));
        assert!((day.sun().elevation_degrees() - 83.0).abs() < 0.5, "{}", day.sun().elevation_degrees());
    }
}
