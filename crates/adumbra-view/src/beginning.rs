//! From options to what a view begins with; everything that can be wrong with them is told before a window opens.

use adumbra::camera::Camera;
use adumbra::format::AnyFile;
use adumbra::light::Sun;
use adumbra::scene::MoverPolicy;

use crate::command::{Command, Side};
use crate::error::{Result, ViewError};
use crate::options::ViewOptions;
use crate::settings::{Settings, Shown};
use crate::shadow_file::{ignored_alpha, is_same_sun, sun_of};

/// The sun where nobody says: as `adumbra bake` has it.
const USUAL_SUN: [f64; 3] = [0.5, 0.8, 0.35];

/// What a view begins with.
pub(crate) struct Beginning {
    pub(crate) options: ViewOptions,
    pub(crate) settings: Settings,
    /// In the order of the options' paths.
    pub(crate) files: Vec<AnyFile>,
}

impl Beginning {
    /// Reads the shadow files.
    ///
    /// # Errors
    /// Options that do not fit, or a file that cannot be read.
    pub(crate) fn new(mut options: ViewOptions) -> Result<Self> {
        let mut settings = settings_of(&options)?;
        options.load.color_textures = true;
        if options.load.movers == MoverPolicy::LeaveOut {
            options.load.movers = MoverPolicy::Keep;
        }
        let files = options.shadow_files.iter().map(AnyFile::read).collect::<Result<Vec<_>, _>>()?;
        if let [first, rest @ ..] = &files[..] {
            if rest.iter().any(|file| std::mem::discriminant(file) == std::mem::discriminant(first))
                || rest.len() > 1
            {
                let what =
                    "--shadow-file: give at most one file of each kind, light-aligned and world-aligned";
                return Err(ViewError::Options { what: what.to_owned() });
            }
            let asked = options.sun.filter(|sun| !is_same_sun(sun, &sun_of(first)));
            settings.sun = asked.unwrap_or_else(|| sun_of(first));
            if files.iter().any(ignored_alpha) && !options.load.ignore_alpha {
                options.load.ignore_alpha = true;
                // The files say so now; a bake in their place is to do the same.
                options.repeated.push("--ignore-alpha".to_owned());
            }
            if options.shadows[0].is_none() && files.iter().all(|file| matches!(file, AnyFile::Tree(_))) {
                settings.shadows[0] = "voxel-cubes".parse()?;
            }
        }
        Ok(Self { options, settings, files })
    }
}

/// What the options say, before there is a scene.
fn settings_of(options: &ViewOptions) -> Result<Settings> {
    let [width, height] = options.size;
    let shadow = |side: usize, usual: &str| options.shadows[side].clone().map_or_else(|| usual.parse(), Ok);
    let mut settings = Settings {
        shadows: [shadow(0, "voxel")?, shadow(1, "csm")?],
        ambient: options.ambient.clone(),
        layer: Default::default(),
        shown: options.shown,
        sun: options.sun.map_or_else(|| Sun::from_direction(USUAL_SUN), Ok)?,
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
    let wrong = |what: String| ViewError::Options { what };
    for command in [
        Command::Shadow { side: Side::First, technique: settings.shadows[0].to_string() },
        Command::Shadow { side: Side::Second, technique: settings.shadows[1].to_string() },
        Command::Time(options.seconds),
        Command::Layer(options.layer.clone()),
        Command::Ao(options.ambient.to_string()),
        Command::Bake(options.resolution),
        Command::Antialias(options.antialias),
        match options.shown {
            Shown::Single => Command::Single,
            Shown::Split(at) => Command::Split(at),
            Shown::Difference(gain) => Command::Difference(gain),
        },
    ] {
        settings.apply(&command).map_err(wrong)?;
    }
    let wrong = |what: &str| ViewError::Options { what: what.to_owned() };
    let places = [options.eye, options.target];
    if places.iter().flatten().flatten().any(|c| !c.is_finite()) {
        return Err(wrong("--eye and --target must be finite"));
    }
    if options.eye.is_some() && options.eye == options.target {
        return Err(wrong("--eye and --target must be two different points"));
    }
    Ok(settings)
}
