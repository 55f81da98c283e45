//! Content of the sections of the page: pictures, plots, commands and checks, or a note that they are
//! missing.

use super::data::Data;
use super::record::Record;
use crate::results::Check;
use adumbra_html::page::{Body, Embedded, Pair, Table};

/// The record and files that the page is made from.
pub(super) struct PageInputs<'a> {
    pub(super) record: &'a Record,
    pub(super) data: &'a mut Data,
}

impl PageInputs<'_> {
    /// Adds the command that reproduces a figure.
    pub(super) fn made_by(&self, section: &str, step: &str, body: &mut Body) {
        let Some(measured) = self.record.section(section) else { return };
        let named = |name: &str| -> Vec<&str> {
            measured.steps.iter().filter(|s| s.name == name).map(|s| s.command.as_str()).collect()
        };
        // A full run measures a section in one command, a quick run in several.
        let commands = Some(named(step)).filter(|c| !c.is_empty()).unwrap_or_else(|| named(section));
        if !commands.is_empty() {
            body.code("Command", &commands.join("\n"));
        }
        if let Some(machine) = self.record.elsewhere(section) {
            body.aside(&elsewhere(section, &machine));
        }
    }

    /// Adds a note that a section's results are missing.
    pub(super) fn missing(&self, section: &str, body: &mut Body) {
        let error = self.record.section(section).and_then(|s| s.steps.iter().find_map(|s| s.error.clone()));
        body.note(&match error {
            Some(error) => format!("Not measured: {error}"),
            None => {
                format!("Not measured in this run. `adumbra-lab report --only {section} -o DIR` measures it.")
            }
        });
    }

    /// Adds a picture, or a note that it is missing.
    pub(super) fn picture(&mut self, section: &str, path: &str, alt: &str, caption: &str, body: &mut Body) {
        match self.data.picture(path, None) {
            Some(picture) => body.picture(&picture, alt, caption),
            None => self.missing(section, body),
        }
    }

    /// Adds a sheet of the paper's own model, which exists only if the benchmark had that model.
    pub(super) fn sheet(&mut self, section: &str, path: &str, alt: &str, body: &mut Body) {
        if let Some(picture) = self.data.picture(path, None) {
            body.picture(&picture, alt, "Ours, on the paper's model");
            self.made_by(section, section, body);
        }
    }

    /// Adds a table with a remark, or a note that it is missing if it has no rows.
    pub(super) fn table(
        &self,
        section: &str,
        step: &str,
        table: &Table,
        remark: Option<&str>,
        body: &mut Body,
    ) {
        if table.rows.is_empty() {
            self.missing(section, body);
            return;
        }
        body.table(table);
        if let Some(remark) = remark {
            body.paragraph(remark);
        }
        self.made_by(section, step, body);
    }

    /// Adds a pair of pictures, or a note that it is missing.
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

    /// Adds a pair of parts of one picture, each `[x, y, width, height]` in pixels, or a note that it is
    /// missing.
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

    /// Adds a plot, or a note that it is missing.
    pub(super) fn plot(&mut self, section: &str, path: &str, alt: &str, caption: &str, body: &mut Body) {
        match self.data.text(path) {
            Some(svg) => body.plot(&svg, alt, caption),
            None => self.missing(section, body),
        }
    }
}

/// Returns a note that a section was measured on another machine or by another build.
pub(super) fn elsewhere(section: &str, machine: &str) -> String {
    format!("`{section}` was measured on another machine or with another build than the last run: {machine}.")
}

/// Describes the location of a table or figure in its paper.
pub(super) fn pages(page: Option<u32>, note: Option<&str>) -> String {
    let page = page.map_or_else(|| "No page number".to_owned(), |p| format!("Page {p}"));
    note.map_or_else(|| format!("{page}."), |n| format!("{page}; {n}."))
}

/// Adds a table of a benchmark's requirements and their outcome.
pub(super) fn checks(checks: &[Check], body: &mut Body) {
    body.table(&Check::table(checks, "Requirements on our results", "does\u{a0}not\u{a0}hold"));
}
