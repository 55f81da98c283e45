//! Requirements on hybrid maps from START to START/4, and their outcome.

use super::measure::{Group, Row, hybrid, plain};
use super::models::{MODELS, PAPER_STARTS};
use super::{FILTERS, HybridResults, ModelFigures};
use crate::results::Check;

/// Share of wrong pixels in excess of that of the shadow map at START.
const MORE_WRONG: f64 = 0.001;
/// Wrong pixels divided by those of the shadow map at START/4.
const OF_COARSE_WRONG: f64 = 0.5;
/// Share of the pixels clear of edges that are lit but called shadowed.
const ACNE: f64 = 0.0005;
/// Bytes divided by those of the shadow map at START.
const MEMORY: f64 = 0.35;
/// Look-up time divided by the shadow map's, for START = 4096 and PCF 5 × 5.
const LOOKUP: f64 = 0.82;
const LOOKUP_AT: (u32, u32) = (4096, 5);

/// A hybrid map and the two shadow maps at its finest and coarsest resolution.
pub(super) struct Case<'a> {
    pub(super) model: &'a ModelFigures,
    pub(super) group: &'a Group,
    pub(super) fine: &'a Row,
    pub(super) coarse: &'a Row,
    pub(super) hybrid: &'a Row,
    /// The hybrid map of 16-bit depth, compared with a shadow map of 16 bits.
    hybrid_16: Option<&'a Row>,
}

impl Case<'_> {
    pub(super) fn more_wrong(&self) -> f64 {
        self.hybrid.wrong() - self.fine.wrong()
    }

    pub(super) fn of_coarse_wrong(&self) -> f64 {
        self.hybrid.wrong() / self.coarse.wrong()
    }

    fn name(&self) -> String {
        let Group { start, filter, .. } = self.group;
        format!("{} {start}, {filter} × {filter}", self.model.title)
    }
}

/// Returns the cases of every model, start and filter.
pub(super) fn cases(document: &HybridResults) -> Vec<Case<'_>> {
    let groups = document.models.iter().flat_map(|m| m.groups.iter().map(move |g| (m, g)));
    groups
        .filter_map(|(model, group)| {
            let Group { start, filter, .. } = *group;
            Some(Case {
                model,
                group,
                fine: group.row(&plain(start, filter))?,
                coarse: group.row(&plain(start / 4, filter))?,
                hybrid: group.row(&hybrid(start, start / 4, filter))?,
                hybrid_16: group.row(&format!("{}:depth=16", hybrid(start, start / 4, filter))),
            })
        })
        .collect()
}

/// How a requirement bounds a figure.
#[derive(Clone, Copy)]
enum Bound {
    AtMost(f64),
    Under(f64),
}

impl Bound {
    fn holds(self, value: f64) -> bool {
        match self {
            Self::AtMost(most) => value <= most,
            Self::Under(most) => value < most,
        }
    }
}

/// Checks every requirement, measured or not.
pub(super) fn all(document: &HybridResults) -> Vec<Check> {
    let cases = required(document);
    let percent = |v: f64| format!("{:.3} %", 100.0 * v);
    let points = |v: f64| format!("{:+.3} points", 100.0 * v);
    let plain = |v: f64| format!("{v:.3}");
    let more = format!(
        "wrong pixels of START-START/4: at most {} percentage points more than SM at START",
        100.0 * MORE_WRONG
    );
    let half = format!("wrong pixels of START-START/4: at most {OF_COARSE_WRONG} × SM at START/4");
    let acne = format!("acne of START-START/4: under {} %", 100.0 * ACNE);
    vec![
        worst(&cases, more, Bound::AtMost(MORE_WRONG), &|c| Some(c.more_wrong()), &points),
        worst(&cases, half, Bound::AtMost(OF_COARSE_WRONG), &|c| Some(c.of_coarse_wrong()), &plain),
        worst(&cases, acne, Bound::Under(ACNE), &|c| Some(c.hybrid.clear.wrong_shadowed), &percent),
        memory(&cases, 32, &|c| Some(c.hybrid)),
        memory(&cases, 16, &|c| c.hybrid_16),
        look_up(&cases),
    ]
}

/// Describes which models, starts and cases were measured, and which are missing.
pub(super) fn covers(document: &HybridResults) -> String {
    let cases = required(document);
    let (mut titles, mut starts) = (Vec::new(), Vec::new());
    for case in &cases {
        titles.push(case.model.title.as_str());
        starts.push(case.group.start);
    }
    titles.dedup();
    starts.sort_unstable();
    starts.dedup();
    let required = MODELS.iter().filter(|m| !m.foliage).map(|m| m.title);
    let mut missing: Vec<String> = required.filter(|t| !titles.contains(t)).map(str::to_owned).collect();
    for model in document.models.iter().filter(|m| titles.contains(&m.title.as_str())) {
        for (&start, filter) in document.starts.iter().flat_map(|s| FILTERS.map(|f| (s, f))) {
            let at = (model.title.as_str(), start, filter);
            let found = cases.iter().any(|c| (c.model.title.as_str(), c.group.start, c.group.filter) == at);
            if !found && starts.contains(&start) {
                missing.push(format!("{} {start}, {filter} × {filter}", model.title));
            }
        }
    }
    let finer = document.starts.iter().filter(|s| !PAPER_STARTS.contains(s));
    missing.extend(
        PAPER_STARTS
            .iter()
            .chain(finer)
            .filter(|s| !starts.contains(s))
            .map(|start| format!("START {start}")),
    );
    let starts: Vec<String> = starts.iter().map(u32::to_string).collect();
    let measured = if cases.is_empty() {
        "no cases.".to_owned()
    } else {
        let (count, titles, starts) = (cases.len(), titles.join(", "), starts.join(", "));
        format!("{count} cases (model, START, filter): {titles}; START {starts}.")
    };
    if missing.is_empty() { measured } else { format!("{measured} Not measured: {}.", missing.join("; ")) }
}

/// Returns every case except those of foliage.
pub(super) fn required(document: &HybridResults) -> Vec<Case<'_>> {
    cases(document).into_iter().filter(|c| !c.model.foliage).collect()
}

/// Checks a requirement by the worst of the cases for which the figure was measured.
fn worst(
    cases: &[Case<'_>],
    requirement: String,
    bound: Bound,
    of: &dyn Fn(&Case<'_>) -> Option<f64>,
    show: &dyn Fn(f64) -> String,
) -> Check {
    let values: Vec<(&Case<'_>, f64)> = cases.iter().filter_map(|c| Some((c, of(c)?))).collect();
    let Some(&(case, value)) = values.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Check { requirement, measured: "not measured".to_owned(), holds: None };
    };
    let over = values.iter().filter(|(_, v)| !bound.holds(*v)).count();
    let count = if over == 0 { String::new() } else { format!("; {over} of {} exceed it", values.len()) };
    let measured = format!("at worst {} ({}){count}", show(value), case.name());
    Check { requirement, measured, holds: Some(over == 0) }
}

/// Checks the memory requirement of the cached map at a depth precision.
///
/// The memory under a moving light is reported as well, but not checked.
fn memory(cases: &[Case<'_>], bits: u32, row: &dyn for<'c> Fn(&'c Case<'_>) -> Option<&'c Row>) -> Check {
    let requirement = format!(
        "memory of START-START/4, {bits}-bit depth, cached for a static light: at most {MEMORY} × SM at START"
    );
    let plain = |v: f64| format!("{v:.3}");
    let mut check =
        worst(cases, requirement, Bound::AtMost(MEMORY), &|c| row(c).map(|r| r.still_share), &plain);
    let moving = cases.iter().filter_map(row).map(|r| r.moving_share).reduce(f64::max);
    if let Some(moving) = moving {
        check.measured.push_str(&format!("; up to {moving:.3} while the light moves"));
    }
    check
}

/// Checks the look-up requirement, model by model.
fn look_up(cases: &[Case<'_>]) -> Check {
    let requirement = format!("median look-up time of 4096-1024, PCF 5 × 5: at most {LOOKUP} × SM at 4096");
    let at = |c: &&Case<'_>| (c.group.start, c.group.filter) == LOOKUP_AT;
    let rows: Vec<(&str, &Row)> =
        cases.iter().filter(at).map(|c| (c.model.title.as_str(), c.hybrid)).collect();
    if rows.is_empty() {
        return Check { requirement, measured: "not measured".to_owned(), holds: None };
    }
    let shown = |(title, r): &(&str, &Row)| {
        let [least, most] = r.lookup_ratio_range;
        format!("{title} {:.2} ({least:.2} to {most:.2})", r.lookup_ratio)
    };
    let measured: Vec<String> = rows.iter().map(shown).collect();
    let holds = rows.iter().all(|(_, r)| r.lookup_ratio <= LOOKUP);
    Check { requirement, measured: measured.join(", "), holds: Some(holds) }
}
