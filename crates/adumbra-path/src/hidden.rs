//! Rays that neither key can decide: the length of their hidden part from which they count as blocked.
//!
//! A point in the shadow of something far away may also have something near between it and the sun, which
//! neither key shows. When the far shadow moves away, the point is in the near shadow, or it is lit. The
//! longer a ray is hidden, the more can be hidden there. The length above which more rays are blocked than
//! not depends on the scene, so it is measured.

use adumbra::grid::vec3::dot;
use adumbra::{Filter, PathSampler, SunStep};
use rayon::prelude::*;

use crate::error::Result;
use crate::place::{Probe, steps_within};
use crate::visible::VisiblePoint;

/// Gaps that are tried, from the path's beginning to its end: at most this many, and one for every few
/// degrees that the sun moves.
const MOST_GAPS: usize = 6;
const DEGREES_FOR_EACH: f64 = 8.0;
/// Angle between the two keys of a gap.
const GAP_DEGREES: f64 = 4.0;
/// Least gain: rays that become right minus rays that become wrong.
const LEAST_GAIN: i64 = 5;

/// Returns the number of voxels from which a ray that is hidden from both keys counts as blocked. With it,
/// the most rays to some suns of the path are right. 0 if that is hardly better than never.
///
/// Cost: two bakes for each gap that is tried: none if the sun moves by less than 8°, six for a day.
pub(crate) fn dark_after(probe: &dyn Probe, steps: &[SunStep], runs: &[[usize; 2]]) -> Result<u32> {
    let way = |&[first, last]: &[usize; 2]| steps[first..=last].windows(2).map(degrees_apart).sum::<f64>();
    let gaps = MOST_GAPS.min((runs.iter().map(way).sum::<f64>() / DEGREES_FOR_EACH) as usize);
    let in_runs: Vec<[usize; 2]> =
        runs.iter().flat_map(|&[first, last]| (first..=last).map(move |step| [step, last])).collect();
    let mut rays = Vec::new();
    for gap in 0..gaps {
        let [step, last] = in_runs[(in_runs.len() - 1) * gap / (gaps - 1).max(1)];
        let first = step.min(first_of_last_gap(steps, runs, last));
        let end = first + steps_within(steps, first, last, GAP_DEGREES);
        if end - first >= 2 {
            unknown(probe, &steps[first..=end], &mut rays)?;
        }
    }
    Ok(best(rays))
}

/// Returns the step at which the last gap of the run that ends with `last` begins.
fn first_of_last_gap(steps: &[SunStep], runs: &[[usize; 2]], last: usize) -> usize {
    let first = runs.iter().find(|run| run[1] == last).map_or(last, |run| run[0]);
    let mut way = 0.0;
    let is_within = |step: &usize| {
        way += degrees_apart(&steps[*step..=*step + 1]);
        way <= GAP_DEGREES
    };
    (first..last).rev().take_while(is_within).last().unwrap_or(last)
}

fn degrees_apart(steps: &[SunStep]) -> f64 {
    dot(steps[0].towards_sun, steps[1].towards_sun).min(1.0).acos().to_degrees()
}

/// Adds the rays to three suns of a gap that neither key decides: for how many voxels each is hidden, and
/// whether it is lit.
fn unknown(probe: &dyn Probe, gap: &[SunStep], rays: &mut Vec<(u32, bool)>) -> Result<()> {
    let [a, b] = [gap[0], gap[gap.len() - 1]].map(|key| probe.bake(key.towards_sun));
    let (a, b) = (a?, b?);
    for quarter in 1..4 {
        let towards_sun = gap[(gap.len() - 1) * quarter / 4].towards_sun;
        let Some(sampler) = PathSampler::new([&a, &b], towards_sun, Filter::Nearest) else { continue };
        let hidden = |(point, lit): &(VisiblePoint, bool)| {
            let voxels = sampler.hidden_voxels(point.p_world, Some(point.normal))?;
            Some((voxels, *lit))
        };
        rays.par_extend(probe.seen(towards_sun).par_iter().filter_map(hidden));
    }
    Ok(())
}

/// Returns the length from which most rays are blocked.
fn best(mut rays: Vec<(u32, bool)>) -> u32 {
    rays.sort_unstable_by(|a, b| b.cmp(a));
    let (mut gain, mut most, mut length) = (0, LEAST_GAIN - 1, 0);
    for same in rays.chunk_by(|a, b| a.0 == b.0) {
        gain += same.iter().map(|(_, lit)| if *lit { -1 } else { 1 }).sum::<i64>();
        if gain > most && same[0].0 > 0 {
            (most, length) = (gain, same[0].0);
        }
    }
    length
}

#[cfg(test)]
mod tests {
    use super::best;

    #[test]
    fn best_length_makes_most_rays_right() {
        let rays = |dark: &[u32], lit: &[u32]| -> Vec<(u32, bool)> {
            let of = |lengths: &[u32], lit| lengths.iter().map(|l| (*l, lit)).collect::<Vec<_>>();
            [of(dark, false), of(lit, true)].concat()
        };
        let dark = [90, 80, 80, 70, 60, 50, 40, 10];
        assert_eq!(best(rays(&dark, &[30, 20, 10])), 40);
        assert_eq!(best(rays(&dark, &[85, 45, 44, 43])), 50);
        assert_eq!(best(rays(&dark[..4], &[])), 0, "too few to know");
        assert_eq!(best(rays(&[], &dark)), 0);
        assert_eq!(best(rays(&[0; 9], &[])), 0, "rays that begin in light are no matter of length");
    }
}
