//! Splits quadtrees of depths into parts, so that a test can change data that a finished tree does not
//! expose.

use adumbra::layout::depths::page::{Page, bundles, page_dims, pages_of};
use adumbra::layout::depths::{DepthTree, DepthsError, TreeBuilder};

/// A quadtree in parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeParts {
    /// Number of voxels along x, y, z.
    pub size: [u32; 3],
    /// Words of the common section.
    pub common: Vec<u32>,
    /// The pages, x fastest.
    pub pages: Vec<PageParts>,
}

/// A page of a quadtree in parts, see [`Page`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PageParts {
    /// The root as it is stored.
    pub root: u32,
    /// Base of the root.
    pub base: u32,
    /// Words of the page.
    pub words: Vec<u32>,
}

impl PageParts {
    fn as_page(&self) -> Page<'_> {
        Page { root: self.root, base: self.base, words: &self.words }
    }
}

impl TreeParts {
    /// Splits a tree into its parts.
    pub fn of(tree: &DepthTree) -> Self {
        let [across, down] = tree.page_dims();
        let places = (0..down).flat_map(|y| (0..across).map(move |x| [x, y]));
        let pages = places.map(|place| {
            let Page { root, base, words } = tree.page(place);
            PageParts { root, base, words: words.to_vec() }
        });
        Self { size: tree.size(), common: tree.common().to_vec(), pages: pages.collect() }
    }

    /// Assembles the parts into a tree.
    ///
    /// # Errors
    /// Returns the fault if they are not a valid tree.
    pub fn tree(&self) -> Result<DepthTree, DepthsError> {
        let dims = page_dims(self.size);
        let mut builder = TreeBuilder::new(self.size, self.common.clone());
        for bundle in bundles(dims) {
            let page = |[x, y]: [u32; 2]| self.pages[(y * dims[0] + x) as usize].as_page();
            builder.add(bundle, &pages_of(bundle, dims).map(|at| at.map_or(Page::OUTSIDE, page)));
        }
        builder.finish()
    }

    /// Returns the words of the common section and of the pages, in the order of [`DepthTree::page`].
    pub fn words_mut(&mut self) -> impl Iterator<Item = &mut u32> {
        self.common.iter_mut().chain(self.pages.iter_mut().flat_map(|page| &mut page.words))
    }
}
