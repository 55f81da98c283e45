//! The document: requirements, the paper's tables next to ours, then all results by model.

use std::fmt::Write as _;

use super::checks::cases;
use super::measure::{Group, Row, hybrid, plain};
use super::models::PAPER_STARTS;
use super::{FILTERS, HybridResults, ModelFigures, why};
use crate::results::Check;
use adumbra_compare::compare::CLEAR_TEXELS;
use adumbra_html::page::Table;
use adumbra_program::format::{figure, megabytes, percent};

const LOADS: [(&str, &str); 2] = [("", "unfiltered"), ("PCF 5 × 5, ", "PCF 5 × 5")];

// Writing to a `String` never fails, so the results of `write!` are discarded throughout.

pub(super) fn markdown(document: &HybridResults) -> String {
    let mut text = head(document);
    let _ = writeln!(
        text,
        "## Requirements\n\nOver {}\n\n{}",
        document.covers,
        Check::markdown(&document.checks)
    );
    text.push_str(&case_table(document));
    text.push_str(&paper_table(document));
    text.push_str(&why::claims(document));
    text.push_str(&why::text(document));
    if !document.sheets.is_empty() || !document.skipped.is_empty() {
        text.push_str("## Figures\n\n");
        for [file, caption] in &document.sheets {
            let _ = writeln!(text, "![{caption}]({file})\n\n{caption}\n");
        }
        for [sheet, why] in &document.skipped {
            let _ = writeln!(text, "{sheet} is skipped: {why}\n");
        }
    }
    for model in &document.models {
        text.push_str(&model_tables(model));
    }
    text
}

fn head(document: &HybridResults) -> String {
    let setup = &document.setup;
    let [width, height] = setup.size;
    format!(
        "# Hybrid-resolution shadow maps\n\nDrawn by {} at {width} x {height}. {}, medians of {} frames in \
        milliseconds. Frame k of every technique is drawn before frame k + 1 of any, each time in a different \
        order, and ratios are medians of the ratios between frames of the same number, so that other load on the \
        machine affects both sides. Made by `{}`.\n\n\
        Each model is on a square ground four times its longest extent, seen from above with its shadow; sun \
        towards ({:.3}, {:.3}, {:.3}). SM is a shadow map and HRSM a hybrid one, named by the texels per side of \
        its finest (START) and coarsest (TARGET) level. Unless a row says otherwise: 32-bit depth, the plane \
        test, 32 bits per texel, and one thread per block. *Moving*: depth and map are rebuilt for each frame. \
        *Still*: both are cached and only the look-up remains; the memory used to build the map is released.\n\n\
        Wrong pixels: the shadow factor and a ray to the sun's centre are on different sides of 1/2, in % of the \
        compared pixels (those with n·l > 0.1 where rays and G-buffer see the same surface). Clear pixels: those \
        more than {CLEAR_TEXELS} of the technique's finest texels away from any edge of the true shadow that the \
        traced picture shows between neighbouring pixels. Acne: lit pixels called shadowed. Leaks: shadowed \
        pixels called lit. Both are in % of all clear pixels. Boundary resolution gained: over the pixels within \
        one TARGET texel of an edge of the true shadow, in the light's plane, the mean of TARGET's texel size \
        divided by that of the level where the look-up ends, minus 1; and the share of these pixels whose \
        look-up ends at START's level.\n\n",
        setup.adapter,
        setup.clock(),
        setup.frames,
        setup.command,
        document.sun[0],
        document.sun[1],
        document.sun[2],
    )
}

/// Compares START-START/4 with the shadow maps at both ends of its range.
fn case_table(document: &HybridResults) -> String {
    let table = Table::of(
        "",
        &cases(document),
        &[
            ("model", |c| c.model.title.clone()),
            ("START", |c| c.group.start.to_string()),
            ("filter", |c| format!("{f} × {f}", f = c.group.filter)),
            ("wrong SM", |c| percent(c.fine.wrong(), 3)),
            ("wrong HRSM", |c| percent(c.hybrid.wrong(), 3)),
            ("difference, points", |c| format!("{:+.3}", 100.0 * c.more_wrong())),
            ("wrong SM START/4", |c| percent(c.coarse.wrong(), 3)),
            ("HRSM / SM START/4", |c| figure(c.of_coarse_wrong(), 2)),
            ("acne SM", |c| percent(c.fine.clear.wrong_shadowed, 3)),
            ("acne HRSM", |c| percent(c.hybrid.clear.wrong_shadowed, 3)),
            ("memory, moving", |c| figure(c.hybrid.moving_share, 2)),
            ("memory, still", |c| figure(c.hybrid.still_share, 2)),
            ("look-up", |c| figure(c.hybrid.lookup_ratio, 2)),
            ("min to max", |c| c.hybrid.lookup_ratio_range.map(|ratio| figure(ratio, 2)).join(" to ")),
            ("shadow, moving", |c| figure(c.hybrid.shadow_ratio, 2)),
            ("shadow, still", |c| figure(c.hybrid.still_ratio, 2)),
        ],
    );
    format!(
        "HRSM START-START/4 compared with SM at START and at START/4. Wrong and acne are in %. Memory, look-up \
        and shadow (depth, build and look-up) are relative to SM at START. For memory, that is the map that is \
        redrawn every frame, because a cached one holds a second layer for moving casters.\n\n{}\n",
        table.markdown()
    )
}

/// Compares the paper's tables 1 and 2 with our whole frames.
fn paper_table(document: &HybridResults) -> String {
    let mut text = String::from(
        "## The paper's tables 1 and 2\n\nThe paper's milliseconds (dual-core Xeon E5620, Quadro K5000) compared \
        with whole frames here: G-buffer, depth, build, look-up and composite, for SM at START and for HRSM \
        START-START/2, the paper's first merge. The paper states neither its filter nor its targets.\n\n| model | triangles | START | paper SM | paper HRSM | ratio |",
    );
    for (load, _) in LOADS {
        let _ = write!(text, " {load}SM | {load}HRSM | ratio | ratio, still |");
    }
    text.push_str("\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for m in &document.models {
        for &start in &document.starts {
            let at = PAPER_STARTS.iter().position(|s| *s == start);
            let paper = at.and_then(|i| m.paper[i]).map_or_else(
                || "– | – | –".to_owned(),
                |[sm, hrsm]| format!("{sm} | {hrsm} | {:.2}", hrsm / sm),
            );
            let _ = write!(text, "| {} | {} | {start} | {paper} |", m.title, m.triangles);
            for filter in FILTERS {
                let rows = m.group(start, filter).and_then(|g| {
                    Some((g.row(&plain(start, filter))?, g.row(&hybrid(start, start / 2, filter))?))
                });
                let cells = rows.map_or_else(
                    || "– | – | – | –".to_owned(),
                    |(sm, hrsm)| {
                        let (a, b) = (sm.frame_ms, hrsm.frame_ms);
                        format!("{a:.2} | {b:.2} | {:.2} | {:.2}", hrsm.frame_ratio, hrsm.still_frame_ratio)
                    },
                );
                let _ = write!(text, " {cells} |");
            }
            text.push('\n');
        }
    }
    text + "\n"
}

fn model_tables(model: &ModelFigures) -> String {
    let c = &model.camera;
    let p = &model.pixels;
    let triple = |v: [f64; 3]| v.map(|c| format!("{c:.4}")).join(", ");
    let mut text = format!(
        "## {}{}\n\n{} triangles plus the ground. Eye ({}), target ({}), vertical field of view {}°. {} pixels \
        are compared; {} are sky, {} face away from the sun, and {} are excluded.\n\n",
        model.title,
        if model.foliage { ": foliage, the paper's known failure" } else { "" },
        model.triangles,
        triple(c.eye),
        triple(c.target),
        c.fov_degrees.unwrap_or_default(),
        p.compared,
        p.sky,
        p.facing_away,
        p.excluded
    );
    for group in &model.groups {
        text.push_str(&group_table(group));
    }
    text
}

fn group_table(group: &Group) -> String {
    let load = LOADS[usize::from(group.filter != 1)].1;
    let table = Table::of(
        "",
        &group.rows,
        &[
            ("technique", |r| format!("`{}`", r.name)),
            ("depth ms", |r| figure(r.depth_ms, 2)),
            ("build", |r| figure(r.build_ms, 2)),
            ("look-up", |r| figure(r.lookup_ms, 2)),
            ("shadow", |r| figure(r.shadow_ms, 2)),
            ("frame", |r| figure(r.frame_ms, 2)),
            ("still", |r| figure(r.still_ms, 2)),
            ("MB moving", |r| megabytes(r.moving_bytes, 2)),
            ("share", |r| figure(r.moving_share, 2)),
            ("MB still", |r| megabytes(r.still_bytes, 2)),
            ("share", |r| figure(r.still_share, 2)),
            ("area by level, finest first %", levels),
            ("RMSE", |r| figure(r.rmse, 4)),
            ("wrong lit %", |r| percent(r.wrong_lit, 3)),
            ("wrong shadowed %", |r| percent(r.wrong_shadowed, 3)),
            ("leaks %", |r| percent(r.clear.wrong_lit, 3)),
            ("acne %", |r| percent(r.clear.wrong_shadowed, 3)),
            ("gained %", |r| percent(r.boundary.map(|b| b.gain), 1)),
            ("at START %", |r| percent(r.boundary.map(|b| b.at_finest), 1)),
        ],
    );
    let mut text = format!("### START {}, {load}\n\n{}\n", group.start, table.markdown());
    for [name, why] in &group.skipped {
        let _ = writeln!(text, "- `{name}` is skipped: {why}");
    }
    for (row, note) in group.rows.iter().flat_map(|r| r.notes.iter().map(move |n| (&r.name, n))) {
        let _ = writeln!(text, "- `{row}`: {note}");
    }
    text + if group.skipped.is_empty() { "" } else { "\n" }
}

/// Returns the share of the area by level, in %.
fn levels(row: &Row) -> String {
    row.levels.as_ref().map_or_else(
        || "–".to_owned(),
        |shares| shares.iter().map(|s| percent(*s, 1)).collect::<Vec<_>>().join(" / "),
    )
}
