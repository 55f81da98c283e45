//! Depths: a quadtree of the depths at which columns switch from lit to shadowed, in place of voxels.
//!
//! Source: Scandolo, Bauszat, Eisemann, *Compressed Multiresolution Hierarchies for High-Quality Precomputed
//! Shadows* and *Merged Multiresolution Hierarchies for Shadow Map Compression*, both 2016. As there, values
//! are chosen inside each column's interval and inherited from node to node, and they are relative to the
//! parent's, so that equal shapes at different depths are stored once. This layout departs from the source in
//! several points. A node has 4 × 4 children. A leaf has 8 × 8 columns and stores its contour once,
//! separately from its depths. Columns that are lit to their end are marked as such and need no value. Equal
//! shapes are found by hash after the depths have been chosen, not by a search.
//!
//! # Words
//! `code` is a sequence of half-words of 16 bits, two per word, the lower first. A *shape* begins at a
//! half-word, its address. It has no depth of its own, but receives a *base* depth. The shapes that it points
//! to come before it.
//!
//! The code has parts: first the *common section*, then *pages*. A page has the shapes below one root, 512 ×
//! 512 columns. Its shapes point to each other by distance, and to shapes of the common section by address,
//! so a page does not depend on where its words are. Shapes that several pages need are in the common
//! section.
//!
//! A node of level n has 4 × 4 children of level n − 2, with index `y·4 + x`. The root of a page has level 9,
//! leaves have level 3. A node's first three half-words have one bit per child. The fields that these bits
//! call for follow in the children's order.
//!
//! | half-word 1 (high) | 0 (low) | 2 (kind) | fields | child |
//! |---|---|---|---|---|
//! | 0 | 0 | 0 | | switches at the base |
//! | 0 | 0 | 1 | | never switches |
//! | 0 | 1 | 0 | near | a shape, same base |
//! | 0 | 1 | 1 | delta | switches at base + delta |
//! | 1 | 0 | 0 | short | a shape, base + its delta |
//! | 1 | 0 | 1 | delta, near | a shape, base + delta |
//! | 1 | 1 | 0 | far | a shape, base + its delta; without a distance, a switch there |
//! | 1 | 1 | 1 | | not used |
//!
//! | field | half-words | meaning |
//! |---|---|---|
//! | near | 1 | an address in the common section below 2^15; or bit 15 = 1 and bits 14..0 = number of half-words from the node's address back to the shape |
//! | delta | 1 | two's complement |
//! | short | 1 | bits 7..0: half-words back; bits 15..8: delta, two's complement |
//! | far | 3 | half-word 0: bits 15..0 of delta; of the word of half-words 1 and 2, lower first: bits 24..0 an address in the common section, or if bit 31 = 1 half-words back; bits 30..25 = bits 21..16 of delta, two's complement |
//!
//! Worked value: `0x0001`, `0x0000`, `0x8200` is far, with a delta of 1 + 2^16 (bit 25 is its bit 16) and bit
//! 31 without a distance, so the child switches at base + 65,537.
//!
//! # Leaves
//! A leaf has n = 1 to 64 different depths v0 < v1 < …, of which the last may be [`NEVER`]; v0 is the base. A
//! *slanted* leaf has parallel planes instead of depths. Their gradient is gx and gy quarters of a voxel per
//! column, and the stored depths are those at the deepest corner of each plane. Column (x, y) then switches
//! nearer to the sun by `(|gx|·dx + |gy|·dy + 3) >> 2`, where dx = 7 − x for gx > 0, else x, and dy is 7 − y
//! for gy > 0, else y. Depths of a leaf saturate at 0 and at [`NEVER`].
//!
//! | half-words | meaning |
//! |---|---|
//! | 1 | bits 5..0: n − 1; 6: the last never switches; 8..7: w, differences take 8 << w bits; 9: slanted; rest 0 |
//! | 1 if slanted | gx in bits 7..0, gy in bits 15..8, two's complement |
//! | by w | v1 − v0, v2 − v1, … except the one to a last depth that never switches; padded with zeros |
//! | 4 per plane | bit p of each column's rank among the depths, p from 0; column `y·8 + x` is that bit of the 64 |
//!
//! The four half-words of a plane are stored lowest first.
//!
//! Worked value: if the columns of row 0 switch at 7 and all others never switch, the leaf is
//! `0x0041`, `0xff00`, `0xffff`, `0xffff`, `0xffff`, with base 7.

mod census;
pub mod child;
pub mod code;
mod common;
pub mod leaf;
pub mod page;
mod ranges;
pub mod shapes;
pub mod slant;
pub mod top;
mod tree_words;
mod validate;
pub mod write;

pub use census::Census;
pub use child::ShapePlace;
pub use ranges::{Range, Ranges, SharedRanges};
pub use tree_words::{ABSENT, TreeWords};
pub use validate::{DepthsError, PageValidator, Part};

use code::{Code, ColumnNode};
use page::{BUNDLE_PAGES, PAGE_LEVEL, Page};
use top::{block_dims, block_level, page_blocks};

/// Depth of a column that never switches, that is, one that is lit to its end.
pub const NEVER: u32 = u32::MAX;
/// Stored in place of an address if every column switches at the base.
pub const UNIFORM: u32 = u32::MAX;
/// Level of a leaf: it has 2^3 columns along each side.
pub const LEAF_LEVEL: u32 = 3;
/// Number of levels from a node to its children.
pub const NODE_LEVELS: u32 = 2;

/// A complete quadtree of switch depths. Every look-up in it ends with a valid result.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DepthTree {
    size: [u32; 3],
    page_dims: [u32; 2],
    /// Number of words of the common section, with which the code begins.
    common_words: usize,
    /// The pages, x fastest.
    places: Vec<PlacedPage>,
    code: Vec<u32>,
    /// Level of the blocks at which look-ups begin.
    block_level: u32,
    /// Number of these blocks along x and y.
    block_dims: [u32; 2],
    /// Address in the code of each block's node, or [`UNIFORM`], and its base; x fastest.
    blocks: Vec<[u32; 2]>,
}

/// A page of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PlacedPage {
    /// The root and its base, as in [`Page`].
    root: u32,
    base: u32,
    /// Index of the page's first word in the code.
    first_word: usize,
    words: usize,
}

/// Memory that a tree holds per page in addition to its words, in bytes.
pub const PLACED_PAGE_BYTES: u64 = size_of::<PlacedPage>() as u64;

/// A tree whose pages are added bundle by bundle.
#[derive(Debug)]
pub struct TreeBuilder {
    tree: DepthTree,
}

impl TreeBuilder {
    /// Begins a tree of `size` voxels along x, y, z with the words of its common section. Pages are outside
    /// the grid until they are added.
    pub fn new(size: [u32; 3], common: Vec<u32>) -> Self {
        let page_dims = page::page_dims(size);
        let pages = page_dims.iter().map(|&n| n as usize).product();
        let block_level = block_level(size);
        let outside = PlacedPage { root: UNIFORM, base: NEVER, first_word: common.len(), words: 0 };
        let tree = DepthTree {
            size,
            page_dims,
            common_words: common.len(),
            places: vec![outside; pages],
            code: common,
            block_level,
            block_dims: block_dims(size, block_level),
            blocks: Vec::new(),
        };
        Self { tree }
    }

    /// Makes room for the words of pages that will be added.
    pub fn reserve(&mut self, words: usize) {
        self.tree.code.reserve_exact(words);
    }

    /// Adds the pages of the bundle at this place. Those outside the grid are ignored.
    pub fn add(&mut self, bundle: [u32; 2], pages: &[Page<'_>; BUNDLE_PAGES]) {
        let dims = self.tree.page_dims;
        for (place, page) in page::pages_of(bundle, dims).into_iter().zip(pages) {
            let Some([x, y]) = place else { continue };
            let Page { root, base, words } = *page;
            let first_word = self.tree.code.len();
            self.tree.code.extend_from_slice(words);
            self.tree.places[(y * dims[0] + x) as usize] =
                PlacedPage { root, base, first_word, words: words.len() };
        }
    }

    /// Returns the tree, after checking that every look-up in it ends with a valid result.
    ///
    /// Cost: one pass over all shapes, and a byte of memory per half-word of the common section and of one
    /// page.
    ///
    /// # Errors
    /// Returns the first fault of a traversal from the roots down.
    pub fn finish(self) -> Result<DepthTree, DepthsError> {
        let mut tree = self.tree;
        tree.code.shrink_to_fit();
        validate::validate(&tree)?;
        tree.blocks = tree.find_blocks();
        Ok(tree)
    }
}

impl DepthTree {
    /// Returns the number of voxels along x, y, z.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// Returns the number of pages along x and y.
    pub fn page_dims(&self) -> [u32; 2] {
        self.page_dims
    }

    /// Returns the words of the common section, with which the code begins.
    pub fn common(&self) -> &[u32] {
        &self.code[..self.common_words]
    }

    /// Returns the page at this place along x and y, as it is in a file.
    pub fn page(&self, [x, y]: [u32; 2]) -> Page<'_> {
        let PlacedPage { root, base, first_word, words } = self.places[(y * self.page_dims[0] + x) as usize];
        Page { root, base, words: &self.code[first_word..][..words] }
    }

    /// Returns the pages of a bundle, as they are in a file.
    pub fn bundle(&self, bundle: [u32; 2]) -> [Page<'_>; BUNDLE_PAGES] {
        page::pages_of(bundle, self.page_dims)
            .map(|place| place.map_or(Page::OUTSIDE, |place| self.page(place)))
    }

    /// Returns the level of the blocks at which look-ups begin: they span 2^level columns along each side. It
    /// is 5, 7 or 9, the lowest for which the table of these blocks is small.
    pub fn root_level(&self) -> u32 {
        self.block_level
    }

    /// Returns the number of blocks at which look-ups begin along x and y: `ceil(size / 2^root_level)`.
    pub fn top_dims(&self) -> [u32; 2] {
        self.block_dims
    }

    /// Returns address in the code and base of each block at which look-ups begin, x fastest.
    pub fn top(&self) -> &[[u32; 2]] {
        &self.blocks
    }

    /// Returns the half-words of all shapes, two per word: the common section, then the pages.
    pub fn code(&self) -> &[u32] {
        &self.code
    }

    /// Returns the address in the code, or [`UNIFORM`], and the base of the root of a page.
    fn root(&self, [x, y]: [u32; 2]) -> [u32; 2] {
        let page = self.places[(y * self.page_dims[0] + x) as usize];
        [Page::address(page.root, page.first_word as u32), page.base]
    }

    /// Finds the blocks at which look-ups begin.
    fn find_blocks(&self) -> Vec<[u32; 2]> {
        let [across, down] = self.top_dims();
        let mut blocks = vec![[UNIFORM, NEVER]; across as usize * down as usize];
        let side = 1 << (PAGE_LEVEL - self.block_level);
        for (page, placed) in (0..).zip(&self.places) {
            let [x, y] = [page % self.page_dims[0], page / self.page_dims[0]];
            let found = page_blocks(&self.page([x, y]), self.common(), self.block_level);
            for (row, found) in (y * side..down).zip(found.chunks_exact(side as usize)) {
                let row = &mut blocks[(row * across + x * side) as usize..((row + 1) * across) as usize];
                for (block, &[root, base]) in row.iter_mut().zip(found) {
                    *block = [Page::address(root, placed.first_word as u32), base];
                }
            }
        }
        blocks
    }

    /// Returns the words that look-ups read.
    #[inline]
    pub fn words(&self) -> TreeWords<'_> {
        TreeWords {
            size: self.size,
            block_level: self.block_level,
            block_dims: self.block_dims,
            blocks: &self.blocks,
            code: &self.code,
        }
    }

    /// Returns the depth at which column (i, j) switches: voxel k is lit if k is less than it. [`NEVER`] if
    /// all voxels of the column are lit, and outside the grid.
    ///
    /// Cost: one step per two levels above 3, then one leaf.
    pub fn value(&self, i: u32, j: u32) -> u32 {
        self.words().value(i, j)
    }

    /// Returns the size in bytes of all words that look-ups read.
    pub fn bytes(&self) -> u64 {
        8 * self.blocks.len() as u64 + 4 * self.code.len() as u64
    }

    /// Returns a reader of the individual shapes.
    #[inline]
    pub fn shapes(&self) -> Code<'_> {
        self.words().shapes()
    }

    /// Returns the block or leaf that contains a column, and its level.
    #[inline]
    pub fn place(&self, i: u32, j: u32) -> (ColumnNode, u32) {
        self.words().place(i, j)
    }

    /// Returns whether voxel (i, j, k) is lit. The voxel must be in the grid.
    pub fn voxel(&self, i: u32, j: u32, k: u32) -> bool {
        k < self.value(i, j)
    }
}
