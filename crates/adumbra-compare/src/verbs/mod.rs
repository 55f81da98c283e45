//! The verbs `compare` and `render`, which several programs offer, each with its own techniques.

pub mod compare;
pub mod render;

use adumbra_render::Techniques;

use crate::baked::MoreFiles;

/// The techniques and files that a program adds to the verbs.
#[derive(Clone, Copy)]
pub struct Offer<'a> {
    /// The techniques.
    pub techniques: Techniques,
    /// Returns an empty set for the further kinds of files that the techniques read.
    pub more_files: &'a (dyn Fn() -> Option<Box<dyn MoreFiles>> + Sync),
}

impl Offer<'_> {
    /// The offer of the program `adumbra`.
    pub const PRODUCT: Self = Self { techniques: Techniques::product(), more_files: &|| None };
}
