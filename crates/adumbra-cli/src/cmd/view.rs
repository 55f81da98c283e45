//! `adumbra view`: a window on a scene.

use adumbra_compare::Result;
use adumbra_compare::args::DeviceArg;
use adumbra_compare::camera_file::CameraFile;
use adumbra_program::exit::{Code, Failure};
use adumbra_program::moment::suns_of_day;
use adumbra_render::RenderError;
use adumbra_scene::{LoadOptions, Projection};
use adumbra_solar::Day;
use adumbra_view::{DayOptions, OptionField, Script, Shown, ViewError, ViewOptions};
use clap::ValueEnum;

use crate::args::View;

pub(crate) fn run(args: &View) -> Result<Code> {
    let options = options(args)?;
    adumbra_view::run(options, Box::new(|line| adumbra_program::note!("{line}"))).map_err(failure)?;
    Ok(Code::Fine)
}

fn options(args: &View) -> Result<ViewOptions> {
    if args.device.device == DeviceArg::Cpu {
        return Err(Failure::Usage(
            "--device cpu: a window needs a GPU adapter; a software adapter is enough".to_owned(),
        )
        .into());
    }
    if args.shadow.len() > 2 {
        return Err(Failure::Usage("--shadow: give at most two, one per side".to_owned()).into());
    }
    let parsed =
        |text: &String| text.parse().map_err(|e: RenderError| Failure::Usage(format!("--shadow: {e}")));
    let shadow = |side: usize| args.shadow.get(side).map(parsed).transpose();
    let shown = match (args.split, args.difference) {
        (Some(at), _) => Shown::Split(at),
        (None, Some(gain)) => Shown::Difference(gain),
        (None, None) => Shown::Single,
    };
    let camera = args.camera.as_deref().map(CameraFile::read).transpose()?;
    let view = args.view.projection()?;
    let (eye, target, projection) = match &camera {
        Some(file) => (Some(file.camera.eye), Some(file.camera.target), file.camera.projection),
        None => (args.view.eye, args.view.target, view),
    };
    if let Projection::Orthographic { .. } = projection
        && (eye.is_none() || target.is_none())
    {
        return Err(Failure::Usage("--ortho: give --eye and --target too".to_owned()).into());
    }
    let given = args.sun.given_for(&args.scene, &args.load)?;
    let memory = args.max_memory.map_or_else(Vec::new, |b| vec!["--max-memory".to_owned(), b.to_string()]);
    let layer = args.layer.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
    Ok(ViewOptions {
        scene: args.scene.clone(),
        load: LoadOptions { max_memory_bytes: args.max_memory, ..args.load.load_options()? },
        shadow_file: args.shadow_file.clone(),
        watch: args.watch,
        shadows: [shadow(0)?, shadow(1)?],
        ambient: args.ao.parse()?,
        layer,
        shown,
        sun: given.or(camera.and_then(|c| c.sun)),
        eye,
        target,
        projection,
        size: args.view.size,
        antialias: args.antialias,
        ball: args.mover.as_deref().map(str::parse).transpose()?,
        ball_text: args.mover.clone(),
        repeated: [args.load.words(), args.device.words(), memory].concat(),
        seconds: args.time,
        playing: args.play,
        show_box: args.show_box,
        show_panel: !args.no_panel,
        continuous: args.continuous,
        resolution: args.resolution,
        budget_mib: args.budget,
        fade_frames: args.fade,
        max_memory_bytes: args.max_memory,
        day: day(args)?,
        gpu: args.device.gpu_options(),
        inputs: args.script.iter().chain(&args.camera).cloned().collect(),
        script: args.script.as_deref().map(Script::read).transpose().map_err(failure)?,
    })
}

/// Returns the day to play. For a path file, only length and hour are options.
fn day(args: &View) -> Result<Option<DayOptions>> {
    if args.day.is_none() && args.shadow_file.is_none() {
        return Ok(None);
    }
    if !(48.0..=86_400.0).contains(&args.day_length) {
        return Err(Failure::Usage(format!("--day-length {}: give 48 to 86400", args.day_length)).into());
    }
    if args.hour.is_some_and(|hour| !hour.is_finite()) {
        return Err(Failure::Usage("--hour: give a number".to_owned()).into());
    }
    let usage = |error: adumbra_solar::Error| Failure::Usage(format!("--day: {error}"));
    let (steps, utc_offset_seconds) = match &args.day {
        Some(text) => {
            let day: Day = text.parse().map_err(usage)?;
            let (steps, offset) = suns_of_day(&day).map_err(usage)?;
            (steps, Some(offset))
        }
        None => (Vec::new(), None),
    };
    if args.day_near.is_some_and(|near| !(near > 0.0 && near.is_finite())) {
        return Err(Failure::Usage("--day-near: give a distance above 0".to_owned()).into());
    }
    let (length_seconds, hour, near_world) = (args.day_length, args.hour, args.day_near);
    Ok(Some(DayOptions {
        steps,
        utc_offset_seconds,
        length_seconds,
        text: args.day.clone(),
        near_world,
        hour,
    }))
}

fn failure(error: ViewError) -> adumbra_compare::Error {
    match error {
        ViewError::Io(error) => error.into(),
        ViewError::Library(error) => error.into(),
        ViewError::Render(error) => error.into(),
        ViewError::Scene(error) => error.into(),
        ViewError::Options { field, what } => {
            let options = options_of(field).map_or_else(String::new, |options| format!(" ({options})"));
            Failure::Usage(format!("{what}{options}")).into()
        }
        other => Failure::BadInput(other.to_string()).into(),
    }
}

/// Returns the options that set a field of the view.
fn options_of(field: OptionField) -> Option<&'static str> {
    Some(match field {
        OptionField::Shadows => "--shadow",
        OptionField::Ambient => "--ao",
        OptionField::Layer => "--layer",
        OptionField::Shown => "--split, --difference",
        OptionField::EyeAndTarget => "--eye, --target",
        OptionField::Target => "--target",
        OptionField::Seconds => "--time",
        OptionField::Antialias => "--antialias",
        OptionField::Resolution => "--resolution",
        OptionField::Budget => "--budget",
        OptionField::Day => "--day",
        _ => return None,
    })
}
