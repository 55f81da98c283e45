//! Live times of a frame by pass, in milliseconds.

use adumbra_render::{FrameTimes, Stage};
use egui_plot::{Legend, Line, Plot, PlotPoints};

use crate::app::App;

/// Stages and their displayed names.
const STAGES: [(&str, Stage); 10] = [
    ("G-buffer", Stage::GBuffer),
    ("depth", Stage::Depth),
    ("build", Stage::Build),
    ("look-up", Stage::Lookup),
    ("screen", Stage::Screen),
    ("AO surface", Stage::AmbientSurface),
    ("AO estimate", Stage::AmbientEstimate),
    ("AO history", Stage::AmbientHistory),
    ("AO filter", Stage::AmbientFilter),
    ("composite", Stage::Composite),
];

pub(super) fn show(ui: &mut egui::Ui, app: &App) {
    let Some(latest) = app.times.back() else { return };
    let both = app.settings.shows_both();
    if latest[0].wall_time {
        ui.small("wall times: the device has no timestamps, or is a software renderer");
    }
    egui::Grid::new("times").num_columns(3).striped(true).show(ui, |ui| {
        for (name, stage) in STAGES {
            let ms = latest.map(|times| times.of(stage));
            if ms[0] < 0.005 && ms[1] < 0.005 {
                continue;
            }
            ui.label(name);
            ui.monospace(format!("{:8.2}", ms[0]));
            if both {
                ui.monospace(format!("{:8.2}", ms[1]));
            }
            ui.end_row();
        }
        ui.strong("total ms");
        let sum = |times: FrameTimes| times.milliseconds.iter().sum::<f64>();
        ui.monospace(format!("{:8.2}", sum(latest[0])));
        if both {
            ui.monospace(format!("{:8.2}", sum(latest[1])));
        }
        ui.end_row();
    });
    let lines = STAGES.iter().filter_map(|(name, stage)| {
        let points: Vec<[f64; 2]> =
            (0..).zip(&app.times).map(|(i, times)| [f64::from(i), times[0].of(*stage)]).collect();
        points.iter().any(|p| p[1] > 0.005).then(|| Line::new(*name, PlotPoints::from(points)))
    });
    let lines: Vec<Line<'_>> = lines.collect();
    Plot::new("times by pass")
        .height(130.0)
        .legend(Legend::default())
        .include_y(0.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .show_x(false)
        .y_axis_label("ms, first side")
        .show(ui, |plot| lines.into_iter().for_each(|line| plot.line(line)));
}
