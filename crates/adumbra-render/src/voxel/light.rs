//! A light-aligned file on the GPU. Its words are those of the file, whatever its layout. The techniques `voxel`,
//! `voxel:soft` and `voxel+csm` use it.

use adumbra::gpu::{Parameters, Words};
use adumbra::query::FixedReceiver;
use adumbra::{Layout, LightBody, LightGrid, ShadowFile};
use adumbra_shaders::layout::VoxelQuery;
use adumbra_shaders::{Source, source};

use super::filter::VoxelFilter;
use super::{VoxelBindings, VoxelSettings, WordBuffers, fixed};
use crate::error::Result;
use crate::gpu::Gpu;

/// A light-aligned file on the GPU with its look-up settings: bind group 1, and the WGSL that reads it.
pub struct BakedLight {
    grid: LightGrid,
    layout: Layout,
    filter: VoxelFilter,
    parameters: Parameters,
    bindings: VoxelBindings,
}

impl BakedLight {
    /// Uploads a valid file. Cost: the bytes of its sections.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::TooLarge`] or [`crate::RenderError::VoxelLimit`] if the file exceeds the device's
    /// limits, and [`crate::RenderError::Library`] if a setting does not exist or penumbrae are requested of a layout
    /// other than depths.
    pub fn from_file(gpu: &Gpu, file: &ShadowFile, settings: VoxelSettings) -> Result<Self> {
        Self::new(gpu, &file.grid, &file.body, settings)
    }

    /// Uploads a valid body over a grid, like [`BakedLight::from_file`].
    ///
    /// # Errors
    /// Returns the errors of [`BakedLight::from_file`].
    pub fn new(gpu: &Gpu, grid: &LightGrid, body: &LightBody, settings: VoxelSettings) -> Result<Self> {
        let VoxelSettings { filter, bias } = settings;
        let layout = body.layout();
        let filter_width = if let VoxelFilter::Taps(width) = filter { width } else { 1 };
        let mut parameters = Parameters::new(grid, body, bias, filter_width, grid.origin())?;
        if let VoxelFilter::Soft { angle_degrees, max_radius_texels } = filter {
            parameters.set_penumbrae(grid, angle_degrees, max_radius_texels)?;
        }
        let words = WordBuffers::new(gpu, "voxel::words", &Words::new(body).parts())?;
        let bindings = VoxelBindings::from_words(gpu, "voxel", &parameters.to_bytes(), &words);
        Ok(Self { grid: *grid, layout, filter, parameters, bindings })
    }

    /// Bind group 1: the uniform, then the words.
    pub fn bindings(&self) -> &VoxelBindings {
        &self.bindings
    }

    /// The WGSL files that define `adumbra_voxel_factor` for this layout and these bindings. They must follow
    /// core/surface.wgsl.
    pub fn look_up(&self) -> Vec<Source> {
        self.look_up_with(self.bindings.access())
    }

    /// The files of [`BakedLight::look_up`] with another access file.
    pub(super) fn look_up_with(&self, access: Source) -> Vec<Source> {
        let layout: &[Source] = match self.layout {
            Layout::Plain => &[source::VOXEL_GRAPH, source::VOXEL_PLAIN],
            Layout::Packed => &[source::VOXEL_GRAPH, source::VOXEL_PACKED],
            Layout::Depths => &[source::DEPTHS, source::DEPTHS_LEAF],
        };
        [&[source::GRID, source::VOXEL], layout, &[access]].concat()
    }

    /// The WGSL files of the technique `voxel` or `voxel:soft`, depending on the filter.
    pub fn visibility_sources(&self) -> Vec<Source> {
        match self.filter {
            VoxelFilter::Taps(_) => [self.look_up(), vec![source::VOXEL_PASS]].concat(),
            VoxelFilter::Soft { .. } => self.soft_sources(),
        }
    }

    pub(super) fn soft_sources(&self) -> Vec<Source> {
        let soft = [source::DISC, source::DEPTHS_SOFT, source::VOXEL_SOFT_PASS];
        [self.look_up(), soft.to_vec()].concat()
    }

    /// The WGSL files that return the level at which a look-up ends.
    pub(crate) fn level_sources(&self) -> Vec<Source> {
        let level = if self.layout == Layout::Depths { source::DEPTHS_LEVEL } else { source::VOXEL_LEVEL };
        [self.look_up(), vec![level, source::VOXEL_LEVEL_PASS]].concat()
    }

    /// Writes the uniform for positions relative to `anchor_world`.
    ///
    /// # Errors
    /// Returns no error that [`BakedLight::new`] would not have returned.
    pub fn set_anchor(&mut self, gpu: &Gpu, anchor_world: [f64; 3]) -> Result<()> {
        self.parameters.set_anchor(&self.grid, anchor_world)?;
        self.bindings.write(gpu, &self.parameters.to_bytes());
        Ok(())
    }

    /// Returns the number of lit taps for receivers in fixed point, equal to `Query::lit_taps` on the CPU.
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

    pub(super) fn layout(&self) -> Layout {
        self.layout
    }
}

pub(super) fn queries(receivers: &[FixedReceiver]) -> Vec<VoxelQuery> {
    let query = |r: &FixedReceiver| VoxelQuery { p_fixed: r.p_fixed.map(|c| c as i32), gradient: r.gradient };
    receivers.iter().map(query).collect()
}
