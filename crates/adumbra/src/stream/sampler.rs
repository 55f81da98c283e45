//! Look-ups on the CPU in the words of a pool.

use std::sync::Arc;

use crate::grid::{LightGrid, Placement};
use crate::query::{Filter, FixedReceiver, PointVisibility, Receiver, lit_taps, receiver};
use crate::settings::Bias;
use crate::stream::pool::{LevelPlaces, PoolLayout, WHOLE};

/// An answer, and the finest level that it is from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelAnswer {
    /// Visibility, 1 = lit.
    pub visibility: f32,
    /// The level of the file that answered, 0 = the finest.
    pub level: u32,
}

/// Looks up the visibility of points in the words of a pool, in the finest level that has the pages. While
/// pages fade, their answer is mixed with that of the next coarser level. A shader gives the same answers
/// from the same words.
#[derive(Clone, Debug)]
pub struct PoolSampler {
    layout: Arc<PoolLayout>,
    bias: Bias,
    filter: Filter,
    /// The grids of the levels, with the app's placement of the file.
    grids: Arc<[LightGrid]>,
}

impl PoolSampler {
    pub(super) fn new(layout: Arc<PoolLayout>, bias: Bias, filter: Filter) -> Self {
        let grids = layout.levels.iter().map(|places| places.grid).collect();
        Self { layout, bias, filter, grids }
    }

    /// Returns look-ups with another bias.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::Error::Range) if a term is out of its range.
    pub fn with_bias(self, bias: Bias) -> crate::Result<Self> {
        bias.check()?;
        Ok(Self { bias, ..self })
    }

    /// Returns look-ups in the world of an app that has placed the file, as
    /// [`Sampler::placed`](crate::Sampler::placed).
    #[must_use]
    pub fn placed(self, placement: &Placement) -> Self {
        Self { grids: self.grids.iter().map(|grid| grid.placed(placement)).collect(), ..self }
    }

    /// Returns the visibility of a world point. `normal` is the surface's unit normal there, if the point is
    /// on a surface. `words` are those of the pool, after all writes that
    /// [`Resident::take_writes`](super::Resident::take_writes) has returned.
    pub fn look_up(&self, words: &[u32], p_world: [f64; 3], normal: Option<[f64; 3]>) -> LevelAnswer {
        let width = self.filter.width();
        let (mut visibility, mut left, mut level) = (0.0, 1.0, None);
        for (places, grid) in self.layout.levels.iter().zip(&*self.grids) {
            let r = receiver(grid, &self.bias, p_world, normal);
            let Some((lit, weight)) = self.lit_taps(words, places, &r) else { continue };
            let share = left * (weight as f32 / WHOLE as f32);
            visibility += share * (lit as f32 / (width * width) as f32);
            left -= share;
            if weight > 0 {
                level.get_or_insert(places.level);
            }
            if left == 0.0 {
                break;
            }
        }
        // The coarsest level has all of its pages.
        LevelAnswer { visibility, level: level.unwrap_or(0) }
    }

    /// Returns the look-ups with a pool's words.
    pub fn with_words<'w>(&'w self, words: &'w [u32]) -> impl PointVisibility + 'w {
        WithWords { sampler: self, words }
    }

    /// Returns the number of lit taps in a level and the weight of that answer, or `None` if it lacks a page.
    fn lit_taps(&self, words: &[u32], places: &LevelPlaces, receiver: &Receiver) -> Option<(u32, u32)> {
        let tree = places.tree(words);
        let r = FixedReceiver::new(receiver, tree.size);
        let reach = i64::from(self.filter.width() / 2);
        let last = [0, 1].map(|a| i64::from(tree.size[a]) - 1);
        let texel = r.texel();
        let low = [0, 1].map(|a| (texel[a] - reach).max(0));
        let high = [0, 1].map(|a| (texel[a] + reach).min(last[a]));
        let is_over_grid = low[0] <= high[0] && low[1] <= high[1];
        let [low, high] = [low, high].map(|column| column.map(|c| c as u32));
        if is_over_grid && !tree.are_resident(low, high) {
            return None;
        }
        let weight = if is_over_grid { places.weight(words, low, high) } else { WHOLE };
        Some((lit_taps(tree, self.filter, &r), weight))
    }
}

struct WithWords<'w> {
    sampler: &'w PoolSampler,
    words: &'w [u32],
}

impl PointVisibility for WithWords<'_> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.sampler.look_up(self.words, p_world, normal).visibility
    }
}
