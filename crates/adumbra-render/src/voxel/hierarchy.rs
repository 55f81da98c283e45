//! The technique `voxel` on a file whose layout is the hierarchy: filtered over K × K texels, or, `voxel:soft`, with the penumbrae of a
//! sun of a given size.

use std::ops::RangeInclusive;

use adumbra::hierarchy::Hierarchy;
use adumbra::light::LightGrid;
use adumbra::query::{FixedReceiver, Query, TapLayers};
use adumbra::settings::Bias;
use adumbra_shaders::constants::HIERARCHY_MAX_RADIUS;
use adumbra_shaders::layout::{HierarchyParams, VoxelParams, VoxelQuery};
use adumbra_shaders::{Source, source};

use super::soft::cone;
use super::{VoxelBindings, VoxelSettings, WordBuffers, bias_uniform, fixed, grid_transform, layers_word};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::technique::{Answer, FrameInput, Technique};

/// How a hierarchy is looked up in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HierarchyFilter {
    /// The mean over K × K texels, K of [`adumbra::query::FILTER_WIDTHS`].
    Taps(u32),
    /// Penumbrae of a sun.
    Soft {
        /// Full angle of the sun, degrees, 0.01 to 20.
        angle_degrees: f64,
        /// Most texels of a penumbra's radius, 1 to 64.
        max_radius_texels: f64,
    },
}

pub(super) const ANGLES_DEGREES: RangeInclusive<f64> = 0.01..=20.0;
pub(super) const RADII_TEXELS: RangeInclusive<f64> = 1.0..=HIERARCHY_MAX_RADIUS as f64;

impl HierarchyFilter {
    /// That a sun and its reach are what the shader can count; widths are the look-up's to check.
    fn check(self) -> adumbra::error::Result<()> {
        let Self::Soft { angle_degrees, max_radius_texels } = self else { return Ok(()) };
        for (option, value, range, words) in [
            ("angle", angle_degrees, ANGLES_DEGREES, "from 0.01 to 20 degrees"),
            ("radius", max_radius_texels, RADII_TEXELS, "from 1 to 64 texels"),
        ] {
            if !range.contains(&value) {
                return Err(adumbra::Error::OptionRange { option, value: value.to_string(), range: words });
            }
        }
        Ok(())
    }
}

/// Answers for a receiver in fixed point, of every look-up that there is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HierarchyAnswer {
    /// What `Query::lit_taps` answers on the CPU.
    pub lit_taps: u32,
    /// What [`Hierarchy::value`] answers for the receiver's column, that at the grid's border for one beside it.
    pub value: u32,
    /// What [`super::SoftTwin`] answers, the receiver's place in the list as pixel (x, 0).
    pub soft: f32,
}

/// A hierarchy on the GPU.
pub struct VoxelHierarchy {
    grid: LightGrid,
    params: HierarchyParams,
    bindings: VoxelBindings,
    filter: HierarchyFilter,
    name: String,
}

impl VoxelHierarchy {
    /// Uploads a hierarchy that is valid. Cost: the bytes of its words.
    ///
    /// # Errors
    /// [`crate::RenderError::TooLarge`], [`crate::RenderError::VoxelLimit`]; [`crate::RenderError::Library`] for another width, angle or radius.
    pub fn new(
        gpu: &Gpu,
        grid: &LightGrid,
        hierarchy: &Hierarchy,
        bias: Bias,
        filter: HierarchyFilter,
    ) -> Result<Self> {
        filter.check()?;
        let (width, sun, name) = match filter {
            HierarchyFilter::Taps(width) => (width, [0.0; 4], format!("voxel:filter={width}")),
            HierarchyFilter::Soft { angle_degrees: angle, max_radius_texels: radius } => (
                1,
                [cone(angle), radius as f32, 0.0, 0.0],
                format!("voxel:soft:angle={angle}:radius={radius}"),
            ),
        };
        Query::new(grid, hierarchy, bias, width)?;
        let wide = 2 * hierarchy.top.len() as u32;
        let [nx, ny] = hierarchy.top_dims;
        let voxel = VoxelParams {
            grid: grid_transform(grid.origin, grid.axes, grid.voxel_size, hierarchy.size, grid.origin)?,
            top_dims: [nx, ny, 1, hierarchy.root_level],
            places: [wide, wide + 2 * hierarchy.wide.len() as u32, width, 0],
            bias: bias_uniform(bias),
        };
        let params = HierarchyParams { voxel, sun };
        let parts = [hierarchy.top.as_flattened(), hierarchy.wide.as_flattened(), &hierarchy.code];
        let words = WordBuffers::new(gpu, "hierarchy::words", &parts)?;
        let bindings = VoxelBindings::of_words(gpu, "hierarchy", &params.bytes(), &words);
        Ok(Self { grid: *grid, params, bindings, filter, name })
    }

    /// The same with other layers for its filter's taps.
    #[must_use]
    pub fn with_layers(mut self, gpu: &Gpu, layers: TapLayers) -> Self {
        self.params.voxel.places[3] = layers_word(layers);
        if layers == TapLayers::Block {
            self.name.push_str(":layers=block");
        }
        self.bindings.write(gpu, &self.params.bytes());
        self
    }

    /// [`VoxelHierarchy::new`] with settings, under the name that it was called for by.
    ///
    /// # Errors
    /// As [`VoxelHierarchy::new`].
    pub fn from_settings(
        gpu: &Gpu,
        name: String,
        grid: &LightGrid,
        hierarchy: &Hierarchy,
        VoxelSettings { filter, layers, bias }: VoxelSettings,
    ) -> Result<Self> {
        Ok(Self { name, ..Self::new(gpu, grid, hierarchy, bias, filter)?.with_layers(gpu, layers) })
    }

    /// Writes the uniform for positions relative to `anchor_world`.
    ///
    /// # Errors
    /// None that [`VoxelHierarchy::new`] has not given.
    pub fn set_anchor(&mut self, gpu: &Gpu, anchor_world: [f64; 3]) -> Result<()> {
        let g = &self.grid;
        let voxel = &mut self.params.voxel;
        let [x, y, z, _] = voxel.grid.size.map(|n| n as u32);
        voxel.grid = grid_transform(g.origin, g.axes, g.voxel_size, [x, y, z], anchor_world)?;
        self.bindings.write(gpu, &self.params.bytes());
        Ok(())
    }

    /// Everything that the shaders answer for receivers in fixed point.
    ///
    /// # Errors
    /// What the device reports.
    pub fn answers(&self, gpu: &Gpu, receivers: &[FixedReceiver]) -> Result<Vec<HierarchyAnswer>> {
        let query = |r: &FixedReceiver| {
            let [x, y, z] = r.p_fixed.map(|c| c as i32);
            VoxelQuery { p_fixed: [x, y, z, 0], gradient: [r.gradient[0], r.gradient[1], 0, 0] }
        };
        let queries: Vec<VoxelQuery> = receivers.iter().map(query).collect();
        let mut files = vec![source::SURFACE];
        files.extend(self.soft_sources());
        files.push(source::HIERARCHY_FIXED);
        let answers = fixed::answer::<_, 16>(gpu, &self.bindings, &files, &queries)?;
        let read = |bytes: [u8; 16]| {
            let word =
                |i: usize| bytes[4 * i..][..4].iter().rev().fold(0, |word, &b| word << 8 | u32::from(b));
            HierarchyAnswer { lit_taps: word(0), value: word(1), soft: f32::from_bits(word(2)) }
        };
        Ok(answers.into_iter().map(read).collect())
    }

    fn soft_sources(&self) -> [Source; 7] {
        [
            source::GRID,
            source::VOXEL,
            source::HIERARCHY,
            source::DISC,
            source::HIERARCHY_SOFT,
            self.bindings.access(),
            source::HIERARCHY_SOFT_PASS,
        ]
    }
}

impl Technique for VoxelHierarchy {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        self.set_anchor(input.gpu, input.anchor_world)
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        let look_up = [source::GRID, source::VOXEL, source::HIERARCHY, self.bindings.access()];
        match (answer, self.filter) {
            (Answer::Visibility, HierarchyFilter::Taps(_)) => {
                Some([&look_up[..], &[source::HIERARCHY_PASS]].concat())
            }
            (Answer::Visibility, HierarchyFilter::Soft { .. }) => Some(self.soft_sources().to_vec()),
            (Answer::Voxel, _) => {
                Some([&look_up[..], &[source::HIERARCHY_LEVEL, source::HIERARCHY_LEVEL_PASS]].concat())
            }
            (Answer::Cascade | Answer::Level, _) => None,
        }
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
