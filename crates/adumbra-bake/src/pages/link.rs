//! Links pages: chooses their common section, and writes each page again with pointers into it.

use adumbra::file::CODING_RATIO;
use adumbra::layout::depths::child::ShapeRef;
use adumbra::layout::depths::page::{BUNDLE_PAGES, BUNDLES_AT_A_TIME, Page, bundles, page_dims, pages_of};
use adumbra::layout::depths::write::OutOfReach;
use adumbra::layout::depths::{DepthTree, NEVER, ShapePlace, TreeBuilder, UNIFORM};
use rayon::prelude::*;

use super::common::Common;
use super::shapes::{Reader, write};
use super::store::PageStore;
use crate::error::{Error, Result};

/// About one byte in this many is common: one in 20 of a town of instanced houses, one in 54 of a city of
/// boxes.
const BYTES_PER_COMMON: u64 = 32;

/// All pages of a grid, each on its own.
pub struct Pages {
    pub(crate) size: [u32; 3],
    /// Number in the store, or [`UNIFORM`], and base of each page, x fastest.
    pub(crate) places: Vec<[u32; 2]>,
    pub(crate) store: PageStore,
    /// Whether equal shapes are stored once, in a page and in all.
    pub(crate) merged: bool,
    /// Whether a page is missing, because it was beyond the reach of pointers.
    pub(crate) is_too_large: bool,
}

impl Pages {
    /// Finds the common section.
    ///
    /// # Errors
    /// Returns [`Error::Spill`] if pages could not be kept on disk, and [`Error::TooManyWords`] if a part is
    /// too large.
    #[inline(never)] // Counted by `cargo xtask count`.
    pub(crate) fn link(self) -> Result<Linked> {
        if self.is_too_large {
            return Err(OutOfReach.into());
        }
        let numbers: Vec<u32> =
            self.places.iter().map(|place| place[0]).filter(|&number| number != UNIFORM).collect();
        let common = if self.merged { Common::of(&self.store, &numbers)? } else { Common::default() };
        self.store.spill().check()?;
        Ok(Linked { pages: self, common })
    }

    /// Returns the bytes that linking needs besides the pages: first to find the common section, then to code
    /// it and a bundle on each thread, and for the bundles that are written at a time.
    pub(crate) fn link_bytes(store: &PageStore, fullest_bundle_bytes: u64) -> u64 {
        let bytes = 2 * store.halves();
        let fullest = bytes.min(rayon::current_num_threads() as u64 * fullest_bundle_bytes);
        let coding = CODING_RATIO * (bytes / BYTES_PER_COMMON + fullest);
        super::common::finding_bytes(store).max(coding) + bytes / 8
    }

    /// Links the pages to a tree in memory.
    ///
    /// # Errors
    /// Returns [`Error::Spill`] if pages could not be kept on disk, and [`Error::TooManyWords`] if a part is
    /// too large.
    pub fn tree(self) -> Result<DepthTree> {
        self.link()?.tree()
    }
}

/// Pages and their common section.
pub(crate) struct Linked {
    pages: Pages,
    common: Common,
}

/// A [`Page`] and its words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct OwnedPage {
    pub(crate) root: u32,
    pub(crate) base: u32,
    pub(crate) words: Vec<u32>,
}

impl OwnedPage {
    fn as_page(&self) -> Page<'_> {
        Page { root: self.root, base: self.base, words: &self.words }
    }
}

/// The scratch memory of a worker.
#[derive(Default)]
struct Scratch {
    reader: Reader,
    places: Vec<ShapeRef>,
}

impl Linked {
    /// Takes the words of the common section, and its shapes by address. Linking needs neither.
    pub(crate) fn take_common(&mut self) -> (Vec<u32>, Vec<ShapePlace>) {
        (std::mem::take(&mut self.common.words), std::mem::take(&mut self.common.shapes))
    }

    /// Writes the bundles, on all threads, and frees their pages. `make` is called with a bundle's place and
    /// pages, and `put` with what it returned, in order.
    ///
    /// # Errors
    /// Returns the errors of `put`, and [`Error::Spill`] if pages could not be kept on disk.
    pub(crate) fn for_each_bundle<T: Send>(
        &self,
        make: impl Fn([u32; 2], &[Page<'_>; BUNDLE_PAGES]) -> T + Sync,
        mut put: impl FnMut([u32; 2], T) -> Result<()>,
    ) -> Result<()> {
        let dims = page_dims(self.pages.size);
        for some in bundles(dims).chunks(BUNDLES_AT_A_TIME) {
            let one = |scratch: &mut Scratch, &at: &[u32; 2]| {
                let pages = pages_of(at, dims).into_iter().map(|place| self.page(scratch, dims, place));
                let pages = pages.collect::<Result<Vec<_>>>()?;
                Ok(make(at, &std::array::from_fn(|slot| pages[slot].as_page())))
            };
            let made: Vec<T> = some.par_iter().map_init(Scratch::default, one).collect::<Result<_>>()?;
            self.pages.store.spill().check()?;
            some.iter().zip(made).try_for_each(|(&at, made)| put(at, made))?;
        }
        Ok(())
    }

    fn page(&self, scratch: &mut Scratch, dims: [u32; 2], place: Option<[u32; 2]>) -> Result<OwnedPage> {
        let at = |[x, y]: [u32; 2]| self.pages.places[(y * dims[0] + x) as usize];
        let [number, base] = place.map_or([UNIFORM, NEVER], at);
        let uniform = |base| OwnedPage { root: UNIFORM, base, words: Vec::new() };
        if number == UNIFORM {
            return Ok(uniform(base));
        }
        // The spill has recorded a lost page as an error, and the caller checks for it.
        let Some((words, root)) = self.pages.store.get(number) else { return Ok(uniform(base)) };
        self.pages.store.forget(number);
        let Scratch { reader, places } = scratch;
        reader.read(&words, root);
        let address = |index: usize| self.common.address(reader.hashes[index]);
        let words = write(&reader.list, address, places)?;
        let Some(root) = places.last().map(|place| place.root()) else { unreachable!("a page has a root") };
        Ok(OwnedPage { root, base, words })
    }

    /// Makes a tree in memory.
    pub(crate) fn tree(mut self) -> Result<DepthTree> {
        let mut builder = TreeBuilder::new(self.pages.size, self.take_common().0);
        let dims = page_dims(self.pages.size);
        let owned = |_, pages: &[Page<'_>; BUNDLE_PAGES]| {
            pages.map(|page| OwnedPage { root: page.root, base: page.base, words: page.words.to_vec() })
        };
        debug_assert_eq!(self.pages.places.len(), (dims[0] * dims[1]) as usize);
        self.for_each_bundle(owned, |at, pages| {
            builder.add(at, &pages.each_ref().map(OwnedPage::as_page));
            Ok(())
        })?;
        builder.finish().map_err(|_| Error::TooManyWords { what: "the quadtree of depths" })
    }
}
