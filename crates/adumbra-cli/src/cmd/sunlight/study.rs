//! A scene that is prepared for rays, and its points.

use std::path::Path;

use adumbra_files::read_text;
use adumbra_program::args::{RunArgs, SceneArgs};
use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::note_input;
use adumbra_program::progress::{Reporter, Style, Units};
use adumbra_program::scene::load_scene_within;
use adumbra_scene::Scene;
use adumbra_sunlight::{Error, Grid, Progress, Receiver, read_csv, surface_points};
use adumbra_truth::trace::{TraceOptions, Tracer};

use crate::args::PointArgs;

/// Most bytes of a table of points.
const TABLE_BYTES: u64 = 4 << 30;

/// Points, and the cells of a grid that they are in.
pub(super) struct Points {
    pub(super) receivers: Vec<Receiver>,
    /// The grid, and the cell of each point.
    pub(super) grid: Option<(Grid, Vec<u32>)>,
}

/// Loads a scene.
pub(super) fn load(path: &Path, load: &SceneArgs, run: &RunArgs) -> Result<Scene, Failure> {
    let scene = load_scene_within(run.memory_limit(), path, &load.load_options()?)?;
    run.check_memory(
        "the scene and its acceleration structure",
        scene.memory_bytes(),
        scene.memory_bytes() + Tracer::building_bytes(&scene),
    )?;
    Ok(scene)
}

/// Prepares a scene for rays.
pub(super) fn tracer<'s>(scene: &'s Scene, load: &SceneArgs, run: &RunArgs) -> Result<Tracer<'s>, Failure> {
    let tracer = Tracer::build(scene, TraceOptions { ignore_alpha: load.ignore_alpha });
    run.memory_limit().check_peak("the scene and its acceleration structure")?;
    Ok(tracer)
}

/// Finds the points. A grid covers all of `scenes`.
pub(super) fn points(
    args: &PointArgs,
    tracer: &Tracer<'_>,
    ignore_alpha: bool,
    scenes: &[&Scene],
) -> Result<Points, Failure> {
    let places = &args.places;
    if let Some(spacing) = places.grid {
        let bounds: Vec<_> = scenes.iter().map(|scene| scene.bounds()).collect();
        let grid = Grid::over(&bounds, spacing).map_err(|error| failure(&error, "--grid"))?;
        let found = grid.receivers(tracer).map_err(|error| failure(&error, "--grid"))?;
        return Ok(Points { receivers: found.receivers, grid: Some((grid, found.cells)) });
    }
    let receivers = match (&places.points, places.surfaces) {
        (Some(table), _) => {
            note_input("the points", table);
            let text = read_text(table, TABLE_BYTES)?;
            read_csv(&text, args.lift).map_err(|error| match error {
                Error::Range { .. } => failure(&error, "--lift"),
                error => Failure::BadInput(format!("{}: {error}", table.display())),
            })?
        }
        (None, spacing) => surface_points(tracer, spacing.unwrap_or_default(), ignore_alpha)
            .map_err(|error| failure(&error, "--surfaces"))?,
    };
    Ok(Points { receivers, grid: None })
}

/// Returns the failure of an error, with the option that it comes from.
pub(super) fn failure(error: &Error, option: &str) -> Failure {
    match error {
        Error::Interrupted => Failure::Other { code: Code::Interrupted, message: error.to_string() },
        Error::NoPoints { .. } => Failure::BadInput(format!("{error} ({option})")),
        _ => Failure::Usage(format!("{error} ({option})")),
    }
}

/// Returns a callback that shows the progress of rays from points.
pub(super) fn reporter(style: Style) -> impl Fn(Progress) + Sync {
    let reporter = Reporter::new(style, Units::POINTS);
    move |progress| reporter.update(progress)
}
