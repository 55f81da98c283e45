//! From options to the state a view starts with. Invalid options are reported before a window opens.

use adumbra::Sun;
use adumbra_program::sun::DEFAULT_SUN;
use adumbra_scene::{Camera, MoverPolicy};
use adumbra_tree::AnyFile;

use crate::command::{Command, Side};
use crate::error::{OptionField as Field, Result, ViewError};
use crate::options::ViewOptions;
use crate::settings::{Settings, Shown};
use crate::shadow_file::{ignored_alpha, is_same_sun, sun_of};

/// The state a view starts with.
pub(crate) struct Startup {
    pub(crate) options: ViewOptions,
    pub(crate) settings: Settings,
    /// The shadow files, in the order of the options' paths.
    pub(crate) files: Vec<AnyFile>,
}

impl Startup {
    /// Derives the settings and reads the shadow files.
    ///
    /// # Errors
    /// Returns an error if options are invalid or a file cannot be read.
    pub(crate) fn new(mut options: ViewOptions) -> Result<Self> {
        let mut settings = settings_of(&options)?;
        options.load.color_textures = true;
        if options.load.movers == MoverPolicy::Skip {
            options.load.movers = MoverPolicy::Keep;
        }
        let files = options.shadow_files.iter().map(AnyFile::read).collect::<Result<Vec<_>, _>>()?;
        if let [first, rest @ ..] = &files[..] {
            if rest.iter().any(|file| std::mem::discriminant(file) == std::mem::discriminant(first))
                || rest.len() > 1
            {
                let what = "give at most one shadow file of each kind, light-aligned and world-aligned";
                return Err(wrong(Field::ShadowFiles)(what.to_owned()));
            }
            let asked = options.sun.filter(|sun| !is_same_sun(sun, &sun_of(first)));
            settings.sun = asked.unwrap_or_else(|| sun_of(first));
            if files.iter().any(ignored_alpha) && !options.load.ignore_alpha {
                options.load.ignore_alpha = true;
                // The files were baked with this option, so a bake that replaces them needs it too.
                options.repeated.push("--ignore-alpha".to_owned());
            }
            if options.shadows[0].is_none() && files.iter().all(|file| matches!(file, AnyFile::Tree(_))) {
                settings.shadows[0] = "voxel-cubes".parse()?;
            }
        }
        Ok(Self { options, settings, files })
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
        sun: options
            .sun
            .map_or_else(|| Sun::from_direction(DEFAULT_SUN), Ok)
            .map_err(adumbra_tree::Error::from)?,
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
    };
    let technique = |side: usize| settings.shadows[side].to_string();
    for (field, command) in [
        (Field::Shadows, Command::Shadow { side: Side::First, technique: technique(0) }),
        (Field::Shadows, Command::Shadow { side: Side::Second, technique: technique(1) }),
        (Field::Seconds, Command::Time(options.seconds)),
        (Field::Layer, Command::Layer(options.layer.clone())),
        (Field::Ambient, Command::Ao(options.ambient.to_string())),
        (Field::Resolution, Command::Bake(options.resolution)),
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
