//! Encoders that write what was built in the words of a layout.

pub(crate) mod depths;
mod packed;

pub use packed::pack;
pub(crate) use packed::pack_paged;
