//! The suite's results as Markdown.

use super::checks::Check;
use super::speed::Scan;
use super::{FastResults, Figures};
use adumbra_html::page::Table;
use adumbra_program::format::{figure, percent};

/// Returns the whole page.
pub(super) fn markdown(document: &FastResults) -> String {
    let mut text = format!(
        "# The fast bake\n\n`{}`: {} threads, one run, one process per bake. Seconds are wall time, including \
        loading and writing. Peak is the process's peak resident memory; a row with a limit on it is baked with \
        that limit as `--max-memory`. 1 MB = 10^6 bytes. Drawn is the share of texels that were examined one by \
        one. Shadowed and interior agreement are of {} points on surfaces, compared with rays. The sun is \
        towards (-0.77, 0.105, -0.63) for jacksboro, towards (0.5, 0.8, 0.35) for the other scenes at 8192, and \
        towards (-0.45, 0.75, -0.35) for the rest.\n\n## Requirements\n\n{}\n## Every bake\n\n{}",
        document.command,
        document.threads,
        document.samples,
        requirements(&document.checks),
        bakes(&document.rows)
    );
    if !document.query.is_empty() {
        text.push_str(
            "\n## Look-ups\n\nbox-city-51k at 65,536, 9 × 9 texels, `adumbra::Sampler` on one core. The points, \
            with normals, are those seen from straight above around the middle of the scene, in rows of 2000 \
            that are visited one after the other. Median of three runs.\n\n",
        );
        text.push_str(&look_ups(&document.query));
    }
    text
}

fn requirements(checks: &[Check]) -> String {
    let word = |outcome: Option<bool>| outcome.map_or("–", |yes| if yes { "yes" } else { "no" });
    let mut table = Table::new("", &["bake", "figure", "measured", "limit", "aim", "holds", "reaches aim"]);
    for check in checks {
        let show = |value: f64| check.figure.show(value);
        let sign = if check.figure.is_floor() { "≥" } else { "≤" };
        table.row([
            check.row.clone(),
            check.figure.words().to_owned(),
            check.measured.map_or_else(|| "not measured".to_owned(), show),
            format!("{sign} {}", show(check.limit)),
            check.aim.map_or_else(|| "–".to_owned(), show),
            word(check.holds).to_owned(),
            word(check.reaches_aim).to_owned(),
        ]);
    }
    table.markdown()
}

fn bakes(rows: &[Figures]) -> String {
    let table = Table::of(
        "",
        rows,
        &[
            ("scene", |r| r.scene.clone()),
            ("N", |r| r.resolution.to_string()),
            ("thickness, m", |r| r.thickness_world.to_string()),
            ("s", |r| figure(r.seconds, 2)),
            ("peak MB", |r| figure(r.peak_bytes / 1e6, 0)),
            ("file MB", |r| figure(r.file_bytes / 1e6, 2)),
            ("drawn %", |r| percent(r.drawn_share, 3)),
            ("shadowed %", |r| percent(r.shadowed_share, 1)),
            ("interior agreement %", |r| percent(r.interior_agreement, 3)),
        ],
    );
    table.markdown()
}

fn look_ups(scans: &[Scan]) -> String {
    let table = Table::of(
        "",
        scans,
        &[
            ("spacing in texels", |s| s.step_texels.to_string()),
            ("points", |s| s.points.to_string()),
            ("million points per second", |s| figure(s.points_per_second / 1e6, 2)),
            ("mean visibility", |s| figure(s.mean_visibility, 3)),
        ],
    );
    table.markdown()
}
