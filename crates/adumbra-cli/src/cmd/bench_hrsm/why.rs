//! Why a hybrid map does or does not save time: what a moving light's shadow is spent on, and how often a map must be looked up in
//! before its build is paid for.

use std::fmt::Write as _;

use super::measure::{Row, hybrid, plain};
use super::{Document, FILTERS};

/// Merges that are compared: the paper's tables', and that of the requirements.
const MERGES: [u32; 2] = [1, 2];

/// Milliseconds over the models.
#[derive(Clone, Copy, Default)]
struct Spent {
    depth: f64,
    build: f64,
    lookup: f64,
    /// Of the shadow map at START.
    plain_lookup: f64,
}

impl Spent {
    fn add(&mut self, hybrid: &Row, plain: &Row) {
        self.depth += hybrid.depth_ms;
        self.build += hybrid.build_ms;
        self.lookup += hybrid.lookup_ms;
        self.plain_lookup += plain.lookup_ms;
    }

    /// Look-ups in one map whose savings make up for its build; none where they save nothing.
    fn paying_lookups(&self) -> Option<f64> {
        let saved = self.plain_lookup - self.lookup;
        (saved > 0.0).then(|| (self.build / saved).ceil())
    }
}

/// The section; empty where nothing was measured.
pub(super) fn text(document: &Document) -> String {
    let mut rows = String::new();
    for &start in &document.starts {
        for (filter, merges) in FILTERS.into_iter().flat_map(|f| MERGES.map(|m| (f, m))) {
            if let Some(spent) = spent(document, start, filter, merges) {
                rows.push_str(&row(start, filter, merges, &spent));
            }
        }
    }
    if rows.is_empty() {
        return rows;
    }
    format!(
        "### Why the paper's gain appears or does not\n\nMilliseconds of a moving light, summed over the models but foliage, as shares of \
        depth, build and look-up; the look-up by SM's at START; and how many look-ups in one map make up for its build.\n\n\
        | START-TARGET | filter | depth % | build % | look-up % | look-up by SM's | look-ups that pay for the build |\n\
        |---|---|---|---|---|---|---|\n{rows}\n\
        The depth pass is SM's own. The build comes on top: the pass of each level reads every START texel again, but \
        those under blocks that have already split, so it grows with START² and not with what is in view, and a light \
        that moves pays it in every frame. Only the look-up can win it back. Unfiltered, SM reads one texel and a hybrid \
        map at least one, so nothing is to be won but what smaller memory gives. Under PCF 5 × 5 SM gathers 9 times a \
        pixel; at START/4 the 2 × 2 coarsest planes under the square answer wherever none has split and they agree, and \
        only the other pixels go on to the 9 blocks of finest texels. At START/2, as in the paper's tables, the square \
        may touch 3 × 3 coarsest texels, which is no fewer reads, so every pixel walks the levels for all 9. Where its \
        look-up is the cheaper, then, a hybrid map pays where it is kept while light and casters stand still, or looked \
        up in often (large pictures, several views); a map that is looked up in once costs its build. Where no look-ups \
        pay, it saves memory and no time.\n\n"
    )
}

/// The paper's claims, each with what was found; empty where nothing was measured.
pub(super) fn claims(document: &Document) -> String {
    let models = || document.models.iter().filter(|m| !m.foliage);
    let range = |values: Vec<f64>| {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (!values.is_empty()).then_some([least, most])
    };
    let rows = |filter: u32, merges: u32, option: &'static str| {
        models()
            .flat_map(move |m| &m.groups)
            .filter(move |g| g.filter == filter)
            .filter_map(move |g| g.row(&format!("{}{option}", hybrid(g.start, g.start >> merges, filter))))
    };
    let shown = |range: Option<[f64; 2]>, unit: &str| {
        range.map_or_else(|| "not measured".to_owned(), |[a, b]| format!("{a:.2} to {b:.2}{unit}"))
    };
    let frames = |filter, of: fn(&Row) -> f64| shown(range(rows(filter, 1, "").map(of).collect()), "");
    let gain = |merges, option| {
        let gains = rows(1, merges, option).filter_map(|r| r.boundary.map(|b| 100.0 * b.gain));
        shown(range(gains.collect()), " %")
    };
    let acne = |option| {
        let acne = rows(1, 2, option).map(|r| 100.0 * r.clear.wrong_shadowed);
        shown(range(acne.collect()), " %")
    };
    if models().next().is_none() {
        return String::new();
    }
    format!(
        "### The paper's claims\n\nOver the models but foliage and every START, least to most.\n\n| claim | found |\n|---|---|\n\
        | whole frames 5 to 18 % shorter at the same START | HRSM START-START/2 by SM at START, a light that moves: {} unfiltered, {} PCF \
        5 × 5; one that stands still: {} and {} |\n\
        | 20 % and more resolution at boundaries | START-START/2: {} by the plane test, {} by the paper's; START-START/4: {} and {} |\n\
        | right self-shadow | acne of START-START/4, unfiltered: {} by the plane test, {} by the paper's with the bias of the finest texels, {} with \
        bias=2:slope=2 (largest START) |\n\n\
        The paper's test counts depth from the light, so with e0 = 0.25 it merges whatever differs by less than a quarter of that distance: \
        on a sun's map nearly all boundaries go, and slopes become steps of the coarsest texels that shadow themselves unless the bias is \
        as wide. The plane test keeps every gap wider than its tolerance and merges slopes whole.\n\n",
        frames(1, |r| r.frame_ratio),
        frames(5, |r| r.frame_ratio),
        frames(1, |r| r.still_frame_ratio),
        frames(5, |r| r.still_frame_ratio),
        gain(1, ""),
        gain(1, ":test=paper"),
        gain(2, ""),
        gain(2, ":test=paper"),
        acne(""),
        acne(":test=paper"),
        acne(":test=paper:bias=2:slope=2"),
    )
}

/// Over all models but foliage that have both maps.
fn spent(document: &Document, start: u32, filter: u32, merges: u32) -> Option<Spent> {
    let groups = document.models.iter().filter(|m| !m.foliage).filter_map(|m| m.group(start, filter));
    let pairs = groups.filter_map(|g| {
        Some((g.row(&hybrid(start, start >> merges, filter))?, g.row(&plain(start, filter))?))
    });
    pairs.fold(None, |sum: Option<Spent>, (hybrid, plain)| {
        let mut sum = sum.unwrap_or_default();
        sum.add(hybrid, plain);
        Some(sum)
    })
}

fn row(start: u32, filter: u32, merges: u32, spent: &Spent) -> String {
    let whole = spent.depth + spent.build + spent.lookup;
    let share = |ms: f64| 100.0 * ms / whole;
    let pays = spent.paying_lookups().map_or_else(|| "none do".to_owned(), |n| format!("{n:.0}"));
    let mut text = String::new();
    // Writing to a String does not fail.
    let _ = writeln!(
        text,
        "| {start}-{} | {filter} × {filter} | {:.1} | {:.1} | {:.1} | {:.2} | {pays} |",
        start >> merges,
        share(spent.depth),
        share(spent.build),
        share(spent.lookup),
        spent.lookup / spent.plain_lookup,
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn build_is_paid_for_by_what_look_ups_save() {
        let spent = Spent { depth: 5.0, build: 10.0, lookup: 3.0, plain_lookup: 7.0 };
        assert_eq!(spent.paying_lookups(), Some(3.0));
        assert_eq!(Spent { lookup: 7.0, ..spent }.paying_lookups(), None);
        assert_eq!(
            row(4096, 5, 2, &Spent { lookup: 5.0, plain_lookup: 10.0, ..spent }),
            "| 4096-1024 | 5 × 5 | 25.0 | 50.0 | 25.0 | 0.50 | 2 |\n"
        );
    }
}
