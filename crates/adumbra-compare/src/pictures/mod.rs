//! Pictures of a comparison: difference pictures, enlarged details, and contact sheets.

mod sheet;

use adumbra_truth::picture::Picture;
pub use sheet::{Cell, sheet};

use crate::error::{Error, Result};
use crate::metrics::is_lit;

/// Colour of pixels that are lit in the truth but shadowed in the result.
const WRONG_SHADOWED: [f32; 3] = [0.95, 0.10, 0.08];
/// Colour of pixels that are shadowed in the truth but lit in the result.
const WRONG_LIT: [f32; 3] = [0.10, 0.30, 1.00];
/// Brightness of shadowed pixels.
const SHADOWED_GREY: f32 = 0.22;
/// Brightness of lit pixels.
const LIT_GREY: f32 = 0.62;
/// Brightness of pixels excluded from the comparison.
const SKIPPED_GREY: f32 = 0.08;

/// Returns a picture that shows where `factors` differ from the truth.
///
/// Factors on the wrong side of 1/2 are red if the truth is lit, blue if it is shadowed. Elsewhere the
/// picture shows the truth in grey, blended towards red or blue by half of the absolute difference. Pixels
/// for which `counts` does not hold are nearly black.
///
/// # Errors
/// Returns [`Error::Sizes`] if the sizes of factors, truth and picture do not match.
pub(crate) fn difference_picture(
    [width, height]: [u32; 2],
    factors: &[f32],
    truth: &[f32],
    counts: impl Fn(usize) -> bool,
) -> Result<Picture> {
    Error::check_sizes("shadow factors and truth", factors.len(), truth.len())?;
    Error::check_sizes("shadow factors and pixels", factors.len(), width as usize * height as usize)?;
    let pixel = |(i, (&factor, &right)): (usize, (&f32, &f32))| {
        if !counts(i) {
            return [SKIPPED_GREY; 3];
        }
        let wrong = if factor < right { WRONG_SHADOWED } else { WRONG_LIT };
        if is_lit(factor) != is_lit(right) {
            return wrong;
        }
        let grey = SHADOWED_GREY + (LIT_GREY - SHADOWED_GREY) * right;
        let off = 0.5 * (factor - right).abs();
        wrong.map(|c| grey + off * (c - grey))
    };
    let rgb = factors.iter().zip(truth).enumerate().flat_map(|p| pixel(p).map(byte)).collect();
    Ok(Picture { width, height, rgb, difference_share: None })
}

/// Returns a picture that shows which pixels change more often (red) or less often (blue) than they should,
/// by `beyond`: the number of changes more, or less below 0. Four changes give the full colour. Pixels that
/// were not compared are nearly black.
///
/// # Errors
/// Returns [`Error::Sizes`] if the sizes do not match.
pub(crate) fn changes_picture([width, height]: [u32; 2], beyond: &[Option<i64>]) -> Result<Picture> {
    Error::check_sizes("changes and pixels", beyond.len(), width as usize * height as usize)?;
    let pixel = |beyond: &Option<i64>| {
        let Some(beyond) = *beyond else { return [SKIPPED_GREY; 3] };
        let wrong = if beyond > 0 { WRONG_SHADOWED } else { WRONG_LIT };
        let share = beyond.unsigned_abs().min(4) as f32 / 4.0;
        wrong.map(|c| LIT_GREY + share * (c - LIT_GREY))
    };
    let rgb = beyond.iter().flat_map(|beyond| pixel(beyond).map(byte)).collect();
    Ok(Picture { width, height, rgb, difference_share: None })
}

/// Returns a picture of RGBA pixels, without their alpha.
pub fn picture_of_rgba([width, height]: [u32; 2], rgba: &[u8]) -> Picture {
    let rgb = rgba.as_chunks::<4>().0.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
    Picture { width, height, rgb, difference_share: None }
}

/// Returns the part of a picture with the top left corner `from` and the given `size` in pixels, clipped to
/// the picture and enlarged `times` times without interpolation.
pub fn enlarged(picture: &Picture, from: [u32; 2], size: [u32; 2], times: u32) -> Picture {
    let part = |a: usize, whole: u32| size[a].min(whole.saturating_sub(from[a]));
    let [width, height] = [part(0, picture.width) * times, part(1, picture.height) * times];
    let pixels =
        (0..height).flat_map(|y| (0..width).map(move |x| (from[0] + x / times, from[1] + y / times)));
    let rgb = pixels.flat_map(|(x, y)| {
        let at = (y as usize * picture.width as usize + x as usize) * 3;
        [picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]]
    });
    Picture { width, height, rgb: rgb.collect(), difference_share: None }
}

fn byte(c: f32) -> u8 {
    (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn difference_picture_marks_both_kinds_of_wrong() {
        let factors = [0.0, 1.0, 1.0, 0.0, 0.0, 0.75];
        let truth = [1.0, 0.0, 1.0, 0.0, 1.0, 1.0];
        let picture = difference_picture([3, 2], &factors, &truth, |i| i != 4).unwrap();
        let p = picture.rgb.as_chunks::<3>().0;
        assert!(p[0][0] > 200 && p[0][2] < 60, "lit called shadowed is red");
        assert!(p[1][2] > 200 && p[1][0] < 60, "shadowed called lit is blue");
        assert!(p[2][0] == p[2][1] && p[2][1] == p[2][2] && p[2][0] > p[3][0], "right is grey");
        assert!(p[4][0] < p[3][0], "what does not count is dark");
        assert!(p[5][0] > p[5][2], "a little too dark is a little red");
        assert!(difference_picture([2, 2], &factors, &truth, |_| true).is_err());
    }

    #[test]
    fn changes_picture_marks_too_frequent_and_too_rare_changes() {
        let beyond = [Some(4), Some(1), Some(0), Some(-4), None, Some(99)];
        let picture = changes_picture([3, 2], &beyond).unwrap();
        let p = picture.rgb.as_chunks::<3>().0;
        assert!(p[0][0] > 200 && p[0][2] < 60 && p[5] == p[0], "too often is red");
        assert!(p[1][0] > p[1][2] && p[1][2] > p[0][2], "once too often is a little red");
        assert!(p[2][0] == p[2][2] && p[4][0] < p[2][0], "as often is grey, and what does not count is dark");
        assert!(p[3][2] > 200 && p[3][0] < 60, "too seldom is blue");
        assert!(changes_picture([2, 2], &beyond).is_err());
    }

    #[test]
    fn enlarged_repeats_the_pixels_of_the_part() {
        let picture = picture_of_rgba([3, 2], &std::array::from_fn::<u8, 24, _>(|i| i as u8 / 4 * 10));
        let part = enlarged(&picture, [1, 0], [9, 1], 2);
        assert_eq!((part.width, part.height), (4, 2));
        let grey: Vec<u8> = part.rgb.chunks(3).map(|p| p[0]).collect();
        assert_eq!(grey, [10, 10, 20, 20, 10, 10, 20, 20]);
        assert_eq!(enlarged(&picture, [3, 0], [1, 1], 2).rgb.len(), 0);
    }
}
