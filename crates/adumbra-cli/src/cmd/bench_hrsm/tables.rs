//! The document: requirements, the paper's tables beside ours, then everything by model.

use std::fmt::Write as _;

use adumbra_lab::compare::CLEAR_TEXELS;

use super::checks::cases;
use super::measure::{Group, Row, hybrid, plain};
use super::{Document, FILTERS, ModelFigures, why};

/// Starts of the paper's tables.
pub(super) const PAPER_STARTS: [u32; 3] = [1024, 2048, 4096];
const LOADS: [(&str, &str); 2] = [("", "unfiltered"), ("PCF 5 × 5, ", "PCF 5 × 5")];

// Writing to a String does not fail, so what `write!` gives is dropped throughout.

pub(super) fn markdown(document: &Document) -> String {
    let mut text = head(document);
    let _ = writeln!(
        text,
        "## Must hold\n\nOver {}\n\n| requirement | measured | |\n|---|---|---|",
        document.covers
    );
    for c in &document.checks {
        let holds = match c.holds {
            Some(true) => "holds",
            Some(false) => "**does not hold**",
            None => "–",
        };
        let _ = writeln!(text, "| {} | {} | {holds} |", c.requirement, c.measured);
    }
    text.push('\n');
    text.push_str(&case_table(document));
    text.push_str(&paper_table(document));
    text.push_str(&why::claims(document));
    text.push_str(&why::text(document));
    if !document.sheets.is_empty() || !document.left_out.is_empty() {
        text.push_str("## Figures\n\n");
        for [file, caption] in &document.sheets {
            let _ = writeln!(text, "![{caption}]({file})\n\n{caption}\n");
        }
        for [sheet, why] in &document.left_out {
            let _ = writeln!(text, "{sheet} is left out: {why}\n");
        }
    }
    for model in &document.models {
        text.push_str(&model_tables(model));
    }
    text
}

fn head(document: &Document) -> String {
    let [width, height] = document.size;
    let clock = if document.software {
        "The adapter is a program and not a GPU: times are wall times of its passes"
    } else if document.wall_time {
        "The device has no timestamps: times are wall times of its passes"
    } else {
        "Times are GPU timestamps"
    };
    format!(
        "# Hybrid-resolution shadow maps\n\nDrawn by {} at {width} x {height}. {clock}, medians of {} frames in milliseconds; frame k of \
        every technique is drawn before frame k + 1 of any, in another order, and ratios are medians of the ratios within frames of one number, so that \
        what else the machine does weighs on both sides. Made by `{}`.\n\n\
        Each model stands on a square ground four times its longest extent, seen from above with its shadow; sun towards ({:.3}, {:.3}, \
        {:.3}). SM is a shadow map, HRSM a hybrid one, named by its finest (START) and coarsest (TARGET) texels a side; 32-bit depth, \
        the plane test, 32 bits a texel, and a thread a block unless a row says otherwise. *Moving*: depth and map are made anew \
        for each frame. *Still*: both are kept, and the look-up is all that is left; what the map was made with is given back.\n\n\
        Wrong pixels: the shadow factor is on the other side of 1/2 than a ray to the sun's middle says, in % of the compared pixels \
        (surfaces with n·l > 0.1 that rays and G-buffer see alike). Clear pixels: those more than {CLEAR_TEXELS} of the technique's finest texels from an edge \
        of the true shadow that the traced picture shows, between neighbouring pixels. Acne: lit ones called shadowed; leaks: shadowed ones called lit; both in % of all clear pixels. Boundary resolution gained: over pixels \
        within one TARGET texel of an edge of the true shadow, in the light's plane, the mean of \
        TARGET's texel edge by that of the level where the look-up ends, less 1; and the share of these pixels that end at START's level.\n\n",
        document.adapter,
        document.frames,
        document.command,
        document.sun[0],
        document.sun[1],
        document.sun[2],
    )
}

/// START-START/4 beside the shadow maps at its ends.
fn case_table(document: &Document) -> String {
    let mut text = String::from(
        "HRSM START-START/4 beside SM at START, and at START/4. Wrong and acne in %; memory, look-up and shadow (depth, build and look-up) \
        as shares of SM's at START; of memory, of the map that is drawn anew, as a kept one holds a second layer for what moves.\n\n\
        | model | START | filter | wrong SM | wrong HRSM | points more | wrong SM START/4 | HRSM by it | acne SM | acne HRSM | memory, \
        moving | memory, still | look-up | least to most | shadow, moving | shadow, still |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for c in cases(document) {
        let [acne_hybrid, acne_plain] = c.acne().map(|a| 100.0 * a);
        let _ = writeln!(
            text,
            "| {} | {} | {f} × {f} | {:.3} | {:.3} | {:+.3} | {:.3} | {:.2} | {acne_plain:.3} | {acne_hybrid:.3} | {:.2} | {:.2} | {:.2} | \
            {:.2} to {:.2} | {:.2} | {:.2} |",
            c.model.title,
            c.group.start,
            100.0 * c.fine.wrong(),
            100.0 * c.hybrid.wrong(),
            100.0 * c.more_wrong(),
            100.0 * c.coarse.wrong(),
            c.of_coarse_wrong(),
            c.hybrid.moving_share,
            c.hybrid.still_share,
            c.hybrid.lookup_ratio,
            c.hybrid.lookup_ratio_range[0],
            c.hybrid.lookup_ratio_range[1],
            c.hybrid.shadow_ratio,
            c.hybrid.still_ratio,
            f = c.group.filter,
        );
    }
    text + "\n"
}

/// The paper's tables 1 and 2 beside whole frames.
fn paper_table(document: &Document) -> String {
    let mut text = String::from(
        "## The paper's tables 1 and 2\n\nIts milliseconds (dual-core Xeon E5620, Quadro K5000) beside whole \
        frames here: G-buffer, depth, build, look-up and composite, SM at START and HRSM START-START/2, the paper's first merge. \
        It names neither its filter nor its targets.\n\n| model | triangles | START | paper SM | paper HRSM | ratio |",
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
        "## {}{}\n\n{} triangles and its ground. Eye ({}), target ({}), {}° high. {} pixels are compared; {} are sky, {} face away, {} are \
        excluded.\n\n",
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
    let mut text = format!(
        "### START {}, {load}\n\n| technique | depth ms | build | look-up | shadow | frame | still | MB moving | share | MB still | share | \
        area by level, finest first % | RMSE | wrong lit % | wrong shadowed % | leaks % | acne % | gained % | at START % |\n\
        |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        group.start
    );
    group.rows.iter().for_each(|row| text.push_str(&row_text(row)));
    text.push('\n');
    for [name, why] in &group.left_out {
        let _ = writeln!(text, "- `{name}` is left out: {why}");
    }
    for (row, note) in group.rows.iter().flat_map(|r| r.notes.iter().map(move |n| (&r.name, n))) {
        let _ = writeln!(text, "- `{row}`: {note}");
    }
    text + if group.left_out.is_empty() { "" } else { "\n" }
}

fn row_text(r: &Row) -> String {
    let two = |pair: Option<[f64; 2]>, digits: usize| {
        pair.map_or_else(
            || "– | –".to_owned(),
            |[a, b]| format!("{:.digits$} | {:.digits$}", 100.0 * a, 100.0 * b),
        )
    };
    let levels = r.levels.as_ref().map_or_else(
        || "–".to_owned(),
        |shares| shares.iter().map(|s| format!("{:.1}", 100.0 * s)).collect::<Vec<_>>().join(" / "),
    );
    format!(
        "| `{}` | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {levels} | {:.4} | {:.3} | {:.3} | {} | {} |\n",
        r.name,
        r.depth_ms,
        r.build_ms,
        r.lookup_ms,
        r.shadow_ms,
        r.frame_ms,
        r.still_ms,
        r.moving_bytes as f64 / 1e6,
        r.moving_share,
        r.still_bytes as f64 / 1e6,
        r.still_share,
        r.rmse,
        100.0 * r.wrong_lit,
        100.0 * r.wrong_shadowed,
        two(Some([r.clear.wrong_lit, r.clear.wrong_shadowed]), 3),
        two(r.boundary.map(|b| [b.gain, b.at_finest]), 1),
    )
}
