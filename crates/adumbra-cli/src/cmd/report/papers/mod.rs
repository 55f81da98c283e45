//! The papers: what they print, from `data/papers.json`, and what stands beside each of their tables, figures and claims.

mod ambient;
mod hybrid;
mod soft;
mod voxel;

use adumbra_lab::page::{Body, Section, Table};
use adumbra_lab::report::grouped;
use serde::Deserialize;
use serde_json::Value;

use super::data::Data;
use super::page::{Seen, pages};

/// What was transcribed from the papers.
const PAPERS: &str = include_str!("../../../../../../data/papers.json");

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

/// A table or a figure as it is printed; of a figure there are no columns and rows, of a table no series.
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

/// What stands beside a paper here.
pub(super) struct Realised {
    /// The paper's key.
    key: &'static str,
    /// What it is short for, in the contents.
    short: &'static str,
    /// By id, all of the paper's tables and figures.
    items: &'static [(&'static str, Show)],
    /// By how a claim begins, all of the paper's.
    claims: &'static [(&'static str, Judge)],
}

/// What stands beside a table or a figure.
#[derive(Clone, Copy)]
pub(super) enum Show {
    /// Below what the paper prints.
    Below(fn(&mut Seen<'_>, &mut Body)),
    /// In one table with what the paper prints, which it shows too.
    Beside(fn(&mut Seen<'_>, &Printed, &mut Body)),
    /// Nothing, and why.
    Nothing(&'static str),
}

/// What was found of a claim.
type Judge = fn(&Data) -> Verdict;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    Holds(String),
    Partly(String),
    HoldsNot(String),
    /// No claim of a measurement: how it is realised.
    Realised(&'static str),
    /// In the folder is no figure for it.
    Unmeasured,
}

impl Verdict {
    /// Holds or does not, as it is found.
    fn of(holds: bool, found: String) -> Self {
        if holds { Self::Holds(found) } else { Self::HoldsNot(found) }
    }

    /// Of several findings: none is no measurement, all is holding, some is partly.
    fn counted(holds: &[bool], found: String) -> Self {
        match holds.iter().filter(|h| **h).count() {
            _ if holds.is_empty() => Self::Unmeasured,
            0 => Self::HoldsNot(found),
            n if n == holds.len() => Self::Holds(found),
            _ => Self::Partly(found),
        }
    }

    /// Says why, where it does not hold as the paper has it.
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
            Self::Realised(how) => ["realised", how],
            Self::Unmeasured => ["not\u{a0}measured", ""],
        };
        [verdict.to_owned(), found.to_owned()]
    }
}

const REALISED: [&Realised; 4] = [&voxel::PAPER, &hybrid::PAPER, &soft::PAPER, &ambient::PAPER];

/// All of them. The file is part of the program, and a test reads it.
pub(super) fn all() -> Vec<Paper> {
    serde_json::from_str::<Papers>(PAPERS).map_or_else(|_| Vec::new(), |p| p.papers)
}

/// A section a paper.
pub(super) fn sections(seen: &mut Seen<'_>) -> Vec<Section> {
    let beside = |p: &Paper| REALISED.into_iter().find(|r| r.key == p.key);
    all().iter().filter_map(|p| Some(section(p, beside(p)?, seen))).collect()
}

fn section(paper: &Paper, realised: &Realised, seen: &mut Seen<'_>) -> Section {
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
    body.part(&format!("{}-claims", paper.key), "What it claims");
    let mut table = Table::new("", &["claim", "page", "found\u{a0}here", ""]);
    for claim in &paper.claims {
        let judge = realised.claims.iter().find(|(begins, _)| claim.text.starts_with(begins));
        let verdict = judge.map_or(Verdict::Unmeasured, |(_, judge)| judge(seen.data));
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
            Some(Show::Beside(show)) => show(seen, printed, &mut body),
            Some(Show::Below(show)) => {
                as_printed(printed, &mut body);
                show(seen, &mut body);
            }
            Some(Show::Nothing(why)) => {
                as_printed(printed, &mut body);
                body.aside(&format!("Nothing of ours beside it: {why}."));
            }
            None => body.aside("Nothing of ours beside it."),
        }
    }
    Section { id: paper.key.clone(), title: realised.short.to_owned(), body }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |c| c.to_uppercase().chain(chars).collect())
}

/// A printed value; from ten thousand on, whole numbers in groups of three digits.
pub(super) fn cell(value: &Value) -> String {
    match (value.as_str(), value.as_u64()) {
        (Some(text), _) => text.to_owned(),
        (None, Some(whole)) if whole >= 10_000 => grouped(whole),
        _ => value.to_string(),
    }
}

/// The paper's own numbers; nothing where it prints none.
fn as_printed(printed: &Printed, body: &mut Body) {
    if !printed.columns.is_empty() {
        let unit = printed.unit.as_ref().map_or_else(String::new, |u| format!(", {u}"));
        let head: Vec<&str> = printed.columns.iter().map(String::as_str).collect();
        let mut table = Table::new(&format!("The paper's{unit}"), &head);
        for row in &printed.rows {
            table.row(row.iter().map(cell));
        }
        body.table(&table);
    }
    let points = printed.series.iter().filter(|s| !s.points.is_empty());
    let mut table = Table::new("The paper's, read from its plot", &["series", "x", "y"]);
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
    fn papers_tables_and_figures_each_have_something_beside_them() {
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
    fn papers_claims_each_have_one_judge() {
        for (paper, realised) in all().iter().zip(REALISED) {
            assert_eq!(paper.claims.len(), realised.claims.len(), "{}", paper.key);
            for claim in &paper.claims {
                let judges = realised.claims.iter().filter(|(begins, _)| claim.text.starts_with(begins));
                assert_eq!(judges.count(), 1, "{}: {}", paper.key, claim.text);
            }
        }
    }

    #[test]
    fn printed_numbers_are_grouped() {
        assert_eq!(cell(&Value::from(2_400_000)), "2,400,000");
        assert_eq!(cell(&Value::from(12_000)), "12,000");
        assert_eq!(cell(&Value::from(1200)), "1200");
        assert_eq!(cell(&Value::from(0.5)), "0.5");
    }

    #[test]
    fn verdict_counts_what_holds() {
        let of = |holds: &[bool]| Verdict::counted(holds, "x".to_owned());
        assert_eq!(of(&[]), Verdict::Unmeasured);
        assert_eq!(of(&[true, true]), Verdict::Holds("x".to_owned()));
        assert_eq!(of(&[true, false]), Verdict::Partly("x".to_owned()));
        assert_eq!(of(&[false]), Verdict::HoldsNot("x".to_owned()));
    }
}
