//! Counterpart to the notes on soft shadows: `bench blur`, a street, and the same city from afar.

use super::super::data::Data;
use super::super::inputs::PageInputs;
use super::{Realised, Show, Verdict};
use crate::bench::blur::{Bleeding, BlurResults, Cost};
use adumbra_compare::report::{Report, TechniqueRow};
use adumbra_html::page::{Body, Table};
use adumbra_program::format::{figure, megabytes, percent};

const FILE: &str = "blur/blur.json";

pub(super) const PAPER: Realised = Realised {
    key: "soft-2009",
    short: "Notes on soft shadows (2009)",
    items: &[
        ("picture 1", Show::Below(blur)),
        ("picture 2", Show::Below(cascades)),
        ("picture 3", Show::Below(variance)),
        ("picture 4", Show::Below(far)),
    ],
    claims: &[
        ("A shadow factor blurred", gap),
        ("The frame rate falls", cost),
        ("Dilation leaves a gap", dilation),
        ("With four splits", outlines),
    ],
};

fn street(name: &str) -> String {
    format!("shadows/street/{}.png", name.replace(':', "_"))
}

fn blur(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let truth = "shadows/street/truth-disc.png";
    for (name, what) in [
        ("blur", "The plain blur: shadows bleed across silhouettes"),
        ("blur-dilate", "Dilation before the blur, as tried in the notes"),
        ("blur-bilateral", "Weights by depth and normal, which fix it"),
    ] {
        let caption = format!("{what}. A street in a generated city; rays towards a sun disc of 0.53°");
        inputs.pair("shadows", (truth, "rays"), (&street(name), &format!("`{name}`")), &caption, body);
    }
    inputs.made_by("shadows", "street", body);
    techniques(inputs, "shadows/street/report.json", "All techniques in this street", body);
    body.heading("Cost and artefacts of the blur");
    let alt = "Milliseconds by number of samples, in two passes and in one";
    inputs.plot(
        "blur",
        "blur/blur.svg",
        alt,
        "Milliseconds of the blur's own passes by number of samples along a line",
        body,
    );
    if let Some(document) = inputs.data.results::<BlurResults>(FILE) {
        let mut table = Table::new(
            "Pixels that a blur of 32 samples changes although nothing on their own surface differs",
            &["", "halo", "gap", "largest change"],
        );
        for bleed in &document.bleeding {
            table.row(bleed.cells());
        }
        body.table(&table);
    }
    inputs.made_by("blur", "blur", body);
}

/// Adds a table of the errors and times of a comparison.
fn techniques(inputs: &mut PageInputs<'_>, file: &str, caption: &str, body: &mut Body) {
    let Some(report) = inputs.data.results::<Report>(file) else { return };
    body.table(&Table::of(
        caption,
        &report.techniques,
        &[
            ("technique", |t| format!("`{}`", t.name)),
            ("ms", |t| figure(t.gpu_ms, 2)),
            ("MB", |t| megabytes(t.bytes, 1)),
            ("RMSE", |t| figure(t.rmse, 4)),
            ("FLIP", |t| figure(t.flip, 4)),
            ("SSIM", |t| figure(t.ssim, 4)),
            ("lit called shadowed %", |t| percent(t.wrong_shadowed, 3)),
            ("shadowed called lit %", |t| percent(t.wrong_lit, 3)),
        ],
    ));
}

/// Adds a pair of pictures of the city from afar.
fn from_afar(inputs: &mut PageInputs<'_>, left: &str, right: &str, caption: &str, body: &mut Body) {
    let file = |n: &str| match n {
        "rays" => "shadows/far/truth-hard.png".to_owned(),
        n => format!("shadows/far/{}.png", n.replace(':', "_")),
    };
    let name = |n: &str| if n == "rays" { n.to_owned() } else { format!("`{n}`") };
    inputs.pair("shadows", (&file(left), &name(left)), (&file(right), &name(right)), caption, body);
}

fn cascades(inputs: &mut PageInputs<'_>, body: &mut Body) {
    from_afar(inputs, "rays", "csm:filter=1", "Ours: four unfiltered cascades, a city from a distance", body);
    inputs.made_by("shadows", "far", body);
}

fn variance(inputs: &mut PageInputs<'_>, body: &mut Body) {
    from_afar(inputs, "rays", "csm-vsm", "Ours: four cascades of variance shadow maps", body);
    inputs.made_by("shadows", "far", body);
}

fn far(inputs: &mut PageInputs<'_>, body: &mut Body) {
    from_afar(inputs, "csm:filter=1", "csm-vsm", "Ours: without and with variance shadow maps", body);
    from_afar(
        inputs,
        "csm-vsm",
        "voxel:filter=5",
        "The same, compared with one baked file, which needs no cascades",
        body,
    );
    techniques(inputs, "shadows/far/report.json", "From a distance", body);
    inputs.made_by("shadows", "far", body);
}

fn bleeding(data: &Data, name: &str) -> Option<Bleeding> {
    data.results::<BlurResults>(FILE)?.bleeding.into_iter().find(|s| s.name == name)
}

fn gap(data: &Data) -> Verdict {
    match (bleeding(data, "blur"), bleeding(data, "within surfaces")) {
        (Some(plain), Some(within)) => Verdict::of(
            plain.gap > 0,
            format!(
                "with 32 samples {} gap pixels and {} halo pixels; within surfaces {} and {}",
                plain.gap, plain.halo, within.gap, within.halo
            ),
        ),
        _ => Verdict::Unmeasured,
    }
}

fn cost(data: &Data) -> Verdict {
    let Some(document) = data.results::<BlurResults>(FILE) else { return Verdict::Unmeasured };
    let growth = |costs: &[Cost]| {
        let Cost { samples, milliseconds, .. } = costs.first()?;
        let times = milliseconds.last()? / milliseconds.first()?;
        Some((f64::from(*samples.last()?) / f64::from(*samples.first()?), times))
    };
    match (growth(&document.two_passes), growth(&document.one_pass)) {
        (Some((samples, two)), Some((_, one))) => Verdict::of(
            two > 2.0,
            format!(
                "{samples:.0} times the samples take {two:.1} times as long in two passes and {one:.0} times as long in one"
            ),
        ),
        _ => Verdict::Unmeasured,
    }
}

fn dilation(data: &Data) -> Verdict {
    let gaps: Vec<u32> = ["dilated by 1", "dilated by 2", "dilated by 4"]
        .iter()
        .filter_map(|name| Some(bleeding(data, name)?.gap))
        .collect();
    let holds: Vec<bool> = gaps.iter().map(|gap| *gap > 0).collect();
    let words: Vec<String> = gaps.iter().map(u32::to_string).collect();
    Verdict::counted(&holds, format!("gap pixels, dilated by 1, 2 and 4: {}", words.join(", ")))
}

fn outlines(data: &Data) -> Verdict {
    let Some(report) = data.results::<Report>("shadows/far/report.json") else { return Verdict::Unmeasured };
    let of = |row: &TechniqueRow| Some([row.rmse?, row.flip?]);
    let errors = |name: &str| of(report.techniques.iter().find(|r| r.name == name)?);
    match (errors("csm:filter=1"), errors("csm-vsm")) {
        (Some(plain), Some(variance)) => Verdict::counted(
            &[variance[0] < plain[0], variance[1] < plain[1]],
            format!(
                "RMSE {:.4} without, {:.4} with; FLIP {:.4} without, {:.4} with",
                plain[0], variance[0], plain[1], variance[1]
            ),
        )
        .because("The outlines in the picture are intact, but compared with hard ray-traced shadows the blur of a variance map has a larger error than aliasing"),
        _ => Verdict::Unmeasured,
    }
}
