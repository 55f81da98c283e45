//! The techniques `voxel-cubes` and `voxel-texture`: a world-aligned tree, filtered over 1, 3³ or 5³ cells.

use adumbra::gpu::GridParameters;
use adumbra::{Frame, LightGrid, Sun};
use adumbra_render::technique::{Answer, FrameInput, SpecText, Technique};
use adumbra_render::voxel::{VoxelBindings, WordBuffers, bias_uniform, fixed, grid_transform};
use adumbra_render::{Fix, Gpu, RenderError, Result};
use adumbra_shaders::layout::{Array, GridTransform};
use adumbra_shaders::{Source, source};

use super::options::{CubesOptions, CubesStore};
use super::pages::PageTexture;
use super::shaders::{self, CubesParams, CubesPlan, CubesQuery, CubesUniform, MAX_PLAN_REGIONS};
use crate::tree::query::{PlanLevels, TreeQuery, TreeReceiver};
use crate::tree::{TreeBody, TreeFile, TreeSpace, VoxelTree};

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
    /// Uploads a file's tree. A symmetric tree is expanded to plain words first. Cost: the bytes of the
    /// words.
    ///
    /// # Errors
    /// Returns [`RenderError::VoxelLimit`] if there are more than [`MAX_PLAN_REGIONS`] regions,
    /// [`RenderError::TooLarge`] or [`RenderError::Other`] if the words cannot be stored, and
    /// [`RenderError::Library`] if the kernel does not exist.
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
        let tap_weights = (0..3).map(|d| weights.along_axis(d) << (4 * d)).sum();
        let plan_levels = PlanLevels::new(&file.space, &file.regions);
        let uniform = CubesUniform {
            params: CubesParams {
                grid: transform(&file.space, file.space.p_min)?,
                towards_sun: sun.map(|c| c as f32),
                bias: bias_uniform(bias),
                depth: file.space.depth,
                base_level: file.space.depth - file.regions.base_depth,
                reach: filter / 2,
                tap_weights,
                counts_all_taps: options.all_taps.into(),
            },
            plan: plan(&plan_levels)?,
        };
        let bytes = uniform.bytes();
        let bindings = match options.store {
            CubesStore::Words => {
                let words = WordBuffers::new(gpu, "voxel-cubes::words", &[tree.words()])?;
                VoxelBindings::from_words(gpu, "voxel-cubes", &bytes, &words)
            }
            CubesStore::Texels => {
                let pages = PageTexture::from_words(gpu, tree.words())?;
                VoxelBindings::from_texture(
                    gpu,
                    "voxel-texture",
                    &bytes,
                    (pages.access(), pages.bytes()),
                    (PageTexture::BINDING, pages.view()),
                )
            }
            CubesStore::Decoded => {
                let pages = PageTexture::from_words(gpu, tree.words())?;
                let words = pages.decode(gpu, tree.words().len() as u64)?;
                VoxelBindings::from_words(gpu, "voxel-texture", &bytes, &words)
            }
        };
        let coarsest = plan_levels.levels().iter().copied().max().unwrap_or(0);
        let cell_world = file.space.voxel_size * f64::from(coarsest).exp2();
        Ok(Self { space: file.space, uniform, bindings, name: options.name(), cell_world })
    }

    /// Creates the technique `voxel-cubes`, or `voxel-texture` with `from_texture`.
    ///
    /// # Errors
    /// Returns the errors of [`Cubes::new`], and [`RenderError::Technique`] if a parameter is unknown or
    /// there is no file.
    pub(crate) fn from_spec(
        gpu: &Gpu,
        spec: &SpecText,
        file: Option<&TreeFile>,
        from_texture: bool,
    ) -> Result<Self> {
        let file = file.ok_or_else(|| spec.wrong("it needs a world-aligned shadow file".to_owned()))?;
        let options = spec.read(|reader| CubesOptions::from_reader(reader, Some(file), from_texture))?;
        Ok(Self { name: spec.to_string(), ..Self::new(gpu, file, options)? })
    }

    /// Bind group 1, for techniques that combine a tree with other look-ups.
    pub fn bindings(&self) -> &VoxelBindings {
        &self.bindings
    }

    /// Writes the uniform for positions relative to `anchor_world`.
    ///
    /// # Errors
    /// Returns no error that [`Cubes::new`] would not have returned.
    pub fn set_anchor(&mut self, gpu: &Gpu, anchor_world: [f64; 3]) -> Result<()> {
        self.uniform.params.grid = transform(&self.space, anchor_world)?;
        self.bindings.write(gpu, &self.uniform.bytes());
        Ok(())
    }

    /// Returns the weights of the lit taps and of all counted taps, for receivers in fixed point. Their
    /// quotients are exactly those of `TreeQuery::lit_weights` on the CPU. If the kernel is within one leaf,
    /// the result is 0 or 1 of a total of 1.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn lit_weights(&self, gpu: &Gpu, receivers: &[TreeReceiver]) -> Result<Vec<[u32; 2]>> {
        let queries: Vec<CubesQuery> = receivers
            .iter()
            .map(|r| CubesQuery { p_fixed: r.p_fixed, level: r.level, normal: r.normal, height: r.height })
            .collect();
        let mut files = vec![source::SURFACE];
        files.extend(self.look_up());
        files.extend([shaders::CUBES_PASS, shaders::CUBES_FIXED]);
        let answers = fixed::answer::<_, 8>(gpu, &self.bindings, &files, &queries)?;
        Ok(answers
            .into_iter()
            .map(|b| [0, 4].map(|i| u32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]])))
            .collect())
    }

    fn look_up(&self) -> [Source; 6] {
        [
            shaders::tree_declarations(),
            source::GRID,
            shaders::CUBES,
            shaders::CUBES_RECEIVER,
            self.bindings.access(),
            shaders::CUBES_MAP,
        ]
    }
}

/// Returns the transform for a cube whose axes are the world's.
fn transform(space: &TreeSpace, anchor_world: [f64; 3]) -> Result<GridTransform> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let cube = LightGrid {
        // Neither the sun nor the frame is used.
        sun: Sun::from_direction([0.0, 1.0, 0.0])?,
        frame: Frame::Light,
        voxel_size: space.voxel_size,
        corner: [0.0; 3],
        axes,
        edges: axes,
        size: [space.side_voxels(); 3],
    };
    // Subtracted first, as in `TreeSpace::to_tree`, which rounds least far from the origin.
    let anchor = std::array::from_fn(|axis| anchor_world[axis] - space.p_min[axis]);
    Ok(grid_transform(&GridParameters::new(&cube, anchor)?))
}

fn plan(plan: &PlanLevels) -> Result<CubesPlan> {
    let edges = plan.edges();
    let max_edges = 2 * MAX_PLAN_REGIONS as usize;
    let longest = edges[0].len().max(edges[1].len());
    if longest > max_edges {
        return Err(RenderError::VoxelLimit {
            what: "the number of regions",
            // Two edges per region.
            value: longest.div_ceil(2) as u64,
            limit: MAX_PLAN_REGIONS.into(),
            fix: Fix::Other("bake with fewer regions"),
        });
    }
    let at = |edges: &[u32], i: usize| edges.get(i).map_or(0, |&e| e as i32);
    let pack = |edges: &[u32]| Array(std::array::from_fn(|i| std::array::from_fn(|k| at(edges, 4 * i + k))));
    let word = |i: usize| {
        let levels = plan.levels().iter().skip(8 * i).take(8);
        levels.zip(0..).map(|(&level, k)| u32::from(level) << (4 * k)).sum::<u32>()
    };
    Ok(CubesPlan {
        edges_x: pack(edges[0]),
        edges_z: pack(edges[1]),
        levels: Array(std::array::from_fn(|i| std::array::from_fn(|k| word(4 * i + k)))),
        edge_count_x: edges[0].len() as u32,
        edge_count_z: edges[1].len() as u32,
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
            Answer::Visibility => &[shaders::CUBES_PASS][..],
            Answer::Voxel => &[shaders::CUBES_LEVEL, shaders::CUBES_LEVEL_PASS],
            Answer::Cascade | Answer::Level | Answer::Resident => return None,
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
