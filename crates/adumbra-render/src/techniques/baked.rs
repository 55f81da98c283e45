//! The baked files that techniques read.

use adumbra::ShadowFile;
use adumbra_tree::TreeFile;

/// The baked files available to techniques.
#[derive(Clone, Copy, Default)]
pub struct Baked<'a> {
    /// A light-aligned file, for `voxel`.
    pub light: Option<&'a ShadowFile>,
    /// A world-aligned file, for `voxel-cubes` and `voxel-texture`.
    pub tree: Option<&'a TreeFile>,
}
