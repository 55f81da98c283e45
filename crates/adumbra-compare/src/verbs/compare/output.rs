//! The files that `compare` writes into its folder.

use std::path::Path;

use crate::Result;
use crate::compare::{Compared, Comparison};
use crate::pictures::{Cell, sheet};
use crate::report::{PathReport, Report, SweepReport, SweepRow, TruthKind};
use adumbra_html::plot::{Along, Legend, Panel, Series, draw_svg};
use adumbra_program::format::{figure, percent};
use adumbra_program::output::Outputs;
use adumbra_truth::picture::Picture;
use serde_json::Value;

use crate::verbs::render::name_in_paths;

/// Largest width of a picture on the sheet, pixels.
const WIDEST: u32 = 640;

/// Writes the tables, the pictures, the sheet, and the files of a path and of a sweep. `of_changes` are a
/// sweep's pictures.
pub(super) fn write(
    folder: &Path,
    report: &Report,
    comparison: &Comparison,
    of_changes: &[Picture],
    document: &Value,
) -> Result<()> {
    let mut outputs = Outputs::default();
    outputs.add(&folder.join("report.json"), format!("{document:#}\n").as_bytes())?;
    outputs.add(&folder.join("report.md"), report.markdown().as_bytes())?;
    for (kind, picture) in &comparison.truths {
        outputs.add_png(&folder.join(format!("truth-{}.png", kind_name(*kind))), picture)?;
    }
    for compared in &comparison.compared {
        let name = name_in_paths(&compared.row.name);
        outputs.add_png(&folder.join(format!("{name}.png")), &compared.picture)?;
        outputs.add_png(&folder.join(format!("{name}.difference.png")), &compared.difference)?;
    }
    outputs.add_png(&folder.join("sheet.png"), &whole_sheet(comparison))?;
    if let Some(path) = &report.path {
        outputs.add(&folder.join("path.csv"), path.csv().as_bytes())?;
        let svg = folder.join("path.svg");
        outputs.add(&svg, draw_svg(&svg, &[panel(path, report)])?.as_bytes())?;
    }
    if let Some(sweep) = &report.sweep {
        let svg = folder.join("sweep.svg");
        outputs.add(&svg, draw_svg(&svg, &sweep_panels(sweep))?.as_bytes())?;
        for (technique, picture) in sweep.techniques.iter().zip(of_changes) {
            let name = name_in_paths(&technique.name);
            outputs.add_png(&folder.join(format!("{name}.changes.png")), picture)?;
        }
    }
    Ok(outputs.place()?)
}

fn kind_name(kind: TruthKind) -> &'static str {
    match kind {
        TruthKind::Hard => "hard",
        TruthKind::Disc => "disc",
    }
}

/// Draws the sheet: one row per technique, with the truth, its picture, and where it is wrong.
fn whole_sheet(comparison: &Comparison) -> Picture {
    let mut cells = Vec::new();
    for compared in &comparison.compared {
        let truth = comparison.truths.iter().find(|t| t.0 == compared.row.truth);
        let [first, second, third] = captions(compared);
        if let Some((kind, picture)) = truth {
            let caption = vec![format!("truth, {} sun", kind_name(*kind))];
            cells.push(Cell { picture, caption });
        }
        cells.push(Cell { picture: &compared.picture, caption: vec![compared.row.name.clone(), first] });
        cells.push(Cell { picture: &compared.difference, caption: vec![second, third] });
    }
    sheet(&cells, 3, WIDEST)
}

fn captions(compared: &Compared) -> [String; 3] {
    let row = &compared.row;
    let time = row
        .gpu_ms
        .map_or_else(String::new, |ms| format!("{ms:.2} ms{} ", if row.wall_time { " (wall)" } else { "" }));
    [
        format!("{time}FLIP {} SSIM {}", figure(row.flip, 4), figure(row.ssim, 4)),
        format!("red: lit called shadowed {} %", percent(row.wrong_shadowed, 3)),
        format!("blue: shadowed called lit {} %", percent(row.wrong_lit, 3)),
    ]
}

fn panel(path: &PathReport, report: &Report) -> Panel {
    let series = path.techniques.iter().map(|t| Series {
        name: t.name.clone(),
        points: (0_u32..).zip(&t.gpu_ms).map(|(frame, ms)| (f64::from(frame), *ms)).collect(),
    });
    let wall = path.techniques.iter().any(|t| t.wall_time);
    Panel {
        title: format!("{}, shadow passes{}", report.scene, if wall { " (wall time)" } else { "" }),
        along: Along::Numbers("frame"),
        y_label: "ms",
        logarithmic: true,
        legend: Legend::UpperRight,
        series: series.collect(),
    }
}

/// Returns the wrong pixels by time, and those that change.
fn sweep_panels(sweep: &SweepReport) -> [Panel; 2] {
    let series = |name: &str, shares: &[Option<f64>]| Series {
        name: name.to_owned(),
        points: (sweep.seconds.iter().zip(shares))
            .filter_map(|(seconds, share)| Some((sweep.hour(*seconds), 100.0 * (*share)?)))
            .collect(),
    };
    let of = |shares: fn(&SweepRow) -> &[Option<f64>]| {
        sweep.techniques.iter().map(move |t| series(&t.name, shares(t)))
    };
    let panel = |title: &str, y_label, series| Panel {
        title: title.to_owned(),
        along: Along::Numbers("hour"),
        y_label,
        logarithmic: false,
        legend: Legend::UpperRight,
        series,
    };
    let rays = series("rays", &sweep.rays_changes_by_step);
    [
        panel("Wrong pixels", "percent", of(|t| &t.wrong_by_step).collect()),
        panel(
            "Pixels that change per step",
            "percent",
            // The rays come last, so that a technique has the same colour in both.
            of(|t| &t.changes_by_step).chain([rays]).collect(),
        ),
    ]
}
