//! The techniques `voxel-cubes` and `voxel-texture`: a world-aligned tree, filtered over 1, 3³ or 5³ cells.

use adumbra::format::{TreeBody, TreeFile};
use adumbra::query::{PlanLevels, TreeQuery, TreeReceiver, Weights};
use adumbra::settings::Bias;
use adumbra::tree::{TreeSpace, VoxelTree};
use adumbra_shaders::constants::MAX_PLAN_REGIONS;
use adumbra_shaders::layout::{Array, CubesParams, CubesPlan, CubesQuery, CubesUniform};
use adumbra_shaders::{Source, source};

use super::{PageTexture, VoxelBindings, WordBuffers, bias_uniform, fixed, grid_transform};
use crate::error::{RenderError, Result};
use crate::gpu::Gpu;
use crate::technique::{Answer, FrameInput, Technique, TechniqueSpec};

/// Where the words are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CubesStore {
    /// Storage buffers.
    Words,
    /// The texels of an RGBA8 texture.
    Texels,
    /// Storage buffers that were decoded from such a texture at load.
    Decoded,
}

/// How a tree is looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubesOptions {
    /// In cells.
    pub bias: Bias,
    /// One of [`adumbra::query::KERNEL_SIDES`].
    pub filter: u32,
    /// Of the taps.
    pub weights: Weights,
    /// Taps behind the receiver's plane count too.
    pub all_taps: bool,
    /// Where the words are read from.
    pub store: CubesStore,
}

impl CubesOptions {
    /// As a technique is called for with these options, but for the bias.
    fn name(&self) -> String {
        let weights = match self.weights {
            Weights::Mean => "mean",
            Weights::Poisson => "poisson",
        };
        let (name, read) = match self.store {
            CubesStore::Words => ("voxel-cubes", ""),
            CubesStore::Texels => ("voxel-texture", ""),
            CubesStore::Decoded => ("voxel-texture", ":read=buffer"),
        };
        let taps = if self.all_taps { ":taps=all" } else { "" };
        format!("{name}:filter={}:weights={weights}{taps}{read}", self.filter)
    }
}

/// A tree on the GPU.
pub struct Cubes {
    space: TreeSpace,
    uniform: CubesUniform,
    bindings: VoxelBindings,
    name: String,
    /// Edge of the coarsest cells, world units.
    cell_world: f64,
}

impl Cubes {
    /// Uploads a file's tree; a symmetric one as the words that it stands for. Cost: the bytes of the words.
    ///
    /// # Errors
    /// [`RenderError::VoxelLimit`] for more than [`MAX_PLAN_REGIONS`] regions; [`RenderError::TooLarge`], [`RenderError::Pages`];
    /// [`RenderError::Library`] for another kernel.
    pub fn new(gpu: &Gpu, file: &TreeFile, options: CubesOptions) -> Result<Self> {
        let decoded;
        let tree: &VoxelTree = match &file.body {
            TreeBody::Words(tree) => tree,
            TreeBody::Symmetric(tree) => {
                decoded = tree.to_tree()?;
                &decoded
            }
        };
        let CubesOptions { bias, filter, weights, .. } = options;
        TreeQuery::new(&file.space, &file.regions, &file.sun, tree, bias, filter, weights)?;
        let sun = file.sun.towards();
        let levels = [file.space.depth, file.space.depth - file.regions.base_depth];
        let packed = (0..3).map(|d| weights.along_axis(d) << (4 * d)).sum();
        let plan_levels = PlanLevels::new(&file.space, &file.regions);
        let uniform = CubesUniform {
            params: CubesParams {
                grid: transform(&file.space, file.space.p_min)?,
                towards_sun: [sun[0] as f32, sun[1] as f32, sun[2] as f32, 0.0],
                bias: bias_uniform(bias),
                kernel: [levels[0], levels[1], filter / 2, packed],
                taps: [options.all_taps.into(), 0, 0, 0],
            },
            plan: plan(&plan_levels)?,
        };
        let bytes = uniform.bytes();
        let bindings = match options.store {
            CubesStore::Words => {
                let words = WordBuffers::new(gpu, "voxel-cubes::words", &[tree.words()])?;
                VoxelBindings::of_words(gpu, "voxel-cubes", &bytes, &words)
            }
            CubesStore::Texels => {
                let pages = PageTexture::of_words(gpu, tree.words())?;
                VoxelBindings::of_texture(gpu, "voxel-texture", &bytes, &pages)
            }
            CubesStore::Decoded => {
                let pages = PageTexture::of_words(gpu, tree.words())?;
                let words = pages.decode(gpu, tree.words().len() as u64)?;
                VoxelBindings::of_words(gpu, "voxel-texture", &bytes, &words)
            }
        };
        let coarsest = plan_levels.levels().iter().copied().max().unwrap_or(0);
        let cell_world = file.space.voxel_size * f64::from(coarsest).exp2();
        Ok(Self { space: file.space, uniform, bindings, name: options.name(), cell_world })
    }

    /// The technique `voxel-cubes` or `voxel-texture`, as [`CubesOptions::from_spec`] reads it.
    ///
    /// # Errors
    /// As [`Cubes::new`]; [`RenderError::Technique`] for other parameters.
    pub fn from_spec(gpu: &Gpu, spec: &TechniqueSpec, file: Option<&TreeFile>) -> Result<Self> {
        let file =
            file.ok_or_else(|| spec.wrong("it needs a world-aligned shadow file: --shadow-file".to_owned()))?;
        let options = CubesOptions::from_spec(spec, Some(file))?;
        Ok(Self { name: spec.to_string(), ..Self::new(gpu, file, options)? })
    }

    /// Group 1, for techniques that look up a tree beside other things.
    pub fn bindings(&self) -> &VoxelBindings {
        &self.bindings
    }

    /// Writes the uniform for positions relative to `anchor_world`.
    ///
    /// # Errors
    /// None that [`Cubes::new`] has not given.
    pub fn set_anchor(&mut self, gpu: &Gpu, anchor_world: [f64; 3]) -> Result<()> {
        self.uniform.params.grid = transform(&self.space, anchor_world)?;
        self.bindings.write(gpu, &self.uniform.bytes());
        Ok(())
    }

    /// Weights of the lit taps and of all that count, for receivers in fixed point: the quotients are exactly those of
    /// `TreeQuery::lit_weights` on the CPU. Where the kernel lies in one leaf both are divided by the weights: 0 or 1, and 1.
    ///
    /// # Errors
    /// What the device reports.
    pub fn lit_weights(&self, gpu: &Gpu, receivers: &[TreeReceiver]) -> Result<Vec<[u32; 2]>> {
        let queries: Vec<CubesQuery> = receivers
            .iter()
            .map(|r| {
                let ([x, y, z], [nx, ny, nz]) = (r.p_fixed, r.normal);
                CubesQuery { p_fixed: [x, y, z, r.level as i32], normal: [nx, ny, nz, r.height] }
            })
            .collect();
        let mut files = vec![source::SURFACE];
        files.extend(self.look_up());
        files.extend([source::VOXEL_CUBES_PASS, source::VOXEL_CUBES_FIXED]);
        let answers = fixed::answer::<_, 8>(gpu, &self.bindings, &files, &queries)?;
        Ok(answers
            .into_iter()
            .map(|b| [0, 4].map(|i| u32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]])))
            .collect())
    }

    fn look_up(&self) -> [Source; 5] {
        [
            source::GRID,
            source::VOXEL_CUBES,
            source::VOXEL_CUBES_RECEIVER,
            self.bindings.access(),
            source::VOXEL_CUBES_MAP,
        ]
    }
}

fn transform(space: &TreeSpace, anchor_world: [f64; 3]) -> Result<adumbra_shaders::layout::GridTransform> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    grid_transform(space.p_min, axes, space.voxel_size, [space.side_voxels(); 3], anchor_world)
}

fn plan(plan: &PlanLevels) -> Result<CubesPlan> {
    let edges = plan.edges();
    let most = 2 * MAX_PLAN_REGIONS as usize;
    let longest = edges[0].len().max(edges[1].len());
    if longest > most {
        return Err(RenderError::VoxelLimit {
            what: "the number of regions",
            // Two edges a region.
            value: longest.div_ceil(2) as u64,
            limit: MAX_PLAN_REGIONS.into(),
            mend: "bake with fewer regions",
        });
    }
    let at = |edges: &[u32], i: usize| edges.get(i).map_or(0, |&e| e as i32);
    let pack = |edges: &[u32]| Array(std::array::from_fn(|i| std::array::from_fn(|k| at(edges, 4 * i + k))));
    let word = |i: usize| {
        let levels = plan.levels().iter().skip(8 * i).take(8);
        levels.zip(0..).map(|(&level, k)| u32::from(level) << (4 * k)).sum::<u32>()
    };
    Ok(CubesPlan {
        counts: [edges[0].len() as u32, edges[1].len() as u32, 0, 0],
        edges_x: pack(edges[0]),
        edges_z: pack(edges[1]),
        levels: Array(std::array::from_fn(|i| std::array::from_fn(|k| word(4 * i + k)))),
    })
}

impl Technique for Cubes {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        self.set_anchor(input.gpu, input.anchor_world)
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        let pass = match answer {
            Answer::Visibility => &[source::VOXEL_CUBES_PASS][..],
            Answer::Voxel => &[source::VOXEL_CUBES_LEVEL, source::VOXEL_CUBES_LEVEL_PASS],
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
        Some(self.cell_world)
    }

    fn voxel_world(&self) -> Option<f64> {
        Some(self.space.voxel_size)
    }

    fn bytes(&self) -> u64 {
        self.bindings.bytes()
    }
}
