//! The technique `voxel`: a light-aligned file, filtered over K × K texels.

use adumbra::dag::Dag;
use adumbra::dag::packed::PackedDag;
use adumbra::format::{LightBody, ShadowFile};
use adumbra::light::LightGrid;
use adumbra::query::{FixedReceiver, TapLayers};
use adumbra::settings::Bias;
use adumbra_shaders::layout::{VoxelParams, VoxelQuery};
use adumbra_shaders::{Source, source};

use super::{
    HierarchyFilter, VoxelBindings, VoxelSettings, WordBuffers, bias_uniform, fixed, grid_transform,
    layers_word,
};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::technique::{Answer, FrameInput, Technique, TechniqueSpec};

/// A light-aligned graph on the GPU.
pub struct Voxel {
    grid: LightGrid,
    params: VoxelParams,
    bindings: VoxelBindings,
    /// core/voxel_plain.wgsl or core/voxel_packed.wgsl.
    nodes: Source,
    name: String,
}

/// What a layout has in its words.
struct GraphWords<'d> {
    /// Top, nodes or units, slabs.
    parts: [&'d [u32]; 3],
    size: [u32; 3],
    top_dims: [u32; 3],
    root_level: u32,
    nodes: Source,
}

impl Voxel {
    /// Uploads a valid file's graph as it is, plain or packed; of a hierarchy its graph, made first. `filter` is one of
    /// [`adumbra::query::FILTER_WIDTHS`].
    ///
    /// # Errors
    /// As [`Voxel::new`].
    pub fn of_file(gpu: &Gpu, file: &ShadowFile, bias: Bias, filter: u32) -> Result<Self> {
        match &file.body {
            LightBody::Plain(dag) => Self::new(gpu, &file.grid, dag, bias, filter),
            LightBody::Packed(packed) => Self::packed(gpu, &file.grid, packed, bias, filter),
            LightBody::Hierarchy(hierarchy) => {
                let grid = &file.grid;
                // Before a graph is made of it, which for a grid that no shader takes could be of any size.
                grid_transform(grid.origin, grid.axes, grid.voxel_size, hierarchy.size, grid.origin)?;
                Self::new(gpu, grid, &hierarchy.to_dag()?, bias, filter)
            }
        }
    }

    /// Uploads a valid graph in the plain layout. `filter` is one of [`adumbra::query::FILTER_WIDTHS`]. Cost: the bytes of top, nodes and slabs.
    ///
    /// # Errors
    /// [`crate::RenderError::TooLarge`], [`crate::RenderError::VoxelLimit`]; [`crate::RenderError::Library`] for another width.
    pub fn new(gpu: &Gpu, grid: &LightGrid, dag: &Dag, bias: Bias, filter: u32) -> Result<Self> {
        adumbra::query::Query::new(grid, dag, bias, filter)?;
        // A slab is its low word, then its high word.
        let words = GraphWords {
            parts: [&dag.top, &dag.nodes, bytemuck::cast_slice(&dag.slabs)],
            size: dag.size,
            top_dims: dag.top_dims,
            root_level: dag.root_level,
            nodes: source::VOXEL_PLAIN,
        };
        Self::of_words(gpu, grid, &words, bias, filter)
    }

    /// Uploads a valid graph in the packed layout, as it is. Cost: the bytes of top, units and slabs.
    ///
    /// # Errors
    /// As [`Voxel::new`].
    pub fn packed(gpu: &Gpu, grid: &LightGrid, packed: &PackedDag, bias: Bias, filter: u32) -> Result<Self> {
        adumbra::query::Query::new(grid, packed, bias, filter)?;
        let two = |[low, high]: &[u16; 2]| u32::from(*low) | u32::from(*high) << 16;
        let units: Vec<u32> = packed.units.as_chunks().0.iter().map(two).collect();
        let words = GraphWords {
            parts: [&packed.top, &units, bytemuck::cast_slice(&packed.slabs)],
            size: packed.size,
            top_dims: packed.top_dims,
            root_level: packed.root_level,
            nodes: source::VOXEL_PACKED,
        };
        Self::of_words(gpu, grid, &words, bias, filter)
    }

    fn of_words(
        gpu: &Gpu,
        grid: &LightGrid,
        graph: &GraphWords<'_>,
        bias: Bias,
        filter: u32,
    ) -> Result<Self> {
        let nodes = graph.parts[0].len() as u32;
        let [nx, ny, nz] = graph.top_dims;
        let params = VoxelParams {
            grid: grid_transform(grid.origin, grid.axes, grid.voxel_size, graph.size, grid.origin)?,
            top_dims: [nx, ny, nz, graph.root_level],
            places: [nodes, nodes + graph.parts[1].len() as u32, filter, 0],
            bias: bias_uniform(bias),
        };
        let words = WordBuffers::new(gpu, "voxel::words", &graph.parts)?;
        let bindings = VoxelBindings::of_words(gpu, "voxel", &params.bytes(), &words);
        Ok(Self { grid: *grid, params, bindings, nodes: graph.nodes, name: format!("voxel:filter={filter}") })
    }

    /// The same with other layers for its filter's taps.
    #[must_use]
    pub fn with_layers(mut self, gpu: &Gpu, layers: TapLayers) -> Self {
        self.params.places[3] = layers_word(layers);
        if layers == TapLayers::Block {
            self.name.push_str(":layers=block");
        }
        self.bindings.write(gpu, &self.params.bytes());
        self
    }

    /// The technique `voxel`, as [`VoxelSettings::from_spec`] reads it, but without penumbrae.
    ///
    /// # Errors
    /// As [`Voxel::of_file`]; [`crate::RenderError::Technique`] for other parameters.
    pub fn from_spec(gpu: &Gpu, spec: &TechniqueSpec, file: Option<&ShadowFile>) -> Result<Self> {
        let file =
            file.ok_or_else(|| spec.wrong("it needs a light-aligned shadow file: --shadow-file".to_owned()))?;
        let VoxelSettings { filter: HierarchyFilter::Taps(filter), layers, bias } =
            VoxelSettings::from_spec(spec, Some(file))?
        else {
            return Err(spec.wrong("penumbrae need the hierarchy itself, not its graph".to_owned()));
        };
        Ok(Self {
            name: spec.to_string(),
            ..Self::of_file(gpu, file, bias, filter)?.with_layers(gpu, layers)
        })
    }

    /// Group 1, for techniques that look up voxels beside other things.
    pub fn bindings(&self) -> &VoxelBindings {
        &self.bindings
    }

    /// The WGSL files that define `voxel_factor`, for this layout and these bindings; core/surface.wgsl goes before them.
    pub fn look_up(&self) -> [Source; 5] {
        [source::GRID, source::VOXEL, source::VOXEL_GRAPH, self.nodes, self.bindings.access()]
    }

    /// Writes the uniform for positions relative to `anchor_world`.
    ///
    /// # Errors
    /// None that [`Voxel::new`] has not given.
    pub fn set_anchor(&mut self, gpu: &Gpu, anchor_world: [f64; 3]) -> Result<()> {
        let g = &self.grid;
        let size = self.params.grid.size;
        let size = [size[0] as u32, size[1] as u32, size[2] as u32];
        self.params.grid = grid_transform(g.origin, g.axes, g.voxel_size, size, anchor_world)?;
        self.bindings.write(gpu, &self.params.bytes());
        Ok(())
    }

    /// Lit taps for receivers in fixed point: what `Query::lit_taps` answers on the CPU.
    ///
    /// # Errors
    /// What the device reports.
    pub fn lit_taps(&self, gpu: &Gpu, receivers: &[FixedReceiver]) -> Result<Vec<u32>> {
        let queries: Vec<VoxelQuery> = receivers
            .iter()
            .map(|r| {
                let [x, y, z] = r.p_fixed.map(|c| c as i32);
                VoxelQuery { p_fixed: [x, y, z, 0], gradient: [r.gradient[0], r.gradient[1], 0, 0] }
            })
            .collect();
        let mut files = vec![source::SURFACE];
        files.extend(self.look_up());
        files.extend([source::VOXEL_PASS, source::VOXEL_FIXED]);
        let answers = fixed::answer::<_, 4>(gpu, &self.bindings, &files, &queries)?;
        Ok(answers.into_iter().map(u32::from_le_bytes).collect())
    }
}

impl Technique for Voxel {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        self.set_anchor(input.gpu, input.anchor_world)
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        let pass = match answer {
            Answer::Visibility => &[source::VOXEL_PASS][..],
            Answer::Voxel => &[source::VOXEL_LEVEL, source::VOXEL_LEVEL_PASS],
            Answer::Cascade | Answer::Level => return None,
        };
        Some([&self.look_up()[..], pass].concat())
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
