//! The movers of a picture, and the times at which it is drawn.

use std::path::{Path, PathBuf};

use crate::Result;
use adumbra_program::exit::Failure;
use adumbra_scene::Scene;
use adumbra_truth::movers::{BallPath, MoveSpec};
use adumbra_truth::trace::{TraceOptions, Tracer};

use super::args::Render;

/// Adds the movers that `--move` asks for. Returns the eye and the target of a camera that sees the first
/// one, if there is one.
pub(super) fn add(
    args: &Render,
    scene: &mut Scene,
    towards_sun: [f64; 3],
    ignore_alpha: bool,
) -> Result<Option<[[f64; 3]; 2]>> {
    let specs: Vec<MoveSpec> = args.movers.iter().map(|s| s.parse()).collect::<Result<_, _>>()?;
    if specs.is_empty() {
        return Ok(None);
    }
    // Paths are searched for among static geometry only.
    let still = if scene.movers.is_empty() {
        None
    } else {
        let mut still = scene.clone();
        still.remove_movers();
        Some(still)
    };
    let tracer = Tracer::build(still.as_ref().unwrap_or(scene), TraceOptions { ignore_alpha });
    let paths: Vec<BallPath> =
        specs.iter().map(|s| s.path(&tracer, towards_sun)).collect::<Result<_, _>>()?;
    let view = paths.first().map(|p| p.viewpoint(&tracer, towards_sun));
    drop(tracer);
    paths.iter().for_each(|path| path.add_to(scene));
    Ok(view)
}

/// Returns the time of each picture in seconds, and its number if there may be several.
pub(super) fn moments(args: &Render, scene: &Scene) -> Result<Vec<(f64, Option<u32>)>> {
    let Some(frames) = args.frames else {
        if !args.time.is_finite() {
            return Err(
                Failure::Usage(format!("--time {}: give a finite number of seconds", args.time)).into()
            );
        }
        return Ok(vec![(args.time, None)]);
    };
    if scene.movers.is_empty() {
        return Err(Failure::Usage(
            "--frames: nothing moves; give --move sphere, or a glTF file with animated nodes".to_owned(),
        )
        .into());
    }
    let last = f64::from((frames - 1).max(1));
    let end = scene.movers.end_seconds();
    Ok((0..frames).map(|i| (end * f64::from(i) / last, Some(i))).collect())
}

/// Returns the path of a frame's picture.
pub(super) fn numbered(path: &Path, number: Option<u32>) -> PathBuf {
    let Some(number) = number else { return path.to_owned() };
    let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or("picture");
    let ending = path.extension().and_then(|s| s.to_str()).unwrap_or("png");
    path.with_file_name(format!("{stem}.{number:04}.{ending}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_number_precedes_the_extension() {
        assert_eq!(numbered(Path::new("a/ball.png"), Some(7)), Path::new("a/ball.0007.png"));
        assert_eq!(numbered(Path::new("a/ball.exr"), None), Path::new("a/ball.exr"));
    }
}
