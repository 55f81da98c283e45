//! Pages: a finished root of the quadtree becomes a page, and pages are linked to a file.
//!
//! A finished root depends on its columns alone, so it becomes a page at once. A page's shapes, each stored
//! once, point to each other by distance. Pages are held in memory or on disk until the last one is done.
//! *Linking* then finds the shapes that several pages have, puts these shapes into the common section, and
//! writes every page again without them. No step depends on the order in which pages were made.

mod common;
mod link;
mod shapes;
mod sketch;
mod store;
#[cfg(test)]
mod store_tests;
#[cfg(test)]
mod tests;

pub(crate) use link::OwnedPage;
pub use link::Pages;
#[cfg(test)]
pub(crate) use shapes::Reader;
pub(crate) use shapes::page;
pub(crate) use store::{PageStore, Spill};
