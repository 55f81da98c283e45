//! From a technique's name to the technique.

use adumbra::format::{ShadowFile, TreeFile};

use super::spec::TechniqueSpec;
use super::{NoShadows, Technique};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::voxel::{Cubes, Voxel};

/// Baked files that techniques may look up in.
#[derive(Clone, Copy, Default)]
pub struct Baked<'a> {
    /// A light-aligned file, for `voxel`.
    pub light: Option<&'a ShadowFile>,
    /// A world-aligned file, for `voxel-cubes` and `voxel-texture`.
    pub tree: Option<&'a TreeFile>,
}

/// Every technique, and one line of what it is.
pub const TECHNIQUES: &[(&str, &str)] = &[
    ("none", "no shadows"),
    ("voxel", "a light-aligned file, filtered over texels"),
    ("voxel-cubes", "a world-aligned file, filtered over voxels"),
    ("voxel-texture", "the same, read from an RGBA8 texture"),
];

/// Builds a technique.
///
/// # Errors
/// [`crate::RenderError::Technique`] for a name or a value that does not exist, or a file that is missing; what the device cannot hold.
pub fn build(gpu: &Gpu, spec: &TechniqueSpec, baked: Baked<'_>) -> Result<Box<dyn Technique>> {
    match spec.name() {
        "none" => {
            spec.reader().finish()?;
            Ok(Box::new(NoShadows))
        }
        "voxel" => Ok(Box::new(Voxel::from_spec(gpu, spec, baked.light)?)),
        "voxel-cubes" | "voxel-texture" => Ok(Box::new(Cubes::from_spec(gpu, spec, baked.tree)?)),
        _ => {
            let names: Vec<&str> = TECHNIQUES.iter().map(|(name, _)| *name).collect();
            Err(spec.wrong(format!("there are: {}", names.join(", "))))
        }
    }
}
