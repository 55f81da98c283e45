//! The texels of files. Those of a whole file are in memory; those of a streamed file are written where they
//! are needed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use adumbra::gpu::{HEADER_WORDS, LookUpTexture};
use bevy::math::UVec2;

/// A file's texels.
#[derive(Clone, Debug)]
pub(crate) enum Texels {
    /// The texels of a whole file.
    Whole(Arc<LookUpTexture>),
    /// The pool of a streamed file.
    Pool(PoolTexels),
}

impl Texels {
    /// Texels per row, a power of two.
    pub(crate) fn width(&self) -> u32 {
        match self {
            Self::Whole(texture) => texture.width(),
            Self::Pool(pool) => pool.width,
        }
    }

    /// Number of rows.
    pub(crate) fn height(&self) -> u32 {
        match self {
            Self::Whole(texture) => texture.height(),
            Self::Pool(pool) => pool.height,
        }
    }
}

/// Equal if both are the same texture or the same pool.
impl PartialEq for Texels {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Whole(a), Self::Whole(b)) => Arc::ptr_eq(a, b),
            (Self::Pool(a), Self::Pool(b)) => a == b,
            _ => false,
        }
    }
}

/// The size of a pool in rows of texels, with a look-up texture's header before the pool's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PoolTexels {
    /// Unique for each pool.
    pub(crate) id: u64,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl PoolTexels {
    /// Lays out a pool of `words` words in rows, as square as possible with a width that is a power of two
    /// and at most `max_side`. The number of rows may exceed `max_side`.
    pub(crate) fn new(words: u32, max_side: u32) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let id = COUNT.fetch_add(1, Ordering::Relaxed);
        let texels = HEADER_WORDS as u64 + u64::from(words);
        let mut width = HEADER_WORDS as u64;
        while width * width < texels && 2 * width <= max_side.into() {
            width *= 2;
        }
        // Both fit 32 bits: they are at most the number of texels, and a pool has at most 2^31 words.
        Self { id, width: width as u32, height: texels.div_ceil(width) as u32 }
    }
}

/// Splits `count` consecutive texels, from texel `first` on, into rectangles of a texture that is `width`
/// texels wide. Each rectangle has its first texel and its size.
///
/// Worked value: with a width of 128, the 300 texels from the 100th on are 28 in the first row, two whole
/// rows, and 16 in the fourth row.
pub(crate) fn rectangles(first: u32, count: u32, width: u32) -> impl Iterator<Item = (UVec2, UVec2)> {
    let (mut at, mut left) = (first, count);
    std::iter::from_fn(move || {
        let start = UVec2::new(at % width, at / width);
        let size = if left == 0 {
            return None;
        } else if start.x != 0 || left < width {
            UVec2::new(left.min(width - start.x), 1)
        } else {
            UVec2::new(width, left / width)
        };
        at += size.x * size.y;
        left -= size.x * size.y;
        Some((start, size))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pool_is_as_square_as_its_width_allows() {
        let pool = |bytes: u32, max_side| {
            let pool = PoolTexels::new(bytes / 4 - HEADER_WORDS as u32, max_side);
            [pool.width, pool.height]
        };
        assert_eq!(pool(32 << 20, 8192), [4096, 2048]);
        assert_eq!(pool(32 << 20, 2048), [2048, 4096]);
        assert_eq!(pool(100 << 10, 8192), [256, 100]);
    }

    #[test]
    fn splits_consecutive_texels_into_at_most_three_rectangles() {
        let all = |first, count| -> Vec<_> {
            let each = rectangles(first, count, 128);
            each.map(|(at, size)| [at.x, at.y, size.x, size.y]).collect()
        };
        assert_eq!(all(100, 300), [[100, 0, 28, 1], [0, 1, 128, 2], [0, 3, 16, 1]]);
        assert_eq!(all(256, 256), [[0, 2, 128, 2]]);
        assert_eq!(all(130, 4), [[2, 1, 4, 1]]);
        assert_eq!(all(5, 0), Vec::<[u32; 4]>::new());
    }
}
