//! Counterpart to Li et al. (2016): `bench hrsm`, and its pairs of resolutions on a ring over a floor.

mod claims;

use serde_json::Value;

use super::super::inputs::{PageInputs, checks};
use super::{Printed, Realised, Show, Verdict, cell};
use crate::bench::hrsm::{HybridResults, ModelFigures, Row};
use adumbra_compare::report::Report;
use adumbra_html::page::{Body, Table};
use adumbra_program::format::percent;

const SECTION: &str = "hrsm";
const FILE: &str = "hrsm/hrsm.json";

pub(super) const PAPER: Realised = Realised {
    key: "hybrid-2016",
    short: "Hybrid-resolution shadow maps (2016)",
    items: &[
        ("table 1", Show::Beside(dragon)),
        ("table 2", Show::Beside(models)),
        ("figure 1", Show::Below(levels)),
        ("figure 2", Show::Below(layout)),
        (
            "figure 3",
            Show::Nothing("a drawing of the list of textures, whose bytes are given under figure 2"),
        ),
        ("figure 4", Show::Below(equal_targets)),
        ("figure 5", Show::Below(thin)),
        ("figure 6", Show::Below(self_shadow)),
        ("figure 7", Show::Below(finer_starts)),
    ],
    claims: &[
        ("At least 20 % more", claims::boundary),
        ("9 to 18 % less time on models such as", |d| claims::less_time(d, Some("Dragon"), 9.0)),
        ("Four texels merge", |_| {
            Verdict::Realised("`test=paper`; the default merges texels that one plane fits")
        }),
        ("Two merges reduce", |_| Verdict::Realised("`hrsm:2048-512`")),
        ("A texel takes 128 bits", |_| Verdict::Realised("`layout=paper`; the default takes 32 or 16")),
        ("Maps of 512²", |_| Verdict::Realised("a START below 1024 prints a warning")),
        ("From 1024 to 4096", |d| claims::less_time(d, Some("Dragon"), 9.0)),
        ("Leaves and hair", claims::foliage),
        ("Self-shadowing is correct", claims::acne),
        ("At an equal target", claims::finer_is_better),
        ("Over Dragon, Bunny", |d| claims::less_time(d, None, 5.0)),
    ],
};

/// Returns a model's row of a technique at a START, unfiltered.
fn row<'v>(model: &'v ModelFigures, start: u32, name: &str) -> Option<&'v Row> {
    model.group(start, 1)?.row(name)
}

/// Returns frame times of a model at a START.
///
/// These are the milliseconds of the shadow map and of the hybrid map with one merge, and the ratio of hybrid
/// to shadow map for a moving light and for a still one.
fn frames(model: &ModelFigures, start: u32) -> Option<[f64; 4]> {
    let plain = row(model, start, &format!("sm:size={start}"))?;
    let hybrid = row(model, start, &format!("hrsm:{start}-{}:filter=1", start / 2))?;
    Some([plain.frame_ms, hybrid.frame_ms, hybrid.frame_ratio, hybrid.still_frame_ratio])
}

/// Returns the measured models, none if there are no results.
fn models_of(document: Option<&HybridResults>) -> &[ModelFigures] {
    document.map_or(&[], |d| &d.models)
}

fn model<'v>(document: Option<&'v HybridResults>, title: &str) -> Option<&'v ModelFigures> {
    models_of(document).iter().find(|m| m.title == title)
}

const WHY: &str = "Ours: whole frames, unfiltered, START merged once, with a moving light. In the column for a static light the scene is static too, \
    so the map is kept. The paper gives neither its filter nor its targets. With a moving light, building the map costs more than its \
    look-ups save. What a kept map saves depends on the adapter; on a software renderer it says little.";

fn percent_less(ratio: f64) -> String {
    if ratio.is_nan() { "–".to_owned() } else { format!("{:+.0} %", 100.0 * (ratio - 1.0)) }
}

/// Columns of the paper's times and of ours.
const TIMES: [&str; 7] = [
    "paper SM ms",
    "paper HRSM ms",
    "paper, change",
    "our SM ms",
    "our HRSM ms",
    "ours, change",
    "ours, static light",
];

fn dragon(inputs: &mut PageInputs<'_>, printed: &Printed, body: &mut Body) {
    let head = [&["START"][..], &TIMES].concat();
    let document = inputs.data.results::<HybridResults>(FILE);
    let measured = model(document.as_ref(), "Dragon");
    let mut table =
        Table::new("Dragon, paper and ours: milliseconds, and the change in time from SM to HRSM", &head);
    for (printed, start) in printed.rows.iter().zip([1024, 2048, 4096]) {
        let number = |i: usize| printed.get(i).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let ours = measured.and_then(|m| frames(m, start));
        let mut cells = vec![start.to_string(), number(1).to_string(), number(2).to_string()];
        cells.push(percent_less(number(2) / number(1)));
        cells.extend(of(ours));
        table.row(cells);
    }
    body.table(&table);
    explain(
        inputs,
        measured.is_some(),
        "the Dragon (2.4 million triangles) is measured with `--scenes`, and all four models with `--full`",
        body,
    );
}

fn of(ours: Option<[f64; 4]>) -> [String; 4] {
    match ours {
        Some([plain, hybrid, ratio, still]) => {
            [format!("{plain:.1}"), format!("{hybrid:.1}"), percent_less(ratio), percent_less(still)]
        }
        None => std::array::from_fn(|_| "–".to_owned()),
    }
}

fn explain(inputs: &PageInputs<'_>, measured: bool, why: &str, body: &mut Body) {
    if measured {
        body.paragraph(WHY);
    } else {
        body.note(&format!("Not measured in this run: {why}."));
    }
    inputs.made_by(SECTION, SECTION, body);
}

fn models(inputs: &mut PageInputs<'_>, printed: &Printed, body: &mut Body) {
    let document = inputs.data.results::<HybridResults>(FILE);
    let head = [&["model", "triangles", "START"][..], &TIMES].concat();
    let mut table = Table::new("All models, paper and ours, as in table 1", &head);
    for printed in &printed.rows {
        let number = |i: usize| printed.get(i).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let name = printed.first().map(cell).unwrap_or_default();
        for (i, start) in [(0, 1024), (1, 2048)] {
            let ours = model(document.as_ref(), &name).and_then(|m| frames(m, start));
            let (plain, hybrid) = (number(3 + i), number(5 + i));
            let triangles = printed.get(2).map(cell).unwrap_or_default();
            let mut cells = vec![name.clone(), triangles, start.to_string()];
            cells.extend([plain, hybrid].map(|ms| format!("{ms:.1}")));
            cells.push(percent_less(hybrid / plain));
            cells.extend(of(ours));
            table.row(cells);
        }
    }
    body.table(&table);
    let document = document.filter(|d| !d.models.is_empty());
    explain(inputs, document.is_some(), "see above", body);
    if let Some(document) = document {
        checks(&document.checks, body);
        body.paragraph(&document.covers);
    }
}

fn levels(inputs: &mut PageInputs<'_>, body: &mut Body) {
    body.paragraph(
        "Ours, after two merges: the map's finest texels in red, coarser ones in orange and green.",
    );
    inputs.picture(SECTION, "hrsm/hrsm-levels.png", "Models with their shadows, coloured by the level of the map that is sampled: red along outlines, green elsewhere", "Sampled levels, by model", body);
    inputs.made_by(SECTION, SECTION, body);
}

fn layout(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let document = inputs.data.results::<HybridResults>(FILE);
    let mut table = Table::new(
        "Ours: size of the paper's layout and of the compact one, two merges",
        &["model", "START", "paper's layout, MB", "compact, MB", "shadow map at START, MB"],
    );
    for model in models_of(document.as_ref()) {
        for start in [1024, 2048, 4096] {
            let name = format!("hrsm:{start}-{}:filter=1", start / 4);
            let [paper, compact, plain] = [format!("{name}:layout=paper"), name, format!("sm:size={start}")]
                .map(|name| row(model, start, &name).map(|r| r.still_bytes as f64 / 1e6));
            if let (Some(paper), Some(compact), Some(plain)) = (paper, compact, plain) {
                let numbers = [paper, compact, plain].map(|v| format!("{v:.2}"));
                table.row([model.title.clone(), start.to_string()].into_iter().chain(numbers));
            }
        }
    }
    let remark = "Sizes are for a static light. Both layouts give bit-identical results.";
    inputs.table(SECTION, SECTION, &table, Some(remark), body);
}

fn picture(name: &str) -> String {
    format!("hrsm/pictures/{}.png", name.replace(':', "_"))
}

/// Adds a pair of pictures of a shadow map and a hybrid one.
fn beside(inputs: &mut PageInputs<'_>, left: &str, right: &str, caption: &str, body: &mut Body) {
    let [a, b] = [left, right].map(picture);
    inputs.pair(SECTION, (&a, &format!("`{left}`")), (&b, &format!("`{right}`")), caption, body);
}

fn equal_targets(inputs: &mut PageInputs<'_>, body: &mut Body) {
    inputs.sheet(
        SECTION,
        "hrsm/hrsm-figure-4.png",
        "The outline of the Dragon's shadow, shadow maps on the left, hybrid maps on the right",
        body,
    );
    body.paragraph("Ours, a ring over a floor, unfiltered. The targets are equal, so only outlines differ.");
    for [left, right] in [
        ["sm:size=1024", "hrsm:2048-1024:filter=1"],
        ["sm:size=512", "hrsm:1024-512:filter=1"],
        ["sm:size=2048", "hrsm:4096-2048:filter=1"],
    ] {
        beside(inputs, left, right, "A ring and its shadow", body);
    }
    errors(inputs, body);
}

fn errors(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let Some(report) = inputs.data.results::<Report>("hrsm/pictures/report.json") else { return };
    body.table(&Table::of(
        "Errors of these pictures, % of the compared pixels",
        &report.techniques,
        &[
            ("technique", |t| format!("`{}`", t.name)),
            ("lit called shadowed", |t| percent(t.wrong_shadowed, 3)),
            ("shadowed called lit", |t| percent(t.wrong_lit, 3)),
        ],
    ));
    inputs.made_by(SECTION, "pictures", body);
}

fn thin(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let alt =
        "A pavilion of thin rods and its shadow, twice: shadow map on the left, hybrid map on the right";
    inputs.picture(
        SECTION,
        "hrsm/hrsm-figure-5.png",
        alt,
        "Ours, a pavilion of rods: SM 2048 left, HRSM 4096-2048 right, unfiltered",
        body,
    );
    inputs.made_by(SECTION, SECTION, body);
}

fn self_shadow(inputs: &mut PageInputs<'_>, body: &mut Body) {
    inputs.sheet(
        SECTION,
        "hrsm/hrsm-figure-6.png",
        "The Dragon's shadow on itself: hybrid map, rays, the paper's test, a shadow map",
        body,
    );
    let (truth, ours) = ("hrsm/pictures/truth-hard.png", picture("hrsm:2048-1024:filter=1"));
    inputs.pair(
        SECTION,
        (truth, "rays"),
        (&ours, "`hrsm:2048-1024`"),
        "Ours, a ring: with the plane test",
        body,
    );
    let paper = picture("hrsm:2048-1024:test=paper:filter=1");
    inputs.pair(
        SECTION,
        (truth, "rays"),
        (&paper, "`test=paper`"),
        "Ours, a ring: with the paper's test as printed",
        body,
    );
    body.paragraph(
        "The paper's test compares differences in depth with a quarter of the distance from the light. A sun is far away, so it merges \
         nearly everything: slopes become steps that shadow themselves. The default test merges texels that one plane fits.",
    );
    inputs.made_by(SECTION, "pictures", body);
}

fn finer_starts(inputs: &mut PageInputs<'_>, body: &mut Body) {
    inputs.sheet(
        SECTION,
        "hrsm/hrsm-figure-7.png",
        "The outline of the Dragon's shadow, target 512, with finer and finer starts",
        body,
    );
    for start in [1024, 2048, 4096] {
        let right = format!("hrsm:{start}-512:filter=1");
        beside(inputs, "sm:size=512", &right, "Ours, a ring: target 512", body);
    }
    inputs.made_by(SECTION, "pictures", body);
}
