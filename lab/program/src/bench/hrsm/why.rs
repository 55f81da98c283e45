//! Why a hybrid map does or does not save time: how a moving light's shadow time is spent, and how many
//! look-ups in one map pay for its build.

use std::fmt::Write as _;

use super::measure::{Row, hybrid, plain};
use super::{FILTERS, HybridResults};

/// Numbers of merges that are compared: that of the paper's tables, and that of the requirements.
const MERGES: [u32; 2] = [1, 2];

/// Milliseconds summed over the models.
#[derive(Clone, Copy, Default)]
struct Spent {
    depth: f64,
    build: f64,
    lookup: f64,
    /// Look-up in the shadow map at START.
    plain_lookup: f64,
}

impl Spent {
    fn add(&mut self, hybrid: &Row, plain: &Row) {
        self.depth += hybrid.depth_ms;
        self.build += hybrid.build_ms;
        self.lookup += hybrid.lookup_ms;
        self.plain_lookup += plain.lookup_ms;
    }

    /// Returns how many look-ups in one map compensate for its build, or `None` if look-ups save nothing.
    fn paying_lookups(&self) -> Option<f64> {
        let saved = self.plain_lookup - self.lookup;
        (saved > 0.0).then(|| (self.build / saved).ceil())
    }
}

/// Returns the section's text, empty if nothing was measured.
pub(super) fn text(document: &HybridResults) -> String {
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
        "### Why the paper's gain appears or does not\n\nShares of depth, build and look-up in the shadow time \
        under a moving light, summed over all models except foliage; the look-up time relative to SM at START; \
        and how many look-ups in one map pay for its build.\n\n\
        | START-TARGET | filter | depth % | build % | look-up % | look-up / SM's | look-ups that pay for the build |\n\
        |---|---|---|---|---|---|---|\n{rows}\n\
        The depth pass is the same as SM's. The build comes on top: the pass of each level reads every START \
        texel again, except those under blocks that have already split. Its cost therefore grows with START², \
        whatever is in view, and a moving light pays it in every frame. Only a cheaper look-up can win it back. \
        Unfiltered, SM reads one texel and a hybrid map at least one, so the only gain is from smaller memory. \
        With PCF 5 × 5, SM gathers 9 times per pixel. At START/4, the 2 × 2 coarsest planes under the filter \
        decide wherever none of them has split and they agree, and only the other pixels continue to the 9 \
        blocks of finest texels. At START/2, as in the paper's tables, the filter may touch 3 × 3 coarsest \
        texels, which saves no reads, so every pixel walks the levels for all 9. If its look-up is cheaper, a \
        hybrid map pays when it is cached while light and casters do not move, or when it is looked up often \
        (large pictures, several views). A map that is looked up only once costs more by its build. If look-ups \
        never pay for the build, it saves memory but no time.\n\n"
    )
}

/// Returns the paper's claims, each with its measurement, or an empty text if nothing was measured.
pub(super) fn claims(document: &HybridResults) -> String {
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
        "### The paper's claims\n\nSmallest to largest value over every START and all models except foliage.\n\n| claim | found |\n|---|---|\n\
        | whole frames 5 to 18 % shorter at the same START | HRSM START-START/2 relative to SM at START, moving \
        light: {} unfiltered, {} with PCF 5 × 5; static light: {} and {} |\n\
        | at least 20 % more resolution at boundaries | START-START/2: {} with the plane test, {} with the \
        paper's; START-START/4: {} and {} |\n\
        | correct self-shadowing | acne of START-START/4, unfiltered: {} with the plane test, {} with the \
        paper's test and the bias of the finest texels, {} with bias=2:slope=2 (largest START) |\n\n\
        The paper's test measures depth from the light, so with e0 = 0.25 it merges everything that differs by \
        less than a quarter of that distance. On a sun's map, nearly all boundaries vanish, and slopes become \
        steps of the coarsest texels, which shadow themselves unless the bias is equally wide. The plane test \
        keeps every gap wider than its tolerance and merges whole slopes.\n\n",
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

/// Sums the times over all models with both maps, except foliage.
fn spent(document: &HybridResults, start: u32, filter: u32, merges: u32) -> Option<Spent> {
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
    let pays = spent.paying_lookups().map_or_else(|| "none".to_owned(), |n| format!("{n:.0}"));
    let mut text = String::new();
    // Writing to a `String` never fails.
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
    fn paying_lookups_are_build_time_over_saving_per_lookup() {
        let spent = Spent { depth: 5.0, build: 10.0, lookup: 3.0, plain_lookup: 7.0 };
        assert_eq!(spent.paying_lookups(), Some(3.0));
        assert_eq!(Spent { lookup: 7.0, ..spent }.paying_lookups(), None);
        assert_eq!(
            row(4096, 5, 2, &Spent { lookup: 5.0, plain_lookup: 10.0, ..spent }),
            "| 4096-1024 | 5 × 5 | 25.0 | 50.0 | 25.0 | 0.50 | 2 |\n"
        );
    }
}
