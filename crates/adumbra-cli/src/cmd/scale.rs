//! Colours for amounts.

/// Colours from the least to the most. Each is lighter than the one before it.
pub(super) const SCALE: [[u8; 3]; 5] =
    [[49, 38, 120], [40, 104, 152], [44, 158, 118], [160, 198, 60], [250, 230, 110]];
/// Colours from much less to much more.
const DIFFERENCE: [[u8; 3]; 5] =
    [[33, 80, 170], [130, 170, 215], [240, 240, 236], [230, 150, 110], [180, 40, 30]];

/// Returns the colour at a place from 0 to 1 on the scale.
pub(super) fn color(place: f64) -> [u8; 3] {
    between(&SCALE, place)
}

/// Returns the colour of a difference from -1 to 1: blue for less, red for more.
pub(super) fn difference_color(place: f64) -> [u8; 3] {
    between(&DIFFERENCE, 0.5 + 0.5 * place)
}

fn between(scale: &[[u8; 3]; 5], place: f64) -> [u8; 3] {
    let step = place.clamp(0.0, 1.0) * (scale.len() - 1) as f64;
    let below = (step as usize).min(scale.len() - 2);
    let part = step - below as f64;
    let [low, high] = [scale[below], scale[below + 1]];
    std::array::from_fn(|c| {
        let [low, high] = [low, high].map(|color| f64::from(color[c]));
        (low + part * (high - low)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_brightens_and_clamps_at_both_ends() {
        assert_eq!([color(0.0), color(1.0), color(0.5)], [SCALE[0], SCALE[4], SCALE[2]]);
        assert_eq!([color(-1.0), color(2.0)], [SCALE[0], SCALE[4]]);
        let luma = |c: [u8; 3]| 2 * u32::from(c[0]) + 7 * u32::from(c[1]) + u32::from(c[2]);
        assert!((0..100).all(|i| luma(color(f64::from(i) / 100.0)) <= luma(color(f64::from(i + 1) / 100.0))));
    }

    #[test]
    fn difference_is_blue_below_and_red_above() {
        let [less, none, more] = [-1.0, 0.0, 1.0].map(difference_color);
        assert!(less[2] > less[0] && more[0] > more[2] && none.iter().all(|&c| c > 230));
    }
}
