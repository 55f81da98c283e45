//! A light-aligned file on the GPU. Its words are those of the file, whatever its layout. The techniques `voxel`,
//! `voxel:soft` and `voxel+csm` use it.

use adumbra::gpu::{Parameters, Penumbra};
use adumbra::query::FixedReceiver;
use adumbra::{LightGrid, ShadowFile};
use adumbra_shaders::layout::VoxelQuery;
use adumbra_shaders::{Source, source};

use super::{VoxelBindings, VoxelSettings, WordBuffers, fixed};
use crate::error::Result;
use crate::gpu::Gpu;

/// The WGSL files of a look-up, but for the access file.
pub(super) const LOOK_UP: &[Source] = &[source::GRID, source::VOXEL, source::DEPTHS, source::DEPTHS_LEAF];

/// A light-aligned file on the GPU with its look-up settings: bind group 1, and the WGSL that reads it.
pub struct BakedLight {
    grid: LightGrid,
    penumbra: Option<Penumbra>,
    parameters: Parameters,
    bindings: VoxelBindings,
}

impl BakedLight {
    /// Uploads a valid file. Cost: the bytes of its sections.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::TooLarge`] or [`crate::RenderError::VoxelLimit`] if the file exceeds the device's
    /// limits, and [`crate::RenderError::Library`] if a setting is out of its range.
    pub fn from_file(gpu: &Gpu, file: &ShadowFile, settings: VoxelSettings) -> Result<Self> {
        let VoxelSettings { look_up } = settings;
        let parameters = Parameters::new(file, &look_up, file.grid.origin())?;
        let words = WordBuffers::new(gpu, "voxel::words", &file.gpu().words().parts())?;
        let bindings = VoxelBindings::from_words(gpu, "voxel", &parameters.to_bytes(), &words);
        Ok(Self { grid: file.grid, penumbra: look_up.penumbra, parameters, bindings })
    }

    /// Bind group 1: the uniform, then the words.
    pub fn bindings(&self) -> &VoxelBindings {
        &self.bindings
    }

    /// The WGSL files that define `adumbra_voxel_factor` for these bindings. They must follow
    /// core/surface.wgsl.
    pub fn look_up(&self) -> Vec<Source> {
        [LOOK_UP, &[self.bindings.access()]].concat()
    }

    /// The WGSL files of the technique `voxel` or `voxel:soft`, depending on the filter.
    pub fn visibility_sources(&self) -> Vec<Source> {
        match self.penumbra {
            None => [self.look_up(), vec![source::VOXEL_PASS]].concat(),
            Some(_) => self.soft_sources(),
        }
    }

    pub(super) fn soft_sources(&self) -> Vec<Source> {
        let soft = [source::DISC, source::DEPTHS_SOFT, source::VOXEL_SOFT_PASS];
        [self.look_up(), soft.to_vec()].concat()
    }

    /// The WGSL files that return the level at which a look-up ends.
    pub(crate) fn level_sources(&self) -> Vec<Source> {
        [self.look_up(), vec![source::DEPTHS_LEVEL, source::VOXEL_LEVEL_PASS]].concat()
    }

    /// Writes the uniform for positions relative to `anchor_world`.
    ///
    /// # Errors
    /// Returns no error that [`BakedLight::from_file`] would not have returned.
    pub fn set_anchor(&mut self, gpu: &Gpu, anchor_world: [f64; 3]) -> Result<()> {
        self.parameters.set_anchor(&self.grid, anchor_world)?;
        self.bindings.write(gpu, &self.parameters.to_bytes());
        Ok(())
    }

    /// Returns the number of lit taps for receivers in fixed point, equal to `Sampler::lit_taps` on the CPU.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn lit_taps(&self, gpu: &Gpu, receivers: &[FixedReceiver]) -> Result<Vec<u32>> {
        let passes = vec![source::VOXEL_PASS, source::VOXEL_FIXED];
        let files = [vec![source::SURFACE], self.look_up(), passes].concat();
        let answers = fixed::answer::<_, 4>(gpu, &self.bindings, &files, &queries(receivers))?;
        Ok(answers.into_iter().map(u32::from_le_bytes).collect())
    }

    /// Edge of a voxel, world units.
    pub fn voxel_world(&self) -> f64 {
        self.grid.voxel_size
    }

    /// Bytes of the file's sections on the device.
    pub fn bytes(&self) -> u64 {
        self.bindings.bytes()
    }
}

/// Returns receivers as the passes over lists read them.
pub fn queries(receivers: &[FixedReceiver]) -> Vec<VoxelQuery> {
    let query = |r: &FixedReceiver| VoxelQuery { p_fixed: r.p_fixed.map(|c| c as i32), gradient: r.gradient };
    receivers.iter().map(query).collect()
}
