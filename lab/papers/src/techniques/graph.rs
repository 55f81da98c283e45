//! The technique `voxel-dag`: a graph of the 2014 paper, filtered over K × K texels.

use adumbra::gpu::GridParameters;
use adumbra::query::FixedReceiver;
use adumbra::{Bias, Filter, LightGrid};
use adumbra_render::technique::{Answer, FrameInput, SpecReader, SpecText, Technique};
use adumbra_render::voxel::{
    Reads, VoxelBindings, WordBuffers, bias_uniform, fixed, grid_transform, queries, read_bias, read_filter,
    reads,
};
use adumbra_render::{Gpu, Result};
use adumbra_shaders::layout::VoxelParams;
use adumbra_shaders::{Source, source};

use super::shaders;
use crate::dag::{DagBody, DagFile, DagLayout};

/// A graph on the GPU.
pub struct Graph {
    name: String,
    grid: LightGrid,
    layout: DagLayout,
    params: VoxelParams,
    bindings: VoxelBindings,
}

/// Settings of a look-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraphSettings {
    /// The filter.
    pub filter: Filter,
    /// Bias, in texels.
    pub bias: Bias,
}

impl GraphSettings {
    /// Parses `voxel-dag[:filter=K][:bias=…][:slope=…][:normal=…]`. Defaults: K = 5, and the file's bias.
    ///
    /// # Errors
    /// Returns [`adumbra_render::RenderError::Technique`] if a parameter is unknown or out of range.
    pub(crate) fn from_reader(reader: &mut SpecReader<'_>, file: Option<&DagFile>) -> Result<Self> {
        let filter = read_filter(reader)?;
        let bias = read_bias(reader, file.map_or_else(Bias::default, |f| f.settings.bias))?;
        Ok(Self { filter, bias })
    }
}

impl Graph {
    /// Uploads a valid file. Cost: the bytes of its sections.
    ///
    /// # Errors
    /// Returns [`adumbra_render::RenderError::TooLarge`] or [`adumbra_render::RenderError::Library`] if the
    /// file exceeds the device's limits.
    pub fn new(gpu: &Gpu, name: String, file: &DagFile, settings: GraphSettings) -> Result<Self> {
        let grid = file.grid;
        let (_, root_level, root_count) = file.body.space();
        let parts = words(&file.body);
        // The second part begins at `extra.x`, the third at `code_offset`.
        let second = parts[0].len();
        let third = second + parts[1].len();
        let params = VoxelParams {
            grid: grid_transform(&GridParameters::new(&grid, grid.origin())?),
            root_count,
            root_level,
            bias: bias_uniform(settings.bias),
            extra: [second as u32, 0, 0],
            code_offset: third as u32,
            filter_width: settings.filter.width(),
            sun_cone: 0.0,
            max_radius_texels: 0.0,
            penumbra_x: [0.0; 2],
            penumbra_y: [0.0; 2],
        };
        let words = WordBuffers::new(gpu, "voxel-dag::words", &parts.each_ref().map(|part| &part[..]))?;
        let bindings = VoxelBindings::from_words(gpu, "voxel-dag", &params.bytes(), &words);
        Ok(Self { name, grid, layout: file.body.layout(), params, bindings })
    }

    /// Creates the technique `voxel-dag`.
    ///
    /// # Errors
    /// Returns the errors of [`Graph::new`], and [`adumbra_render::RenderError::Technique`] if a parameter is
    /// unknown or there is no file.
    pub(crate) fn from_spec(gpu: &Gpu, spec: &SpecText, file: Option<&DagFile>) -> Result<Self> {
        let file = file.ok_or_else(|| spec.wrong("it needs a graph file".to_owned()))?;
        let settings = spec.read(|reader| GraphSettings::from_reader(reader, Some(file)))?;
        Self::new(gpu, spec.to_string(), file, settings)
    }

    /// The WGSL files that define `adumbra_voxel_factor`. They must follow core/surface.wgsl.
    pub fn look_up(&self) -> Vec<Source> {
        [look_up_of(self.layout), vec![self.bindings.access()]].concat()
    }

    /// Returns the number of lit taps for receivers in fixed point, equal to `DagQuery::lit_taps` on the CPU.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn lit_taps(&self, gpu: &Gpu, receivers: &[FixedReceiver]) -> Result<Vec<u32>> {
        let passes = vec![source::VOXEL_PARAMS, source::VOXEL_FIXED];
        let files = [vec![source::SURFACE], self.look_up(), passes].concat();
        let answers = fixed::answer::<_, 4>(gpu, &self.bindings, &files, &queries(receivers))?;
        Ok(answers.into_iter().map(u32::from_le_bytes).collect())
    }

    /// Looks up receivers in fixed point and returns the reads of each look-up.
    ///
    /// # Errors
    /// Returns the errors of [`adumbra_render::voxel::reads`].
    pub fn reads(&self, gpu: &Gpu, receivers: &[FixedReceiver]) -> Result<Vec<Reads>> {
        reads(gpu, &self.bindings, &look_up_of(self.layout), receivers)
    }

    /// Writes the uniform for positions relative to `anchor_world`.
    ///
    /// # Errors
    /// Returns no error that [`Graph::new`] would not have returned.
    pub fn set_anchor(&mut self, gpu: &Gpu, anchor_world: [f64; 3]) -> Result<()> {
        self.params.grid = grid_transform(&GridParameters::new(&self.grid, anchor_world)?);
        self.bindings.write(gpu, &self.params.bytes());
        Ok(())
    }
}

/// Returns the WGSL files of a look-up in a layout, without the access file.
pub fn look_up_of(layout: DagLayout) -> Vec<Source> {
    let nodes = match layout {
        DagLayout::Plain => shaders::GRAPH_PLAIN,
        DagLayout::Packed => shaders::GRAPH_PACKED,
    };
    vec![shaders::graph_declarations(), source::GRID, source::VOXEL, shaders::GRAPH, nodes]
}

/// Returns the words of a graph in three parts: top; nodes, or units, two per word, the lower first; leaf
/// masks, the low half first.
pub fn words(body: &DagBody) -> [Vec<u32>; 3] {
    let halves = |masks: &[u64]| masks.iter().flat_map(|&m| [m as u32, (m >> 32) as u32]).collect();
    match body {
        DagBody::Plain(dag) => [dag.top.clone(), dag.nodes.clone(), halves(&dag.leaf_masks)],
        DagBody::Packed(packed) => {
            let two = |[low, high]: &[u16; 2]| u32::from(*low) | u32::from(*high) << 16;
            let units = packed.units.as_chunks().0.iter().map(two).collect();
            [packed.top.clone(), units, halves(&packed.leaf_masks)]
        }
    }
}

impl Technique for Graph {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        self.set_anchor(input.gpu, input.anchor_world)
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        let pass = match answer {
            Answer::Visibility => vec![source::VOXEL_PARAMS, source::VOXEL_PASS],
            Answer::Voxel => vec![source::VOXEL_PARAMS, shaders::GRAPH_LEVEL, source::VOXEL_LEVEL_PASS],
            Answer::Cascade | Answer::Level | Answer::Resident => return None,
        };
        Some([self.look_up(), pass].concat())
    }

    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        [Some(self.bindings.layout()), None]
    }

    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        [Some(self.bindings.group()), None]
    }

    fn texel_world(&self, _view_depth: f32) -> Option<f64> {
        Some(self.grid.voxel_size)
    }

    fn voxel_world(&self) -> Option<f64> {
        Some(self.grid.voxel_size)
    }

    fn bytes(&self) -> u64 {
        self.bindings.bytes()
    }
}
