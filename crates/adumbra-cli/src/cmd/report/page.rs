//! The page: what the run was, a section a paper, all tables, how to cite.

use adumbra_lab::page::{Body, Embedded, Page, Pair, Section, Table};
use serde_json::Value;

use super::data::Data;
use super::papers;
use super::record::{Outcome, Record};
use crate::args::SECTIONS;

/// What all benchmarks write as Markdown, by section.
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

/// What a part of the page is made of.
pub(super) struct Seen<'a> {
    pub(super) record: &'a Record,
    pub(super) data: &'a mut Data,
}

impl Seen<'_> {
    /// The command that makes a figure again.
    pub(super) fn made_by(&self, section: &str, step: &str, body: &mut Body) {
        let Some(measured) = self.record.section(section) else { return };
        let named = |name: &str| -> Vec<&str> {
            measured.steps.iter().filter(|s| s.name == name).map(|s| s.command.as_str()).collect()
        };
        // Full runs measure in one command what quick ones divide.
        let commands = Some(named(step)).filter(|c| !c.is_empty()).unwrap_or_else(|| named(section));
        if !commands.is_empty() {
            body.code("Command", &commands.join("\n"));
        }
        if let Some(machine) = self.record.elsewhere(section) {
            body.aside(&elsewhere(section, &machine));
        }
    }

    /// Says that a section's figures are not there.
    pub(super) fn missing(&self, section: &str, body: &mut Body) {
        let error = self.record.section(section).and_then(|s| s.steps.iter().find_map(|s| s.error.clone()));
        body.note(&match error {
            Some(error) => format!("Not measured: {error}"),
            None => {
                format!(
                    "Not measured in this run; `adumbra report --only {section} -o DIR` adds what there is."
                )
            }
        });
    }

    /// A picture, or the words that it is missing.
    pub(super) fn picture(&mut self, section: &str, path: &str, alt: &str, caption: &str, body: &mut Body) {
        match self.data.picture(path, None) {
            Some(picture) => body.picture(&picture, alt, caption),
            None => self.missing(section, body),
        }
    }

    /// A pair of pictures, or the words that it is missing.
    pub(super) fn pair(
        &mut self,
        section: &str,
        left: (&str, &str),
        right: (&str, &str),
        caption: &str,
        body: &mut Body,
    ) {
        let pictures = [left, right].map(|(path, _)| self.data.picture(path, None));
        self.shown(section, pictures, [left.1, right.1], caption, body);
    }

    /// The same of parts of one picture, `[x, y, width, height]`.
    pub(super) fn pair_of_parts(
        &mut self,
        section: &str,
        path: &str,
        left: ([u32; 4], &str),
        right: ([u32; 4], &str),
        caption: &str,
        body: &mut Body,
    ) {
        let pictures = [left, right].map(|(part, _)| self.data.picture(path, Some(part)));
        self.shown(section, pictures, [left.1, right.1], caption, body);
    }

    fn shown(
        &self,
        section: &str,
        pictures: [Option<Embedded>; 2],
        names: [&str; 2],
        caption: &str,
        body: &mut Body,
    ) {
        match pictures {
            [Some(left), Some(right)] => {
                body.pair(&Pair { left: (&left, names[0]), right: (&right, names[1]), caption });
            }
            _ => self.missing(section, body),
        }
    }

    /// A plot, or the words that it is missing.
    pub(super) fn plot(&mut self, section: &str, path: &str, alt: &str, caption: &str, body: &mut Body) {
        match self.data.text(path) {
            Some(svg) => body.plot(&svg, alt, caption),
            None => self.missing(section, body),
        }
    }
}

fn elsewhere(section: &str, machine: &str) -> String {
    format!("`{section}` was measured elsewhere or by another build than this page's last run: {machine}.")
}

/// Where a table or figure stands in its paper.
pub(super) fn pages(page: Option<u32>, note: Option<&str>) -> String {
    let page = page.map_or_else(|| "Without a page number".to_owned(), |p| format!("Page {p}"));
    note.map_or_else(|| format!("{page}."), |n| format!("{page}; {n}."))
}

/// A number at a JSON pointer; NaN where there is none.
pub(super) fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

/// Items of a list at a JSON pointer.
pub(super) fn rows<'v>(value: &'v Value, pointer: &str) -> &'v [Value] {
    value.pointer(pointer).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// A text at a key.
pub(super) fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value[key].as_str().unwrap_or_default()
}

/// What a benchmark says must hold, and whether it does.
pub(super) fn checks(document: &Value, body: &mut Body) {
    let mut table = Table::new("What must hold of ours", &["requirement", "measured", ""]);
    for check in rows(document, "/checks") {
        let holds =
            check["holds"].as_bool().map_or("–", |h| if h { "holds" } else { "does\u{a0}not\u{a0}hold" });
        table.row([text(check, "requirement"), text(check, "measured"), holds]);
    }
    body.table(&table);
}

/// The whole page of what was measured.
pub(super) fn page(record: &Record, data: &mut Data) -> String {
    let mut seen = Seen { record, data };
    let mut sections = vec![run(record)];
    sections.extend(papers::sections(&mut seen));
    sections.push(tables(&seen));
    sections.push(cite(record));
    Page {
        title: "Shadows and ambient occlusion, measured again".to_owned(),
        description: "Four papers on real-time shadows and ambient occlusion, their tables and figures beside those of adumbra."
            .to_owned(),
        opening: opening(record),
        sections,
    }
    .html()
}

fn opening(record: &Record) -> Body {
    let mut body = Body::default();
    body.paragraph(
        "adumbra realises the methods of four papers: precomputed voxel shadows, hybrid-resolution shadow maps, a blur of shadows on the \
         screen, and ambient occlusion in screen space. This page shows each of their tables and figures beside what adumbra measured, \
         with the command that measures it again. All shadows and all occlusion are judged by rays against the same triangles.",
    );
    body.paragraph(
        "Visibility is 1 where light arrives and 0 in shadow. A pixel is wrong where its visibility is on the other side of one half than \
         that of the rays. Milliseconds are medians on the adapter named below; where that is a program and not a GPU, only their ratios \
         say something.",
    );
    let failed = record.sections.iter().filter(|s| s.outcome != Outcome::Measured);
    let failed: Vec<String> = failed.map(|s| format!("{} ({})", s.section, s.outcome.words())).collect();
    if !failed.is_empty() {
        body.note(&format!("Not all went well: {}. See below.", failed.join(", ")));
    }
    body
}

/// The machine, and what was run.
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
    let mut table = Table::new("", &["section", "what", "sizes", "date", "seconds", "outcome"]);
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
        "Commands are typed in this page's folder. Where they name `$SCENES` or `$TRUTH`, those are the folders given as `--scenes` and \
         `--truth`. Scenes that are made come from a seed, and are the same everywhere:",
    );
    let made: Vec<String> = super::plan::made_commands().collect();
    body.code("Commands", &made.join("\n"));
    Section { id: "run".to_owned(), title: "This run".to_owned(), body }
}

/// What every benchmark wrote, whole.
fn tables(seen: &Seen<'_>) -> Section {
    let mut body = Body::default();
    body.paragraph("What the benchmarks wrote, with nothing left out.");
    for (section, files) in TABLES {
        let Some(measured) = seen.record.section(section) else { continue };
        let what = SECTIONS.iter().find(|(name, _)| *name == section).map_or(section, |(_, what)| what);
        body.part(&format!("tables-{section}"), what);
        let mut commands: Vec<&str> = measured.steps.iter().map(|s| s.command.as_str()).collect();
        commands.dedup();
        body.code("Commands", &commands.join("\n"));
        if let Some(machine) = seen.record.elsewhere(section) {
            body.aside(&elsewhere(section, &machine));
        }
        for file in files {
            let Some(text) = seen.data.text(file) else { continue };
            let title = text.lines().next().unwrap_or(file).trim_start_matches('#').trim().to_owned();
            let mut inside = Body::default();
            // The title stands outside.
            inside.markdown(text.split_once('\n').map_or("", |(_, rest)| rest), 2);
            body.folded(&title, &inside);
        }
    }
    Section { id: "tables".to_owned(), title: "All tables".to_owned(), body }
}

fn cite(record: &Record) -> Section {
    let mut body = Body::default();
    body.paragraph("The papers, and the program:");
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
