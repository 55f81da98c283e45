//! Times of several techniques on a machine that does other things besides: their frames take turns, so that what slows one
//! down slows the others too.

use adumbra_render::{Answer, FrameTimes, Prepared, Renderer, Shot};

use crate::error::Result;
use crate::report::median;

/// Draws frame k of every technique before frame k + 1 of any; gives each technique's `frames` times. What a first frame makes is timed
/// too: draw it before.
///
/// # Errors
/// What the renderer reports.
pub fn interleaved(
    renderer: &mut Renderer,
    shot: &Shot,
    techniques: &mut [&mut Prepared],
    frames: u32,
) -> Result<Vec<Vec<FrameTimes>>> {
    let mut times = vec![Vec::new(); techniques.len()];
    for _ in 0..frames {
        for (technique, times) in techniques.iter_mut().zip(&mut times) {
            times.push(renderer.draw(shot, technique, Answer::Visibility)?);
        }
    }
    Ok(times)
}

/// The median over frames of `what`; NaN of none.
pub fn median_time(times: &[FrameTimes], what: impl Fn(&FrameTimes) -> f64) -> f64 {
    median(times.iter().map(what).collect())
}

/// The median over frames k of `what` of frame k of `times` by that of `beside`; NaN of none.
pub fn median_ratio(times: &[FrameTimes], beside: &[FrameTimes], what: impl Fn(&FrameTimes) -> f64) -> f64 {
    median(times.iter().zip(beside).map(|(a, b)| what(a) / what(b)).collect())
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
    fn median_ratio_is_blind_to_what_slows_both() {
        let (a, b) = (frames(&[1.0, 8.0, 2.0]), frames(&[2.0, 16.0, 4.0]));
        assert_eq!(median_ratio(&a, &b, |t| t.of(Stage::Lookup)), 0.5);
        assert_eq!(median_time(&a, |t| t.of(Stage::Lookup)), 2.0);
        assert!(median_time(&[], |t| t.of(Stage::Lookup)).is_nan());
    }
}
