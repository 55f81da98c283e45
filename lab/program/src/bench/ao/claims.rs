//! The paper's figures 3 to 5, its times and its settings compared with ours.

use std::fmt::Write as _;

use adumbra_render::occlusion::Estimator;

use super::variants::{FIG_3, FIG_4, FIG_5, Variant, WITHOUT_ATTENUATION};
use super::{AoResults, SceneFigures};
use crate::occlusion::{BLUR_PIXELS, Claims, EDGE_COSINE, EDGE_PIXELS, EDGE_STEP, FLAT, OPEN};

/// Milliseconds on a GTS 450 for the Dragon, with and without the bilateral filter.
///
/// The column headings are lost in print. The order is most likely that of the paper's text.
const PAPER_TIMES: [(Estimator, [f64; 2]); 4] = [
    (Estimator::Hbao, [14.64, 10.97]),
    (Estimator::Ssao, [8.37, 4.54]),
    (Estimator::Alchemy, [8.33, 4.67]),
    (Estimator::Issao, [8.77, 5.10]),
];

// Writing to a `String` never fails, so the results of `write!` are discarded throughout.

pub(super) fn text(document: &AoResults) -> String {
    let mut text = format!(
        "## The paper's claims\n\nThe high pass of a picture is the picture minus its Gaussian blur with a \
        standard deviation of {BLUR_PIXELS} pixels. *Detail*: the correlation of the high pass with the truth's \
        (1 is best); in brackets, its variance divided by the truth's (below 1: blurred; above 1: noisy or too \
        strong). *Self-occlusion*: mean occlusion where the truth is above {OPEN}. *Edges*: RMSE within \
        {EDGE_PIXELS} pixels of a discontinuity (a neighbour more than {EDGE_STEP} radii away from the surface's \
        plane, or a cosine between the normals below {EDGE_COSINE}). *Noise*: root mean square of the high pass \
        where the truth's is below {FLAT} around the pixel. `preset=figN` is issao with the untuned settings \
        that the paper prints for its figure N, in multiples of its radius R.\n\n"
    );
    let table = |text: &mut String,
                 title: &str,
                 names: &[(String, Pick)],
                 cell: &dyn Fn(&Claims) -> String| {
        let known: Vec<&(String, Pick)> =
            names.iter().filter(|(_, pick)| document.scenes.iter().any(|s| pick.of(s).is_some())).collect();
        let _ = write!(text, "{title}\n\n| scene |");
        for (name, _) in &known {
            let _ = write!(text, " `{name}` |");
        }
        let _ = writeln!(text, "\n|---|{}", "---|".repeat(known.len()));
        for scene in &document.scenes {
            let _ = write!(text, "| {} |", scene.title);
            for (_, pick) in &known {
                let _ = write!(text, " {} |", pick.of(scene).map_or_else(|| "–".to_owned(), cell));
            }
            text.push('\n');
        }
        text.push('\n');
    };
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.4}"));
    let all = |filtered: bool| Estimator::ALL.map(|e| (e.name().to_owned(), Pick::Row(e, filtered)));
    let with = |extra: &[&'static str]| {
        let presets = extra.iter().map(|o| (super::variants::name(o), Pick::Variant(o)));
        all(true).into_iter().chain(presets).collect::<Vec<_>>()
    };
    let detail = |c: &Claims| {
        let variance = c.detail_variance.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
        c.detail_correlation.map_or_else(|| "–".to_owned(), |v| format!("{v:.3} ({variance})"))
    };
    table(&mut text, "Figure 3, detail, with filter:", &with(&[FIG_3]), &detail);
    table(&mut text, "Figure 3, detail, without filter:", &all(false), &detail);
    let dark = [WITHOUT_ATTENUATION, FIG_4, "preset=fig4:attenuation=off"];
    table(&mut text, "Figure 4, self-occlusion, with filter:", &with(&dark), &|c| number(c.self_occlusion));
    let edges = |c: &Claims| format!("{} / {}", number(c.edge_rmse), number(c.noise));
    table(
        &mut text,
        "Figure 5, edges / noise, with filter:",
        &with(&[FIG_5, "preset=fig5:filter=gauss"]),
        &edges,
    );
    table(&mut text, "Edges / noise, without filter:", &all(false), &edges);
    text + &ablation(document)
}

/// The estimator or variant whose results a column shows.
enum Pick {
    Row(Estimator, bool),
    Variant(&'static str),
}

impl Pick {
    fn of<'a>(&self, scene: &'a SceneFigures) -> Option<&'a Claims> {
        match self {
            Self::Row(e, filtered) => {
                scene.row(*e).map(|r| if *filtered { &r.filtered.claims } else { &r.raw.claims })
            }
            Self::Variant(options) => scene.variant(options).map(|v| &v.claims),
        }
    }
}

/// Returns a table of issao with and without the attenuation, as in figure 4.
fn ablation(document: &AoResults) -> String {
    let mut text = String::from(
        "Figure 4, the attenuation: issao with and without it, all else equal. RMSE with the mean signed error \
        in brackets, then self-occlusion and noise; first with filter, then without.\n\n\
        | scene | issao | RMSE | self-occlusion | noise | RMSE, no filter | self-occlusion | noise \
        |\n|---|---|---|---|---|---|---|---|\n",
    );
    let mut rows = 0;
    for scene in &document.scenes {
        for options in ["", WITHOUT_ATTENUATION, FIG_4, "preset=fig4:attenuation=off"] {
            let Some(v) = scene.variant(options) else { continue };
            let number = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.4}"));
            let cells = |e: &crate::occlusion::OcclusionErrors, c: &Claims| {
                let [dark, noise] = [c.self_occlusion, c.noise].map(number);
                format!("{:.4} ({:+.4}) | {dark} | {noise}", e.rmse, e.mean_signed)
            };
            let _ = writeln!(
                text,
                "| {} | `{}` | {} | {} |",
                scene.title,
                v.name(),
                cells(&v.errors, &v.claims),
                cells(&v.raw_errors, &v.raw_claims)
            );
            rows += usize::from(!options.is_empty());
        }
    }
    if rows == 0 { String::new() } else { text + "\n" }
}

/// Returns a table of the paper's times and ours for the Dragon.
pub(super) fn times(document: &AoResults) -> String {
    let Some(dragon) = document.scenes.iter().find(|s| s.name == "dragon") else { return String::new() };
    let mut text = format!(
        "## The paper's times\n\nMilliseconds for the Dragon with {} samples. The paper's were measured on a GTS \
        450; its estimators are most likely in this order. In brackets: the ratio to alchemy's time.\n\n\
        | estimator | paper, with filter | here | paper, without | here |\n|---|---|---|---|---|\n",
        document.samples
    );
    let paper = PAPER_TIMES.iter().find(|(e, _)| *e == Estimator::Alchemy).map_or([1.0; 2], |(_, t)| *t);
    for (estimator, times) in PAPER_TIMES {
        let Some(row) = dragon.row(estimator) else { continue };
        let _ = writeln!(
            text,
            "| `{estimator}` | {:.2} ({:.2}) | {:.2} ({:.2}) | {:.2} ({:.2}) | {:.2} ({:.2}) |",
            times[0],
            times[0] / paper[0],
            row.ms,
            row.by_alchemy,
            times[1],
            times[1] / paper[1],
            row.raw_ms,
            row.raw_by_alchemy
        );
    }
    text + "\n"
}

/// Returns a table of the variants of issao by scene.
pub(super) fn variants(document: &AoResults) -> String {
    let mut text = String::from(
        "## Variants of issao\n\nTuned parameters, except for presets, which use the paper's. Time is in \
        milliseconds, with the ratio to plain issao's in brackets. RMSE is with filter, with the mean signed \
        error in brackets. Flicker is the mean change. `reuse=on` is measured after 16 frames with a static \
        camera.\n\n\
        | scene | variant | time | RMSE | flicker | changed % |\n|---|---|---|---|---|---|\n",
    );
    for scene in &document.scenes {
        for v in &scene.variants {
            let Variant { ms, by_issao, errors, flicker, .. } = v;
            let flicker = flicker
                .map_or_else(|| "– | –".to_owned(), |f| format!("{:.5} | {:.2}", f.mean, 100.0 * f.share));
            let _ = writeln!(
                text,
                "| {} | `{}` | {ms:.2} ({by_issao:.2}) | {:.4} ({:+.4}) | {flicker} |",
                scene.title,
                v.name(),
                errors.rmse,
                errors.mean_signed
            );
        }
    }
    text + "\n"
}

#[cfg(test)]
mod tests {
    use super::PAPER_TIMES;

    #[test]
    fn ao_paper_times_match_papers_json() {
        let data: serde_json::Value =
            serde_json::from_str(include_str!("../../../data/papers.json")).unwrap();
        let papers = data["papers"].as_array().unwrap();
        let rows = &papers.iter().find(|p| p["key"] == "ao-2014").unwrap()["tables"][0]["rows"];
        for (column, (estimator, times)) in (1..).zip(PAPER_TIMES) {
            let printed = [&rows[0][column], &rows[1][column]];
            assert!(*printed[0] == times[0] && *printed[1] == times[1], "{estimator}: {printed:?}");
        }
    }
}
