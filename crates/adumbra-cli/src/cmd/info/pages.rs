//! A picture of the bytes of each page of a level, as look-ups read them.

use adumbra::layout::depths::DepthTree;
use adumbra_truth::picture::Picture;

use crate::cmd::scale::{SCALE, color};

/// Pixels that the longer side of a picture has at most, unless it has more pages.
const LONGEST_SIDE: u32 = 1024;
/// Most pixels along each side of a page.
const LARGEST_PAGE: u32 = 64;
/// The colour of pages without bytes of their own.
const UNIFORM: [u8; 3] = [40, 40, 40];
/// The bytes of each page of a level, x fastest.
pub(super) struct PageBytes {
    dims: [u32; 2],
    bytes: Vec<u64>,
}

impl PageBytes {
    pub(super) fn of(tree: &DepthTree) -> Self {
        let dims = tree.page_dims();
        let places = (0..dims[1]).flat_map(|y| (0..dims[0]).map(move |x| [x, y]));
        Self { dims, bytes: places.map(|place| 4 * tree.page(place).words.len() as u64).collect() }
    }

    /// Returns the fewest, the median and the most bytes of the pages that have any.
    pub(super) fn spread(&self) -> Option<[u64; 3]> {
        let mut some: Vec<u64> = self.bytes.iter().copied().filter(|&bytes| bytes > 0).collect();
        some.sort_unstable();
        Some([*some.first()?, some[some.len() / 2], *some.last()?])
    }

    /// Draws a square per page, x to the right and y downwards. The scale is logarithmic, from the fewest
    /// bytes to the most.
    pub(super) fn picture(&self) -> Picture {
        let side = (LONGEST_SIDE / self.dims[0].max(self.dims[1])).clamp(1, LARGEST_PAGE);
        let [width, height] = self.dims.map(|pages| pages * side);
        let [fewest, _, most] = self.spread().unwrap_or_default();
        let range = (most as f64 / fewest as f64).ln();
        let color = |bytes: u64| match bytes {
            0 => UNIFORM,
            _ if most == fewest => SCALE[0],
            _ => color((bytes as f64 / fewest as f64).ln() / range),
        };
        let colors: Vec<[u8; 3]> = self.bytes.iter().map(|&bytes| color(bytes)).collect();
        let rows = colors.chunks(self.dims[0] as usize).flat_map(|row| (0..side).map(move |_| row));
        let rgb = rows.flat_map(|row| row.iter().flat_map(|color| color.repeat(side as usize))).collect();
        Picture { width, height, rgb, difference_share: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_has_a_coloured_square_for_each_page() {
        let pages = PageBytes { dims: [3, 1], bytes: vec![0, 40, 4000] };
        assert_eq!(pages.spread(), Some([40, 4000, 4000]));
        let picture = pages.picture();
        assert_eq!([picture.width, picture.height], [3 * 64, 64]);
        assert_eq!(picture.rgb.len(), 3 * 3 * 64 * 64);
        let pixel = |x: usize, y: usize| &picture.rgb[3 * (y * 192 + x)..][..3];
        for y in [0, 63] {
            assert_eq!([pixel(0, y), pixel(63, y)], [UNIFORM; 2]);
            assert_eq!([pixel(64, y), pixel(127, y)], [SCALE[0]; 2]);
            assert_eq!([pixel(128, y), pixel(191, y)], [SCALE[4]; 2]);
        }
    }

    #[test]
    fn level_without_bytes_is_drawn() {
        let pages = PageBytes { dims: [1, 2], bytes: vec![0, 0] };
        assert_eq!(pages.spread(), None);
        assert!(pages.picture().rgb.chunks(3).all(|pixel| pixel == UNIFORM));
    }

    #[test]
    fn large_grids_have_a_pixel_per_page() {
        let pages = PageBytes { dims: [2000, 1], bytes: vec![4; 2000] };
        assert_eq!([pages.picture().width, pages.picture().height], [2000, 1]);
    }
}
