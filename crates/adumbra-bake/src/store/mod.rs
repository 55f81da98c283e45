//! Storage of what is built: shapes without duplicates, in memory or in pages on disk.

pub(crate) mod paged;
pub(crate) mod shapes;
