//! The technique `voxel+csm`: what stands still casts through a baked file, what moves through cascades, the darker of the two counts.
//!
//! Source: the future work of *The Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm*, 2021. The
//! cascades hold movers alone, so their depth passes cost what moves.

use adumbra::format::ShadowFile;
use adumbra_shaders::{Source, source};

use crate::error::Result;
use crate::gpu::Gpu;
use crate::maps::{MapCasters, MapSettings, ShadowMap};
use crate::technique::{Answer, FrameInput, Technique, TechniqueSpec};
use crate::voxel::Voxel;

/// A baked file and a map of movers.
pub struct VoxelCsm {
    name: String,
    voxel: Voxel,
    map: ShadowMap,
}

impl VoxelCsm {
    /// `voxel+csm[:filter=K][:csm=PARAMETERS]`: the width of the file's filter, and parameters of `csm` with `/` between them, such as
    /// `csm=cascades=2/filter=3`.
    ///
    /// # Errors
    /// As [`Voxel::from_spec`] and [`ShadowMap::new`]; [`crate::RenderError::Technique`] for `static=cached` too, of which cascades
    /// without static casters have nothing.
    pub fn from_spec(gpu: &Gpu, spec: &TechniqueSpec, file: Option<&ShadowFile>) -> Result<Self> {
        let mut reader = spec.reader();
        let filter = reader.text("filter").map_or_else(String::new, |f| format!(":filter={f}"));
        let map = reader.text("csm").map_or_else(String::new, |p| format!(":{}", p.replace('/', ":")));
        reader.finish()?;
        let voxel = Voxel::from_spec(gpu, &format!("voxel{filter}").parse()?, file)?;
        let map: TechniqueSpec = format!("csm{map}").parse()?;
        let settings = MapSettings::from_spec(&map)?.ok_or_else(|| spec.wrong("csm is no map".to_owned()))?;
        if settings.cache_static {
            return Err(
                spec.wrong("csm=static=cached: nothing that stands still is in the cascades".to_owned())
            );
        }
        let settings = MapSettings { casters: MapCasters::Movers, ..settings };
        let map = ShadowMap::new(gpu, map.name(), settings)?;
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
        if answer != Answer::Visibility {
            return self.map.sources(answer);
        }
        let both = self.voxel.look_up().into_iter().chain(self.map.visibility_sources());
        Some(both.chain([source::VOXEL_CSM]).collect())
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

    fn notes(&self) -> Vec<String> {
        self.map.notes()
    }
}
