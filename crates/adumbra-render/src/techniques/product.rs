//! The shadow techniques of this crate: their names, the files that they read, their traits, and how to build
//! them.

use std::str::FromStr;

use super::baked::TechniqueFiles;
use super::list::{Design, Role, TechniqueEntry, TechniqueSpec, Techniques, build};
use super::none::NoShadows;
use super::traits::{Reads, Traits, Truth};
use crate::error::{RenderError, Result};
use crate::gpu::Gpu;
use crate::hybrid::{HybridMap, HybridSettings};
use crate::maps::{MapKind, MapSettings, ShadowMap};
use crate::screen_blur::{BlurName, BlurSettings, ScreenBlur};
use crate::technique::{SpecReader, Technique};
use crate::voxel::{Voxel, VoxelSettings};
use crate::voxel_csm::{VoxelCsm, VoxelCsmSettings};

/// Every technique of this crate, ray tracing last.
pub const TECHNIQUES: &[TechniqueEntry] = &[
    entry("none", "no shadows", Role::NoShadows, &Nothing),
    entry("sm", "shadow map, nearest texel", Role::Shadows, &Map(MapKind::NEAREST, Traits::DRAWN)),
    entry(
        "pcf",
        "shadow map, percentage-closer filtering; filter=2 is the sampler's own",
        Role::Shadows,
        &Map(MapKind::PCF, Traits::DRAWN),
    ),
    entry(
        "pcss",
        "shadow map, penumbrae of the sun's disc",
        Role::Shadows,
        &Map(MapKind::PCSS, Traits::SOFT),
    ),
    entry("vsm", "variance shadow map", Role::Shadows, &Map(MapKind::VSM, Traits::DRAWN)),
    entry("evsm", "exponential variance shadow map", Role::Shadows, &Map(MapKind::EVSM, Traits::DRAWN)),
    entry("msm", "moment shadow map", Role::Shadows, &Map(MapKind::MSM, Traits::DRAWN)),
    entry("csm", "cascades of shadow maps along the view", Role::Cascades, &Map(MapKind::CSM, Traits::DRAWN)),
    entry(
        "csm-vsm",
        "cascades of variance shadow maps",
        Role::Cascades,
        &Map(MapKind::CSM_VSM, Traits::DRAWN),
    ),
    entry(
        "csm-evsm",
        "cascades of exponential variance shadow maps",
        Role::Cascades,
        &Map(MapKind::CSM_EVSM, Traits::DRAWN),
    ),
    entry("hrsm", "hybrid-resolution shadow map: hrsm:START-TARGET texels per side", Role::Shadows, &Hybrid),
    entry("blur", "another technique's factor, blurred in screen space", Role::Blur, &Blur(BlurName::Plain)),
    entry(
        "blur-dilate",
        "another technique's factor, its shadows dilated and then blurred in screen space",
        Role::Blur,
        &Blur(BlurName::Dilated),
    ),
    entry(
        "blur-bilateral",
        "another technique's factor, blurred in screen space within surfaces",
        Role::Blur,
        &Blur(BlurName::Bilateral),
    ),
    entry(
        "voxel",
        "a light-aligned file, filtered over texels; voxel:soft, penumbrae; voxel:path, a sun path",
        Role::Shadows,
        &LightFile,
    ),
    entry(
        "voxel+csm",
        "a light-aligned file for static casters, cascades for movers: csm=cascades=2/filter=3",
        Role::Shadows,
        &LightFileAndCascades,
    ),
    entry("truth", "rays, on the CPU", Role::Rays, &Rays),
];

const fn entry(
    name: &'static str,
    summary: &'static str,
    role: Role,
    design: &'static dyn Design,
) -> TechniqueEntry {
    TechniqueEntry { name, summary, role, design }
}

impl Techniques {
    /// Returns [`TECHNIQUES`].
    pub const fn product() -> Self {
        Self::of(TECHNIQUES)
    }
}

/// Parses a technique of [`TECHNIQUES`].
impl FromStr for TechniqueSpec {
    type Err = RenderError;

    fn from_str(text: &str) -> Result<Self> {
        Techniques::product().parse(text)
    }
}

#[derive(Debug)]
struct Nothing;

impl Design for Nothing {
    fn read(&self, _reader: &mut SpecReader<'_>, _baked: TechniqueFiles<'_>) -> Result<()> {
        Ok(())
    }

    fn build(
        &self,
        _gpu: &Gpu,
        _spec: &TechniqueSpec,
        _baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        Ok(Box::new(NoShadows))
    }
}

#[derive(Debug)]
struct Rays;

impl Design for Rays {
    fn read(&self, _reader: &mut SpecReader<'_>, _baked: TechniqueFiles<'_>) -> Result<()> {
        Ok(())
    }

    fn build(
        &self,
        _gpu: &Gpu,
        spec: &TechniqueSpec,
        _baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        Err(spec.wrong("its rays are traced on the CPU, so it cannot be built for the GPU".to_owned()))
    }
}

#[derive(Debug)]
struct Map(MapKind, Traits);

impl Design for Map {
    fn traits(&self, _spec: &TechniqueSpec) -> Traits {
        self.1
    }

    fn read(&self, reader: &mut SpecReader<'_>, _baked: TechniqueFiles<'_>) -> Result<()> {
        MapSettings::from_reader(reader, self.0).map(drop)
    }

    fn build(
        &self,
        gpu: &Gpu,
        spec: &TechniqueSpec,
        _baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        let settings = MapSettings::from_spec(spec.text(), self.0)?;
        Ok(Box::new(ShadowMap::new(gpu, &spec.to_string(), settings)?))
    }
}

#[derive(Debug)]
struct Hybrid;

impl Design for Hybrid {
    fn read(&self, reader: &mut SpecReader<'_>, _baked: TechniqueFiles<'_>) -> Result<()> {
        HybridSettings::from_reader(reader).map(drop)
    }

    fn build(
        &self,
        gpu: &Gpu,
        spec: &TechniqueSpec,
        _baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        let settings = HybridSettings::from_spec(spec.text())?;
        Ok(Box::new(HybridMap::new(gpu, &spec.to_string(), settings)?))
    }
}

#[derive(Debug)]
struct Blur(BlurName);

impl Design for Blur {
    /// A blur of any technique widens shadow edges as the sun's disc does.
    fn traits(&self, spec: &TechniqueSpec) -> Traits {
        let of_base = spec.base().map_or(Traits::DRAWN, TechniqueSpec::traits);
        Traits { truth: Truth::SunDisc, ..of_base }
    }

    fn read(&self, reader: &mut SpecReader<'_>, _baked: TechniqueFiles<'_>) -> Result<()> {
        BlurSettings::from_reader(reader, self.0).map(drop)
    }

    fn build(
        &self,
        gpu: &Gpu,
        spec: &TechniqueSpec,
        baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        let settings = spec.text().read(|reader| BlurSettings::from_reader(reader, self.0))?;
        let base = spec.base().ok_or_else(|| spec.wrong("it has no base".to_owned()))?;
        Ok(Box::new(ScreenBlur::new(gpu, spec.to_string(), build(gpu, base, baked)?, settings)))
    }
}

impl BlurSettings {
    /// Reads the settings of a blur, apart from the technique that it blurs: [`TechniqueSpec::base`].
    ///
    /// # Errors
    /// Returns [`RenderError::Technique`] if the technique is not a blur.
    pub fn of(spec: &TechniqueSpec) -> Result<Self> {
        let name = match spec.name() {
            "blur" => BlurName::Plain,
            "blur-dilate" => BlurName::Dilated,
            "blur-bilateral" => BlurName::Bilateral,
            _ => return Err(spec.wrong("it is no blur".to_owned())),
        };
        spec.text().read(|reader| Self::from_reader(reader, name))
    }
}

#[derive(Debug)]
struct LightFile;

impl Design for LightFile {
    fn traits(&self, spec: &TechniqueSpec) -> Traits {
        if VoxelSettings::has_penumbrae(spec.text()) {
            Traits { reads: Reads::LightFile, shows_movers: false, ..Traits::SOFT }
        } else {
            Traits { reads: Reads::LightFile, shows_movers: false, ..Traits::DRAWN }
        }
    }

    fn read(&self, reader: &mut SpecReader<'_>, baked: TechniqueFiles<'_>) -> Result<()> {
        VoxelSettings::from_reader(reader, baked.light).map(drop)
    }

    fn build(
        &self,
        gpu: &Gpu,
        spec: &TechniqueSpec,
        baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        Ok(Box::new(Voxel::from_spec(gpu, spec.text(), baked.light)?))
    }
}

#[derive(Debug)]
struct LightFileAndCascades;

impl Design for LightFileAndCascades {
    fn traits(&self, _spec: &TechniqueSpec) -> Traits {
        Traits { reads: Reads::LightFile, ..Traits::DRAWN }
    }

    fn read(&self, reader: &mut SpecReader<'_>, _baked: TechniqueFiles<'_>) -> Result<()> {
        VoxelCsmSettings::from_reader(reader).map(drop)
    }

    fn build(
        &self,
        gpu: &Gpu,
        spec: &TechniqueSpec,
        baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        Ok(Box::new(VoxelCsm::from_spec(gpu, spec.text(), baked.light)?))
    }
}
