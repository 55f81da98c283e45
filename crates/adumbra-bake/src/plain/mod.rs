//! The plain builder: every texel is drawn. The reference that the fast builder is tested against.

#[cfg(test)]
pub(crate) mod agreement;
pub(crate) mod build;
#[cfg(test)]
mod reference;
mod tile;
