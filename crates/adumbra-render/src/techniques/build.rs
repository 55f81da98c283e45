//! Builds a technique on a device from its text.

use super::baked::Baked;
use super::none::NoShadows;
use super::registry::{Kind, unknown};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::hybrid::{HybridMap, HybridSettings};
use crate::maps::{MapSettings, ShadowMap};
use crate::screen_blur::{BlurSettings, ScreenBlur};
use crate::technique::{Technique, TechniqueSpec};
use crate::voxel::{Cubes, Voxel};
use crate::voxel_csm::VoxelCsm;

/// Builds a technique.
///
/// # Errors
/// Returns [`crate::RenderError::Technique`] if a name or value does not exist or a file is missing. Also returns an
/// error if the device cannot hold the technique's resources.
pub fn build(gpu: &Gpu, spec: &TechniqueSpec, baked: Baked<'_>) -> Result<Box<dyn Technique>> {
    Ok(match spec.entry().ok_or_else(|| unknown(spec))?.kind {
        Kind::NoShadows => {
            spec.reader().finish()?;
            Box::new(NoShadows)
        }
        Kind::Map(kind) => {
            Box::new(ShadowMap::new(gpu, &spec.to_string(), MapSettings::from_spec(spec, kind)?)?)
        }
        Kind::Hybrid => Box::new(HybridMap::new(gpu, &spec.to_string(), HybridSettings::from_spec(spec)?)?),
        Kind::Blur(_) => {
            let (settings, base) = BlurSettings::read(spec)?;
            let base = build(gpu, &base, baked)?;
            Box::new(ScreenBlur::new(gpu, spec.to_string(), base, settings))
        }
        Kind::Voxel => Box::new(Voxel::from_spec(gpu, spec, baked.light)?),
        Kind::VoxelCsm => Box::new(VoxelCsm::from_spec(gpu, spec, baked.light)?),
        Kind::Cubes { from_texture } => Box::new(Cubes::from_spec(gpu, spec, baked.tree, from_texture)?),
        Kind::Truth => {
            return Err(
                spec.wrong("its rays are traced on the CPU, so it cannot be built for the GPU".to_owned())
            );
        }
    })
}
