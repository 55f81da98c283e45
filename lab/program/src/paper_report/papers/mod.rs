//! The papers: their content from `data/papers.json`, and our counterpart to each of their tables, figures
//! and claims.

mod ambient;
mod hybrid;
mod soft;
mod voxel;

use serde::Deserialize;
use serde_json::Value;

use super::data::Data;
use super::inputs::{PageInputs, pages};
use adumbra_html::page::{Body, Section, Table};
use adumbra_program::format::grouped;

/// Transcription of the papers.
const PAPERS: &str = include_str!("../../../data/papers.json");

#[derive(Debug, Deserialize)]
pub(super) struct Papers {
    pub(super) papers: Vec<Paper>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Paper {
    pub(super) key: String,
    pub(super) title_en: String,
    pub(super) title_original: String,
    pub(super) authors: Vec<String>,
    pub(super) authors_original: Vec<String>,
    pub(super) year: u32,
    pub(super) venue: String,
    pub(super) notes: Vec<String>,
    pub(super) claims: Vec<Claim>,
    pub(super) tables: Vec<Printed>,
    pub(super) figures: Vec<Printed>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Claim {
    pub(super) text: String,
    pub(super) page: Option<u32>,
}

/// A table or a figure as printed. A figure has no columns and rows, a table no series.
#[derive(Debug, Deserialize)]
pub(super) struct Printed {
    pub(super) id: String,
    pub(super) caption: String,
    pub(super) page: Option<u32>,
    pub(super) note: Option<String>,
    pub(super) unit: Option<String>,
    #[serde(default)]
    pub(super) columns: Vec<String>,
    #[serde(default)]
    pub(super) rows: Vec<Vec<Value>>,
    #[serde(default)]
    pub(super) series: Vec<PrintedSeries>,
}

#[derive(Debug, Deserialize)]
pub(super) struct PrintedSeries {
    pub(super) name: String,
    pub(super) points: Vec<[f64; 2]>,
}

/// Our counterpart to a paper.
pub(super) struct Realised {
    /// The paper's key.
    key: &'static str,
    /// Short name in the contents.
    short: &'static str,
    /// All of the paper's tables and figures by id.
    items: &'static [(&'static str, Show)],
    /// All of the paper's claims, each by its first words.
    claims: &'static [(&'static str, Evaluate)],
}

/// Our counterpart to a table or a figure.
#[derive(Clone, Copy)]
pub(super) enum Show {
    /// Content below the paper's own.
    Below(fn(&mut PageInputs<'_>, &mut Body)),
    /// Content in one table together with the paper's own, which it shows too.
    Beside(fn(&mut PageInputs<'_>, &Printed, &mut Body)),
    /// Nothing, with the reason.
    Nothing(&'static str),
}

/// Function that evaluates a claim.
type Evaluate = fn(&Data) -> Verdict;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    Holds(String),
    Partly(String),
    HoldsNot(String),
    /// The claim is not about a measurement; describes how it is implemented.
    Realised(&'static str),
    /// The folder has no measurement for it.
    Unmeasured,
}

impl Verdict {
    /// Returns a verdict from a single finding.
    fn of(holds: bool, found: String) -> Self {
        if holds { Self::Holds(found) } else { Self::HoldsNot(found) }
    }

    /// Returns a verdict from several findings.
    ///
    /// It holds if all of them do, partly if some do, and is unmeasured if there are none.
    fn counted(holds: &[bool], found: String) -> Self {
        match holds.iter().filter(|h| **h).count() {
            _ if holds.is_empty() => Self::Unmeasured,
            0 => Self::HoldsNot(found),
            n if n == holds.len() => Self::Holds(found),
            _ => Self::Partly(found),
        }
    }

    /// Adds the reason if the claim does not hold, or holds only in part.
    fn because(self, why: &str) -> Self {
        match self {
            Self::HoldsNot(found) => Self::HoldsNot(format!("{found}. {why}")),
            Self::Partly(found) => Self::Partly(format!("{found}. {why}")),
            other => other,
        }
    }

    fn words(&self) -> [String; 2] {
        let [verdict, found] = match self {
            Self::Holds(found) => ["holds", found],
            Self::Partly(found) => ["in\u{a0}part", found],
            Self::HoldsNot(found) => ["does\u{a0}not\u{a0}hold", found],
            Self::Realised(how) => ["implemented", how],
            Self::Unmeasured => ["not\u{a0}measured", ""],
        };
        [verdict.to_owned(), found.to_owned()]
    }
}

const REALISED: [&Realised; 4] = [&voxel::PAPER, &hybrid::PAPER, &soft::PAPER, &ambient::PAPER];

/// Returns all papers. The file is embedded in the program, and a test checks that it is readable.
pub(super) fn all() -> Vec<Paper> {
    serde_json::from_str::<Papers>(PAPERS).map_or_else(|_| Vec::new(), |p| p.papers)
}

/// Returns one section per paper.
pub(super) fn sections(inputs: &mut PageInputs<'_>) -> Vec<Section> {
    let beside = |p: &Paper| REALISED.into_iter().find(|r| r.key == p.key);
    all().iter().filter_map(|p| Some(section(p, beside(p)?, inputs))).collect()
}

fn section(paper: &Paper, realised: &Realised, inputs: &mut PageInputs<'_>) -> Section {
    let mut body = Body::default();
    body.paragraph(&format!(
        "{}: “{}”. {}, {}.",
        paper.authors.join(", "),
        paper.title_en,
        paper.venue,
        paper.year
    ));
    body.foreign("zh", &format!("{}：{}", paper.authors_original.join("，"), paper.title_original));
    if !paper.notes.is_empty() {
        body.list(&paper.notes);
    }
    body.part(&format!("{}-claims", paper.key), "Claims");
    let mut table = Table::new("", &["claim", "page", "result\u{a0}here", ""]);
    for claim in &paper.claims {
        let evaluate = realised.claims.iter().find(|(begins, _)| claim.text.starts_with(begins));
        let verdict = evaluate.map_or(Verdict::Unmeasured, |(_, evaluate)| evaluate(inputs.data));
        let [verdict, found] = verdict.words();
        let page = claim.page.map_or_else(String::new, |p| p.to_string());
        table.row([claim.text.clone(), page, verdict, found]);
    }
    body.table(&table);
    for printed in paper.tables.iter().chain(&paper.figures) {
        let id = format!("{}-{}", paper.key, printed.id.replace([' ', '.'], "-"));
        let said = printed.caption.to_lowercase().starts_with(&printed.id);
        let title = if said {
            printed.caption.clone()
        } else {
            format!("{}: {}", capital(&printed.id), printed.caption)
        };
        body.part(&id, &title);
        body.paragraph(&pages(printed.page, printed.note.as_deref()));
        let show = realised.items.iter().find(|(id, _)| *id == printed.id).map(|(_, show)| *show);
        match show {
            Some(Show::Beside(show)) => show(inputs, printed, &mut body),
            Some(Show::Below(show)) => {
                as_printed(printed, &mut body);
                show(inputs, &mut body);
            }
            Some(Show::Nothing(why)) => {
                as_printed(printed, &mut body);
                body.aside(&format!("No counterpart here: {why}."));
            }
            None => body.aside("No counterpart here."),
        }
    }
    Section { id: paper.key.clone(), title: realised.short.to_owned(), body }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |c| c.to_uppercase().chain(chars).collect())
}

/// Formats a printed value. Whole numbers from ten thousand on have thousands separators.
pub(super) fn cell(value: &Value) -> String {
    match (value.as_str(), value.as_u64()) {
        (Some(text), _) => text.to_owned(),
        (None, Some(whole)) if whole >= 10_000 => grouped(whole),
        _ => value.to_string(),
    }
}

/// Adds the paper's own numbers, if it prints any.
fn as_printed(printed: &Printed, body: &mut Body) {
    if !printed.columns.is_empty() {
        let unit = printed.unit.as_ref().map_or_else(String::new, |u| format!(", {u}"));
        let head: Vec<&str> = printed.columns.iter().map(String::as_str).collect();
        let mut table = Table::new(&format!("As printed in the paper{unit}"), &head);
        for row in &printed.rows {
            table.row(row.iter().map(cell));
        }
        body.table(&table);
    }
    let points = printed.series.iter().filter(|s| !s.points.is_empty());
    let mut table = Table::new("Read from the paper's plot", &["series", "x", "y"]);
    for series in points {
        for [x, y] in &series.points {
            table.row([series.name.clone(), x.to_string(), y.to_string()]);
        }
    }
    if !table.rows.is_empty() {
        body.table(&table);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_paper_table_and_figure_has_a_counterpart() {
        let papers = serde_json::from_str::<Papers>(PAPERS).unwrap().papers;
        assert_eq!(papers.len(), REALISED.len());
        for (paper, realised) in papers.iter().zip(REALISED) {
            assert_eq!(paper.key, realised.key);
            let printed: Vec<&str> =
                paper.tables.iter().chain(&paper.figures).map(|p| p.id.as_str()).collect();
            let shown: Vec<&str> = realised.items.iter().map(|(id, _)| *id).collect();
            assert_eq!(printed, shown, "{}", paper.key);
        }
    }

    #[test]
    fn every_paper_claim_has_one_evaluation() {
        for (paper, realised) in all().iter().zip(REALISED) {
            assert_eq!(paper.claims.len(), realised.claims.len(), "{}", paper.key);
            for claim in &paper.claims {
                let judges = realised.claims.iter().filter(|(begins, _)| claim.text.starts_with(begins));
                assert_eq!(judges.count(), 1, "{}: {}", paper.key, claim.text);
            }
        }
    }

    #[test]
    fn printed_numbers_have_thousands_separators() {
        assert_eq!(cell(&Value::from(2_400_000)), "2,400,000");
        assert_eq!(cell(&Value::from(12_000)), "12,000");
        assert_eq!(cell(&Value::from(1200)), "1200");
        assert_eq!(cell(&Value::from(0.5)), "0.5");
    }

    #[test]
    fn counted_findings_hold_in_full_in_part_or_not() {
        let of = |holds: &[bool]| Verdict::counted(holds, "x".to_owned());
        assert_eq!(of(&[]), Verdict::Unmeasured);
        assert_eq!(of(&[true, true]), Verdict::Holds("x".to_owned()));
        assert_eq!(of(&[true, false]), Verdict::Partly("x".to_owned()));
        assert_eq!(of(&[false]), Verdict::HoldsNot("x".to_owned()));
    }
}
