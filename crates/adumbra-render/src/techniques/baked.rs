//! The baked files that techniques read.

use std::any::Any;

use adumbra::ShadowFile;

use crate::voxel::LightFile;

/// The baked files available to techniques.
#[derive(Clone, Copy, Default)]
pub struct TechniqueFiles<'a> {
    /// A light-aligned file, for `voxel`.
    pub light: Option<LightFile<'a>>,
    /// Files of other kinds, for techniques of a dependent crate, which knows their type.
    pub other: Option<&'a (dyn Any + Send + Sync)>,
}

impl<'a> TechniqueFiles<'a> {
    /// Creates files of one light-aligned file.
    pub fn of(file: &'a ShadowFile) -> Self {
        Self { light: Some(LightFile::Whole(file)), other: None }
    }
}
