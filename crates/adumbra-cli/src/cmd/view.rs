//! `adumbra view`: a window on a scene.

use adumbra::camera::Projection;
use adumbra_lab::camera_file::CameraFile;
use adumbra_view::{Script, Shown, ViewOptions};
use clap::ValueEnum;

use crate::args::{DeviceArg, View};
use crate::exit::{Code, Failure, Outcome};

pub(crate) fn run(args: &View) -> Outcome {
    let options = options(args)?;
    adumbra_view::run(options, Box::new(|line| eprintln!("{line}")))?;
    Ok(Code::Fine)
}

fn options(args: &View) -> Result<ViewOptions, Failure> {
    if args.device.device == DeviceArg::Cpu {
        return Err(Failure::Usage(
            "--device cpu: a window needs a GPU adapter, a software one will do".to_owned(),
        ));
    }
    if args.shadow.len() > 2 {
        return Err(Failure::Usage("--shadow: give at most two, one a side".to_owned()));
    }
    let shadow = |side: usize| args.shadow.get(side).map(|s| s.parse()).transpose();
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
        return Err(Failure::Usage("--ortho: give --eye and --target too".to_owned()));
    }
    let given = args.sun.is_given().then(|| args.sun.sun()).transpose()?;
    let memory = args.max_memory.map_or_else(Vec::new, |b| vec!["--max-memory".to_owned(), b.to_string()]);
    let layer = args.layer.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
    Ok(ViewOptions {
        scene: args.scene.clone(),
        load: args.load.load_options(args.max_memory)?,
        shadow_files: args.shadow_file.clone(),
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
        max_memory_bytes: args.max_memory,
        gpu: args.device.gpu_options(),
        inputs: args.script.iter().chain(&args.camera).cloned().collect(),
        script: args.script.as_deref().map(Script::read).transpose()?,
    })
}
