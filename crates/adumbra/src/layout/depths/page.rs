//! Pages and bundles: how a quadtree is cut into parts that can be copied anywhere, and in which order they
//! are stored.
//!
//! A page is a square of 2^[`PAGE_LEVEL`] columns a side, and the shapes below its root. A bundle is 4 × 4
//! pages. Bundles are stored along a Hilbert curve (Hilbert, *Über die stetige Abbildung einer Linie auf ein
//! Flächenstück*, 1891), so that a range of the file is a compact piece of the grid. Within a bundle pages
//! are in rows.

use crate::layout::depths::{NEVER, UNIFORM};

/// A page spans 2^9 columns along each side.
pub const PAGE_LEVEL: u32 = 9;
/// Number of pages along each side of a bundle.
pub const BUNDLE_SIDE: u32 = 4;
/// Number of pages of a bundle.
pub const BUNDLE_PAGES: usize = (BUNDLE_SIDE * BUNDLE_SIDE) as usize;
/// Number of words of a bundle before those of its pages: root, base and number of words of each.
pub const HEAD_WORDS: usize = 3 * BUNDLE_PAGES;
/// Number of bundles that a writer makes at a time on all threads, and holds until they are written.
pub const BUNDLES_AT_A_TIME: usize = 64;
/// Bit of a page's root: the address counts half-words from the page's beginning. Without this bit, the
/// address is in the common section.
pub const IN_PAGE: u32 = 1 << 31;

/// A page, wherever its words are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Page<'w> {
    /// [`UNIFORM`], an address in the common section, or with [`IN_PAGE`] one in the page.
    pub root: u32,
    /// The depth at which the root's base is.
    pub base: u32,
    /// Half-words of the page's shapes, two per word.
    pub words: &'w [u32],
}

impl Page<'_> {
    /// A page outside the grid.
    pub const OUTSIDE: Self = Self::uniform(NEVER);

    /// Converts an address in the form of [`Page::root`] to half-words from the beginning of the common
    /// section. The page's words begin `words_behind` words after that beginning.
    pub fn address(root: u32, words_behind: u32) -> u32 {
        match root {
            UNIFORM => UNIFORM,
            _ if root & IN_PAGE != 0 => 2 * words_behind + (root & !IN_PAGE),
            _ => root,
        }
    }

    /// Returns a page whose columns all switch at this depth.
    pub const fn uniform(base: u32) -> Self {
        Self { root: UNIFORM, base, words: &[] }
    }
}

/// Returns the number of pages along x and y that cover `size` voxels.
pub fn page_dims(size: [u32; 3]) -> [u32; 2] {
    [size[0], size[1]].map(|n| n.div_ceil(1 << PAGE_LEVEL))
}

/// Returns the number of bundles that cover this many pages.
pub fn bundle_count(page_dims: [u32; 2]) -> u64 {
    page_dims.iter().map(|n| u64::from(n.div_ceil(BUNDLE_SIDE))).product()
}

/// Returns the bundles that cover this many pages, in order, each by its place along x and y.
pub fn bundles(page_dims: [u32; 2]) -> Vec<[u32; 2]> {
    let dims = page_dims.map(|n| n.div_ceil(BUNDLE_SIDE));
    let side = i64::from(dims[0].max(dims[1]).next_power_of_two());
    let mut order = Vec::new();
    curve(dims.map(i64::from), [0, 0], [side, 0], [0, side], &mut order);
    order
}

/// Follows the curve through the square at `corner` with these edges. Squares outside the grid are left out.
fn curve(dims: [i64; 2], corner: [i64; 2], x: [i64; 2], y: [i64; 2], order: &mut Vec<[u32; 2]>) {
    let least = [0, 1].map(|a| corner[a] + x[a].min(0) + y[a].min(0));
    if least[0] >= dims[0] || least[1] >= dims[1] {
        return;
    }
    if (x[0] + x[1]).abs() == 1 {
        order.push(least.map(|c| c as u32));
        return;
    }
    let (x_half, y_half) = (x.map(|c| c / 2), y.map(|c| c / 2));
    let back = |v: [i64; 2]| v.map(|c| -c);
    let at = |parts: &[[i64; 2]]| [0, 1].map(|a| corner[a] + parts.iter().map(|part| part[a]).sum::<i64>());
    curve(dims, corner, y_half, x_half, order);
    curve(dims, at(&[x_half]), x_half, y_half, order);
    curve(dims, at(&[x_half, y_half]), x_half, y_half, order);
    curve(dims, at(&[x_half, y]), back(y_half), back(x_half), order);
}

/// Returns the pages of a bundle in order, by their places along x and y. `None` is outside the grid.
pub fn pages_of(bundle: [u32; 2], page_dims: [u32; 2]) -> [Option<[u32; 2]>; BUNDLE_PAGES] {
    std::array::from_fn(|slot| {
        let within = [slot as u32 % BUNDLE_SIDE, slot as u32 / BUNDLE_SIDE];
        let place = [0, 1].map(|a| bundle[a] * BUNDLE_SIDE + within[a]);
        (place[0] < page_dims[0] && place[1] < page_dims[1]).then_some(place)
    })
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn curve_visits_each_bundle_once_and_in_adjacent_steps() {
        assert_eq!(bundles([8, 8]), [[0, 0], [1, 0], [1, 1], [0, 1]]);
        for pages in [[1, 1], [4, 4], [5, 3], [64, 64], [61, 17], [1, 400]] {
            let order = bundles(pages);
            assert_eq!(order.len() as u64, bundle_count(pages));
            assert_eq!(order.iter().collect::<HashSet<_>>().len(), order.len());
            let steps = order.windows(2).map(|w| w[0][0].abs_diff(w[1][0]) + w[0][1].abs_diff(w[1][1]));
            let far = steps.filter(|&step| step != 1).count();
            // A full square has no gaps; elsewhere the curve leaves the grid and comes back.
            assert!(far == 0 || pages[0] != pages[1], "{pages:?}: {far} jumps");
        }
    }

    #[test]
    fn curve_of_narrow_grid_skips_the_rest_of_its_square() {
        assert_eq!(bundles([1 << 23, 1]).len(), 1 << 21);
    }

    #[test]
    fn pages_of_a_bundle_are_in_rows() {
        let pages = pages_of([1, 0], [6, 2]);
        let inside: Vec<_> = pages.iter().enumerate().filter_map(|(i, p)| p.map(|p| (i, p))).collect();
        assert_eq!(inside, [(0, [4, 0]), (1, [5, 0]), (4, [4, 1]), (5, [5, 1])]);
    }
}
