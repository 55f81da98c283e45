//! Changes between lit and dark, pixel by pixel, while the camera is fixed and the sun moves.

use crate::error::{Error, Result};
use crate::metrics::is_lit;

/// Counts how often each pixel changes between lit and dark.
///
/// Memory: 12 bytes per pixel, for any number of steps.
#[derive(Clone, Debug)]
pub struct Changes {
    pixels: Vec<Pixel>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    /// Whether the pixel was lit in the previous step; `None` if it was not compared in that step.
    before: Option<bool>,
    /// Number of pairs of consecutive steps in which the pixel was compared both times.
    pairs: u32,
    changes: u32,
}

/// Changes from one step to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepChanges {
    /// Number of pixels that are compared in both steps.
    pub pixels: u64,
    /// Number of these that changed.
    pub changes: u64,
}

impl StepChanges {
    /// Returns the share of the pixels that changed, or `None` without pixels.
    pub fn share(&self) -> Option<f64> {
        (self.pixels > 0).then(|| self.changes as f64 / self.pixels as f64)
    }
}

/// How much more often pixels change than in the rays' own sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excess {
    /// Changes in excess per pixel and step, summed over the pixels that change more often than with rays.
    pub per_step: f64,
    /// The part of these at pixels that never change with rays.
    pub steady_per_step: f64,
    /// Share of pixels that change more often than with rays.
    pub pixels: f64,
    /// The most changes in excess at a pixel.
    pub most: u32,
}

impl Changes {
    /// Creates counts of 0.
    pub fn new(pixels: usize) -> Self {
        Self { pixels: vec![Pixel::default(); pixels] }
    }

    /// Adds a step: the shadow factor of each pixel, and whether the pixel is compared.
    ///
    /// # Errors
    /// Returns [`Error::Sizes`] if the numbers of pixels differ.
    pub fn add(&mut self, factors: &[f32], is_compared: &[bool]) -> Result<StepChanges> {
        Error::check_sizes("shadow factors and pixels", factors.len(), self.pixels.len())?;
        Error::check_sizes("shadow factors and compared pixels", factors.len(), is_compared.len())?;
        let mut step = StepChanges::default();
        for ((pixel, &factor), &is_compared) in self.pixels.iter_mut().zip(factors).zip(is_compared) {
            let now = is_compared.then(|| is_lit(factor));
            if let (Some(before), Some(now)) = (pixel.before, now) {
                let changed = before != now;
                pixel.pairs += 1;
                pixel.changes += u32::from(changed);
                step.pixels += 1;
                step.changes += u64::from(changed);
            }
            pixel.before = now;
        }
        Ok(step)
    }

    /// Marks a gap: the next step is not compared with the last one.
    pub fn interrupt(&mut self) {
        self.pixels.iter_mut().for_each(|pixel| pixel.before = None);
    }

    /// Returns the sum over all steps.
    pub fn total(&self) -> StepChanges {
        self.pixels.iter().fold(StepChanges::default(), |sum, pixel| StepChanges {
            pixels: sum.pixels + u64::from(pixel.pairs),
            changes: sum.changes + u64::from(pixel.changes),
        })
    }

    /// Returns the number of pixels that were compared in two consecutive steps.
    pub fn compared(&self) -> u64 {
        self.pixels.iter().filter(|pixel| pixel.pairs > 0).count() as u64
    }

    /// Returns for each pixel how much more often it changes than in `rays`, or `None` if it was not
    /// compared.
    ///
    /// # Errors
    /// Returns [`Error::Sizes`] if the numbers of pixels differ.
    pub fn beyond(&self, rays: &Self) -> Result<Vec<Option<i64>>> {
        Error::check_sizes("pixels and those of rays", self.pixels.len(), rays.pixels.len())?;
        let beyond = |(own, rays): (&Pixel, &Pixel)| {
            (own.pairs > 0).then(|| i64::from(own.changes) - i64::from(rays.changes))
        };
        Ok(self.pixels.iter().zip(&rays.pixels).map(beyond).collect())
    }

    /// Returns how much more often pixels change than in `rays`, or `None` if no pixel was compared.
    ///
    /// # Errors
    /// Returns [`Error::Sizes`] if the numbers of pixels differ.
    pub fn excess(&self, rays: &Self) -> Result<Option<Excess>> {
        let beyond = self.beyond(rays)?;
        let more = || {
            beyond
                .iter()
                .copied()
                .zip(&rays.pixels)
                .filter_map(|(b, rays)| Some((b.filter(|b| *b > 0)?, rays)))
        };
        let (pixels, pairs) = (self.compared(), self.total().pixels);
        let per_step = |changes: i64| changes as f64 / pairs as f64;
        Ok((pixels > 0).then(|| Excess {
            per_step: per_step(more().map(|(beyond, _)| beyond).sum()),
            steady_per_step: per_step(
                more().filter(|(_, rays)| rays.changes == 0).map(|(beyond, _)| beyond).sum(),
            ),
            pixels: more().count() as f64 / pixels as f64,
            most: more().map(|(beyond, _)| beyond).max().map_or(0, |most| most as u32),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds steps with the factors of four pixels, of which the last one is never compared.
    fn added(steps: &[[f32; 4]]) -> Changes {
        let mut changes = Changes::new(4);
        for step in steps {
            changes.add(step, &[true, true, true, false]).unwrap();
        }
        changes
    }

    #[test]
    fn excess_counts_flicker_and_ignores_missed_changes() {
        let rays = [[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 1.0, 1.0], [1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]];
        let rays = added(&rays);
        assert_eq!(rays.total(), StepChanges { pixels: 9, changes: 2 });
        // The first pixel misses its only change, the second flickers, the third changes as it should and
        // twice more.
        let own = [[0.4, 0.3, 0.9, 0.0], [0.5, 0.6, 0.1, 0.0], [0.0, 0.2, 0.8, 0.0], [0.0, 0.2, 0.1, 1.0]];
        let own = added(&own);
        assert_eq!((own.total().changes, own.compared()), (5, 3));
        assert_eq!(own.beyond(&rays).unwrap(), [Some(-1), Some(2), Some(2), None]);
        let excess = own.excess(&rays).unwrap();
        let expected = Excess { per_step: 4.0 / 9.0, steady_per_step: 2.0 / 9.0, pixels: 2.0 / 3.0, most: 2 };
        assert_eq!(excess, Some(expected));
        assert_eq!(rays.excess(&rays).unwrap(), Some(Excess::default()));
    }

    #[test]
    fn each_step_is_compared_with_the_last_unless_interrupted() {
        let mut changes = Changes::new(2);
        assert_eq!(changes.add(&[0.0, 0.0], &[true, true]).unwrap().share(), None);
        assert_eq!(changes.excess(&changes.clone()).unwrap(), None);
        changes.interrupt();
        assert_eq!(changes.add(&[1.0, 1.0], &[true, false]).unwrap(), StepChanges::default());
        assert_eq!(changes.add(&[0.0, 0.0], &[true, true]).unwrap(), StepChanges { pixels: 1, changes: 1 });
        assert!(changes.add(&[0.0], &[true, true]).is_err());
        assert!(changes.add(&[0.0, 1.0], &[true]).is_err());
    }
}
