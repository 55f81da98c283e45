//! The technique `voxel+csm`: shadows of static casters from a baked file, those of movers from cascaded
//! shadow maps. The darker of the two is used.
//!
//! Source: the future work of *The Optimization and realization of Compact Precomputed Voxelized Shadows
//! Algorithm*, 2021. The cascades contain only movers, so the cost of their depth passes depends on the
//! movers alone.

use std::any::Any;

use adumbra::{Bias, Filter};
use adumbra_shaders::{Source, source};

use crate::error::Result;
use crate::gpu::Gpu;
use crate::maps::{MapCasters, MapKind, MapSettings, ShadowMap};
use crate::technique::{Answer, FrameInput, SpecReader, SpecText, Technique};
use crate::voxel::{BakedLight, LightFile, NO_FILE, VoxelSettings, read_filter};

/// A baked file and a shadow map of the movers.
pub struct VoxelCsm {
    name: String,
    light: BakedLight,
    map: ShadowMap,
}

/// Settings of [`VoxelCsm`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelCsmSettings {
    /// The file's filter.
    pub filter: Filter,
    /// The cascades, which contain only movers.
    pub map: MapSettings,
}

impl VoxelCsmSettings {
    /// Reads `voxel+csm[:filter=K][:csm=PARAMETERS]`: the file's filter, and the parameters of `csm`
    /// with `/` between them, such as `csm=cascades=2/filter=3`.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] for other parameters, and for `static=cached`, which is
    /// useless in cascades without static casters.
    pub fn from_spec(spec: &SpecText) -> Result<Self> {
        spec.read(Self::from_reader)
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>) -> Result<Self> {
        let spec = reader.spec();
        let filter = read_filter(reader)?;
        let map = reader.technique("csm", "the cascades for movers", Some("csm"), "")?;
        let map = MapSettings::from_spec(&map, MapKind::CSM)?;
        if map.cache_static {
            return Err(spec.wrong("csm=static=cached: these cascades contain no static casters".to_owned()));
        }
        Ok(Self { filter, map: MapSettings { casters: MapCasters::Movers, ..map } })
    }

    /// Look-up settings of the file, with this bias.
    fn voxel(&self, bias: Bias) -> VoxelSettings {
        VoxelSettings::taps(self.filter, bias)
    }
}

impl VoxelCsm {
    /// Builds the technique `voxel+csm` from text, read by [`VoxelCsmSettings::from_spec`].
    ///
    /// # Errors
    /// Returns the errors of [`BakedLight::new`] and [`ShadowMap::new`], and
    /// [`crate::RenderError::Technique`] for other parameters or if there is no file.
    pub fn from_spec(gpu: &Gpu, spec: &SpecText, file: Option<LightFile<'_>>) -> Result<Self> {
        let settings = VoxelCsmSettings::from_spec(spec)?;
        let file = file.ok_or_else(|| spec.wrong(NO_FILE.to_owned()))?;
        let light = BakedLight::new(gpu, file, settings.voxel(file.bias()))?;
        let map = ShadowMap::new(gpu, "csm", settings.map)?;
        Ok(Self { name: spec.to_string(), light, map })
    }
}

impl Technique for VoxelCsm {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        self.light.prepare(input)?;
        self.map.prepare(input)
    }

    fn encode_depth(&mut self, input: &FrameInput<'_>, encoder: &mut wgpu::CommandEncoder) {
        self.map.encode_depth(input, encoder);
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        match answer {
            Answer::Visibility => {
                let both = self.light.file_factor().into_iter().chain(self.map.visibility_sources());
                Some(both.chain([source::VOXEL_CSM]).collect())
            }
            Answer::Voxel => self.light.level_sources(),
            Answer::Resident => self.light.resident_sources(),
            Answer::Cascade | Answer::Level => self.map.sources(answer),
        }
    }

    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        [Some(self.light.bindings().layout()), self.map.layouts()[1]]
    }

    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        [Some(self.light.bindings().group()), self.map.groups()[1]]
    }

    fn bytes(&self) -> u64 {
        self.light.bytes() + self.map.bytes()
    }

    fn readable(&self) -> Option<&dyn Any> {
        Some(&self.map)
    }

    fn texel_world(&self, _view_depth: f32) -> Option<f64> {
        Some(self.light.voxel_world())
    }

    fn voxel_world(&self) -> Option<f64> {
        Some(self.light.voxel_world())
    }

    fn notes(&self) -> Vec<String> {
        self.map.notes()
    }
}
