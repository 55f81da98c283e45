//! The shadow-map technique: every fit with every filter.
//!
//! Bind group 2, for filters that compare: parameters, depth, a comparison sampler, a gather sampler. For
//! moments: parameters, moments, and a filtering sampler if the device filters 32-bit floats.

use std::any::Any;

use adumbra::{LightExtent, Sun};
use adumbra_shaders::layout::{Array, MapLayer, MapParams, MomentParams};
use adumbra_shaders::{Source, source};
use wgpu::{BindingResource, BindingType, Features, FilterMode, SamplerBindingType, ShaderStages};

use super::cascades::{ENDLESS, LayerFit, cascade_layers, depth_range, reach, scene_layer};
use super::depth_pass::{DepthPass, DepthPassOptions};
use super::layers::Layer;
use super::moments_pass::{MomentsPass, kind_source};
use super::params::{MapCasters, MapFilter, MapFit, MapSettings};
use super::textures::DepthTextures;
use crate::error::Result;
use crate::gpu::{Gpu, binding};
use crate::technique::{Answer, FrameInput, Technique};

/// A shadow map on one device.
pub struct ShadowMap {
    name: String,
    settings: MapSettings,
    params: MapParams,
    uniform: wgpu::Buffer,
    depth: DepthTextures,
    kept: Option<DepthTextures>,
    layers: Vec<Layer>,
    pass: DepthPass,
    moments: Option<MomentsPass>,
    filtering: bool,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

impl ShadowMap {
    /// Creates the textures and pipelines for these settings, which are assumed to be in range.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::TooLarge`] if the device does not support the size.
    pub fn new(gpu: &Gpu, name: &str, settings: MapSettings) -> Result<Self> {
        let (size, count) = (settings.size, settings.layers());
        let options = DepthPassOptions { format: settings.depth.format(), normals: false };
        let depth = DepthTextures::new(gpu, "map::depth", size, count, options)?;
        let keeps = settings.cache_static && settings.casters == MapCasters::All;
        let kept =
            if keeps { Some(DepthTextures::new(gpu, "map::kept", size, count, options)?) } else { None };
        let moments = match &settings.filter {
            MapFilter::Moments(m) => Some(MomentsPass::new(gpu, m, &depth, size)?),
            _ => None,
        };
        let filtering = gpu.has(Features::FLOAT32_FILTERABLE);
        let pass = DepthPass::new(gpu, options);
        let mut params = filter_params(&settings);
        params.mip_levels = moments.as_ref().map_or(1.0, |m| m.levels() as f32);
        let uniform = gpu.uniform("map::params", &params.bytes());
        let (layout, group) = look_up_group(gpu, &uniform, &depth, moments.as_ref(), filtering);
        let layers = (0..count).map(|_| Layer::new(gpu, &pass)).collect();
        let name = name.to_owned();
        Ok(Self {
            name,
            settings,
            params,
            uniform,
            depth,
            kept,
            layers,
            pass,
            moments,
            filtering,
            layout,
            group,
        })
    }

    /// The parameters of the last frame.
    pub fn params(&self) -> &MapParams {
        &self.params
    }

    /// The settings that the map was created with.
    pub fn settings(&self) -> &MapSettings {
        &self.settings
    }

    /// The depth texture, with one array layer per map layer.
    pub fn depth_texture(&self) -> &wgpu::Texture {
        &self.depth.all.texture
    }

    /// The moments texture, with one array layer per map layer and with mip levels. `None` for other filters.
    pub(crate) fn moments_texture(&self) -> Option<&wgpu::Texture> {
        self.moments.as_ref().map(|m| &m.textures.all.texture)
    }

    /// Whether look-ups of moments read mip levels through the sampler.
    pub(crate) fn is_filtering(&self) -> bool {
        self.filtering
    }

    /// The WGSL files that define `map_visibility` for bind group 2, with everything they need except
    /// core/surface.wgsl.
    pub fn visibility_sources(&self) -> Vec<Source> {
        let mut files = vec![source::MAP_LAYER, source::MAPS];
        match &self.settings.filter {
            MapFilter::Nearest => files.extend([source::DISC, source::PCF, source::MAP_NEAREST]),
            MapFilter::Pcf { width: 2 } => files.extend([source::DISC, source::PCF, source::MAP_HARDWARE]),
            MapFilter::Pcf { .. } => files.extend([source::DISC, source::PCF, source::MAP_PCF]),
            MapFilter::Poisson { .. } => files.extend([source::DISC, source::PCF, source::MAP_POISSON]),
            MapFilter::Pcss { .. } => {
                files.extend([source::DISC, source::PCF, source::PCSS, source::MAP_PCSS]);
            }
            MapFilter::Moments(m) => {
                let look_up = if self.filtering { source::MAP_MOMENTS } else { source::MAP_MOMENTS_LOADED };
                files.extend([source::MOMENTS, kind_source(m.kind), look_up]);
            }
        }
        files.push(source::MAP_LOOKUP);
        files
    }

    /// Returns this frame's layers, and the view depths between which shadows fade to lit.
    fn fit(&self, input: &FrameInput<'_>) -> Result<(Vec<LayerFit>, [f64; 2])> {
        let margin = self.settings.filter.reach_texels() + self.settings.bias.normal_offset_texels;
        let scene = scene_fit(input, self.settings.size, margin)?;
        let MapFit::Cascades(cascades) = &self.settings.fit else {
            return Ok((vec![scene], [ENDLESS; 2]));
        };
        // Bounds of the static scene: splits do not follow movers unless there is nothing else.
        let still = input.scene.bounds();
        let bounds = if still.min[0] <= still.max[0] { still } else { input.bounds };
        let far = reach(input.view, &bounds, cascades.far_world);
        // Penumbrae depend on a caster's distance, so PCSS cannot clamp casters onto the near plane.
        let presses = input.gpu.has(Features::DEPTH_CLIP_CONTROL)
            && !matches!(self.settings.filter, MapFilter::Pcss { .. });
        let layers = cascade_layers(input.view, &scene, cascades, far, margin, presses);
        let last = layers.last().map_or([ENDLESS; 2], |l| l.end);
        Ok((layers, [last[1], last[0]]))
    }
}

impl dyn Technique + '_ {
    /// Returns the technique's shadow map, if it has one, for reading back.
    pub fn map(&self) -> Option<&ShadowMap> {
        self.readable()?.downcast_ref()
    }
}

impl Technique for ShadowMap {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        let (fits, fade) = self.fit(input)?;
        self.params.layer_count = fits.len() as u32;
        let static_casters = self.settings.casters == MapCasters::All;
        for (layer, fit) in self.layers.iter_mut().zip(&fits) {
            layer.prepare(input, fit, static_casters, self.kept.is_some());
        }
        for (layer, fit) in self.params.layers.0.iter_mut().zip(&fits) {
            *layer = fit.layer(input.anchor_world);
        }
        self.params.fade_view_depth = fade[0] as f32;
        self.params.fade_end_view_depth = fade[1] as f32;
        let pixel = 2.0 * input.view.half[1] / f64::from(input.camera.height);
        let [fixed, growing] = if input.view.orthographic { [pixel, 0.0] } else { [0.0, pixel] };
        self.params.pixel_world = fixed as f32;
        self.params.pixel_world_per_depth = growing as f32;
        input.gpu.queue.write_buffer(&self.uniform, 0, &self.params.bytes());
        Ok(())
    }

    fn encode_depth(&mut self, input: &FrameInput<'_>, encoder: &mut wgpu::CommandEncoder) {
        let used = self.params.layer_count as usize;
        for (index, layer) in self.layers[..used].iter_mut().enumerate() {
            let changed = layer.encode(input, &self.pass, encoder, index, &self.depth, self.kept.as_ref());
            if let (true, Some(moments)) = (changed, &self.moments) {
                moments.encode(encoder, index);
            }
        }
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        Some(match answer {
            Answer::Cascade => vec![source::MAP_CASCADE],
            Answer::Level | Answer::Voxel | Answer::Resident => return None,
            Answer::Visibility => self.visibility_sources().into_iter().chain([source::MAP_ONLY]).collect(),
        })
    }

    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        [None, Some(&self.layout)]
    }

    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        [None, Some(&self.group)]
    }

    fn texel_world(&self, view_depth: f32) -> Option<f64> {
        let layers = &self.params.layers.0[..self.params.layer_count as usize];
        let layer = layers.iter().find(|l| view_depth < l.end_view_depth).or(layers.last());
        layer.map(|l| f64::from(l.texel_world))
    }

    fn bytes(&self) -> u64 {
        let lists: u64 = self.layers.iter().map(Layer::bytes).sum();
        let kept = self.kept.as_ref().map_or(0, DepthTextures::bytes);
        let moments = self.moments.as_ref().map_or(0, |m| m.textures.bytes());
        self.depth.bytes() + kept + moments + lists + self.uniform.size()
    }

    fn readable(&self) -> Option<&dyn Any> {
        Some(self)
    }

    fn notes(&self) -> Vec<String> {
        if self.moments.is_some() && !self.filtering {
            return vec![format!(
                "{}: moments are interpolated in the shader, without mip levels",
                self.name
            )];
        }
        Vec::new()
    }
}

/// Fits one layer over all static casters, with `margin` texels on every side.
///
/// # Errors
/// Returns an error if the direction towards the sun is invalid.
pub(crate) fn scene_fit(input: &FrameInput<'_>, size: u32, margin: f64) -> Result<LayerFit> {
    let sun = Sun::from_direction(input.towards_sun)?;
    let (still, all) = extents(input, &sun);
    let clipped = !input.gpu.has(Features::DEPTH_CLIP_CONTROL);
    let depth = depth_range(&still, clipped.then_some(&all));
    Ok(scene_layer(&still, depth, input.scene.lattice_world(), size, margin))
}

/// Extents of the static casters and of everything, in light space. Without static casters, both cover
/// everything. In an empty scene, both are a point.
fn extents(input: &FrameInput<'_>, sun: &Sun) -> (LightExtent, LightExtent) {
    let is_empty = |e: &LightExtent| !(e.min[0] <= e.max[0]);
    let still = input.scene.light_extent(sun);
    let mut all = still;
    if input.bounds.min[0] <= input.bounds.max[0] {
        all.add_box(&input.bounds);
    }
    if is_empty(&all) {
        all.add(input.anchor_world);
    }
    (if is_empty(&still) { all } else { still }, all)
}

/// Returns the parameters. Those that change from frame to frame get placeholders.
fn filter_params(settings: &MapSettings) -> MapParams {
    let (mut width, mut taps, mut half_tangent, mut radius) = (1, 1, 0.0, 0.0);
    let mut moments = MomentParams { exponents: [0.0; 2], min_deviation_texels: 0.0, bleed: 0.0 };
    match settings.filter {
        MapFilter::Nearest => {}
        MapFilter::Pcf { width: w } => width = w,
        MapFilter::Poisson { radius: r } => (taps, radius) = (16, r),
        MapFilter::Pcss { sun_degrees, max_radius } => {
            (taps, radius) = (32, max_radius);
            half_tangent = libm::tan(0.5 * sun_degrees.to_radians());
        }
        MapFilter::Moments(m) => {
            width = m.blur;
            moments = MomentParams {
                exponents: m.exponents.map(|e| e as f32),
                min_deviation_texels: m.min_deviation_texels as f32,
                bleed: m.bleed as f32,
            };
        }
    }
    MapParams {
        layers: Array([MapLayer::EMPTY; 8]),
        bias: settings.bias.uniform(&settings.filter),
        moments,
        layer_count: settings.layers(),
        side_texels: settings.size,
        filter_width: width,
        tap_count: taps,
        max_radius_texels: radius as f32,
        sun_tangent: half_tangent as f32,
        fade_view_depth: 0.0,
        fade_end_view_depth: 0.0,
        min_bias_depth: settings.depth.min_bias_depth() as f32,
        pixel_world: 0.0,
        pixel_world_per_depth: 0.0,
        mip_levels: 0.0,
    }
}

fn look_up_group(
    gpu: &Gpu,
    uniform: &wgpu::Buffer,
    depth: &DepthTextures,
    moments: Option<&MomentsPass>,
    filtering: bool,
) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let sampler = |filter, compare: Option<wgpu::CompareFunction>| {
        gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("map"),
            mag_filter: filter,
            min_filter: filter,
            mipmap_filter: if compare.is_none() && filter == FilterMode::Linear {
                wgpu::MipmapFilterMode::Linear
            } else {
                wgpu::MipmapFilterMode::Nearest
            },
            compare,
            ..Default::default()
        })
    };
    let comparing = sampler(FilterMode::Linear, Some(wgpu::CompareFunction::LessEqual));
    let gathering = sampler(FilterMode::Nearest, None);
    let smooth = sampler(FilterMode::Linear, None);
    let mut kinds = vec![binding::UNIFORM];
    let mut resources = vec![uniform.as_entire_binding()];
    let mut bind = |kind: BindingType, resource| {
        kinds.push(kind);
        resources.push(resource);
    };
    match moments {
        Some(moments) => {
            let view = BindingResource::TextureView(&moments.textures.all.view);
            bind(if filtering { binding::SAMPLED_ARRAY } else { binding::LOADED_ARRAY }, view);
            if filtering {
                bind(binding::SAMPLER, BindingResource::Sampler(&smooth));
            }
        }
        None => {
            bind(binding::DEPTH_ARRAY, BindingResource::TextureView(&depth.all.view));
            bind(binding::COMPARISON, BindingResource::Sampler(&comparing));
            let plain = BindingType::Sampler(SamplerBindingType::NonFiltering);
            bind(plain, BindingResource::Sampler(&gathering));
        }
    }
    let layout = gpu.layout("map", ShaderStages::COMPUTE, &kinds);
    let group = gpu.bind("map", &layout, resources);
    (layout, group)
}
