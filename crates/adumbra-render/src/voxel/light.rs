//! A light-aligned file on the GPU. Its words are those of the file, in every layout. The techniques `voxel`,
//! `voxel:soft` and `voxel+csm` use it.

use std::sync::Arc;

use adumbra::gpu::{LookUp, Parameters, Penumbra};
use adumbra::query::FixedReceiver;
use adumbra::{Placement, ShadowFile};
use adumbra_shaders::constants::MAX_LEVELS;
use adumbra_shaders::layout::VoxelQuery;
use adumbra_shaders::{Source, source};

use super::moving::{self, Levels, MovingKeys, MovingLight};
use super::{LightFile, StreamedFile, VoxelBindings, VoxelSettings, WordBuffers, fixed};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::technique::FrameInput;

/// A light-aligned file on the GPU with its look-up settings: bind group 1, and the WGSL that reads it.
pub struct BakedLight {
    /// The levels that look-ups may use, the finest first. A file that was uploaded whole has one level.
    levels: Levels,
    streamed: Option<Arc<StreamedFile>>,
    /// The keys of a sun path. They replace levels.
    path: Option<MovingKeys>,
    penumbra: Option<Penumbra>,
    /// Placement of the file's world in the app's world.
    placement: Placement,
    bindings: VoxelBindings,
}

impl BakedLight {
    /// Uploads a valid file, or uses the pool of a streamed file. Cost of a whole file: the bytes of its
    /// sections.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::TooLarge`] or [`crate::RenderError::VoxelLimit`] if the file or the pool
    /// exceeds the device's limits, and [`crate::RenderError::Library`] if a setting is out of its range.
    pub fn new(gpu: &Gpu, file: LightFile<'_>, settings: VoxelSettings) -> Result<Self> {
        match file {
            LightFile::Whole(file) => Self::from_file(gpu, file, settings),
            LightFile::Streamed(file) => Self::from_stream(gpu, file, settings),
            LightFile::Between { keys, towards_sun } => {
                moving::check_reach(keys, towards_sun)?;
                let light = MovingLight::new(keys, towards_sun, usize::MAX);
                Self::from_keys(gpu, Arc::new(light), settings, true)
            }
            LightFile::Moving(light) => Self::from_keys(gpu, Arc::clone(light), settings, false),
        }
    }

    /// Uploads two keys of a sun path.
    fn from_keys(
        gpu: &Gpu,
        light: Arc<MovingLight>,
        settings: VoxelSettings,
        is_still: bool,
    ) -> Result<Self> {
        let VoxelSettings { look_up, quick } = settings;
        let (keys, levels) = MovingKeys::new(gpu, light, (look_up, quick), is_still)?;
        let bindings = moving::bindings(gpu, &keys, &levels);
        let LookUp { penumbra, placement, .. } = look_up;
        Ok(Self { levels, streamed: None, path: Some(keys), penumbra, placement, bindings })
    }

    /// Uploads a valid file. Cost: the bytes of its sections.
    ///
    /// # Errors
    /// Returns the errors of [`BakedLight::new`].
    pub fn from_file(gpu: &Gpu, file: &ShadowFile, settings: VoxelSettings) -> Result<Self> {
        let VoxelSettings { look_up, .. } = settings;
        let parameters = Parameters::new(file, &look_up, file.grid.origin())?;
        let words = WordBuffers::new(gpu, "voxel::words", &file.gpu().words().parts())?;
        let bindings = VoxelBindings::from_words(gpu, "voxel", &parameters.to_bytes(), &words);
        let levels = vec![(file.grid, parameters)];
        let LookUp { penumbra, placement, .. } = look_up;
        Ok(Self { levels, streamed: None, path: None, penumbra, placement, bindings })
    }

    fn from_stream(gpu: &Gpu, file: &Arc<StreamedFile>, settings: VoxelSettings) -> Result<Self> {
        let VoxelSettings { look_up, .. } = settings;
        let parameters = file.parameters(&look_up, file.grid().origin())?;
        let levels: Vec<_> = file.grids().into_iter().zip(parameters).collect();
        let words = file.pool(gpu)?;
        let bindings = VoxelBindings::from_words(gpu, "voxel", &uniform_of(&levels, true), &words);
        Ok(Self {
            levels,
            streamed: Some(Arc::clone(file)),
            path: None,
            penumbra: look_up.penumbra,
            placement: look_up.placement,
            bindings,
        })
    }

    /// Bind group 1: the uniform, then the words.
    pub fn bindings(&self) -> &VoxelBindings {
        &self.bindings
    }

    /// The WGSL files that define `adumbra_voxel_factor` for these bindings. They must follow
    /// core/surface.wgsl.
    pub fn look_up(&self) -> Vec<Source> {
        [source::LOOK_UP, &[self.bindings.access()]].concat()
    }

    /// The WGSL files that define `adumbra_file_factor`. They must follow core/surface.wgsl.
    pub(crate) fn file_factor(&self) -> Vec<Source> {
        let parameters: &[Source] = match (&self.streamed, &self.path) {
            (Some(_), _) => &[source::DEPTHS_BLEND, source::VOXEL_LEVELS],
            (None, Some(_)) if self.penumbra.is_some() => moving::DISC,
            (None, Some(_)) => moving::FILTER,
            (None, None) => &[source::VOXEL_PARAMS],
        };
        [&self.look_up(), parameters].concat()
    }

    /// The WGSL files of the technique `voxel` or `voxel:soft`, depending on the filter.
    pub fn visibility_sources(&self) -> Vec<Source> {
        if self.penumbra.is_some() && self.path.is_none() {
            return self.soft_sources();
        }
        [self.file_factor(), vec![source::VOXEL_PASS]].concat()
    }

    pub(super) fn soft_sources(&self) -> Vec<Source> {
        let access =
            if self.streamed.is_some() { source::VOXEL_LEVELS_SOFT } else { source::VOXEL_PARAMS_SOFT };
        let soft = vec![source::DISC, source::DEPTHS_SOFT, access, source::VOXEL_SOFT_PASS];
        [self.file_factor(), soft].concat()
    }

    /// The WGSL files that return the level at which a look-up ends. `None` for a sun path, whose look-ups
    /// march.
    pub(crate) fn level_sources(&self) -> Option<Vec<Source>> {
        if self.path.is_some() {
            return None;
        }
        let pass =
            if self.streamed.is_some() { source::VOXEL_LEVELS_BLOCK_PASS } else { source::VOXEL_LEVEL_PASS };
        Some([self.file_factor(), vec![source::DEPTHS_LEVEL, pass]].concat())
    }

    /// The WGSL files that return the level of detail that answers. `None` for a file that was uploaded
    /// whole.
    pub(crate) fn resident_sources(&self) -> Option<Vec<Source>> {
        self.streamed.as_ref()?;
        Some([self.file_factor(), vec![source::VOXEL_LEVELS_RESIDENT_PASS]].concat())
    }

    /// Advances a streamed file or a moving sun by one frame, and writes the uniform.
    ///
    /// # Errors
    /// Returns no error that [`BakedLight::new`] would not have returned.
    pub fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        if let Some(streamed) = &self.streamed {
            streamed.advance(input.gpu, input.camera, &self.placement);
        }
        if let Some(keys) = &mut self.path
            && let Some((levels, are_words_others)) = keys.advance(input.gpu, input.anchor_world)?
        {
            self.levels = levels;
            if are_words_others {
                self.bindings = moving::bindings(input.gpu, keys, &self.levels);
            }
        }
        self.set_anchor(input.gpu, input.anchor_world)
    }

    /// Changes the placement of the file's world in the app's world. It takes effect with the next call of
    /// [`BakedLight::set_anchor`] or [`BakedLight::prepare`]. The sun of a path remains a direction of the
    /// file's world: convert it with [`Placement::direction_to_file`].
    pub fn place(&mut self, placement: Placement) {
        self.placement = placement;
    }

    /// Writes the uniform for positions relative to `anchor_world`.
    ///
    /// # Errors
    /// Returns no error that [`BakedLight::new`] would not have returned.
    pub fn set_anchor(&mut self, gpu: &Gpu, anchor_world: [f64; 3]) -> Result<()> {
        for (grid, parameters) in &mut self.levels {
            parameters.set_anchor(&grid.placed(&self.placement), anchor_world)?;
        }
        let uniform = match &self.path {
            Some(keys) => keys.uniform(&self.levels),
            None => uniform_of(&self.levels, self.streamed.is_some()),
        };
        self.bindings.write(gpu, &uniform);
        Ok(())
    }

    /// Returns the number of lit taps for receivers in fixed point, equal to `Sampler::lit_taps` on the CPU.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn lit_taps(&self, gpu: &Gpu, receivers: &[FixedReceiver]) -> Result<Vec<u32>> {
        let passes = vec![source::VOXEL_PARAMS, source::VOXEL_FIXED];
        let files = [vec![source::SURFACE], self.look_up(), passes].concat();
        let answers = fixed::answer::<_, 4>(gpu, &self.bindings, &files, &queries(receivers))?;
        Ok(answers.into_iter().map(u32::from_le_bytes).collect())
    }

    /// Marches rays from these starts through each key of a sun path. The results equal
    /// [`adumbra::query::march`] on the CPU: 0 blocked, 1 clear, 2 or more unknown. Gradients are ignored.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn marched(&self, gpu: &Gpu, starts: &[FixedReceiver]) -> Result<Vec<[u32; 2]>> {
        let files = [vec![source::SURFACE], self.file_factor(), vec![source::MARCH_FIXED]].concat();
        let answers = fixed::answer::<_, 8>(gpu, &self.bindings, &files, &queries(starts))?;
        let words = |bytes: [u8; 8]| {
            [0, 4].map(|at| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
        };
        Ok(answers.into_iter().map(words).collect())
    }

    /// Edge of a voxel, world units.
    pub fn voxel_world(&self) -> f64 {
        self.levels[0].0.voxel_size * self.placement.scale()
    }

    /// Bytes of the file's sections on the device.
    pub fn bytes(&self) -> u64 {
        self.bindings.bytes()
    }
}

/// Returns the uniform: the parameters of a whole file, or of the levels of a streamed file, padded to the
/// number of levels in access/voxel_levels.wgsl.
fn uniform_of(levels: &Levels, is_streamed: bool) -> Vec<u8> {
    let mut bytes: Vec<u8> = levels.iter().flat_map(|(_, parameters)| parameters.to_bytes()).collect();
    if is_streamed {
        bytes.resize(MAX_LEVELS as usize * Parameters::BYTES, 0);
    }
    bytes
}

/// Returns receivers as the passes over lists read them.
pub fn queries(receivers: &[FixedReceiver]) -> Vec<VoxelQuery> {
    let query = |r: &FixedReceiver| VoxelQuery { p_fixed: r.p_fixed.map(|c| c as i32), gradient: r.gradient };
    receivers.iter().map(query).collect()
}
