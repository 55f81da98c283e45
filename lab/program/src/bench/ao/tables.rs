//! The document: requirements, the summary, error against time, the paper's claims, current engines, then all
//! results by scene.

use std::fmt::Write as _;

use adumbra_render::occlusion::Estimator;

use super::measure::Row;
use super::sweep::{self, SAMPLES};
use super::{AoResults, FLOOR_FRAMES, SceneFigures, claims};
use crate::occlusion::{Flicker, OcclusionErrors};
use crate::peers::occlusion;
use crate::results::Check;
use adumbra_html::page::Table;
use adumbra_program::format::{figure, percent};

// Writing to a `String` never fails, so the results of `write!` are discarded throughout.

pub(super) fn markdown(document: &AoResults) -> String {
    let mut text = head(document);
    let _ = writeln!(text, "## Requirements\n\n{}", Check::markdown(&document.checks));
    if !document.scenes.is_empty() {
        text.push_str(&summary(document));
        text.push_str(&equal_time(document));
        text.push_str(&against_time(document));
        text.push_str(&claims::text(document));
        text.push_str(&claims::times(document));
        text.push_str(&claims::variants(document));
    }
    if let Some(rows) = &document.peers {
        let _ = write!(
            text,
            "## Compared with current engines\n\n320 x 240, no anti-aliasing, alpha masks ignored. Every valid \
            pixel is compared with another renderer's truth for the radius in its file. RMSE of visibility, with \
            the mean signed error in brackets (above 0 is too light). Our rows use the settings tuned on the \
            half that excludes the scene; box-city-5k is in neither half and uses those tuned on all eight \
            scenes. Rows marked *elsewhere* were measured with those engines on the same cameras.\n\n{}\n",
            occlusion::markdown(rows)
        );
    }
    for [what, why] in &document.skipped {
        let _ = writeln!(text, "`{what}` is skipped: {why}\n");
    }
    for scene in &document.scenes {
        text.push_str(&scene_table(scene));
        for [file, caption] in document.sheets.iter().filter(|[file, _]| is_of(file, scene)) {
            let _ = writeln!(text, "![{caption}]({file})\n\n{caption}\n");
        }
    }
    text.truncate(text.trim_end().len());
    text + "\n"
}

/// Returns whether a sheet shows a scene. The sheets of the claims show the Dragon.
fn is_of(file: &str, scene: &SceneFigures) -> bool {
    file == format!("ao-{}.png", scene.name) || (scene.name == "dragon" && file.starts_with("ao-figure"))
}

fn head(document: &AoResults) -> String {
    let setup = &document.setup;
    let [width, height] = setup.size;
    let [path_width, path_height] = document.path_size;
    let mut text = format!(
        "# Ambient occlusion compared with rays\n\nDrawn by {} at {width} x {height}, {} samples per pixel. \
        {}, medians of {} frames in milliseconds. Frame k of every estimator is drawn before frame k + 1 of \
        any, each time in a different order, and ratios are medians of the ratios between frames of the same \
        number. Made by `{}`.\n\n\
        All estimators share depth, normals, samples, noise and filter (bilateral, two one-dimensional passes). \
        Their parameters were [tuned](ao-tuning.md) by the same search on each half of the scenes, and each \
        scene is measured with those of the half that excludes it. Truth: {} cosine-weighted rays per pixel, up \
        to the same radius. Errors are over the pixels where rays and G-buffer see the same surface. Mean signed \
        is the mean of visibility minus truth (above 0 is too light). SSIM and FLIP (67 pixels per degree) are \
        of the whole visibility picture in grey. Flicker is the mean change of visibility from frame to frame at \
        the same points of the world, and changed is the share of these points that change by more than 0.05, \
        along a path of 16 frames at {path_width} x {path_height}. The truth's own flicker, over {FLOOR_FRAMES} \
        frames, comes from resampling and from the noise of its rays.\n\n",
        setup.adapter,
        document.samples,
        setup.clock(),
        setup.frames,
        setup.command,
        document.rays
    );
    if !document.untuned.is_empty() {
        let _ = writeln!(
            text,
            "Run with their defaults, because the record has no parameters for them: {}.\n",
            document.untuned.join(", ")
        );
    }
    text
}

/// Returns a table of RMSE by scene, and of the time relative to alchemy's.
fn summary(document: &AoResults) -> String {
    let names = Estimator::ALL.map(|e| format!("`{e}`")).join(" | ");
    let columns = "---|".repeat(Estimator::ALL.len());
    let mut text = format!(
        "## Summary\n\nRMSE by scene, first with filter, then without; the lowest is in bold. *none* is no \
        occlusion.\n\n\
        | scene | radius | none | {names} | no filter: {names} | issao's time / alchemy's | min to max | without \
        filter |\n\
        |---|---|---|{columns}{columns}---|---|---|\n"
    );
    for s in &document.scenes {
        let _ = write!(text, "| {} | {:.4} | {:.4} |", s.title, s.radius_world, s.none.rmse);
        for filtered in [true, false] {
            let of = |r: &Row| if filtered { r.filtered.errors.rmse } else { r.raw.errors.rmse };
            let least = s.rows.iter().map(of).fold(f64::INFINITY, f64::min);
            for row in &s.rows {
                let rmse = of(row);
                let _ = if rmse <= least {
                    write!(text, " **{rmse:.4}** |")
                } else {
                    write!(text, " {rmse:.4} |")
                };
            }
        }
        let _ = match s.row(Estimator::Issao) {
            Some(r) => writeln!(
                text,
                " {:.3} | {:.2} to {:.2} | {:.3} |",
                r.by_alchemy, r.by_alchemy_range[0], r.by_alchemy_range[1], r.raw_by_alchemy
            ),
            None => writeln!(text, " – | – | – |"),
        };
    }
    text + "\n"
}

fn equal_time(document: &AoResults) -> String {
    let scenes = document.scenes.iter().filter_map(|s| Some((&*s.title, s.equal_time.as_ref()?)));
    let table = Table::of(
        "",
        &scenes.collect::<Vec<_>>(),
        &[
            ("scene", |(title, _)| (*title).to_owned()),
            ("issao's samples", |(_, e)| e.issao_samples.to_string()),
            ("issao ms", |(_, e)| figure(e.issao_ms, 2)),
            ("gtao ms", |(_, e)| figure(e.gtao_ms, 2)),
            ("ratio", |(_, e)| figure(e.ratio, 3)),
            ("issao RMSE", |(_, e)| figure(e.issao_rmse, 4)),
            ("gtao RMSE", |(_, e)| figure(e.gtao_rmse, 4)),
        ],
    );
    format!(
        "## issao against gtao at equal time\n\nThe largest number of issao's samples, 4 to 64, that takes no \
        longer than gtao with 12. Both run with filter and are timed in alternation.\n\n{}\n",
        table.markdown()
    )
}

fn against_time(document: &AoResults) -> String {
    let mut text = format!(
        "## Error against time\n\n![Error against time](ao-time.svg)\n\nWith filter: milliseconds, and RMSE \
        relative to no occlusion, both means over {} scenes. Parameters are those tuned for 12 samples.\n\n| samples | {} |\n|---|{}\n",
        document.scenes.len(),
        Estimator::ALL.map(|e| format!("`{e}`")).join(" | "),
        "---|".repeat(Estimator::ALL.len())
    );
    for samples in SAMPLES {
        let _ = write!(text, "| {samples} |");
        for estimator in Estimator::ALL {
            let _ = match sweep::mean(&document.scenes, estimator, samples) {
                Some([ms, error]) => write!(text, " {ms:.2}: {error:.4} |"),
                None => write!(text, " – |"),
            };
        }
        text.push('\n');
    }
    text + "\n"
}

fn scene_table(s: &SceneFigures) -> String {
    let p = &s.pixels;
    let error = figure(s.standard_error, 4);
    let mut text = format!(
        "## {}\n\nRadius {:.4}; settings tuned on {}. {} pixels are compared, {} are sky, and {} are excluded \
        because rays and G-buffer see different surfaces. The truth's measured standard error is {error}; its \
        bound is {:.4}. Edges are {:.1} % of the compared pixels, flat regions {:.1} %.\n\n{}\n",
        s.title,
        s.radius_world,
        s.tuned_on.name(),
        p.compared,
        p.sky,
        p.excluded,
        s.standard_error_bound,
        100.0 * s.edge_share,
        100.0 * s.flat_share,
        estimator_table(s).markdown(),
    );
    for r in &s.rows {
        let settings: Vec<String> = r.settings.iter().map(|(name, v)| format!("{name}={v}")).collect();
        let _ = writeln!(text, "- `{}`: {}", r.estimator, settings.join(", "));
    }
    text + "\n"
}

/// Returns a table of the results on a scene: open sky, the truth, and every estimator with and without
/// filter.
fn estimator_table(s: &SceneFigures) -> Table {
    let head = [
        "estimator",
        "surfaces ms",
        "estimate ms",
        "filter ms",
        "all ms",
        "RMSE",
        "mean signed",
        "SSIM",
        "FLIP",
        "flicker",
        "changed %",
    ];
    let mut table = Table::new("", &head);
    let mut row = |name: &str, ms: [Option<f64>; 4], errors: [String; 4], flicker: Option<Flicker>| {
        let flicker = [figure(flicker.map(|f| f.mean), 5), percent(flicker.map(|f| f.share), 2)];
        let cells = ms.map(|ms| figure(ms, 2)).into_iter().chain(errors).chain(flicker);
        table.row([name.to_owned()].into_iter().chain(cells));
    };
    let signed = |e: &OcclusionErrors| format!("{:+.4}", e.mean_signed);
    let dash = || "–".to_owned();
    row("none", [None; 4], [figure(s.none.rmse, 4), signed(&s.none), dash(), dash()], None);
    row("truth", [None; 4], ["0", "0", "1", "0"].map(str::to_owned), s.truth_flicker);
    for r in &s.rows {
        let name = format!("`{}`", r.estimator);
        let without = format!("`{}:filter=none`", r.estimator);
        let [surface, estimate] = [r.surface_ms, r.estimate_ms].map(Some);
        for (name, ms, p) in [
            (name, [surface, estimate, Some(r.filter_ms), Some(r.ms)], &r.filtered),
            (without, [surface, estimate, None, Some(r.raw_ms)], &r.raw),
        ] {
            let errors = [figure(p.errors.rmse, 4), signed(&p.errors), figure(p.ssim, 4), figure(p.flip, 4)];
            row(&name, ms, errors, p.flicker);
        }
    }
    table
}
