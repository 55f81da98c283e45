//! The page: a description of the run, one section per paper, all tables, how to cite.

use super::data::Data;
use super::inputs::{PageInputs, elsewhere};
use super::papers;
use super::record::{Outcome, Record};
use crate::args::SECTIONS;
use adumbra_html::page::{Body, Page, Section, Table};

/// Markdown files that the benchmarks write, by section.
const TABLES: [(&str, &[&str]); 9] = [
    ("bake", &["bake/bake.md"]),
    ("verify", &["verify/verify.md", "verify/verify-volume.md"]),
    ("tree", &["tree/tree.md"]),
    ("hrsm", &["hrsm/hrsm.md", "hrsm/pictures/report.md"]),
    ("blur", &["blur/blur.md"]),
    (
        "shadows",
        &[
            "shadows/shadows.md",
            "shadows/street/report.md",
            "shadows/far/report.md",
            "shadows/path/report.md",
        ],
    ),
    ("ao", &["ao/ao.md"]),
    ("peers", &["peers/peers.md"]),
    ("fast", &["fast/fast.md"]),
];

/// Returns the whole page of the recorded measurements.
pub(super) fn page(record: &Record, data: &mut Data) -> String {
    let mut inputs = PageInputs { record, data };
    let mut sections = vec![run(record)];
    sections.extend(papers::sections(&mut inputs));
    sections.push(tables(&inputs));
    sections.push(cite(record));
    Page {
        title: "Shadows and ambient occlusion, measured again".to_owned(),
        description: "Four papers on real-time shadows and ambient occlusion: their tables and figures compared with measurements of adumbra."
            .to_owned(),
        opening: opening(record),
        sections,
    }
    .html()
}

fn opening(record: &Record) -> Body {
    let mut body = Body::default();
    body.paragraph(
        "adumbra implements the methods of four papers: precomputed voxel shadows, hybrid-resolution shadow maps, a screen-space blur of \
         shadows, and screen-space ambient occlusion. This page shows each of their tables and figures next to adumbra's measurements, \
         with the command that repeats the measurement. All shadows and all occlusion are compared with rays traced against the same \
         triangles.",
    );
    body.paragraph(
        "Visibility is 1 in light and 0 in shadow. A pixel is wrong if its visibility and that of the rays are on different sides of 0.5. \
         Milliseconds are medians on the adapter named below. If that is a software renderer, only their ratios are meaningful.",
    );
    let failed = record.sections.iter().filter(|s| s.outcome != Outcome::Measured);
    let failed: Vec<String> = failed.map(|s| format!("{} ({})", s.section, s.outcome.words())).collect();
    if !failed.is_empty() {
        body.note(&format!("Not every section succeeded: {}. See below.", failed.join(", ")));
    }
    body
}

/// Returns the section on the machine and on the sections that were run.
fn run(record: &Record) -> Section {
    let m = &record.machine;
    let mut body = Body::default();
    let mut table = Table::new("The machine", &["", ""]);
    table.row(["date", m.date.as_str()]);
    for row in m.rows() {
        table.row(row);
    }
    body.table(&table);
    body.part("sections", "What was run");
    let mut table = Table::new("", &["section", "contents", "sizes", "date", "seconds", "outcome"]);
    for section in &record.sections {
        let what = SECTIONS.iter().find(|(name, _)| *name == section.section).map_or("", |(_, what)| what);
        table.row([
            section.section.clone(),
            what.to_owned(),
            if section.full { "full" } else { "quick" }.to_owned(),
            section.machine.date.clone(),
            format!("{:.0}", section.seconds()),
            section.outcome.words().to_owned(),
        ]);
    }
    body.table(&table);
    for section in &record.sections {
        if let Some(machine) = record.elsewhere(&section.section) {
            body.note(&elsewhere(&section.section, &machine));
        }
        for step in &section.steps {
            if let Some(error) = &step.error {
                body.note(&format!("{}: {error}", section.section));
                body.code("Command", &step.command);
            }
        }
    }
    body.paragraph(
        "Run the commands in this page's folder. `$SCENES` and `$TRUTH` are the folders given as `--scenes` and `--truth`. Generated scenes \
         come from a fixed seed and are identical on every machine:",
    );
    let made: Vec<String> = super::plan::made_commands().collect();
    body.code("Commands", &made.join("\n"));
    Section { id: "run".to_owned(), title: "This run".to_owned(), body }
}

/// Returns the section with the complete output of every benchmark.
fn tables(inputs: &PageInputs<'_>) -> Section {
    let mut body = Body::default();
    body.paragraph("The complete output of every benchmark.");
    for (section, files) in TABLES {
        let Some(measured) = inputs.record.section(section) else { continue };
        let what = SECTIONS.iter().find(|(name, _)| *name == section).map_or(section, |(_, what)| what);
        body.part(&format!("tables-{section}"), what);
        let mut commands: Vec<&str> = measured.steps.iter().map(|s| s.command.as_str()).collect();
        commands.dedup();
        body.code("Commands", &commands.join("\n"));
        if let Some(machine) = inputs.record.elsewhere(section) {
            body.aside(&elsewhere(section, &machine));
        }
        for file in files {
            let Some(text) = inputs.data.text(file) else { continue };
            let title = text.lines().next().unwrap_or(file).trim_start_matches('#').trim().to_owned();
            let mut inside = Body::default();
            // The title is shown outside the folded part.
            inside.markdown(text.split_once('\n').map_or("", |(_, rest)| rest), 2);
            body.folded(&title, &inside);
        }
    }
    Section { id: "tables".to_owned(), title: "All tables".to_owned(), body }
}

fn cite(record: &Record) -> Section {
    let mut body = Body::default();
    body.paragraph("The papers and the program:");
    let mut text = String::new();
    for paper in papers::all() {
        let key = paper.key.replace('-', "");
        let kind = if paper.venue.contains("thesis") { "thesis" } else { "article" };
        let place = match kind {
            "thesis" => "type = {Bachelor's thesis}, institution",
            _ => "journal",
        };
        let venue = paper.venue.trim_start_matches("Bachelor's thesis, ").to_owned();
        text += &format!(
            "@{kind}{{{key},\n  author = {{{}}},\n  title = {{{}}},\n  note = {{{}}},\n  {place} = {{{venue}}},\n  year = {{{}}}\n}}\n\n",
            paper.authors.join(" and "),
            paper.title_en,
            paper.title_original,
            paper.year
        );
    }
    let m = &record.machine;
    text += &format!(
        "@software{{adumbra,\n  author = {{{{The adumbra authors}}}},\n  title = {{adumbra: a sun's shadows in a small file}},\n  version = {{{}}},\n  year = {{{}}}\n}}\n",
        m.version(),
        m.date.get(..4).unwrap_or_default()
    );
    body.code("BibTeX", &text);
    Section { id: "cite".to_owned(), title: "How to cite".to_owned(), body }
}
