//! What was found of the claims of Li et al. (2016).

use serde_json::Value;

use super::super::super::data::Data;
use super::super::super::page::{number, rows, text};
use super::super::Verdict;
use super::{FILE, frames, row};

/// Least and most as words.
fn range(values: &[f64], show: impl Fn(f64) -> String) -> String {
    let [least, most] = [f64::min as fn(f64, f64) -> f64, f64::max]
        .map(|f| values.iter().copied().reduce(f).unwrap_or(f64::NAN));
    let [a, b] = [least, most].map(show);
    if a == b { a } else { format!("{a} to {b}") }
}

pub(super) fn boundary(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let gains = |suffix: &str| {
        let mut values = Vec::new();
        for model in rows(&document, "/models") {
            for start in [1024_u64, 2048, 4096] {
                let name = format!("hrsm:{start}-{}:filter=1{suffix}", start / 2);
                values.extend(row(model, start, &name).map(|r| 100.0 * number(r, "/boundary/gain")));
            }
        }
        values
    };
    let (ours, papers) = (gains(""), gains(":test=paper"));
    let holds: Vec<bool> =
        [&ours, &papers].iter().filter(|v| !v.is_empty()).map(|v| v.iter().all(|g| *g >= 20.0)).collect();
    let words = |v: &[f64]| range(v, |g| format!("{g:.0} %"));
    let found =
        format!("one merge: {} by the plane test, {} by the paper's test", words(&ours), words(&papers));
    Verdict::counted(&holds, found).because(
        "The paper's test divides by the distance from the light, so it merges outlines of a far sun too",
    )
}

/// At least `percent` less time, of a model or of all.
pub(super) fn less_time(data: &Data, title: Option<&str>, percent: f64) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let wanted = |m: &&Value| m["foliage"] != true && title.is_none_or(|t| text(m, "title") == t);
    let measured: Vec<[f64; 4]> = rows(&document, "/models")
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
        format!("{} while the light moves, {} while it stands still", words(&moving), words(&still)),
    )
    .because("While the light moves the map is built anew, which costs more than its look-ups save here")
}

pub(super) fn foliage(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let Some(oak) = rows(&document, "/models").iter().find(|m| m["foliage"] == true) else {
        return Verdict::Unmeasured;
    };
    let finest = |start: u64| {
        let row = row(oak, start, &format!("hrsm:{start}-{}:filter=1", start / 4))?;
        row.pointer("/levels/0").and_then(Value::as_f64)
    };
    let shares: Vec<f64> = [1024, 2048, 4096].into_iter().filter_map(finest).map(|s| 100.0 * s).collect();
    Verdict::Holds(format!(
        "an oak keeps {} of the map's area at its finest texels",
        range(&shares, |s| format!("{s:.0} %"))
    ))
}

pub(super) fn acne(data: &Data) -> Verdict {
    let document = data.json(FILE).unwrap_or_default();
    let shares = |suffix: &str| {
        let mut values = Vec::new();
        for model in rows(&document, "/models").iter().filter(|m| m["foliage"] != true) {
            for start in [1024_u64, 2048, 4096] {
                let name = format!("hrsm:{start}-{}:filter=1{suffix}", start / 2);
                values.extend(row(model, start, &name).map(|r| 100.0 * number(r, "/clear/wrong_shadowed")));
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
            "lit pixels called shadowed, away from outlines: {} by the plane test, {} by the paper's",
            words(&ours),
            words(&papers)
        ),
    )
}

pub(super) fn finer_is_better(data: &Data) -> Verdict {
    let Some(report) = data.json("hrsm/pictures/report.json") else { return Verdict::Unmeasured };
    let wrong = |name: &str| {
        let row = rows(&report, "/techniques").iter().find(|r| text(r, "name") == name)?;
        Some(100.0 * (number(row, "/wrong_lit") + number(row, "/wrong_shadowed")))
    };
    let names = ["sm:size=512", "hrsm:1024-512:filter=1", "hrsm:2048-512:filter=1", "hrsm:4096-512:filter=1"];
    let values: Vec<f64> = names.into_iter().filter_map(wrong).collect();
    let steps: Vec<bool> = values.windows(2).map(|w| w[1] < w[0]).collect();
    let words: Vec<String> = values.iter().map(|v| format!("{v:.2}")).collect();
    Verdict::counted(
        &steps,
        format!("wrong pixels of SM 512 and of starts 1024, 2048, 4096: {} %", words.join(", ")),
    )
}
