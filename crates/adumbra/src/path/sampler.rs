//! Visibility at a moment between two keys.

use std::sync::Arc;

use crate::file::ShadowFile;
use crate::grid::{LightGrid, Placement};
use crate::layout::depths::DepthTree;
use crate::query::{
    FIXED_BITS, Filter, FixedReceiver, GRADIENT_BITS, MarchSlope, Marched, PointVisibility, lit_taps, march,
    receiver,
};
use crate::settings::{Bias, FileSettings};

/// Looks up points for a sun between two suns that files were baked for.
///
/// A ray is marched through the nearer file's depths. If it has been in a shadow, which may hide something
/// from that file, the other file is used. If neither file can decide, the ray counts as lit, unless it is
/// hidden from both for at least the first file's
/// [`dark_after_voxels`](crate::FileSettings::dark_after_voxels). A filter is the mean of 3 × 3 such rays,
/// half the filter apart, on the receiver's plane.
///
/// Cost: a march takes the time of three to eight unfiltered look-ups. One in 30 to one in 10 points needs
/// two marches.
#[derive(Clone, Debug)]
pub struct PathSampler {
    keys: [Key; 2],
    bias: Bias,
    filter: Filter,
    dark_after_voxels: u32,
    quick: bool,
}

#[derive(Clone, Debug)]
struct Key {
    grid: LightGrid,
    tree: Arc<DepthTree>,
    slope: MarchSlope,
}

impl PathSampler {
    /// Returns look-ups for a sun, given as a unit vector, from two files, the one with the nearer sun first.
    /// Both may be the same file. `None` if the sun is behind the plane of a file's own sun, or so far from
    /// that sun that a ray moves sideways by more than 256 texels per voxel of depth.
    pub fn new(files: [&ShadowFile; 2], towards_sun: [f64; 3], filter: Filter) -> Option<Self> {
        let key = |file: &ShadowFile| {
            let slope = MarchSlope::new(&file.grid, towards_sun)?;
            Some(Key { grid: file.grid, tree: Arc::clone(&file.tree), slope })
        };
        let keys = [key(files[0])?, key(files[1])?];
        let FileSettings { bias, dark_after_voxels, .. } = files[0].settings;
        Some(Self { keys, bias, filter, dark_after_voxels, quick: false })
    }

    /// Returns look-ups that march only where both files' own answers differ. They read fewer words, and are
    /// wrong where a shadow passes over a point between the two suns. For the same error, the keys have to be
    /// about half as far apart.
    #[must_use]
    pub fn quick(self) -> Self {
        Self { quick: true, ..self }
    }

    /// Returns look-ups with another bias.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::Error::Range) if a term is out of its range.
    pub fn with_bias(self, bias: Bias) -> crate::Result<Self> {
        bias.check()?;
        Ok(Self { bias, ..self })
    }

    /// Returns look-ups in the world of an app that has placed the files. The sun is still the one given to
    /// [`PathSampler::new`], in the files' world; [`Placement::direction_to_file`] converts to it.
    #[must_use]
    pub fn placed(self, placement: &Placement) -> Self {
        Self { keys: self.keys.map(|key| Key { grid: key.grid.placed(placement), ..key }), ..self }
    }

    /// Returns the visibility of a world point, 1 = lit. `normal` is the surface's unit normal there, if the
    /// point is on a surface.
    pub fn look_up(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        if self.quick
            && let Some(lit) = self.agreed(p_world, normal)
        {
            return lit;
        }
        let starts = self.keys.each_ref().map(|key| key.starts(&self.bias, self.filter, p_world, normal));
        let count = starts[0].len();
        let lit = (0..count).filter(|&tap| self.is_lit([starts[0][tap], starts[1][tap]])).count();
        lit as f32 / count as f32
    }

    /// Returns the visibility if both files agree on it, and it is 0 or 1.
    fn agreed(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> Option<f32> {
        let width = self.filter.width();
        let lit = self.keys.each_ref().map(|key| {
            let r = receiver(&key.grid, &self.bias, p_world, normal);
            lit_taps(key.tree.words(), self.filter, &FixedReceiver::new(&r, key.grid.size))
        });
        let is_sure = lit[0] == 0 || lit[0] == width * width;
        (is_sure && lit[0] == lit[1]).then(|| if lit[0] == 0 { 0.0 } else { 1.0 })
    }

    /// Whether a ray meets nothing. `starts` has its start in each grid.
    fn is_lit(&self, starts: [[i64; 3]; 2]) -> bool {
        let marched = |key: usize| march(self.keys[key].tree.words(), self.keys[key].slope, starts[key]);
        marched(0).is_lit(|| marched(1), self.dark_after_voxels)
    }

    /// Returns for how many voxels from its start the ray of a world point is hidden from both files. `None`
    /// if a file can decide whether the ray meets something.
    pub fn hidden_voxels(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> Option<u32> {
        let hidden = self.keys.each_ref().map(|key| {
            let start = key.slope.start(&key.grid, &self.bias, p_world, normal);
            match march(key.tree.words(), key.slope, start) {
                Marched::Unknown { hidden_rise } => Some(hidden_rise >> FIXED_BITS),
                Marched::Blocked | Marched::Clear => None,
            }
        });
        Some(hidden[0]?.min(hidden[1]?))
    }
}

impl Key {
    /// Returns the starts of a filter's rays.
    fn starts(
        &self,
        bias: &Bias,
        filter: Filter,
        p_world: [f64; 3],
        normal: Option<[f64; 3]>,
    ) -> Vec<[i64; 3]> {
        let middle = self.slope.start(&self.grid, bias, p_world, normal);
        let apart = i64::from(filter.width() / 2);
        if apart == 0 {
            return vec![middle];
        }
        let r = receiver(&self.grid, bias, p_world, normal);
        let gradient = FixedReceiver::new(&r, self.grid.size).gradient.map(i64::from);
        let taps = (-1..=1).flat_map(|y| (-1..=1).map(move |x| [x * apart, y * apart]));
        taps.map(|texels| {
            let rise = (gradient[0] * texels[0] + gradient[1] * texels[1]) << (FIXED_BITS - GRADIENT_BITS);
            [middle[0] + (texels[0] << FIXED_BITS), middle[1] + (texels[1] << FIXED_BITS), middle[2] + rise]
        })
        .collect()
    }
}

impl PointVisibility for PathSampler {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.look_up(p_world, normal)
    }
}
