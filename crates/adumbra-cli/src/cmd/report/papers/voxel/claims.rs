//! What was found of the claims of 2021.

use adumbra::tree::morton;
use serde_json::Value;

use super::super::super::data::Data;
use super::super::super::page::{number, rows, text};
use super::super::Verdict;
use super::{COMPLETE, FILE, MERGED, PATH, SHARED, closed_bytes, seconds};

/// Rows of a part of the benchmark of one scene.
fn of_scene<'v>(document: &'v Value, part: &str, scene: &str) -> Vec<&'v Value> {
    rows(document, &format!("/{part}")).iter().filter(|r| text(r, "scene") == scene).collect()
}

/// A scene's rows by depth.
fn by_depth<'v>(document: &'v Value, part: &str, scene: &str) -> Vec<&'v Value> {
    let mut found = of_scene(document, part, scene);
    found.sort_by(|a, b| number(a, "/depth").total_cmp(&number(b, "/depth")));
    found
}

pub(super) fn doubling(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let found = by_depth(&document, "reductions/rows", "landscape");
    let [.., before, after] = found.as_slice() else { return Verdict::Unmeasured };
    let growth = |key: &str| number(after, key) / number(before, key);
    let (all, merged, shared) = (growth(COMPLETE), growth(MERGED), growth(SHARED));
    Verdict::of(
        (all - 8.0).abs() < 0.1,
        format!(
            "the landscape's deepest step: {all:.1} times complete, {merged:.1} merged, {shared:.1} shared"
        ),
    )
}

/// What the survey's lossy merging leaves of its scene: 938 of 1228 MB.
const SURVEY_LOSSY: f64 = 938.0 / 1228.0;

pub(super) fn lossy(data: &Data) -> Verdict {
    lossy_of(&data.json(FILE).unwrap_or_default())
}

fn lossy_of(document: &Value) -> Verdict {
    let found: Vec<(&str, f64)> = rows(document, "/options/rows")
        .iter()
        .filter(|r| text(r, "option") == "lossy 0.5 %")
        .map(|r| (text(r, "scene"), number(r, "/times_plain")))
        .filter(|(_, share)| share.is_finite())
        .collect();
    let holds: Vec<bool> = found.iter().map(|(_, share)| *share <= SURVEY_LOSSY).collect();
    let words: Vec<String> =
        found.iter().map(|(scene, share)| format!("{scene} {:.0} %", 100.0 * share)).collect();
    Verdict::counted(
        &holds,
        format!(
            "the survey leaves {:.0} %, of another scene; ours, changing 0.5 % of the border voxels: {}",
            100.0 * SURVEY_LOSSY,
            words.join(", ")
        ),
    )
    .because("What can be merged depends on the scene")
}

/// Whether the share of `what` in `whole` falls from depth to depth.
pub(super) fn merging_shrinks(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let shares: Vec<f64> = by_depth(&document, "reductions/rows", "landscape")
        .iter()
        .map(|r| 100.0 * number(r, MERGED) / number(r, COMPLETE))
        .collect();
    let holds: Vec<bool> = shares.windows(2).map(|w| w[1] < w[0]).collect();
    let words: Vec<String> = shares.iter().map(|s| format!("{s:.2} %")).collect();
    Verdict::counted(&holds, format!("landscape, by depth: {}", words.join(", ")))
}

pub(super) fn closed_is_smaller(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let found = closed_bytes(&document);
    let holds: Vec<bool> = found.iter().map(|(_, open, closed)| closed < open).collect();
    let words: Vec<String> =
        found.iter().map(|(scene, open, closed)| format!("{scene} {:.0} %", 100.0 * closed / open)).collect();
    Verdict::counted(&holds, format!("bytes left at depth 10: {}", words.join(", ")))
}

pub(super) fn deep_recursion(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    // The options' trees, depth 11, are built by recursion as the reductions' are.
    let depth = rows(&document, "/reductions/rows").iter().map(|r| number(r, "/depth")).reduce(f64::max);
    match depth {
        Some(depth) => Verdict::HoldsNot(format!(
            "recursion goes as deep as the tree, and built depth {depth:.0} here; what overflows must be something else than its depth"
        )),
        None => Verdict::Unmeasured,
    }
}

pub(super) fn recursion_first(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let at_8: Vec<&Value> = rows(&document, "/builders/rows").iter().filter(|r| r["depth"] == 8).collect();
    let mut holds = Vec::new();
    let mut words = Vec::new();
    for row in at_8 {
        let [recursive, iterative, pooled] = seconds(row);
        holds.extend([recursive < pooled, pooled < iterative]);
        words.push(format!("{}: {recursive:.3}, {iterative:.3}, {pooled:.3} s", text(row, "scene")));
    }
    Verdict::counted(&holds, format!("recursive, iterative, pooled: {}", words.join("; ")))
    .because("No object is collected here when a frame goes, as in the paper's C#; what is left between the three lies near the noise")
}

pub(super) fn landscape_shares_more(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let share = |scene: &str| {
        let found = by_depth(&document, "reductions/rows", scene);
        found.last().map(|r| (number(r, "/depth"), 100.0 * number(r, SHARED) / number(r, MERGED)))
    };
    match (share("landscape"), share("primitives")) {
        (Some((depth, landscape)), Some((_, simple))) => Verdict::of(
            landscape < simple,
            format!("depth {depth:.0}: landscape {landscape:.0} %, simple solids {simple:.0} %"),
        )
        .because("Shares depend on the scenes, and the paper's are not published"),
        _ => Verdict::Unmeasured,
    }
}

pub(super) fn hash_beside_sort(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let mut holds = Vec::new();
    let mut words = Vec::new();
    for scene in ["primitives", "landscape"] {
        let found = by_depth(&document, "reductions/rows", scene);
        let Some(row) = found.last() else { continue };
        let ratio = |key: &str| number(row, &format!("/{key}/hash")) / number(row, &format!("/{key}/sort"));
        let (time, memory) = (ratio("seconds"), ratio("held_bytes"));
        holds.extend([time < 1.0, memory < 1.0]);
        words.push(format!(
            "{scene} at depth {}: {time:.2} of the time, {memory:.2} of the memory",
            row["depth"]
        ));
    }
    Verdict::counted(&holds, words.join("; "))
        .because("Here both are fast where a pyramid skips what is decided")
}

pub(super) fn bias_beside_acne(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let mut holds = Vec::new();
    let mut words = Vec::new();
    for scene in ["primitives", "landscape"] {
        let found = of_scene(&document, "filters/rows", scene);
        let of = |look_up: &str| {
            found.iter().find(|r| text(r, "look_up") == look_up).map(|r| 100.0 * number(r, "/acne"))
        };
        if let (Some(none), Some(bias)) = (of("no bias, no filter"), of("bias")) {
            holds.push(bias < none);
            words.push(format!("{scene} {none:.2} % without, {bias:.2} % with"));
        }
    }
    Verdict::counted(&holds, format!("lit points called shadowed: {}", words.join("; ")))
}

pub(super) fn good_shadows(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let mut holds = Vec::new();
    let mut words = Vec::new();
    for (scene, depth) in [("primitives", 11), ("landscape", 10)] {
        let found = of_scene(&document, "frames/rows/frames", scene);
        if let Some(row) = found.iter().find(|r| r["depth"] == depth && text(r, "frame") == "world") {
            let right = 100.0 * number(row, "/interior_agreement");
            holds.push(right >= 99.9);
            words.push(format!(
                "{scene} at depth {depth}: {right:.3} % of points two voxels from outlines agree with rays"
            ));
        }
    }
    Verdict::counted(&holds, words.join("; "))
}

pub(super) fn beside_cascades(data: &Data) -> Verdict {
    let document = data.json(PATH).unwrap_or_default();
    let cheaper = rows(&document, "/path/cheaper");
    let share = |filter: u32| {
        let row = cheaper.iter().find(|c| text(c, "voxel").contains(&format!("filter={filter}")))?;
        Some(number(row, "/share"))
    };
    match (share(3), share(5)) {
        (Some(three), Some(five)) => Verdict::counted(
            &[three >= 1.0, five > 0.5],
            format!(
                "cheaper than cascades in {:.0} % of the frames with 3 × 3 × 3, in {:.0} % with 5 × 5 × 5",
                100.0 * three,
                100.0 * five
            ),
        ),
        _ => Verdict::Unmeasured,
    }
}

pub(super) fn worked_examples(_: &Data) -> Verdict {
    let plane: Vec<u32> = morton::path([5, 3, 0], 3).iter().map(|child| child >> 1).collect();
    let holds = plane == [2, 1, 3] && morton::path([5, 3, 5], 3) == [5, 2, 7];
    Verdict::of(holds, format!("{plane:?} and {:?}", morton::path([5, 3, 5], 3)))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn lossy_is_held_to_the_survey() {
        let of = |shares: &[Option<f64>]| {
            let row =
                |share: &Option<f64>| json!({"option": "lossy 0.5 %", "scene": "city", "times_plain": share});
            let rows: Vec<Value> = shares.iter().map(row).collect();
            lossy_of(&json!({"options": {"rows": rows}}))
        };
        assert!(
            matches!(of(&[Some(0.7)]), Verdict::Holds(found) if found.contains("76 %") && found.ends_with("city 70 %"))
        );
        assert!(matches!(of(&[Some(0.7), Some(0.8)]), Verdict::Partly(_)));
        assert!(matches!(of(&[Some(0.9)]), Verdict::HoldsNot(_)));
        assert_eq!([of(&[]), of(&[None])], [Verdict::Unmeasured, Verdict::Unmeasured]);
    }
}
