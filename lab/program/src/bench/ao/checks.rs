//! The requirements and their outcome.

use adumbra_render::occlusion::Estimator;

use super::{AoResults, SceneFigures, peers};
use crate::occlusion::{Claims, SCENES};
use crate::peers::RowSource;
use crate::peers::occlusion::{OcclusionRow, SCENES as PEER_SCENES};
use crate::results::Check;
use adumbra_compare::metrics::median;

/// Number of the eight scenes on which issao must have the lowest RMSE of the paper's four estimators.
const LOWEST: usize = 5;
/// Largest allowed ratio of issao's time to alchemy's.
const TIME: f64 = 1.05;
/// Number of the eight scenes on which issao must have a lower RMSE than gtao at equal time.
const AHEAD: usize = 4;
/// The estimators that the paper compares.
const PAPER: [Estimator; 4] = [Estimator::Ssao, Estimator::Hbao, Estimator::Alchemy, Estimator::Issao];

pub(super) fn all(document: &AoResults) -> Vec<Check> {
    let scenes = &document.scenes;
    let mut checks = vec![lowest(scenes), time(scenes), equal_time(scenes), engines(document)];
    let claim = |text: &str, beside, lower, of: &dyn Fn(&Claims) -> Option<f64>| {
        compared(scenes, text, beside, lower, of)
    };
    checks.push(claim(
        "claim: more detail than `hbao`, by the correlation of the high pass with the truth's",
        Estimator::Hbao,
        false,
        &|c| c.detail_correlation,
    ));
    checks.push(claim(
        "claim: less self-occlusion than `ssao`, by mean occlusion where the truth is open",
        Estimator::Ssao,
        true,
        &|c| c.self_occlusion,
    ));
    checks.push(claim(
        "claim: cleaner edges than `alchemy` after filtering, by RMSE at edges",
        Estimator::Alchemy,
        true,
        &|c| c.edge_rmse,
    ));
    checks
}

fn rmse(scene: &SceneFigures, estimator: Estimator) -> f64 {
    scene.row(estimator).map_or(f64::INFINITY, |r| r.filtered.errors.rmse)
}

/// Returns the titles of the scenes, or "none".
fn titles(scenes: &[&SceneFigures]) -> String {
    let names: Vec<&str> = scenes.iter().map(|s| &*s.title).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Returns whether at least `wanted` scenes comply.
///
/// Returns `None` if too few do but not all scenes are measured yet.
fn counted(found: usize, wanted: usize, measured: usize) -> Option<bool> {
    if found >= wanted { Some(true) } else { (measured == SCENES.len()).then_some(false) }
}

fn lowest(scenes: &[SceneFigures]) -> Check {
    let others = || PAPER.into_iter().filter(|e| *e != Estimator::Issao);
    let ahead = |s: &&SceneFigures| others().all(|e| rmse(s, Estimator::Issao) < rmse(s, e));
    let found: Vec<&SceneFigures> = scenes.iter().filter(ahead).collect();
    Check {
        requirement: format!(
            "`issao` with filter has the lowest RMSE of ssao, hbao, alchemy, issao on at least {LOWEST} of the {} scenes",
            SCENES.len()
        ),
        measured: format!("{} of {}: {}", found.len(), scenes.len(), titles(&found)),
        holds: counted(found.len(), LOWEST, scenes.len()),
    }
}

fn time(scenes: &[SceneFigures]) -> Check {
    let ratios: Vec<f64> =
        scenes.iter().filter_map(|s| s.row(Estimator::Issao)).map(|r| r.by_alchemy).collect();
    let (least, most) =
        ratios.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), r| (l.min(*r), m.max(*r)));
    let middle = median(ratios.clone());
    let (measured, holds) = if ratios.is_empty() {
        ("not measured".to_owned(), None)
    } else {
        (format!("{middle:.3}; {least:.3} to {most:.3} over the scenes"), Some(middle <= TIME))
    };
    Check {
        requirement: format!(
            "at most {TIME} × alchemy's time: the median over scenes of each scene's median ratio over frames"
        ),
        measured,
        holds,
    }
}

fn equal_time(scenes: &[SceneFigures]) -> Check {
    let ahead = |s: &&SceneFigures| s.equal_time.as_ref().is_some_and(|e| e.issao_rmse < e.gtao_rmse);
    let found: Vec<&SceneFigures> = scenes.iter().filter(ahead).collect();
    let slower = scenes.iter().filter_map(|s| s.equal_time.as_ref()).filter(|e| e.ratio > 1.0).count();
    let note = if slower > 0 { format!("; still slower than gtao on {slower}") } else { String::new() };
    Check {
        requirement: format!(
            "at equal time, `issao` has a lower RMSE than `gtao` on at least {AHEAD} of the {} scenes",
            SCENES.len()
        ),
        measured: format!("{} of {}: {}{note}", found.len(), scenes.len(), titles(&found)),
        holds: counted(found.len(), AHEAD, scenes.len()),
    }
}

fn engines(document: &AoResults) -> Check {
    let requirement =
        "on the truth cameras, `issao` with filter has a lower RMSE than every engine".to_owned();
    let Some(rows) = &document.peers else {
        return Check { requirement, measured: "not measured".to_owned(), holds: None };
    };
    let of = |row: &OcclusionRow, i: usize| row.scenes[i].map_or(f64::INFINITY, |f| f.rmse);
    let ours = peers::name(Estimator::Issao, document.samples, true);
    let ours = rows.iter().find(|r| r.name == ours);
    let best = |i| {
        let elsewhere = rows.iter().filter(|r| r.source == RowSource::MeasuredElsewhere);
        elsewhere.map(|r| of(r, i)).fold(f64::INFINITY, f64::min)
    };
    let figures = [0, 1, 2].map(|i| (ours.map_or(f64::INFINITY, |r| of(r, i)), best(i)));
    let words: Vec<String> = PEER_SCENES
        .iter()
        .zip(figures)
        .map(|(name, (own, best))| format!("{name} {own:.3} against {best:.3}"))
        .collect();
    let holds = figures.iter().all(|(own, best)| own < best);
    Check { requirement, measured: words.join(", "), holds: Some(holds) }
}

/// Compares issao's mean over the scenes with another estimator's, both with filter.
fn compared(
    scenes: &[SceneFigures],
    requirement: &str,
    beside: Estimator,
    lower: bool,
    of: &dyn Fn(&Claims) -> Option<f64>,
) -> Check {
    let pair = |s: &SceneFigures| {
        let of = |e| s.row(e).and_then(|r| of(&r.filtered.claims));
        Some([of(Estimator::Issao)?, of(beside)?])
    };
    let pairs: Vec<[f64; 2]> = scenes.iter().filter_map(pair).collect();
    let requirement = requirement.to_owned();
    if pairs.is_empty() {
        return Check { requirement, measured: "not measured".to_owned(), holds: None };
    }
    let better = |own: f64, other: f64| if lower { own < other } else { own > other };
    let [own, other] = [0, 1].map(|i| pairs.iter().map(|p| p[i]).sum::<f64>() / pairs.len() as f64);
    let won = pairs.iter().filter(|p| better(p[0], p[1])).count();
    Check {
        requirement,
        measured: format!("mean {own:.4} against {other:.4}; better on {won} of {} scenes", pairs.len()),
        holds: Some(better(own, other)),
    }
}
