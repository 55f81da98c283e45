//! Verdicts on the claims of Li et al. (2016).

use super::super::Verdict;
use super::{FILE, frames, models_of, row};
use crate::bench::hrsm::{HybridResults, ModelFigures, Row};
use crate::paper_report::data::Data;
use adumbra_compare::report::Report;

/// Formats the least and the greatest of the values.
fn range(values: &[f64], show: impl Fn(f64) -> String) -> String {
    let ends = [f64::min as fn(f64, f64) -> f64, f64::max]
        .map(|f| values.iter().copied().filter(|v| v.is_finite()).reduce(f));
    let [Some(least), Some(most)] = ends else { return "not measured".to_owned() };
    let [a, b] = [least, most].map(show);
    if a == b { a } else { format!("{a} to {b}") }
}

pub(super) fn boundary(data: &Data) -> Verdict {
    let document = data.results::<HybridResults>(FILE);
    let gains = |suffix: &str| {
        let mut values = Vec::new();
        for model in models_of(document.as_ref()) {
            for start in [1024, 2048, 4096] {
                let name = format!("hrsm:{start}-{}:filter=1{suffix}", start / 2);
                let gain = |r: &Row| r.boundary.map_or(f64::NAN, |b| 100.0 * b.gain);
                values.extend(row(model, start, &name).map(gain));
            }
        }
        values
    };
    let (ours, papers) = (gains(""), gains(":test=paper"));
    let holds: Vec<bool> =
        [&ours, &papers].iter().filter(|v| !v.is_empty()).map(|v| v.iter().all(|g| *g >= 20.0)).collect();
    let words = |v: &[f64]| range(v, |g| format!("{g:.0} %"));
    let found =
        format!("one merge: {} with the plane test, {} with the paper's test", words(&ours), words(&papers));
    Verdict::counted(&holds, found).because(
        "The paper's test divides by the distance from the light, so under a distant sun it merges outlines too",
    )
}

/// Returns the verdict on a claim of at least `percent` less time, for one model or for all.
pub(super) fn less_time(data: &Data, title: Option<&str>, percent: f64) -> Verdict {
    let document = data.results::<HybridResults>(FILE);
    let wanted = |m: &&ModelFigures| !m.foliage && title.is_none_or(|t| m.title == t);
    let measured: Vec<[f64; 4]> = models_of(document.as_ref())
        .iter()
        .filter(wanted)
        .flat_map(|m| [1024, 2048, 4096].into_iter().filter_map(move |start| frames(m, start)))
        .collect();
    let of = |i: usize| measured.iter().map(|f| 100.0 * (f[i] - 1.0)).collect::<Vec<f64>>();
    let (moving, still) = (of(2), of(3));
    let holds: Vec<bool> = moving.iter().chain(&still).map(|less| *less <= -percent).collect();
    let words = |v: &[f64]| range(v, |g| format!("{g:+.0} %"));
    Verdict::counted(
        &holds,
        format!("{} with a moving light, {} with a static light", words(&moving), words(&still)),
    )
    .because(
        "With a moving light the map is rebuilt every frame, which costs more here than its look-ups save",
    )
}

pub(super) fn foliage(data: &Data) -> Verdict {
    foliage_of(models_of(data.results::<HybridResults>(FILE).as_ref()))
}

/// Foliage is an exception if it gains less time than every other model at the same START.
fn foliage_of(models: &[ModelFigures]) -> Verdict {
    let (leaves, others): (Vec<&ModelFigures>, Vec<&ModelFigures>) = models.iter().partition(|m| m.foliage);
    let starts = [1024, 2048, 4096];
    let mut holds = Vec::new();
    let mut taken = [Vec::new(), Vec::new()];
    for start in starts {
        // Moving light, then still light.
        for (light, taken) in [2, 3].into_iter().zip(&mut taken) {
            let ratios = |models: &[&ModelFigures]| -> Vec<f64> {
                models
                    .iter()
                    .filter_map(|m| Some(frames(m, start)?[light]))
                    .filter(|r| r.is_finite())
                    .collect()
            };
            let (leaves, others) = (ratios(&leaves), ratios(&others));
            if let Some(worst) = others.into_iter().reduce(f64::max) {
                holds.extend(leaves.iter().map(|leaf| *leaf > worst));
            }
            taken.extend(leaves.iter().map(|leaf| 100.0 * (leaf - 1.0)));
        }
    }
    let finest = |m: &ModelFigures, start: u32| {
        row(m, start, &format!("hrsm:{start}-{}:filter=1", start / 4))?.levels.as_ref()?.first().copied()
    };
    let kept = leaves.iter().flat_map(|m| starts.into_iter().filter_map(move |s| finest(m, s)));
    let shares: Vec<f64> = kept.map(|share| 100.0 * share).collect();
    let time = |v: &[f64]| range(v, |p| format!("{p:+.0} %"));
    let found = format!(
        "frame times of an oak: {} with a moving light, {} with a static light; share of the map's area at its finest texels: {}",
        time(&taken[0]),
        time(&taken[1]),
        range(&shares, |s| format!("{s:.0} %"))
    );
    Verdict::counted(&holds, found).because("Counts as an exception if every other model gains more")
}

pub(super) fn acne(data: &Data) -> Verdict {
    let document = data.results::<HybridResults>(FILE);
    let shares = |suffix: &str| {
        let mut values = Vec::new();
        for model in models_of(document.as_ref()).iter().filter(|m| !m.foliage) {
            for start in [1024, 2048, 4096] {
                let name = format!("hrsm:{start}-{}:filter=1{suffix}", start / 2);
                values.extend(row(model, start, &name).map(|r| 100.0 * r.clear.wrong_shadowed));
            }
        }
        values
    };
    let (ours, papers) = (shares(""), shares(":test=paper"));
    let right = |v: &[f64]| v.iter().all(|s| *s < 0.05);
    let holds: Vec<bool> = [&ours, &papers].iter().filter(|v| !v.is_empty()).map(|v| right(v)).collect();
    let words = |v: &[f64]| range(v, |s| format!("{s:.3} %"));
    Verdict::counted(
        &holds,
        format!(
            "lit pixels called shadowed, away from outlines: {} with the plane test, {} with the paper's",
            words(&ours),
            words(&papers)
        ),
    )
}

pub(super) fn finer_is_better(data: &Data) -> Verdict {
    let Some(report) = data.results::<Report>("hrsm/pictures/report.json") else {
        return Verdict::Unmeasured;
    };
    let wrong = |name: &str| {
        Some(100.0 * report.techniques.iter().find(|r| r.name == name)?.wrong().unwrap_or(f64::NAN))
    };
    let names = ["sm:size=512", "hrsm:1024-512:filter=1", "hrsm:2048-512:filter=1", "hrsm:4096-512:filter=1"];
    let values: Vec<f64> = names.into_iter().filter_map(wrong).collect();
    let steps: Vec<bool> = values.windows(2).map(|w| w[1] < w[0]).collect();
    let words: Vec<String> = values.iter().map(|v| format!("{v:.2}")).collect();
    Verdict::counted(
        &steps,
        format!(
            "wrong pixels of SM 512, and of HRSM 512 with START 1024, 2048, 4096: {} %",
            words.join(", ")
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a model whose other values are taken from a recorded result.
    fn model(foliage: bool, moving: Option<f64>, still: Option<f64>) -> ModelFigures {
        let known = include_str!("../../../../tests/recorded/hrsm.json");
        let known: HybridResults = serde_json::from_str(known).unwrap();
        let mut model = known.models[0].clone();
        let mut group = model.group(1024, 1).unwrap().clone();
        group.rows.retain(|r| ["sm:size=1024", "hrsm:1024-512:filter=1"].contains(&&*r.name));
        for row in &mut group.rows {
            row.frame_ratio = moving.unwrap_or(f64::NAN);
            row.still_frame_ratio = still.unwrap_or(f64::NAN);
        }
        model.groups = vec![group];
        model.foliage = foliage;
        model
    }

    #[test]
    fn foliage_claim_holds_if_it_gains_less_than_others() {
        let of = foliage_of;
        let others = [model(false, Some(1.1), Some(0.8)), model(false, Some(1.3), Some(0.9))];
        let with = |oak: ModelFigures| of(&[others.as_slice(), &[oak]].concat());
        let found = match with(model(true, Some(1.5), Some(1.0))) {
            Verdict::Holds(found) => found,
            other => panic!("{other:?}"),
        };
        assert!(found.contains("+50 % with a moving light") && found.ends_with("not measured"), "{found}");
        assert!(matches!(with(model(true, Some(1.2), Some(1.0))), Verdict::Partly(_)));
        assert!(matches!(with(model(true, Some(1.2), Some(0.7))), Verdict::HoldsNot(_)));
        assert_eq!(with(model(true, None, None)), Verdict::Unmeasured);
        assert_eq!(of(&others), Verdict::Unmeasured);
        assert_eq!(
            of(&[model(true, Some(1.2), Some(1.0))]),
            Verdict::Unmeasured,
            "nothing to be an exception of"
        );
    }

    #[test]
    fn range_without_finite_values_is_not_measured() {
        let of = |values: &[f64]| range(values, |v| format!("{v:.0} %"));
        assert_eq!([of(&[]), of(&[f64::NAN])], ["not measured", "not measured"]);
        assert_eq!([of(&[1.0, f64::NAN, 3.0]), of(&[2.0])], ["1 % to 3 %", "2 %"]);
    }
}
