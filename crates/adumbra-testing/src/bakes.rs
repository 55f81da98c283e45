//! Bakes whose voxels a test inspects.

use adumbra::ShadowFile;
use adumbra_bake::{BakeOptions, Result, Watch, bake};
use adumbra_scene::Scene;

/// Bakes the file that `options` ask for.
///
/// # Errors
/// Returns the errors of [`bake`].
pub fn bake_file(scene: &Scene, options: &BakeOptions) -> Result<ShadowFile> {
    Ok(bake(scene, options, Watch::none())?.file)
}
