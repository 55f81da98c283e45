//! From options to the state a view starts with. Invalid options are reported before a window opens.

use adumbra::{Sun, SunPath};
use adumbra_program::exit::Failure;
use adumbra_program::moment::sun_path;
use adumbra_program::sun::DEFAULT_SUN;
use adumbra_scene::{Camera, LoadedAs, MoverPolicy, UpAxis};

use crate::command::{Command, Side};
use crate::day::{Day, DayOptions};
use crate::error::{OptionField as Field, Result, ViewError};
use crate::options::ViewOptions;
use crate::settings::{Settings, Shown};
use crate::shadow_file::{ShownFile, is_same_sun};

/// The state a view starts with.
pub(crate) struct Startup {
    pub(crate) options: ViewOptions,
    pub(crate) settings: Settings,
    pub(crate) file: Option<ShownFile>,
    pub(crate) day: Option<StartingDay>,
}

/// A day, and the path file with its keys, if there is one.
pub(crate) struct StartingDay {
    pub(crate) day: Day,
    pub(crate) path: Option<SunPath>,
}

impl Startup {
    /// Derives the settings and reads the shadow file.
    ///
    /// # Errors
    /// Returns an error if options are invalid or the file cannot be read.
    pub(crate) fn new(mut options: ViewOptions) -> Result<Self> {
        let mut settings = settings_of(&options)?;
        options.load.color_textures = true;
        if options.load.movers == MoverPolicy::Skip {
            options.load.movers = MoverPolicy::Keep;
        }
        if let Some(path) =
            options.shadow_file.as_deref().map(sun_path).transpose().map_err(failure)?.flatten()
        {
            let day = Some(starting_day(options.day.as_ref(), Some(path))?);
            return Ok(Self { options, settings, file: None, day }.at_its_sun());
        }
        let asked = options.day.as_ref().filter(|day| day.text.is_some());
        let day = asked.map(|day| starting_day(Some(day), None)).transpose()?;
        let read = |path| ShownFile::read(path, settings.stream_options());
        let file = options.shadow_file.as_ref().map(|path| read(path)).transpose()?;
        if let Some(file) = &file {
            let asked = options.sun.filter(|sun| !is_same_sun(sun, &file.sun()));
            settings.sun = asked.unwrap_or_else(|| file.sun());
            let before = options.load.clone();
            options.load.follow(LoadedAs::from(&file.settings()), &options.scene);
            // The file was baked with these options, so a bake that replaces it needs them too.
            if options.load.ignore_alpha && !before.ignore_alpha {
                options.repeated.push("--ignore-alpha".to_owned());
            }
            if options.load.up == Some(UpAxis::Z) && before.up.is_none() {
                options.repeated.extend(["--up".to_owned(), "z".to_owned()]);
            }
        }
        Ok(Self { options, settings, file, day }.at_its_sun())
    }

    /// Sets the sun to that of the day, if there is a day.
    fn at_its_sun(mut self) -> Self {
        if let Some(StartingDay { day, .. }) = &self.day {
            self.settings.sun = day.sun();
        }
        self
    }
}

/// Returns the day of a path file, with the length and hour of `asked`. Without a path file, returns the day
/// `asked`.
fn starting_day(asked: Option<&DayOptions>, path: Option<SunPath>) -> Result<StartingDay> {
    let of_path = path.as_ref().map(|path| DayOptions {
        steps: path.steps().to_vec(),
        utc_offset_seconds: path.place_degrees().map(|_| path.utc_offset_seconds()),
        length_seconds: asked.map_or(DayOptions::LENGTH_SECONDS, |day| day.length_seconds),
        text: None,
        near_world: None,
        hour: asked.and_then(|day| day.hour),
    });
    let day = of_path.as_ref().or(asked).and_then(Day::new);
    let day =
        day.ok_or_else(|| wrong(Field::Day)("the sun is never above the horizon on this day".to_owned()))?;
    Ok(StartingDay { day, path })
}

fn failure(failure: Failure) -> ViewError {
    match failure {
        Failure::Io(error) => error.into(),
        Failure::Reader(error) => error.into(),
        other => ViewError::Fault { what: other.to_string() },
    }
}

/// Returns a function that turns a message into an error of this option.
fn wrong(field: Field) -> impl Fn(String) -> ViewError {
    move |what| ViewError::Options { field, what }
}

/// Returns the settings that follow from the options before a scene is loaded.
fn settings_of(options: &ViewOptions) -> Result<Settings> {
    let [width, height] = options.size;
    let shadow = |side: usize, usual: &str| options.shadows[side].clone().map_or_else(|| usual.parse(), Ok);
    let mut settings = Settings {
        shadows: [shadow(0, "voxel")?, shadow(1, "csm")?],
        ambient: options.ambient.clone(),
        layer: Default::default(),
        shown: options.shown,
        sun: options.sun.map_or_else(|| Sun::from_direction(DEFAULT_SUN), Ok)?,
        camera: Camera {
            eye: [0.0, 1.0, 1.0],
            target: [0.0; 3],
            projection: options.projection,
            width,
            height,
        },
        ball: options.ball.is_some(),
        seconds: options.seconds,
        playing: options.playing,
        show_box: options.show_box,
        show_panel: options.show_panel,
        show_help: false,
        antialias: options.antialias,
        continuous: options.continuous,
        resolution: options.resolution,
        budget_mib: options.budget_mib,
        fade_frames: options.fade_frames,
    };
    let technique = |side: usize| settings.shadows[side].to_string();
    for (field, command) in [
        (Field::Shadows, Command::Shadow { side: Side::First, technique: technique(0) }),
        (Field::Shadows, Command::Shadow { side: Side::Second, technique: technique(1) }),
        (Field::Seconds, Command::Time(options.seconds)),
        (Field::Layer, Command::Layer(options.layer.clone())),
        (Field::Ambient, Command::Ao(options.ambient.to_string())),
        (Field::Resolution, Command::Bake(options.resolution)),
        (Field::Budget, Command::Budget(options.budget_mib)),
        (Field::Antialias, Command::Antialias(options.antialias)),
        (
            Field::Shown,
            match options.shown {
                Shown::Single => Command::Single,
                Shown::Split(at) => Command::Split(at),
                Shown::Difference(gain) => Command::Difference(gain),
            },
        ),
    ] {
        settings.apply(&command).map_err(wrong(field))?;
    }
    let wrong = |what: &str| wrong(Field::EyeAndTarget)(what.to_owned());
    let places = [options.eye, options.target];
    if places.iter().flatten().flatten().any(|c| !c.is_finite()) {
        return Err(wrong("the camera's eye and target must be finite"));
    }
    if options.eye.is_some() && options.eye == options.target {
        return Err(wrong("the camera's eye and target must be two different points"));
    }
    Ok(settings)
}
