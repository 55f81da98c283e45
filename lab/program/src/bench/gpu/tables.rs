//! The tables of `bench gpu`.

use std::fmt::Write as _;

use super::{GpuResults, Row, Section};

pub(super) fn markdown(document: &GpuResults) -> String {
    let GpuResults { adapter, software, size: [width, height], frames, seconds, .. } = document;
    let mut text = format!(
        "# Measured on {adapter}\n\n`adumbra-lab bench gpu -o DIR`: {width} × {height} pixels, medians of up to {frames} \
         frames, GPU timestamps, in milliseconds; in brackets each pass. Scenes are generated and baked on the way; \
         nothing begins after {seconds} s.\n"
    );
    // Writing to a `String` never fails.
    if *software {
        text.push_str(
            "\nThis adapter runs in software: the times are wall times and say nothing about a GPU.\n",
        );
    }
    for section in &document.sections {
        table(&mut text, section);
    }
    if !document.left_out.is_empty() {
        text.push_str("\n## Left out\n\n");
        for [what, reason] in &document.left_out {
            let _ = writeln!(text, "- {what}: {reason}");
        }
    }
    text
}

fn table(text: &mut String, section: &Section) {
    let Section { title, scene, triangles, rows } = section;
    let _ = writeln!(text, "\n## {title}\n\n{scene}, {triangles} triangles\n");
    let Some(first) = rows.first() else {
        text.push_str("Nothing was measured.\n");
        return;
    };
    let names: Vec<&str> = first.views.iter().map(|view| view.view.as_str()).collect();
    let _ = writeln!(text, "| | {} | MB |\n|---|{}---|", names.join(" | "), "---|".repeat(names.len()));
    for Row { technique, bytes, views } in rows {
        let _ = write!(text, "| `{technique}` |");
        for view in views {
            let passes = view.passes.iter().map(|(pass, ms)| format!("{pass} {ms:.3}"));
            let mark = if view.wall_time { "*" } else { "" };
            let passes = passes.collect::<Vec<_>>().join(", ");
            let _ = write!(text, " {:.3}{mark} ({passes}; {}) |", view.milliseconds, view.frames);
        }
        let _ = writeln!(text, " {:.2} |", *bytes as f64 / 1e6);
    }
    if rows.iter().any(|row| row.views.iter().any(|view| view.wall_time)) {
        text.push_str("\n\\* wall time\n");
    }
}
