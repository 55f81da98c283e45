//! What must hold of hybrid maps from START to START/4, and whether it does.

use serde::Serialize;

use super::measure::{Group, Row, hybrid, plain};
use super::{Document, ModelFigures};

/// Wrong pixels above those of the shadow map at START, share.
const MORE_WRONG: f64 = 0.001;
/// Wrong pixels by those of the shadow map at START/4.
const OF_COARSE_WRONG: f64 = 0.5;
/// Lit pixels clear of edges that are called shadowed, share.
const ACNE: f64 = 0.0005;
/// Bytes by those of the shadow map at START.
const MEMORY: f64 = 0.35;
/// Look-up by the shadow map's, START = 4096, PCF 5 × 5.
const LOOKUP: f64 = 0.82;
const LOOKUP_AT: (u32, u32) = (4096, 5);

/// A requirement's worst case.
#[derive(Serialize)]
pub(super) struct Check {
    pub(super) requirement: String,
    pub(super) measured: String,
    pub(super) holds: bool,
}

/// A hybrid map beside the two shadow maps that it stands between.
pub(super) struct Case<'a> {
    pub(super) model: &'a ModelFigures,
    pub(super) group: &'a Group,
    pub(super) fine: &'a Row,
    pub(super) coarse: &'a Row,
    pub(super) hybrid: &'a Row,
}

impl Case<'_> {
    pub(super) fn more_wrong(&self) -> f64 {
        self.hybrid.wrong() - self.fine.wrong()
    }

    pub(super) fn of_coarse_wrong(&self) -> f64 {
        self.hybrid.wrong() / self.coarse.wrong()
    }

    /// Acne of hybrid and shadow map.
    pub(super) fn acne(&self) -> [f64; 2] {
        [self.hybrid, self.fine].map(|r| r.clear.map_or(f64::NAN, |c| c.wrong_shadowed))
    }

    fn name(&self) -> String {
        let Group { start, filter, .. } = self.group;
        format!("{} {start}, {filter} × {filter}", self.model.title)
    }
}

/// Every model, start and filter.
pub(super) fn cases(document: &Document) -> Vec<Case<'_>> {
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
            })
        })
        .collect()
}

/// Every requirement that something was measured for.
pub(super) fn all(document: &Document) -> Vec<Check> {
    let cases: Vec<Case<'_>> = cases(document).into_iter().filter(|c| !c.model.foliage).collect();
    let worst =
        |requirement: String, most: f64, of: &dyn Fn(&Case<'_>) -> f64, show: &dyn Fn(f64) -> String| {
            let worst = cases.iter().max_by(|a, b| of(a).total_cmp(&of(b)))?;
            let value = of(worst);
            let over = cases.iter().filter(|c| of(c) > most).count();
            let count = if over == 0 { String::new() } else { format!("; {over} of {} beyond", cases.len()) };
            let measured = format!("at worst {} ({}){count}", show(value), worst.name());
            Some(Check { requirement, measured, holds: value <= most })
        };
    let percent = |v: f64| format!("{:.3} %", 100.0 * v);
    let plain = |v: f64| format!("{v:.3}");
    let more = format!(
        "wrong pixels of START-START/4: at most {} percentage points more than SM at START",
        100.0 * MORE_WRONG
    );
    let half = format!("wrong pixels of START-START/4: at most {OF_COARSE_WRONG} × SM at START/4");
    let acne = format!("acne of START-START/4: under {} %", 100.0 * ACNE);
    let memory = format!("memory of START-START/4, held for a still light: at most {MEMORY} × SM at START");
    let checks = [
        worst(more, MORE_WRONG, &|c| c.more_wrong(), &|v| format!("{:+.3} points", 100.0 * v)),
        worst(half, OF_COARSE_WRONG, &|c| c.of_coarse_wrong(), &plain),
        worst(acne, ACNE, &|c| c.acne()[0], &percent),
        worst(memory, MEMORY, &|c| c.hybrid.still_share, &plain),
        look_up(&cases),
    ];
    checks.into_iter().flatten().collect()
}

/// The look-up's requirement, model by model.
fn look_up(cases: &[Case<'_>]) -> Option<Check> {
    let at = |c: &&Case<'_>| (c.group.start, c.group.filter) == LOOKUP_AT;
    let ratios: Vec<(&str, f64)> =
        cases.iter().filter(at).map(|c| (c.model.title, c.hybrid.lookup_ratio)).collect();
    let measured: Vec<String> = ratios.iter().map(|(title, r)| format!("{title} {r:.2}")).collect();
    (!ratios.is_empty()).then(|| Check {
        requirement: format!("look-up of 4096-1024, PCF 5 × 5: at most {LOOKUP} × SM at 4096"),
        measured: measured.join(", "),
        holds: ratios.iter().all(|(_, r)| *r <= LOOKUP),
    })
}
