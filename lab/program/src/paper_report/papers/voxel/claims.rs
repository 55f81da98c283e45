//! Verdicts on the claims of 2021.

use adumbra_papers::tree::morton;

use super::super::Verdict;
use super::{PATH, closed_bytes, document};
use crate::bench::tree::{OptionRow, ReductionRow, TreeResults};
use crate::paper_report::data::Data;
use adumbra_compare::report::Report;

/// Returns a scene's reductions sorted by depth.
fn by_depth<'d>(document: &'d TreeResults, scene: &str) -> Vec<&'d ReductionRow> {
    let mut found: Vec<_> = document.reduction_rows().iter().filter(|r| r.scene == scene).collect();
    found.sort_by_key(|r| r.depth);
    found
}

pub(super) fn doubling(data: &Data) -> Verdict {
    let document = document(data);
    let found = by_depth(&document, "landscape");
    let [.., before, after] = found.as_slice() else { return Verdict::Unmeasured };
    let growth = |of: fn(&ReductionRow) -> f64| of(after) / of(before);
    let all = growth(|r| r.complete_bytes);
    let [merged, shared] = [growth(|r| r.merged_bytes as f64), growth(|r| r.graph_bytes as f64)];
    Verdict::of(
        (all - 8.0).abs() < 0.1,
        format!(
            "landscape, last step in depth: {all:.1} times the bytes complete, {merged:.1} merged, {shared:.1} shared"
        ),
    )
}

/// Share of its scene that the survey's lossy merging leaves: 938 of 1228 MB.
const SURVEY_LOSSY: f64 = 938.0 / 1228.0;

pub(super) fn lossy(data: &Data) -> Verdict {
    lossy_of(&document(data).options.map_or_else(Vec::new, |part| part.rows))
}

fn lossy_of(rows: &[OptionRow]) -> Verdict {
    let lossy = rows.iter().filter(|r| r.option == "lossy 0.5 %");
    let found: Vec<(&str, f64)> = lossy.map(|r| (r.scene.as_str(), r.times_plain)).collect();
    let holds: Vec<bool> = found.iter().map(|(_, share)| *share <= SURVEY_LOSSY).collect();
    let words: Vec<String> =
        found.iter().map(|(scene, share)| format!("{scene} {:.0} %", 100.0 * share)).collect();
    Verdict::counted(
        &holds,
        format!(
            "the survey leaves {:.0} % on another scene; ours, with 0.5 % of the border voxels changed: {}",
            100.0 * SURVEY_LOSSY,
            words.join(", ")
        ),
    )
    .because("What can be merged depends on the scene")
}

/// Returns the verdict on whether the share that upward merging leaves falls from depth to depth.
pub(super) fn merging_shrinks(data: &Data) -> Verdict {
    let document = document(data);
    let shares: Vec<f64> =
        by_depth(&document, "landscape").iter().map(|r| 100.0 * r.merged_share()).collect();
    let holds: Vec<bool> = shares.windows(2).map(|w| w[1] < w[0]).collect();
    let words: Vec<String> = shares.iter().map(|s| format!("{s:.2} %")).collect();
    Verdict::counted(&holds, format!("landscape, by depth: {}", words.join(", ")))
}

pub(super) fn closed_is_smaller(data: &Data) -> Verdict {
    let document = document(data);
    let found = closed_bytes(&document);
    let holds: Vec<bool> = found.iter().map(|(_, open, closed)| closed < open).collect();
    let words: Vec<String> =
        found.iter().map(|(scene, open, closed)| format!("{scene} {:.0} %", 100.0 * closed / open)).collect();
    Verdict::counted(&holds, format!("bytes left at depth 10: {}", words.join(", ")))
}

pub(super) fn deep_recursion(data: &Data) -> Verdict {
    let document = document(data);
    // The options' trees, of depth 11, are built by recursion as well, like those of the reductions.
    let depth = document.reduction_rows().iter().map(|r| r.depth).max();
    match depth {
        Some(depth) => Verdict::HoldsNot(format!(
            "recursion is only as deep as the tree, and built depth {depth} here; the overflow must have another cause"
        )),
        None => Verdict::Unmeasured,
    }
}

pub(super) fn recursion_first(data: &Data) -> Verdict {
    let document = document(data);
    let mut holds = Vec::new();
    let mut words = Vec::new();
    let rows = document.builders.iter().flat_map(|part| &part.rows);
    for row in rows.filter(|r| r.depth == 8) {
        let [recursive, iterative, pooled] = row.seconds.list();
        holds.extend([recursive < pooled, pooled < iterative]);
        words.push(format!("{}: {recursive:.3}, {iterative:.3}, {pooled:.3} s", row.scene));
    }
    Verdict::counted(&holds, format!("recursive, iterative, pooled: {}", words.join("; ")))
    .because("Unlike in the paper's C#, no frames are garbage-collected here; the remaining differences are close to noise")
}

pub(super) fn landscape_shares_more(data: &Data) -> Verdict {
    let document = document(data);
    let share = |scene: &str| {
        let found = by_depth(&document, scene);
        found.last().map(|r| (r.depth, 100.0 * r.shared_share()))
    };
    match (share("landscape"), share("primitives")) {
        (Some((depth, landscape)), Some((_, simple))) => Verdict::of(
            landscape < simple,
            format!("depth {depth}: landscape {landscape:.0} %, simple solids {simple:.0} %"),
        )
        .because("Shares depend on the scenes, and the paper's scenes are not published"),
        _ => Verdict::Unmeasured,
    }
}

pub(super) fn hash_beside_sort(data: &Data) -> Verdict {
    let document = document(data);
    let mut holds = Vec::new();
    let mut words = Vec::new();
    for scene in ["primitives", "landscape"] {
        let found = by_depth(&document, scene);
        let Some(row) = found.last() else { continue };
        let time = row.seconds.hash / row.seconds.sort;
        let memory = row.held_bytes.hash as f64 / row.held_bytes.sort as f64;
        holds.extend([time < 1.0, memory < 1.0]);
        words.push(format!(
            "{scene} at depth {}: {time:.2} times the time, {memory:.2} times the memory",
            row.depth
        ));
    }
    Verdict::counted(&holds, words.join("; "))
        .because("Here a pyramid skips regions that are already decided, so both are fast")
}

pub(super) fn bias_beside_acne(data: &Data) -> Verdict {
    let document = document(data);
    let mut holds = Vec::new();
    let mut words = Vec::new();
    for scene in ["primitives", "landscape"] {
        let of = |look_up: &str| {
            let mut rows = document.filters.iter().flat_map(|part| &part.rows);
            rows.find(|r| r.scene == scene && r.look_up == look_up).map(|r| 100.0 * r.acne)
        };
        if let (Some(none), Some(bias)) = (of("no bias, no filter"), of("bias")) {
            holds.push(bias < none);
            words.push(format!("{scene} {none:.2} % without, {bias:.2} % with"));
        }
    }
    Verdict::counted(&holds, format!("lit points called shadowed: {}", words.join("; ")))
}

pub(super) fn good_shadows(data: &Data) -> Verdict {
    let document = document(data);
    let mut holds = Vec::new();
    let mut words = Vec::new();
    for (scene, depth) in [("primitives", 11), ("landscape", 10)] {
        let mut rows = document.frame_rows().iter().filter(|r| r.scene == scene);
        if let Some(row) = rows.find(|r| r.depth == depth && r.frame == "world") {
            let right = 100.0 * row.interior_agreement;
            holds.push(right >= 99.9);
            words.push(format!(
                "{scene} at depth {depth}: {right:.3} % of the points at least two voxels from outlines agree with rays"
            ));
        }
    }
    Verdict::counted(&holds, words.join("; "))
}

pub(super) fn beside_cascades(data: &Data) -> Verdict {
    let path = data.results::<Report>(PATH).and_then(|report| report.path);
    let share = |filter: u32| {
        let cheaper = &path.as_ref()?.cheaper;
        Some(cheaper.iter().find(|c| c.voxel.contains(&format!("filter={filter}")))?.share)
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
    use super::*;

    #[test]
    fn lossy_claim_is_compared_with_survey() {
        let of = |shares: &[f64]| {
            let row = |times_plain: &f64| OptionRow {
                scene: "city".to_owned(),
                depth: 11,
                option: "lossy 0.5 %".to_owned(),
                bytes: 1,
                times_plain: *times_plain,
                seconds: 1.0,
                changed_voxels: None,
                leaf_voxels: None,
                nanoseconds: 1.0,
            };
            lossy_of(&shares.iter().map(row).collect::<Vec<_>>())
        };
        assert!(
            matches!(of(&[0.7]), Verdict::Holds(found) if found.contains("76 %") && found.ends_with("city 70 %"))
        );
        assert!(matches!(of(&[0.7, 0.8]), Verdict::Partly(_)));
        assert!(matches!(of(&[0.9]), Verdict::HoldsNot(_)));
        assert_eq!(of(&[]), Verdict::Unmeasured);
    }
}
