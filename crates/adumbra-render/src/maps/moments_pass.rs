//! Moments of a layer's depth: blurred along rows, then along columns, then reduced to mip levels.
//! Counterpart of passes/moments_*.wgsl.
//!
//! Each layer is filtered separately with its border repeated, so no cascade bleeds into another.

use adumbra_shaders::constants::PIXEL_GROUP;
use adumbra_shaders::layout::{Array, MomentBlurParams};
use adumbra_shaders::{Source, assemble, source};
use wgpu::{BindingResource, ShaderStages, TextureFormat};

use super::params::{MomentKind, MomentSettings};
use super::textures::{DepthTextures, MomentTextures};
use crate::error::Result;
use crate::gpu::{Gpu, binding};

/// The passes and the textures that they fill.
pub(super) struct MomentsPass {
    pub(super) textures: MomentTextures,
    rows: wgpu::ComputePipeline,
    columns: wgpu::ComputePipeline,
    mip: wgpu::ComputePipeline,
    /// By layer: rows, columns, then one group per further mip level.
    groups: Vec<Vec<wgpu::BindGroup>>,
}

/// The WGSL file that defines this kind of moments.
pub(super) fn kind_source(kind: MomentKind) -> Source {
    match kind {
        MomentKind::Variance => source::VSM,
        MomentKind::ExponentialVariance => source::EVSM,
        MomentKind::FourMoments => source::MSM,
    }
}

/// The texture format of this kind of moments.
fn kind_format(kind: MomentKind) -> TextureFormat {
    match kind {
        MomentKind::Variance => TextureFormat::Rg32Float,
        MomentKind::ExponentialVariance | MomentKind::FourMoments => TextureFormat::Rgba32Float,
    }
}

/// Weights of a Gaussian `width` texels wide, from the middle outwards. Its standard deviation is a fifth of
/// the width.
pub fn gaussian(width: u32) -> Vec<f32> {
    let deviation = 0.2 * f64::from(width);
    let weight = |i: u32| libm::exp(-0.5 * (f64::from(i) / deviation) * (f64::from(i) / deviation));
    let weights: Vec<f64> = (0..=width / 2).map(weight).collect();
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    weights.iter().map(|w| (w / sum) as f32).collect()
}

impl MomentsPass {
    pub(super) fn new(
        gpu: &Gpu,
        settings: &MomentSettings,
        depth: &DepthTextures,
        size: u32,
    ) -> Result<Self> {
        let format = kind_format(settings.kind);
        let layer_count = depth.layers.len() as u32;
        let textures = MomentTextures::new(gpu, format, size, layer_count)?;
        let kind = kind_source(settings.kind);
        let common = [source::SURFACE, source::MAP_LAYER, source::MAPS, source::MOMENTS, kind];
        let stage = ShaderStages::COMPUTE;
        let written = binding::written(format);
        let rows_layout =
            gpu.layout("moments_rows", stage, &[binding::UNIFORM, binding::DEPTH_ARRAY, written]);
        let columns_layout =
            gpu.layout("moments_columns", stage, &[binding::UNIFORM, binding::LOADED, written]);
        let mip_layout = gpu.layout("moments_mip", stage, &[binding::LOADED, written]);
        let pipeline = |passes: &[Source], entry, layout| {
            gpu.compute(entry, assemble(&[&common[..], passes].concat()), entry, &[Some(layout)])
        };
        let weights = gaussian(settings.blur);
        let groups = (0..layer_count).map(|layer| {
            let uniform = gpu.uniform("moments", &blur_params(settings, &weights, layer, size).bytes());
            let view = BindingResource::TextureView;
            let levels = &textures.levels[layer as usize];
            let rows = &textures.rows.view;
            let first = vec![uniform.as_entire_binding(), view(&depth.all.view), view(rows)];
            let second = vec![uniform.as_entire_binding(), view(rows), view(&levels[0])];
            let mut groups = vec![
                gpu.bind("moments_rows", &rows_layout, first),
                gpu.bind("moments_columns", &columns_layout, second),
            ];
            for pair in levels.windows(2) {
                groups.push(gpu.bind("moments_mip", &mip_layout, vec![view(&pair[0]), view(&pair[1])]));
            }
            groups
        });
        Ok(Self {
            groups: groups.collect(),
            rows: pipeline(&[source::MOMENTS_LINE, source::MOMENTS_ROWS], "moments_rows", &rows_layout),
            columns: pipeline(
                &[source::MOMENTS_LINE, source::MOMENTS_COLUMNS],
                "moments_columns",
                &columns_layout,
            ),
            mip: pipeline(&[source::MOMENTS_MIP], "moments_mip", &mip_layout),
            textures,
        })
    }

    /// Number of mip levels.
    pub(super) fn levels(&self) -> u32 {
        self.textures.all.texture.mip_level_count()
    }

    /// Encodes the passes that fill one layer from its depth.
    pub(super) fn encode(&self, encoder: &mut wgpu::CommandEncoder, layer: usize) {
        let size = self.textures.all.texture.width();
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (step, group) in self.groups[layer].iter().enumerate() {
            let (pipeline, side) = match step {
                0 => (&self.rows, size),
                1 => (&self.columns, size),
                level => (&self.mip, size >> (level - 1)),
            };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(side.div_ceil(PIXEL_GROUP), side.div_ceil(PIXEL_GROUP), 1);
        }
    }
}

fn blur_params(settings: &MomentSettings, weights: &[f32], layer: u32, size: u32) -> MomentBlurParams {
    let weight = |i: usize| weights.get(i).copied().unwrap_or(0.0);
    MomentBlurParams {
        weights: Array(std::array::from_fn(|row| std::array::from_fn(|c| weight(4 * row + c)))),
        exponents: settings.exponents.map(|e| e as f32),
        layer,
        side_texels: size,
        taps_per_side: weights.len() as u32 - 1,
    }
}
