//! From a technique's name to the technique.

use adumbra::format::{LightBody, ShadowFile, TreeFile};

use super::spec::TechniqueSpec;
use super::{NoShadows, Technique};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::hybrid::{HybridMap, HybridSettings};
use crate::maps::{MapSettings, ShadowMap};
use crate::screen_blur::{BlurSettings, ScreenBlur};
use crate::voxel::{Cubes, Voxel, VoxelHierarchy};
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
    ("pcf", "shadow map, comparisons over filter=2 (the sampler's own), 3, 5, 7 or poisson"),
    ("pcss", "shadow map, penumbrae of a sun of angle= degrees"),
    ("vsm", "variance shadow map, blur= texels, light bleeding cut at bleed="),
    ("evsm", "exponential variance shadow map"),
    ("msm", "moment shadow map"),
    (
        "csm",
        "cascades=1 to 8, split=practical, uniform or log, filter=1, 2, 3, 5, 7 or poisson, static=cached",
    ),
    ("csm-vsm", "cascades of variance shadow maps"),
    ("csm-evsm", "cascades of exponential variance shadow maps"),
    ("hrsm", "hybrid-resolution shadow map, START-TARGET texels a side (4096-1024), test=plane or paper"),
    ("blur", "another technique's factor, blurred on the screen"),
    ("blur-dilate", "the same, with the shade dilated first"),
    ("blur-bilateral", "the same, within surfaces"),
    (
        "voxel",
        "a light-aligned file, filtered over texels; voxel:soft, penumbrae of a sun of angle= degrees (layout hierarchy)",
    ),
    ("voxel+csm", "the same for what stands still, cascades for movers (csm=cascades=2/filter=3)"),
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
            if base.name().starts_with("blur") {
                return Err(spec.wrong("base: a blur over a blur".to_owned()));
            }
            let base = build(gpu, &base, baked)?;
            Ok(Box::new(ScreenBlur::new(gpu, spec.to_string(), base, settings)))
        }
        "hrsm" => {
            let settings = HybridSettings::from_spec(spec)?;
            Ok(Box::new(HybridMap::new(gpu, &spec.to_string(), settings)?))
        }
        "voxel" => Ok(match baked.light {
            Some(ShadowFile { grid, settings, body: LightBody::Hierarchy(hierarchy) }) => {
                Box::new(VoxelHierarchy::from_spec(gpu, spec, grid, hierarchy, settings.bias)?)
            }
            file => Box::new(Voxel::from_spec(gpu, spec, file)?),
        }),
        "voxel+csm" => Ok(Box::new(VoxelCsm::from_spec(gpu, spec, baked.light)?)),
        "voxel-cubes" | "voxel-texture" => Ok(Box::new(Cubes::from_spec(gpu, spec, baked.tree)?)),
        _ => {
            if let Some(settings) = MapSettings::from_spec(spec)? {
                return Ok(Box::new(ShadowMap::new(gpu, &spec.to_string(), settings)?));
            }
            let names: Vec<&str> = TECHNIQUES.iter().map(|(name, _)| *name).collect();
            Err(spec.wrong(format!("there is no such technique; there are: {}", names.join(", "))))
        }
    }
}
