//! The sky in patches of about equal size: 145 after Tregenza, *Subdivision of the Sky Hemisphere for
//! Luminance Measurements* (1987), or 577 after Reinhart's subdivision of it by 2 (as in Radiance's
//! `reinhart.cal`).
//!
//! Rows go from the horizon up, and each row goes clockwise from north, where the middle of its first patch
//! is. The last patch is a cap about the zenith.

use std::f64::consts::{PI, TAU};

/// Number of patches in each of Tregenza's rows, from the horizon up, without the cap at the zenith.
const TREGENZA_ROWS: [u32; 7] = [30, 30, 24, 24, 18, 12, 6];

/// A division of the sky into patches.
#[derive(Clone, Debug)]
pub struct Patches {
    centers: Vec<[f64; 3]>,
    solid_angles: Vec<f64>,
    weights: Vec<[f64; 3]>,
}

impl Patches {
    /// Tregenza's 145 patches.
    pub fn tregenza() -> Self {
        Self::new(1)
    }

    /// Reinhart's 577 patches: twice the rows, and twice the patches in each.
    pub fn reinhart_577() -> Self {
        Self::new(2)
    }

    fn new(times: u32) -> Self {
        let rows: Vec<u32> =
            TREGENZA_ROWS.iter().flat_map(|&count| (0..times).map(move |_| count * times)).collect();
        let height = 0.5 * PI / (rows.len() as f64 + 0.5);
        let mut patches = Self { centers: Vec::new(), solid_angles: Vec::new(), weights: Vec::new() };
        for (row, &count) in rows.iter().enumerate() {
            patches.add_row([row as f64 * height, (row + 1) as f64 * height], count);
        }
        patches.add_row([rows.len() as f64 * height, 0.5 * PI], 1);
        patches
    }

    /// Adds `count` patches between two elevations, radians.
    fn add_row(&mut self, [low, high]: [f64; 2], count: u32) {
        let (sin_low, sin_high) = (libm::sin(low), libm::sin(high));
        let width = TAU / f64::from(count);
        // The integral of the unit vector over a patch: upward, and outward at its middle.
        let upward = 0.5 * width * (sin_high * sin_high - sin_low * sin_low);
        let slice = 0.5 * (high - low) + 0.25 * (libm::sin(2.0 * high) - libm::sin(2.0 * low));
        let outward = if count == 1 { 0.0 } else { 2.0 * libm::sin(0.5 * width) * slice };
        let elevation = if count == 1 { 0.5 * PI } else { 0.5 * (low + high) };
        for number in 0..count {
            let (sin, cos) = libm::sincos(f64::from(number) * width);
            let flat = if count == 1 { 0.0 } else { libm::cos(elevation) };
            self.centers.push([flat * sin, libm::sin(elevation), -flat * cos]);
            self.solid_angles.push(width * (sin_high - sin_low));
            self.weights.push([outward * sin, upward, -outward * cos]);
        }
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.centers.len()
    }

    /// Whether there is no patch. Always false.
    pub fn is_empty(&self) -> bool {
        self.centers.is_empty()
    }

    /// Unit vectors towards the patches' middles, in world space.
    pub fn centers(&self) -> &[[f64; 3]] {
        &self.centers
    }

    /// Solid angles of the patches, steradians. They sum to 2π.
    pub fn solid_angles(&self) -> &[f64] {
        &self.solid_angles
    }

    /// Integrals of the unit vector over the patches. Their products with a normal are the patches' solid
    /// angles weighted by the cosine. They are exact for patches that are entirely on the normal's side. For
    /// an upward normal they sum to π.
    pub fn weights(&self) -> &[[f64; 3]] {
        &self.weights
    }
}

#[cfg(test)]
mod tests {
    use adumbra::grid::vec3::dot;

    use super::*;

    fn both() -> [Patches; 2] {
        [Patches::tregenza(), Patches::reinhart_577()]
    }

    #[test]
    fn patches_are_counted_as_published() {
        assert_eq!(both().map(|patches| patches.len()), [145, 577]);
        // Tregenza's rows are 12° apart, and the first patches look 6° up.
        let [tregenza, _] = both();
        let elevation = |patch: usize| tregenza.centers()[patch][1].asin().to_degrees();
        for (patch, degrees) in [(0, 6.0), (29, 6.0), (30, 18.0), (60, 30.0), (138, 78.0), (144, 90.0)] {
            assert!((elevation(patch) - degrees).abs() < 1e-5, "{patch}: {}", elevation(patch));
        }
    }

    #[test]
    fn patches_begin_in_the_north_and_go_clockwise() {
        for patches in both() {
            let [first, quarter] = [0, 30 * patches.len() / 577 + 15].map(|p| patches.centers()[p.min(15)]);
            assert!(first[2] < -0.99 && first[0].abs() < 1e-12, "{first:?}");
            assert!(quarter[0] > 0.0, "{quarter:?}");
        }
    }

    #[test]
    fn patches_cover_the_sky_once() {
        for patches in both() {
            let whole: f64 = patches.solid_angles().iter().sum();
            assert!((whole - TAU).abs() < 1e-12, "{whole}");
            let upward: f64 = patches.weights().iter().map(|w| w[1]).sum();
            assert!((upward - PI).abs() < 1e-12, "{upward}");
            // A wall sees half of a cosine-weighted sky, except for patches across its plane.
            let wall: f64 = patches.weights().iter().map(|&w| dot(w, [1.0, 0.0, 0.0]).max(0.0)).sum();
            assert!((wall / (0.5 * PI) - 1.0).abs() < 0.015, "{wall}");
        }
    }

    #[test]
    fn patches_have_weights_near_center_and_solid_angle() {
        for patches in both() {
            let all = patches.weights().iter().zip(patches.centers()).zip(patches.solid_angles());
            for ((weight, center), angle) in all {
                let expected = center.map(|c| c * angle);
                assert!((0..3).all(|a| (weight[a] - expected[a]).abs() < 0.02 * angle), "{weight:?}");
            }
        }
    }
}
