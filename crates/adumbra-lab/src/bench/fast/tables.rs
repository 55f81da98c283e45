//! The suite's results as Markdown.

use std::fmt::Write as _;

use super::Document;
use super::checks::Check;

/// Returns the whole page. Writing to a `String` never fails.
pub(super) fn markdown(document: &Document) -> String {
    let mut text = format!(
        "# The fast bake\n\n`{}`: {} threads, one run, one process per bake. Seconds are wall time, including \
        loading and writing. Peak is the process's peak resident memory; a row with a limit on it is baked with \
        that limit as `--max-memory`. 1 MB = 10^6 bytes. Drawn is the share of texels that were examined one by \
        one. Shadowed and interior agreement are of {} points on surfaces, compared with rays. The sun is \
        towards (-0.77, 0.105, -0.63) for jacksboro, towards (0.5, 0.8, 0.35) for the other scenes at 8192, and \
        towards (-0.45, 0.75, -0.35) for the rest.\n\n## Requirements\n\n| bake | figure | measured | limit | \
        aim | holds | reaches aim |\n|---|---|---|---|---|---|---|\n",
        document.command, document.threads, document.samples
    );
    for check in &document.checks {
        text.push_str(&line(check));
    }
    text.push_str(
        "\n## Every bake\n\n| scene | N | thickness, m | layout | s | peak MB | file MB | drawn % | shadowed % | interior agreement % |\n\
        |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for r in &document.rows {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.2} | {:.0} | {:.2} | {:.3} | {:.1} | {:.3} |",
            r.scene,
            r.resolution,
            r.thickness_world,
            r.layout.as_str().unwrap_or_default(),
            r.seconds,
            r.peak_bytes / 1e6,
            r.file_bytes / 1e6,
            100.0 * r.drawn_share,
            100.0 * r.shadowed_share,
            100.0 * r.interior_agreement,
        );
    }
    if !document.query.is_empty() {
        text.push_str(
            "\n## Look-ups\n\nbox-city-51k at 65,536, 9 × 9 texels, `adumbra::Cursor` on one core. The points, \
            with normals, are those seen from straight above around the middle of the scene, in rows of 2000 \
            that are visited one after the other. Median of three runs.\n\n| spacing in texels | points | \
            million points per second | mean visibility |\n|---|---|---|---|\n",
        );
    }
    for scan in &document.query {
        let _ = writeln!(
            text,
            "| {} | {} | {:.2} | {:.3} |",
            scan.step_texels,
            scan.points,
            scan.points_per_second / 1e6,
            scan.mean_visibility
        );
    }
    text
}

fn line(check: &Check) -> String {
    let show = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| check.figure.show(v));
    let word = |outcome: Option<bool>| outcome.map_or("–", |yes| if yes { "yes" } else { "no" });
    format!(
        "| {} | {} | {} | {} {} | {} | {} | {} |\n",
        check.row,
        check.figure.words(),
        check.measured.map_or_else(|| "not measured".to_owned(), |m| check.figure.show(m)),
        if check.figure.is_floor() { "≥" } else { "≤" },
        check.figure.show(check.limit),
        show(check.aim),
        word(check.holds),
        word(check.reaches_aim)
    )
}
