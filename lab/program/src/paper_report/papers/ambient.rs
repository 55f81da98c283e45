//! Counterpart to Qiu et al. (2014): `bench ao`, and pictures of the room with two blocks.

use serde_json::Value;

use super::super::data::Data;
use super::super::inputs::{PageInputs, checks};
use super::{Printed, Realised, Show, Verdict};
use crate::bench::ao::{AoResults, Row, SceneFigures};
use crate::occlusion::SCENES;
use adumbra_html::page::{Body, Table};

const SECTION: &str = "ao";
const FILE: &str = "ao/ao.json";
const ROOM: &str = "a room with two blocks, open on one side";

pub(super) const PAPER: Realised = Realised {
    key: "ao-2014",
    short: "Screen-space ambient occlusion (2014)",
    items: &[
        ("table 1", Show::Beside(times)),
        ("settings", Show::Below(settings)),
        (
            "figure 1",
            Show::Nothing(
                "a drawing of the sample positions; `taps.rs` implements them, identically on GPU and CPU",
            ),
        ),
        (
            "figure 2",
            Show::Nothing("a drawing; as it requires, samples out of range contribute nothing here"),
        ),
        ("figure 3", Show::Below(|inputs, body| DETAIL.show(inputs, body))),
        ("figure 4", Show::Below(|inputs, body| ATTENUATION.show(inputs, body))),
        ("figure 5", Show::Below(|inputs, body| EDGES.show(inputs, body))),
        ("figure 6", Show::Below(everything)),
    ],
    claims: &[
        ("With 12 samples ISSAO shows more detail", |d| claim(d, "claim: more detail")),
        ("The attenuation removes", ablation),
        ("ISSAO with its bilateral filter", |d| claim(d, "claim: cleaner edges")),
        ("ISSAO takes about as long", as_long),
    ],
};

/// Returns the paper's scene if it was measured, else the first one.
fn scene(document: &AoResults) -> Option<&SceneFigures> {
    document.scenes.iter().find(|s| s.name == "dragon").or(document.scenes.first())
}

fn row<'v>(scene: &'v SceneFigures, estimator: &str) -> Option<&'v Row> {
    scene.rows.iter().find(|r| r.estimator == estimator)
}

/// Returns the benchmark's results, or `None` if there are none.
fn document(data: &Data) -> Option<AoResults> {
    data.results(FILE)
}

fn scenes(document: Option<&AoResults>) -> &[SceneFigures] {
    document.map_or(&[], |d| &d.scenes)
}

fn times(inputs: &mut PageInputs<'_>, printed: &Printed, body: &mut Body) {
    let document = document(inputs.data);
    let measured = document.as_ref().and_then(scene);
    let title = measured.map_or("", |s| &*s.title);
    let mut table = Table::new(
        &format!(
            "Milliseconds: the paper's for the Dragon, ours for {title}; in parentheses relative to Alchemy"
        ),
        &[
            "estimator",
            "paper, filtered",
            "ours, filtered",
            "paper, unfiltered",
            "ours, unfiltered",
            "RMSE, filtered",
            "RMSE, unfiltered",
        ],
    );
    let value = |row: usize, column: usize| {
        printed.rows.get(row).and_then(|r| r.get(column)).and_then(Value::as_f64).unwrap_or(f64::NAN)
    };
    for (column, estimator) in [(1, "hbao"), (2, "ssao"), (3, "alchemy"), (4, "issao")] {
        let papers = |r: usize| format!("{:.2} ({:.2})", value(r, column), value(r, column) / value(r, 3));
        let ours = measured.and_then(|s| row(s, estimator));
        let time = |of: fn(&Row) -> [f64; 2]| {
            ours.map(of).map_or_else(|| "–".to_owned(), |[ms, by]| format!("{ms:.2} ({by:.2})"))
        };
        let error =
            |of: fn(&Row) -> f64| ours.map(of).map_or_else(|| "–".to_owned(), |rmse| format!("{rmse:.4}"));
        table.row([
            format!("`{estimator}`"),
            papers(0),
            time(|r| [r.ms, r.by_alchemy]),
            papers(1),
            time(|r| [r.raw_ms, r.raw_by_alchemy]),
            error(|r| r.filtered.errors.rmse),
            error(|r| r.raw.errors.rmse),
        ]);
    }
    body.table(&table);
    if measured.is_none() {
        inputs.missing(SECTION, body);
        return;
    }
    body.paragraph(
        "All estimators take 12 samples in the same chain of passes. RMSE is against rays of the same radius. Ratios are comparable; \
         milliseconds are not, because the paper's are from a GTS 450.",
    );
    inputs.made_by(SECTION, SECTION, body);
    checks(document.as_ref().map_or(&[], |d| &d.checks), body);
}

fn settings(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let document = document(inputs.data);
    let mut table = Table::new(
        "Ours: ISSAO with these settings, as fractions of R, compared with the tuned ones",
        &["scene", "settings", "RMSE", "mean signed error"],
    );
    for scene in scenes(document.as_ref()) {
        for (options, name) in [
            ("", "tuned"),
            ("preset=fig3", "figure 3"),
            ("preset=fig4", "figure 4"),
            ("preset=fig5", "figure 5"),
        ] {
            if let Some(v) = scene.variant(options) {
                table.row([
                    scene.title.to_string(),
                    name.to_owned(),
                    format!("{:.4}", v.errors.rmse),
                    format!("{:+.4}", v.errors.mean_signed),
                ]);
            }
        }
    }
    let remark = "The paper prints these numbers in scene units that it does not specify. Taken as fractions of R, they make the picture too dark or too light by the mean signed error.";
    inputs.table(SECTION, SECTION, &table, Some(remark), body);
}

fn file(name: &str) -> String {
    format!("ao/{name}.png")
}

/// Adds a pair of pictures of the room.
fn pair(inputs: &mut PageInputs<'_>, left: &str, right: &str, body: &mut Body) {
    let [a, b] = [left, right].map(|n| file(&n.replace([':', '='], "-")));
    let caption = format!("Ambient visibility of {ROOM}, radius 1");
    let name = |n: &str| if n == "truth" { "rays".to_owned() } else { format!("`{n}`") };
    inputs.pair(SECTION, (&a, &name(left)), (&b, &name(right)), &caption, body);
    for picture in [left, right] {
        inputs.made_by(SECTION, picture, body);
    }
}

/// A sheet of the Dragon, and pictures of the room next to issao's.
struct Figure {
    sheet: &'static str,
    alt: &'static str,
    /// Pictures to show left of the divider. The picture of issao is right of it.
    left: &'static [&'static str],
}

const DETAIL: Figure = Figure {
    sheet: "ao-figure-3",
    alt: "The Dragon's head by rays, hbao, issao, and issao with the paper's settings",
    left: &["hbao", "truth"],
};
const ATTENUATION: Figure = Figure {
    sheet: "ao-figure-4",
    alt: "The Dragon's flank by rays, and by issao with and without its attenuation, tuned and with the paper's settings",
    left: &["issao:attenuation=off"],
};
const EDGES: Figure = Figure {
    sheet: "ao-figure-5",
    alt: "The Dragon's edges by rays, alchemy, issao, and issao with a Gaussian filter",
    left: &["alchemy", "issao:filter=none"],
};

impl Figure {
    fn show(&self, inputs: &mut PageInputs<'_>, body: &mut Body) {
        inputs.sheet(SECTION, &file(self.sheet), self.alt, body);
        for left in self.left {
            pair(inputs, left, "issao", body);
        }
    }
}

fn everything(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let document = document(inputs.data);
    for SceneFigures { name, title, .. } in scenes(document.as_ref()) {
        let alt = format!("{title}: ambient visibility by rays and by every estimator");
        inputs.picture(SECTION, &file(&format!("ao-{name}")), &alt, &alt, body);
    }
    pair(inputs, "truth", "gtao", body);
    inputs.plot(
        SECTION,
        "ao/ao-time.svg",
        "RMSE over milliseconds, one line per estimator",
        "Error against time, 4 to 64 samples",
        body,
    );
    inputs.made_by(SECTION, SECTION, body);
}

/// Describes how many of the benchmark's scenes a verdict is based on.
fn scenes_measured(scenes: &[SceneFigures]) -> String {
    format!("Measured on {} of the benchmark's {} scenes", scenes.len(), SCENES.len())
}

/// Returns the verdict on a claim that the benchmark itself checks.
fn claim(data: &Data, begins: &str) -> Verdict {
    let Some(document) = document(data) else { return Verdict::Unmeasured };
    let check = document.checks.iter().find(|c| c.requirement.starts_with(begins));
    match check.and_then(|c| Some((c, c.holds?))) {
        Some((check, holds)) => {
            let what = check.requirement.trim_start_matches("claim: ");
            Verdict::of(holds, format!("{what}: {}", check.measured))
                .because(&scenes_measured(&document.scenes))
        }
        None => Verdict::Unmeasured,
    }
}

fn as_long(data: &Data) -> Verdict {
    let document = document(data);
    let scenes = scenes(document.as_ref());
    let by_alchemy = |s: &SceneFigures| Some(row(s, "issao")?.by_alchemy);
    let ratios: Vec<String> =
        scenes.iter().filter_map(|s| Some(format!("{} {:.2}", s.title, by_alchemy(s)?))).collect();
    let holds: Vec<bool> = scenes.iter().filter_map(by_alchemy).map(|r| r <= 1.15).collect();
    Verdict::counted(&holds, format!("time relative to Alchemy (paper: 1.05): {}", ratios.join(", ")))
}

fn ablation(data: &Data) -> Verdict {
    let document = document(data);
    let scenes = scenes(document.as_ref());
    let mut holds = Vec::new();
    let mut found = Vec::new();
    for scene in scenes {
        let found_of = [scene.variant(""), scene.variant("attenuation=off")];
        let [Some(with), Some(without)] = found_of else { continue };
        let mut cells = Vec::new();
        let [with, without] = [with, without].map(|v| &v.claims);
        for (a, b, what) in [
            (with.self_occlusion, without.self_occlusion, "self-occlusion"),
            (with.noise, without.noise, "noise"),
        ] {
            let (Some(a), Some(b)) = (a, b) else { continue };
            holds.push(a < b);
            cells.push(format!("{what} {a:.4} with it, {b:.4} without"));
        }
        found.push(format!("{}: {}", scene.title, cells.join("; ")));
    }
    Verdict::counted(&holds, found.join(". ")).because(&scenes_measured(scenes))
}
