//! Beside Qiu et al. (2014): `bench ao`, and pictures of the room with two blocks.

use adumbra_lab::occlusion::SCENES;
use adumbra_lab::page::{Body, Table};
use serde_json::Value;

use super::super::data::Data;
use super::super::page::{Seen, checks, number, rows, text};
use super::{Printed, Realised, Show, Verdict};

const SECTION: &str = "ao";
const FILE: &str = "ao/ao.json";
const ROOM: &str = "a room open to one side with two blocks";

pub(super) const PAPER: Realised = Realised {
    key: "ao-2014",
    short: "Ambient occlusion in screen space (2014)",
    items: &[
        ("table 1", Show::Beside(times)),
        ("settings", Show::Below(settings)),
        (
            "figure 1",
            Show::Nothing(
                "a drawing of where samples are taken; `taps.rs` holds the rule, the same on GPU and CPU",
            ),
        ),
        (
            "figure 2",
            Show::Nothing("a drawing; terms of samples out of reach count nothing here, as it asks"),
        ),
        ("figure 3", Show::Below(detail)),
        ("figure 4", Show::Below(attenuation)),
        ("figure 5", Show::Below(edges)),
        ("figure 6", Show::Below(everything)),
    ],
    claims: &[
        ("With 12 samples ISSAO shows more detail", |d| claim(d, "claim: more detail")),
        ("The attenuation removes", ablation),
        ("ISSAO with its bilateral filter", |d| claim(d, "claim: cleaner edges")),
        ("ISSAO takes about as long", as_long),
    ],
};

/// The paper's scene if it was measured, else the first.
fn scene(document: &Value) -> Option<&Value> {
    let scenes = rows(document, "/scenes");
    scenes.iter().find(|s| text(s, "name") == "dragon").or(scenes.first())
}

fn row<'v>(scene: &'v Value, estimator: &str) -> Option<&'v Value> {
    rows(scene, "/rows").iter().find(|r| text(r, "estimator") == estimator)
}

fn times(seen: &mut Seen<'_>, printed: &Printed, body: &mut Body) {
    let document = seen.data.json(FILE).unwrap_or_default();
    let measured = scene(&document);
    let title = measured.map_or("", |s| text(s, "title"));
    let mut table = Table::new(
        &format!("Milliseconds: the paper's of the Dragon, ours of {title}; in brackets by Alchemy's"),
        &[
            "estimator",
            "paper, with filter",
            "ours",
            "paper, without",
            "ours",
            "RMSE, with filter",
            "without",
        ],
    );
    let value = |row: usize, column: usize| {
        printed.rows.get(row).and_then(|r| r.get(column)).and_then(Value::as_f64).unwrap_or(f64::NAN)
    };
    for (column, estimator) in [(1, "hbao"), (2, "ssao"), (3, "alchemy"), (4, "issao")] {
        let papers = |r: usize| format!("{:.2} ({:.2})", value(r, column), value(r, column) / value(r, 3));
        let ours = measured.and_then(|s| row(s, estimator));
        let time = |ms: &str, by: &str| {
            ours.map_or_else(|| "–".to_owned(), |r| format!("{:.2} ({:.2})", number(r, ms), number(r, by)))
        };
        let error = |key: &str| ours.map_or_else(|| "–".to_owned(), |r| format!("{:.4}", number(r, key)));
        table.row([
            format!("`{estimator}`"),
            papers(0),
            time("/ms", "/by_alchemy"),
            papers(1),
            time("/raw_ms", "/raw_by_alchemy"),
            error("/filtered/errors/rmse"),
            error("/raw/errors/rmse"),
        ]);
    }
    body.table(&table);
    if measured.is_none() {
        seen.missing(SECTION, body);
        return;
    }
    body.paragraph(
        "12 samples each, on one chain of passes; RMSE against rays of the same radius. Ratios are comparable, milliseconds are not: the \
         paper's are of a GTS 450.",
    );
    seen.made_by(SECTION, SECTION, body);
    checks(&document, body);
}

fn settings(seen: &mut Seen<'_>, body: &mut Body) {
    let document = seen.data.json(FILE).unwrap_or_default();
    let mut table = Table::new(
        "Ours: ISSAO with these settings, in radii of its R, beside its tuned ones",
        &["scene", "settings", "RMSE", "mean signed error"],
    );
    for scene in rows(&document, "/scenes") {
        for (options, name) in [
            ("", "tuned"),
            ("preset=fig3", "figure 3"),
            ("preset=fig4", "figure 4"),
            ("preset=fig5", "figure 5"),
        ] {
            if let Some(v) = rows(scene, "/variants").iter().find(|v| text(v, "options") == options) {
                table.row([
                    text(scene, "title").to_owned(),
                    name.to_owned(),
                    format!("{:.4}", number(v, "/errors/rmse")),
                    format!("{:+.4}", number(v, "/errors/mean_signed")),
                ]);
            }
        }
    }
    if table.rows.is_empty() {
        seen.missing(SECTION, body);
    } else {
        body.table(&table);
        body.paragraph("The paper prints numbers in the units of its scenes, which it does not name; taken as shares of its R they are too dark or too light by what the last column says.");
        seen.made_by(SECTION, SECTION, body);
    }
}

fn file(name: &str) -> String {
    format!("ao/{name}.png")
}

/// Two pictures of the room.
fn pair(seen: &mut Seen<'_>, left: &str, right: &str, body: &mut Body) {
    let [a, b] = [left, right].map(|n| file(&n.replace([':', '='], "-")));
    let caption = format!("Ambient visibility of {ROOM}, radius 1");
    let name = |n: &str| if n == "truth" { "rays".to_owned() } else { format!("`{n}`") };
    seen.pair(SECTION, (&a, &name(left)), (&b, &name(right)), &caption, body);
    for picture in [left, right] {
        seen.made_by(SECTION, picture, body);
    }
}

/// A sheet of the Dragon, where it was measured.
fn sheet(seen: &mut Seen<'_>, name: &str, alt: &str, body: &mut Body) {
    if let Some(picture) = seen.data.picture(&file(name), None) {
        body.picture(&picture, alt, "Ours, the paper's model");
        seen.made_by(SECTION, SECTION, body);
    }
}

fn detail(seen: &mut Seen<'_>, body: &mut Body) {
    sheet(
        seen,
        "ao-figure-3",
        "The Dragon's head by rays, hbao, issao, and issao with the paper's settings",
        body,
    );
    pair(seen, "hbao", "issao", body);
    pair(seen, "truth", "issao", body);
}

fn attenuation(seen: &mut Seen<'_>, body: &mut Body) {
    sheet(
        seen,
        "ao-figure-4",
        "The Dragon's flank by rays, issao with its attenuation and without, tuned and with the paper's settings",
        body,
    );
    pair(seen, "issao:attenuation=off", "issao", body);
}

fn edges(seen: &mut Seen<'_>, body: &mut Body) {
    sheet(
        seen,
        "ao-figure-5",
        "The Dragon's edges by rays, alchemy, issao, and issao with a Gaussian for its filter",
        body,
    );
    pair(seen, "alchemy", "issao", body);
    pair(seen, "issao:filter=none", "issao", body);
}

fn everything(seen: &mut Seen<'_>, body: &mut Body) {
    let document = seen.data.json(FILE).unwrap_or_default();
    for scene in rows(&document, "/scenes") {
        let (name, title) = (text(scene, "name"), text(scene, "title"));
        let alt = format!("{title}: ambient visibility by rays and by every estimator");
        seen.picture(SECTION, &file(&format!("ao-{name}")), &alt, &alt, body);
    }
    pair(seen, "truth", "gtao", body);
    seen.plot(
        SECTION,
        "ao/ao-time.svg",
        "RMSE over milliseconds, a line an estimator",
        "Errors by time, 4 to 64 samples",
        body,
    );
    seen.made_by(SECTION, SECTION, body);
}

/// How many of the benchmark's scenes speak for a verdict.
fn scenes_measured(document: &Value) -> String {
    format!("Measured on {} of its {} scenes", rows(document, "/scenes").len(), SCENES.len())
}

/// A claim that the benchmark checks by itself.
fn claim(data: &Data, begins: &str) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let check = rows(&document, "/checks").iter().find(|c| text(c, "requirement").starts_with(begins));
    match check.and_then(|c| Some((c, c["holds"].as_bool()?))) {
        Some((check, holds)) => {
            let what = text(check, "requirement").trim_start_matches("claim: ");
            Verdict::of(holds, format!("{what}: {}", text(check, "measured")))
                .because(&scenes_measured(&document))
        }
        None => Verdict::Unmeasured,
    }
}

fn as_long(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let ratios: Vec<String> = rows(&document, "/scenes")
        .iter()
        .filter_map(|s| Some(format!("{} {:.2}", text(s, "title"), number(row(s, "issao")?, "/by_alchemy"))))
        .collect();
    let all =
        rows(&document, "/scenes").iter().filter_map(|s| row(s, "issao")).map(|r| number(r, "/by_alchemy"));
    let holds: Vec<bool> = all.map(|r| r <= 1.15).collect();
    Verdict::counted(&holds, format!("by Alchemy's time (the paper: 1.05): {}", ratios.join(", ")))
}

fn ablation(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let mut holds = Vec::new();
    let mut found = Vec::new();
    for scene in rows(&document, "/scenes") {
        let variant = |options: &str| rows(scene, "/variants").iter().find(|v| text(v, "options") == options);
        let (Some(with), Some(without)) = (variant(""), variant("attenuation=off")) else { continue };
        let mut cells = Vec::new();
        for (key, what) in [("/claims/self_occlusion", "self-occlusion"), ("/claims/noise", "noise")] {
            let [a, b] = [with, without].map(|v| number(v, key));
            if a.is_nan() || b.is_nan() {
                continue;
            }
            holds.push(a < b);
            cells.push(format!("{what} {a:.4}, without {b:.4}"));
        }
        found.push(format!("{}: {}", text(scene, "title"), cells.join("; ")));
    }
    Verdict::counted(&holds, found.join(". ")).because(&scenes_measured(&document))
}
