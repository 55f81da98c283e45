//! Beside the notes on soft shadows: `bench blur`, a street, and the same city from afar.

use adumbra_lab::page::{Body, Table};
use serde_json::Value;

use super::super::data::Data;
use super::super::page::{Seen, number, rows, text};
use super::{Realised, Show, Verdict};

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
        ("A shade factor blurred", gap),
        ("Frames fall steeply", cost),
        ("Dilation, however often", dilation),
        ("With four splits", outlines),
    ],
};

fn street(name: &str) -> String {
    format!("shadows/street/{}.png", name.replace(':', "_"))
}

fn blur(seen: &mut Seen<'_>, body: &mut Body) {
    let truth = "shadows/street/truth-disc.png";
    for (name, what) in [
        ("blur", "The plain blur: shadows bleed over silhouettes"),
        ("blur-dilate", "Dilated before the blur, as the notes tried"),
        ("blur-bilateral", "Weights that see depth and normal, which mend it"),
    ] {
        let caption = format!("{what}. A street of a made city; rays towards a sun of 0.53°");
        seen.pair("shadows", (truth, "rays"), (&street(name), &format!("`{name}`")), &caption, body);
    }
    seen.made_by("shadows", "street", body);
    techniques(seen, "shadows/street/report.json", "Every technique in that street", body);
    body.heading("What a blur costs and spoils");
    let alt = "Milliseconds by samples, in two passes and in one";
    seen.plot(
        "blur",
        "blur/blur.svg",
        alt,
        "Milliseconds of the blur's own passes by samples along a line",
        body,
    );
    if let Some(document) = seen.data.json("blur/blur.json") {
        let mut table = Table::new(
            "Pixels that 32 samples change though nothing on their own surface differs",
            &["", "halo", "gap", "largest change"],
        );
        for row in rows(&document, "/spoils") {
            let largest = format!("{:.3}", number(row, "/largest"));
            table.row([
                text(row, "name").to_owned(),
                row["halo"].to_string(),
                row["gap"].to_string(),
                largest,
            ]);
        }
        body.table(&table);
    }
    seen.made_by("blur", "blur", body);
}

/// Errors and times of a comparison.
fn techniques(seen: &mut Seen<'_>, file: &str, caption: &str, body: &mut Body) {
    let Some(report) = seen.data.json(file) else { return };
    let head =
        ["technique", "ms", "MB", "RMSE", "FLIP", "SSIM", "lit called shadowed %", "shadowed called lit %"];
    let mut table = Table::new(caption, &head);
    for row in rows(&report, "/techniques") {
        let of = |key: &str, scale: f64, digits: usize| format!("{:.digits$}", scale * number(row, key));
        table.row([
            format!("`{}`", text(row, "name")),
            of("/gpu_ms", 1.0, 2),
            of("/bytes", 1e-6, 1),
            of("/rmse", 1.0, 4),
            of("/flip", 1.0, 4),
            of("/ssim", 1.0, 4),
            of("/wrong_shadowed", 100.0, 3),
            of("/wrong_lit", 100.0, 3),
        ]);
    }
    body.table(&table);
}

/// A pair of the city from afar.
fn from_afar(seen: &mut Seen<'_>, left: &str, right: &str, caption: &str, body: &mut Body) {
    let file = |n: &str| match n {
        "rays" => "shadows/far/truth-hard.png".to_owned(),
        n => format!("shadows/far/{}.png", n.replace(':', "_")),
    };
    let name = |n: &str| if n == "rays" { n.to_owned() } else { format!("`{n}`") };
    seen.pair("shadows", (&file(left), &name(left)), (&file(right), &name(right)), caption, body);
}

fn cascades(seen: &mut Seen<'_>, body: &mut Body) {
    from_afar(seen, "rays", "csm:filter=1", "Ours: four cascades without a filter, a city from afar", body);
    seen.made_by("shadows", "far", body);
}

fn variance(seen: &mut Seen<'_>, body: &mut Body) {
    from_afar(seen, "rays", "csm-vsm", "Ours: four cascades of variance maps", body);
    seen.made_by("shadows", "far", body);
}

fn far(seen: &mut Seen<'_>, body: &mut Body) {
    from_afar(seen, "csm:filter=1", "csm-vsm", "Ours: without variance maps, and with them", body);
    from_afar(
        seen,
        "csm-vsm",
        "voxel:filter=5",
        "The same beside one baked file, which needs no cascades",
        body,
    );
    techniques(seen, "shadows/far/report.json", "From afar", body);
    seen.made_by("shadows", "far", body);
}

fn spoils<'v>(document: &'v Value, name: &str) -> Option<&'v Value> {
    rows(document, "/spoils").iter().find(|r| text(r, "name") == name)
}

fn gap(data: &Data) -> Verdict {
    let document = data.json("blur/blur.json").unwrap_or_default();
    match (spoils(&document, "blur"), spoils(&document, "within surfaces")) {
        (Some(plain), Some(mended)) => Verdict::of(
            number(plain, "/gap") > 0.0,
            format!(
                "{} pixels of gap and {} of halo with 32 samples; within surfaces {} and {}",
                plain["gap"], plain["halo"], mended["gap"], mended["halo"]
            ),
        ),
        _ => Verdict::Unmeasured,
    }
}

fn cost(data: &Data) -> Verdict {
    let document = data.json("blur/blur.json").unwrap_or_default();
    let growth = |key: &str| {
        let row = rows(&document, key).first()?;
        let [samples, times] = ["/samples", "/milliseconds"].map(|k| rows(row, k));
        let ratio = |v: &[Value]| Some(v.last()?.as_f64()? / v.first()?.as_f64()?);
        Some((ratio(samples)?, ratio(times)?))
    };
    match (growth("/two_passes"), growth("/one_pass")) {
        (Some((samples, two)), Some((_, one))) => Verdict::of(
            two > 2.0,
            format!(
                "{samples:.0} times the samples take {two:.1} times as long in two passes and {one:.0} times in one"
            ),
        ),
        _ => Verdict::Unmeasured,
    }
}

fn dilation(data: &Data) -> Verdict {
    let document = data.json("blur/blur.json").unwrap_or_default();
    let gaps: Vec<f64> = ["dilated by 1", "dilated by 2", "dilated by 4"]
        .iter()
        .filter_map(|name| Some(number(spoils(&document, name)?, "/gap")))
        .collect();
    let holds: Vec<bool> = gaps.iter().map(|g| *g > 0.0).collect();
    let words: Vec<String> = gaps.iter().map(|g| format!("{g:.0}")).collect();
    Verdict::counted(&holds, format!("pixels of gap, dilated by 1, 2 and 4: {}", words.join(", ")))
}

fn outlines(data: &Data) -> Verdict {
    let Some(report) = data.json("shadows/far/report.json") else { return Verdict::Unmeasured };
    let of = |name: &str, key: &str| {
        rows(&report, "/techniques").iter().find(|r| text(r, "name") == name).map(|r| number(r, key))
    };
    let errors = |name: &str| Some([of(name, "/rmse")?, of(name, "/flip")?]);
    match (errors("csm:filter=1"), errors("csm-vsm")) {
        (Some(plain), Some(variance)) => Verdict::counted(
            &[variance[0] < plain[0], variance[1] < plain[1]],
            format!(
                "RMSE {:.4} without, {:.4} with; FLIP {:.4} without, {:.4} with",
                plain[0], variance[0], plain[1], variance[1]
            ),
        )
        .because("Outlines are whole in the picture, but beside rays towards a hard sun the blur of a variance map errs more than jags do"),
        _ => Verdict::Unmeasured,
    }
}
