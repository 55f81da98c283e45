//! From a technique's name to the technique.

use adumbra::format::{LightBody, ShadowFile, TreeFile};

use super::describe::unknown;
use super::spec::TechniqueSpec;
use super::{NoShadows, Technique};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::hybrid::{HybridMap, HybridSettings};
use crate::maps::{MapSettings, ShadowMap};
use crate::screen_blur::{BlurSettings, ScreenBlur};
use crate::voxel::{Cubes, Voxel, VoxelHierarchy, VoxelSettings};
use crate::voxel_csm::VoxelCsm;

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
    ("sm", "shadow map, nearest texel"),
    ("pcf", "shadow map, comparisons of several texels; filter=2 is the sampler's own"),
    ("pcss", "shadow map, penumbrae of a sun"),
    ("vsm", "variance shadow map"),
    ("evsm", "exponential variance shadow map"),
    ("msm", "moment shadow map"),
    ("csm", "cascades of shadow maps along the view"),
    ("csm-vsm", "cascades of variance shadow maps"),
    ("csm-evsm", "cascades of exponential variance shadow maps"),
    ("hrsm", "hybrid-resolution shadow map: hrsm:START-TARGET texels a side"),
    ("blur", "another technique's factor, blurred on the screen"),
    ("blur-dilate", "the same, with the shade dilated first"),
    ("blur-bilateral", "the same, within surfaces"),
    ("voxel", "a light-aligned file, filtered over texels; voxel:soft, penumbrae (layout hierarchy)"),
    ("voxel+csm", "the same for what stands still, cascades for movers: csm=cascades=2/filter=3"),
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
        "blur" | "blur-dilate" | "blur-bilateral" => {
            let (settings, base) = BlurSettings::read(spec)?;
            let base = build(gpu, &base, baked)?;
            Ok(Box::new(ScreenBlur::new(gpu, spec.to_string(), base, settings)))
        }
        "hrsm" => {
            let settings = HybridSettings::from_spec(spec)?;
            Ok(Box::new(HybridMap::new(gpu, &spec.to_string(), settings)?))
        }
        "voxel" => Ok(match baked.light {
            Some(file @ ShadowFile { grid, body: LightBody::Hierarchy(hierarchy), .. }) => {
                let settings = VoxelSettings::from_spec(spec, Some(file))?;
                Box::new(VoxelHierarchy::from_settings(gpu, spec.to_string(), grid, hierarchy, settings)?)
            }
            file => Box::new(Voxel::from_spec(gpu, spec, file)?),
        }),
        "voxel+csm" => Ok(Box::new(VoxelCsm::from_spec(gpu, spec, baked.light)?)),
        "voxel-cubes" | "voxel-texture" => Ok(Box::new(Cubes::from_spec(gpu, spec, baked.tree)?)),
        _ => {
            if let Some(settings) = MapSettings::from_spec(spec)? {
                return Ok(Box::new(ShadowMap::new(gpu, &spec.to_string(), settings)?));
            }
            Err(unknown(spec))
        }
    }
}
