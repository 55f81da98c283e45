//! Look-ups of many points.

use crate::error::{Error, RangeError, RangeField, Result};
use crate::query::{FixedReceiver, PointVisibility, Sampler, receiver};

impl Sampler {
    /// Writes the visibilities of successive points to `out`, with one normal per point or none at all. They
    /// equal those of [`Sampler::visibility`], but cost less if successive points are close to each other.
    ///
    /// # Errors
    /// Returns [`Error::Range`] unless `out`, and `normals` if there are any, are as long as `points_world`.
    pub fn visibilities(
        &self,
        points_world: &[[f64; 3]],
        normals: Option<&[[f64; 3]]>,
        out: &mut [f32],
    ) -> Result<()> {
        self.check_lengths(points_world, normals, out)?;
        self.fill(points_world, normals, out);
        Ok(())
    }

    /// Does what [`Sampler::visibilities`] does, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// Returns the errors of [`Sampler::visibilities`].
    #[cfg(feature = "rayon")]
    pub fn par_visibilities(
        &self,
        points_world: &[[f64; 3]],
        normals: Option<&[[f64; 3]]>,
        out: &mut [f32],
    ) -> Result<()> {
        use rayon::prelude::*;

        /// Points that are looked up one after the other.
        const BATCH: usize = 1 << 12;
        self.check_lengths(points_world, normals, out)?;
        out.par_chunks_mut(BATCH).enumerate().for_each(|(batch, out)| {
            let range = batch * BATCH..batch * BATCH + out.len();
            self.fill(&points_world[range.clone()], normals.map(|n| &n[range]), out);
        });
        Ok(())
    }

    fn check_lengths(
        &self,
        points_world: &[[f64; 3]],
        normals: Option<&[[f64; 3]]>,
        out: &[f32],
    ) -> Result<()> {
        let points = points_world.len();
        match [Some(out.len()), normals.map(<[_]>::len)].into_iter().flatten().find(|&n| n != points) {
            Some(other) => {
                let value = format!("{other} for {points} points");
                Err(Error::Range(RangeError::new(RangeField::PointCount, value, "one for each point")))
            }
            None => Ok(()),
        }
    }

    fn fill(&self, points_world: &[[f64; 3]], normals: Option<&[[f64; 3]]>, out: &mut [f32]) {
        let (bias, size) = (self.bias(), self.tree().size());
        let mut lit_taps = self.successive_lit_taps();
        for (i, (out, &p)) in out.iter_mut().zip(points_world).enumerate() {
            let r = receiver(self.grid(), &bias, p, normals.map(|n| n[i]));
            *out = self.share(lit_taps(&FixedReceiver::new(&r, size)));
        }
    }
}

impl PointVisibility for Sampler {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        Sampler::visibility(self, p_world, normal)
    }

    fn visibilities(&self, points_world: &[[f64; 3]], normals: Option<&[[f64; 3]]>) -> Vec<f32> {
        let mut out = vec![0.0; points_world.len()];
        self.fill(points_world, normals, &mut out);
        out
    }
}
