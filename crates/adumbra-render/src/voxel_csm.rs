//! The technique `voxel+csm`: what stands still casts through a baked file, what moves through cascades, the darker of the two counts.
//!
//! Source: the future work of *The Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm*, 2021. The
//! cascades hold movers alone, so their depth passes cost what moves.

use adumbra::format::ShadowFile;
use adumbra::query::TapLayers;
use adumbra_shaders::{Source, source};

use crate::error::Result;
use crate::gpu::Gpu;
use crate::maps::{MapCasters, MapSettings, ShadowMap};
use crate::technique::{Answer, FrameInput, SpecReader, Technique, TechniqueSpec};
use crate::voxel::{Voxel, read_layers, read_width};

/// A baked file and a map of movers.
pub struct VoxelCsm {
    name: String,
    voxel: Voxel,
    map: ShadowMap,
}

/// Its two halves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelCsmSettings {
    /// Width of the file's filter, texels.
    pub filter: u32,
    /// Of that filter's taps.
    pub layers: TapLayers,
    /// The cascades, of movers alone.
    pub map: MapSettings,
}

impl VoxelCsmSettings {
    /// `voxel+csm[:filter=K][:layers=tap|block][:csm=PARAMETERS]`: the file's filter, and parameters of `csm` with `/` between them, such as
    /// `csm=cascades=2/filter=3`.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for other parameters, and for `static=cached`, of which cascades without static casters have
    /// nothing.
    pub fn from_spec(spec: &TechniqueSpec) -> Result<Self> {
        let mut reader = spec.reader();
        let settings = Self::from_reader(&mut reader)?;
        reader.finish()?;
        Ok(settings)
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>) -> Result<Self> {
        let spec = reader.spec();
        let filter = read_width(reader)?;
        let layers = read_layers(reader)?;
        let map = reader.technique("csm", "the cascades for what moves", Some("csm"), "")?;
        let map = MapSettings::from_spec(&map)?.ok_or_else(|| spec.wrong("csm is no map".to_owned()))?;
        if map.cache_static {
            return Err(
                spec.wrong("csm=static=cached: nothing that stands still is in the cascades".to_owned())
            );
        }
        Ok(Self { filter, layers, map: MapSettings { casters: MapCasters::Movers, ..map } })
    }
}

impl VoxelCsm {
    /// The technique `voxel+csm`, as [`VoxelCsmSettings::from_spec`] reads it.
    ///
    /// # Errors
    /// As [`Voxel::of_file`] and [`ShadowMap::new`]; [`crate::RenderError::Technique`] for other parameters, or no file.
    pub fn from_spec(gpu: &Gpu, spec: &TechniqueSpec, file: Option<&ShadowFile>) -> Result<Self> {
        let settings = VoxelCsmSettings::from_spec(spec)?;
        let file =
            file.ok_or_else(|| spec.wrong("it needs a light-aligned shadow file: --shadow-file".to_owned()))?;
        let voxel =
            Voxel::of_file(gpu, file, file.settings.bias, settings.filter)?.with_layers(gpu, settings.layers);
        let map = ShadowMap::new(gpu, "csm", settings.map)?;
        Ok(Self { name: spec.to_string(), voxel, map })
    }
}

impl Technique for VoxelCsm {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        self.voxel.prepare(input)?;
        self.map.prepare(input)
    }

    fn encode_depth(&mut self, input: &FrameInput<'_>, encoder: &mut wgpu::CommandEncoder) {
        self.map.encode_depth(input, encoder);
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        match answer {
            Answer::Visibility => {
                let both = self.voxel.look_up().into_iter().chain(self.map.visibility_sources());
                Some(both.chain([source::VOXEL_CSM]).collect())
            }
            Answer::Voxel => self.voxel.sources(answer),
            Answer::Cascade | Answer::Level => self.map.sources(answer),
        }
    }

    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        [self.voxel.layouts()[0], self.map.layouts()[1]]
    }

    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        [self.voxel.groups()[0], self.map.groups()[1]]
    }

    fn bytes(&self) -> u64 {
        self.voxel.bytes() + self.map.bytes()
    }

    fn map(&self) -> Option<&ShadowMap> {
        Some(&self.map)
    }

    fn texel_world(&self, view_depth: f32) -> Option<f64> {
        self.voxel.texel_world(view_depth)
    }

    fn voxel_world(&self) -> Option<f64> {
        self.voxel.voxel_world()
    }

    fn notes(&self) -> Vec<String> {
        self.map.notes()
    }
}
