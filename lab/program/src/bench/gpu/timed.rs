//! Medians of many frames.

use std::time::{Duration, Instant};

use adumbra_render::occlusion::OcclusionPasses;
use adumbra_render::{Answer, FrameTimes, Renderer, Stage, TechniqueFiles, build};
use adumbra_scene::Scene;

use super::scenes::{NamedView, moved};
use super::{Bench, Row, View};
use adumbra_compare::Result;
use adumbra_compare::compare::median_time;

/// Names of the passes of shadows and of ambient occlusion.
const SHADOW: &[(&str, Stage)] = &[
    ("depth", Stage::Depth),
    ("build", Stage::Build),
    ("look-up", Stage::Lookup),
    ("screen", Stage::Screen),
];
const AMBIENT: &[(&str, Stage)] = &[
    ("surface", Stage::AmbientSurface),
    ("estimate", Stage::AmbientEstimate),
    ("history", Stage::AmbientHistory),
    ("filter", Stage::AmbientFilter),
];
/// Time limit for the frames of one view. A software adapter cannot draw all frames in this time.
const MOST_PER_VIEW: Duration = Duration::from_millis(1200);
const FEWEST_FRAMES: usize = 3;

impl Bench<'_> {
    /// Measures one technique in every view. `movers` move from frame to frame. A technique that the device
    /// cannot hold is listed as left out.
    pub(super) fn technique(
        &mut self,
        renderer: &mut Renderer,
        views: &[NamedView],
        [technique, file]: [&str; 2],
        baked: TechniqueFiles<'_>,
        movers: Option<&Scene>,
    ) -> Result<Option<Row>> {
        let named = if file.is_empty() { technique.to_owned() } else { format!("{technique}, {file}") };
        if self.is_over(&named) {
            return Ok(None);
        }
        let spec = crate::TECHNIQUES.parse(technique)?;
        let prepared = build(&self.gpu, &spec, baked).and_then(|built| renderer.prepare(built));
        let mut prepared = match prepared {
            Ok(prepared) => prepared,
            Err(error) => {
                self.leave_out(&named, error.to_string());
                return Ok(None);
            }
        };
        let mut found = Vec::new();
        for NamedView { name, shot } in views {
            let times = self.frames(|number| {
                if let Some(movers) = movers {
                    renderer.move_movers(&moved(movers, number));
                }
                Ok(renderer.draw(shot, &mut prepared, Answer::Visibility)?)
            })?;
            found.push(view(name, &times, SHADOW, FrameTimes::shadow));
        }
        let row = Row { technique: named, bytes: prepared.technique().bytes(), views: found };
        adumbra_program::note!("{}: {}", row.technique, row.said());
        Ok(Some(row))
    }

    /// Measures ambient occlusion in every view.
    pub(super) fn occlusion(
        &mut self,
        renderer: &mut Renderer,
        views: &[NamedView],
        name: &str,
        mut passes: OcclusionPasses,
    ) -> Result<Option<Row>> {
        if self.is_over(name) {
            return Ok(None);
        }
        let mut none = renderer.prepare(build(&self.gpu, &"none".parse()?, TechniqueFiles::default())?)?;
        let mut found = Vec::new();
        for NamedView { name, shot } in views {
            renderer.draw(shot, &mut none, Answer::Visibility)?;
            let times = self.frames(|_| Ok(renderer.occlude(shot, &mut passes)?))?;
            found.push(view(name, &times, AMBIENT, FrameTimes::ambient));
        }
        let row = Row { technique: name.to_owned(), bytes: 0, views: found };
        adumbra_program::note!("{name}: {}", row.said());
        Ok(Some(row))
    }

    /// Draws one untimed frame, then timed frames until the requested number or the time limit is reached.
    fn frames(&self, mut draw: impl FnMut(u32) -> Result<FrameTimes>) -> Result<Vec<FrameTimes>> {
        draw(0)?;
        let start = Instant::now();
        let mut times = Vec::new();
        for number in 1..=self.args.frames {
            times.push(draw(number)?);
            if times.len() >= FEWEST_FRAMES && start.elapsed() >= MOST_PER_VIEW {
                break;
            }
        }
        Ok(times)
    }
}

fn view(
    name: &str,
    times: &[FrameTimes],
    passes: &[(&str, Stage)],
    all: impl Fn(&FrameTimes) -> f64,
) -> View {
    let of = |&(pass, stage): &(&str, Stage)| (pass.to_owned(), median_time(times, |t| t.of(stage)));
    View {
        view: name.to_owned(),
        frames: times.len(),
        milliseconds: median_time(times, all),
        passes: passes.iter().map(of).filter(|(_, milliseconds)| *milliseconds > 0.0).collect(),
        wall_time: times.iter().any(|t| t.wall_time),
    }
}

impl Row {
    fn said(&self) -> String {
        let of_view = |view: &View| format!("{} {:.3} ms", view.view, view.milliseconds);
        self.views.iter().map(of_view).collect::<Vec<_>>().join(", ")
    }
}
