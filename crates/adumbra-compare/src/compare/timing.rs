//! Timing of several techniques on a machine with other load. Their frames are interleaved, so that a
//! disturbance slows all of them.

use adumbra_render::{Answer, FrameTimes, Prepared, Renderer, Shot};

use crate::error::Result;
use crate::metrics::median;

/// Draws frame k of every technique before frame k + 1 of any, and returns the times of each technique's
/// `frames` frames.
///
/// Each round begins with another technique, and every other round runs backwards, so that no technique is
/// always drawn after the same one. The first frame is timed too. To exclude resources created on first use,
/// draw a frame before.
///
/// # Errors
/// Returns the errors of the renderer.
pub fn interleaved(
    renderer: &mut Renderer,
    shot: &Shot,
    techniques: &mut [&mut Prepared],
    frames: u32,
) -> Result<Vec<Vec<FrameTimes>>> {
    take_turns(techniques.len(), frames, |at| Ok(renderer.draw(shot, techniques[at], Answer::Visibility)?))
}

/// Calls `draw` with the indices 0 to `count` - 1 in the interleaved order of [`interleaved`], `frames` times
/// each, and returns the times by index.
///
/// # Errors
/// Returns the errors of `draw`.
pub fn take_turns(
    count: usize,
    frames: u32,
    mut draw: impl FnMut(usize) -> Result<FrameTimes>,
) -> Result<Vec<Vec<FrameTimes>>> {
    let mut times = vec![Vec::new(); count];
    for round in 0..frames as usize {
        for at in turns(round, count) {
            times[at].push(draw(at)?);
        }
    }
    Ok(times)
}

/// Returns the indices in the order of a round.
fn turns(round: usize, count: usize) -> impl Iterator<Item = usize> {
    (0..count).map(move |turn| {
        let at = (turn + round) % count;
        if round.is_multiple_of(2) { at } else { count - 1 - at }
    })
}

/// Returns the median of `what` over the frames, NaN if there are none.
pub fn median_time(times: &[FrameTimes], what: impl Fn(&FrameTimes) -> f64) -> f64 {
    median(times.iter().map(what).collect())
}

/// Returns the median over frames k of the ratio of `what` in frame k of `times` to that in frame k of
/// `beside`, NaN if there are no frames.
pub fn median_ratio(times: &[FrameTimes], beside: &[FrameTimes], what: impl Fn(&FrameTimes) -> f64) -> f64 {
    median(times.iter().zip(beside).map(|(a, b)| what(a) / what(b)).collect())
}

/// Returns the smallest and the largest of the ratios whose median is [`median_ratio`], or +∞ and -∞ if there
/// are no frames.
pub fn ratio_range(
    times: &[FrameTimes],
    beside: &[FrameTimes],
    what: impl Fn(&FrameTimes) -> f64,
) -> [f64; 2] {
    let ratios = times.iter().zip(beside).map(|(a, b)| what(a) / what(b));
    ratios.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], r| [least.min(r), most.max(r)])
}

#[cfg(test)]
mod tests {
    use adumbra_render::Stage;

    use super::*;

    fn frames(lookups: &[f64]) -> Vec<FrameTimes> {
        let frame = |&ms: &f64| {
            let mut times = FrameTimes::default();
            times.milliseconds[Stage::Lookup as usize] = ms;
            times
        };
        lookups.iter().map(frame).collect()
    }

    #[test]
    fn median_ratio_ignores_a_slowdown_of_both() {
        let (a, b) = (frames(&[1.0, 8.0, 2.0]), frames(&[2.0, 16.0, 4.0]));
        assert_eq!(median_ratio(&a, &b, |t| t.of(Stage::Lookup)), 0.5);
        assert_eq!(median_time(&a, |t| t.of(Stage::Lookup)), 2.0);
        assert!(median_time(&[], |t| t.of(Stage::Lookup)).is_nan());
        let c = frames(&[1.0, 4.0, 16.0]);
        assert_eq!(ratio_range(&a, &c, |t| t.of(Stage::Lookup)), [0.125, 2.0]);
    }

    #[test]
    fn turns_have_each_index_once_and_a_new_start_each_round() {
        let orders: Vec<Vec<usize>> = (0..4).map(|round| turns(round, 5).collect()).collect();
        assert_eq!(orders[0], [0, 1, 2, 3, 4]);
        assert_eq!(orders[1], [3, 2, 1, 0, 4]);
        for order in &orders {
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, [0, 1, 2, 3, 4]);
        }
        let mut first: Vec<usize> = orders.iter().map(|o| o[0]).collect();
        first.dedup();
        assert_eq!(first.len(), 4);
        assert_eq!(turns(3, 0).count(), 0);
    }
}
