//! A sun that is swept across a day in equal steps of time, and the sun path whose keys answer for it.

use std::path::Path;
use std::sync::Arc;

use adumbra::grid::vec3::normalize;
use adumbra::stream::BytesSource;
use adumbra::{ShadowFile, SunPath};
use adumbra_bake::Watch;
use adumbra_path::{BakedKey, BakedPath, PathOptions, bake_path};
use adumbra_program::exit::Failure;
use adumbra_program::memory::MemoryLimit;
use adumbra_program::moment::{shown, span, sun_path, suns_of_day};
use adumbra_program::output::note_input;
use adumbra_render::voxel::{LightFile, MovingLight};
use adumbra_render::{Reads, TechniqueFiles, TechniqueSpec};
use adumbra_scene::LoadedAs;
use adumbra_solar::{Day, position};

use crate::baked::BakeOnDemand;
use crate::error::Result;

/// Cosine of the largest angle between the suns of a day and of a path of the same place and date: half a
/// degree.
const SAME_SUN: f64 = 0.999_962;

/// A sun that is swept across a day.
pub struct SweptSun {
    moments: Vec<SunMoment>,
    /// The day; `None` if the sun comes from a path file.
    day: Option<Day>,
    keys: Option<PathKeys>,
    /// How far the local clock is ahead of UTC; `None` for listed suns, which have no clock.
    utc_offset_seconds: Option<i32>,
}

/// A step of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunMoment {
    /// The moment: seconds since 1970-01-01 00:00 UTC, or as the path counts them.
    pub seconds: f64,
    /// Unit vector towards the sun; `None` if it is at or below the horizon.
    pub towards_sun: Option<[f64; 3]>,
}

/// The keys of a path around a moment, as techniques read them.
struct PathKeys {
    path: SunPath,
    around: [Key; 2],
    light: Arc<MovingLight>,
}

/// A key of a path, with its index.
type Key = (usize, ShadowFile);

impl SweptSun {
    /// Returns the sun of a day in `steps` equal steps of time.
    ///
    /// # Errors
    ///
    /// Returns an error if the day has no such hours, or the sun is above the horizon in fewer than two
    /// steps.
    pub fn of_day(day: &Day, steps: u32) -> Result<Self> {
        let ends = of_option(day.ends())?.map(|seconds| seconds as f64);
        let moment = |seconds: f64| {
            let sun = of_option(position(&day.location, seconds, day.atmosphere.as_ref()))?;
            let towards_sun = Some(sun.towards()).filter(|towards| towards[1] > 0.0);
            Ok(SunMoment { seconds, towards_sun })
        };
        let moments = times(ends, steps).map(moment).collect::<Result<_>>()?;
        let utc_offset_seconds = Some(day.zone().offset_seconds(ends[0]));
        Self { moments, day: Some(day.clone()), keys: None, utc_offset_seconds }.checked()
    }

    /// Returns the sun of a path file in `steps` equal steps of time, over the whole path or a day within it.
    ///
    /// # Errors
    ///
    /// Returns an error if the file is not a sun path, cannot be read, does not fit into the limit, does not
    /// cover the day, or has suns that differ from the day's, and if the sun is above the horizon in fewer
    /// than two steps.
    pub fn of_file(file: &Path, day: Option<&Day>, steps: u32, limit: MemoryLimit) -> Result<Self> {
        let name = file.display();
        note_input("the shadow file itself", file);
        let Some(path) = sun_path(file)? else {
            return Err(Failure::Usage(format!(
                "--shadow-file: {name} is not a sun path; bake one with bake --sun-path"
            ))
            .into());
        };
        limit.check_keys(&path)?;
        let [first, last] = span(&path);
        let ends = match day {
            Some(day) => of_option(day.ends())?.map(|seconds| seconds as f64),
            None => [first, last],
        };
        if ends[0] < first || ends[1] > last {
            let [first, last] = [first, last].map(|seconds| shown(&path, seconds));
            return Err(Failure::Usage(format!(
                "--sun-sweep: {name} is from {first} to {last} of its day; choose hours within, or bake these with bake --sun-path"
            ))
            .into());
        }
        let moment = |seconds| SunMoment { seconds, towards_sun: path.sun_at(seconds) };
        let moments: Vec<SunMoment> = times(ends, steps).map(moment).collect();
        if let Some(day) = day {
            let same = |(a, b): (&SunMoment, &SunMoment)| match (a.towards_sun, b.towards_sun) {
                (Some(a), Some(b)) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2] >= SAME_SUN,
                _ => true,
            };
            if !moments.iter().zip(&Self::of_day(day, steps)?.moments).all(same) {
                return Err(Failure::Usage(format!(
                    "--sun-sweep: {name} has other suns; give the place that it was baked for, or leave out DAY"
                ))
                .into());
            }
        }
        let utc_offset_seconds = path.place_degrees().map(|_| path.utc_offset_seconds());
        let mut sun = Self { moments, day: None, keys: None, utc_offset_seconds }.checked()?;
        sun.set_path(path)?;
        Ok(sun)
    }

    fn checked(self) -> Result<Self> {
        let (up, steps) = (self.up().count(), self.moments.len());
        if up >= 2 {
            return Ok(self);
        }
        Err(Failure::Usage(format!(
            "--sun-sweep: the sun is above the horizon in {up} of {steps} steps; choose other hours"
        ))
        .into())
    }

    /// Bakes a sun path if a technique reads one and none was given. Prints a note to stderr before the bake.
    ///
    /// # Errors
    ///
    /// Returns an error if the bake fails, or a technique reads a file of another kind.
    pub fn complete(&mut self, specs: &[TechniqueSpec], how: &BakeOnDemand<'_>) -> Result<()> {
        if let Some(spec) = specs.iter().find(|spec| matches!(spec.reads(), Reads::Other(_))) {
            return Err(Failure::Usage(format!(
                "--shadow {spec}: it reads a file of one sun, and --sun-sweep moves the sun; leave out one of them"
            ))
            .into());
        }
        let is_read = specs.iter().any(|spec| spec.reads() == Reads::LightFile);
        let Some(day) = self.day.as_ref().filter(|_| is_read && self.keys.is_none()) else { return Ok(()) };
        adumbra_program::note!(
            "note: no sun path as --shadow-file; baking one with {} texels along its longest side",
            how.resolution
        );
        let (steps, utc_offset_seconds) = of_option(suns_of_day(day))?;
        let BakedPath { keys, .. } =
            bake_path(how.scene, &steps, &PathOptions::new(how.options()), Watch::none(), |_| {})?;
        let keys: Vec<(f64, Vec<u8>)> =
            keys.into_iter().map(|BakedKey { seconds, bytes, .. }| (seconds, bytes)).collect();
        let mut bytes = Vec::new();
        let location = [day.location.latitude_degrees(), day.location.longitude_degrees()];
        SunPath::write(&mut bytes, steps, &keys, utc_offset_seconds, Some(location))
            .map_err(adumbra_path::Error::from)?;
        self.set_path(SunPath::open(Arc::new(BytesSource(bytes)), "the sun path")?)
    }

    fn set_path(&mut self, path: SunPath) -> Result<()> {
        let (seconds, towards_sun) = self.middle();
        let around = read_keys(&path, path.keys_at(seconds).unwrap_or_default(), &[])?;
        let light = Arc::new(MovingLight::new(files_of(&around), towards_sun, usize::MAX));
        self.keys = Some(PathKeys { path, around, light });
        Ok(())
    }

    /// Sets the current moment, and reads the keys around it unless they are already loaded.
    ///
    /// # Errors
    ///
    /// Returns an error if a key cannot be read.
    pub fn set(&mut self, seconds: f64, towards_sun: [f64; 3]) -> Result<()> {
        let Some(PathKeys { path, around, light }) = &mut self.keys else { return Ok(()) };
        if let Some(indices) = path.keys_at(seconds) {
            *around = read_keys(path, indices, around)?;
        }
        light.set(files_of(around), towards_sun);
        Ok(())
    }

    /// Returns the files in the form that techniques take: the path at the current moment.
    pub fn baked(&self) -> TechniqueFiles<'_> {
        TechniqueFiles { light: self.keys.as_ref().map(|keys| LightFile::Moving(&keys.light)), other: None }
    }

    /// Returns how the scene of the keys was loaded, if there are keys.
    pub fn scene(&self) -> Option<LoadedAs> {
        self.keys.as_ref().map(|keys| LoadedAs::from(&keys.light.first_key().settings))
    }

    /// Returns all steps, including those at night.
    pub fn moments(&self) -> &[SunMoment] {
        &self.moments
    }

    /// Returns the path whose keys are used, if there is one.
    pub fn path(&self) -> Option<&SunPath> {
        self.keys.as_ref().map(|keys| &keys.path)
    }

    /// Returns the middle moment of the steps in which the sun is up, and the unit vector towards the sun at
    /// that moment.
    pub fn middle(&self) -> (f64, [f64; 3]) {
        let up: Vec<(f64, [f64; 3])> = self.up().collect();
        // With an even number of steps, use the mean of the middle two, so that the camera does not depend on
        // parity.
        let [a, b] = [up[(up.len() - 1) / 2], up[up.len() / 2]];
        (0.5 * (a.0 + b.0), normalize([0, 1, 2].map(|axis| a.1[axis] + b.1[axis])))
    }

    fn up(&self) -> impl Iterator<Item = (f64, [f64; 3])> {
        self.moments.iter().filter_map(|moment| Some((moment.seconds, moment.towards_sun?)))
    }

    /// Returns how far the local clock is ahead of UTC in seconds; `None` for listed suns, which have no
    /// clock.
    pub fn utc_offset_seconds(&self) -> Option<i32> {
        self.utc_offset_seconds
    }
}

/// Returns the times of `steps` equal steps from `first` to `last`.
fn times([first, last]: [f64; 2], steps: u32) -> impl Iterator<Item = f64> {
    let share = move |step: u32| f64::from(step) / f64::from(steps.max(2) - 1);
    (0..steps).map(move |step| (first + share(step) * (last - first)).min(last))
}

/// Returns two keys of a path. Reads only keys that are not in `read`.
fn read_keys(path: &SunPath, [first, second]: [usize; 2], read: &[Key]) -> Result<[Key; 2]> {
    let key = |index: usize, read: &[Key]| match read.iter().find(|key| key.0 == index) {
        Some(key) => Ok(key.clone()),
        None => path.key(index).map(|file| (index, file)),
    };
    let first = [key(first, read)?];
    let second = key(second, &[&first, read].concat())?;
    let [first] = first;
    Ok([first, second])
}

fn files_of(keys: &[Key; 2]) -> [&ShadowFile; 2] {
    keys.each_ref().map(|(_, file)| file)
}

/// Adds the name of the option to an error of a day.
fn of_option<T>(result: adumbra_solar::Result<T>) -> Result<T> {
    result.map_err(|error| Failure::Usage(format!("--sun-sweep: {error}")).into())
}
