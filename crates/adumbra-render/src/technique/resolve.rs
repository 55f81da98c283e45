//! The look-up: runs a technique's `adumbra_shadow_factor` for every pixel or for every point of a list.

use adumbra_shaders::constants::{LIST_GROUP, PIXEL_GROUP};
use adumbra_shaders::layout::{GpuType, PointQuery};
use adumbra_shaders::{assemble, source};
use wgpu::{BindGroupLayout, BufferUsages, ShaderStages};

use super::{Answer, Technique};
use crate::error::{RenderError, Result};
use crate::frame::{FACTOR_FORMAT, Targets};
use crate::gpu::{Gpu, binding};
use crate::readback::read_buffer;

/// Maximum bytes of points in one dispatch.
const MAX_BYTES: u64 = 1 << 27;
/// Maximum number of workgroups in one dispatch.
const MAX_GROUPS: usize = 65535;

/// Bind group layouts that all look-ups share.
pub struct Resolver {
    pixels: BindGroupLayout,
    points: BindGroupLayout,
}

/// Look-up pipelines of one technique.
pub struct Lookup {
    pixels: Option<wgpu::ComputePipeline>,
    cascades: Option<wgpu::ComputePipeline>,
    levels: Option<wgpu::ComputePipeline>,
    voxels: Option<wgpu::ComputePipeline>,
    residents: Option<wgpu::ComputePipeline>,
    points: Option<wgpu::ComputePipeline>,
}

impl Lookup {
    fn pipeline(&self, answer: Answer) -> Option<&wgpu::ComputePipeline> {
        match answer {
            Answer::Visibility => self.pixels.as_ref(),
            Answer::Cascade => self.cascades.as_ref(),
            Answer::Level => self.levels.as_ref(),
            Answer::Voxel => self.voxels.as_ref(),
            Answer::Resident => self.residents.as_ref(),
        }
    }

    /// Whether the technique supports this answer for pixels.
    pub fn answers(&self, answer: Answer) -> bool {
        self.pipeline(answer).is_some()
    }
}

impl Resolver {
    /// Creates the layouts.
    pub fn new(gpu: &Gpu) -> Self {
        let pixels = [binding::UNIFORM, binding::DEPTH, binding::LOADED, binding::written(FACTOR_FORMAT)];
        let points = [binding::UNIFORM, binding::STORAGE, binding::STORAGE_OUT];
        Self {
            pixels: gpu.layout("resolve", ShaderStages::COMPUTE, &pixels),
            points: gpu.layout("points", ShaderStages::COMPUTE, &points),
        }
    }

    /// Builds a technique's pipelines.
    pub fn lookup(&self, gpu: &Gpu, technique: &dyn Technique) -> Lookup {
        let [first, second] = technique.layouts();
        let pipeline = |layout, answer, pass, entry| {
            let files = technique.sources(answer)?;
            let all: Vec<_> = [source::SURFACE, source::VIEW_DEPTH, source::FRAME]
                .into_iter()
                .chain(files)
                .chain([pass])
                .collect();
            let label = format!("{entry}::{}", technique.name());
            Some(gpu.compute(&label, assemble(&all), entry, &[Some(layout), first, second]))
        };
        Lookup {
            pixels: pipeline(&self.pixels, Answer::Visibility, source::RESOLVE, "resolve"),
            cascades: pipeline(&self.pixels, Answer::Cascade, source::RESOLVE, "resolve_all"),
            levels: pipeline(&self.pixels, Answer::Level, source::RESOLVE, "resolve_all"),
            voxels: pipeline(&self.pixels, Answer::Voxel, source::RESOLVE, "resolve_all"),
            residents: pipeline(&self.pixels, Answer::Resident, source::RESOLVE, "resolve_all"),
            points: pipeline(&self.points, Answer::Visibility, source::POINTS, "answer_points"),
        }
    }

    /// Looks up every pixel and writes the answers to `targets.factor`. Does nothing if the technique does
    /// not support this answer: see [`Lookup::answers`].
    pub fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::Buffer,
        targets: &Targets,
        technique: &dyn Technique,
        (lookup, answer): (&Lookup, Answer),
    ) {
        let Some(pipeline) = lookup.pipeline(answer) else { return };
        let group = gpu.bind(
            "resolve",
            &self.pixels,
            vec![
                frame.as_entire_binding(),
                wgpu::BindingResource::TextureView(&targets.depth.view),
                wgpu::BindingResource::TextureView(&targets.normal.view),
                wgpu::BindingResource::TextureView(&targets.factor.view),
            ],
        );
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        bind_technique(&mut pass, technique);
        let [w, h] = targets.size;
        pass.dispatch_workgroups(w.div_ceil(PIXEL_GROUP), h.div_ceil(PIXEL_GROUP), 1);
    }

    /// Looks up a list of points. The technique must be prepared and its depth passes must be done.
    ///
    /// # Errors
    /// Returns [`RenderError::Technique`] if the technique cannot look up points, and whatever error the
    /// device reports.
    pub fn answer(
        &self,
        gpu: &Gpu,
        frame: &wgpu::Buffer,
        technique: &dyn Technique,
        lookup: &Lookup,
        points: &[PointQuery],
    ) -> Result<Vec<f32>> {
        let Some(pipeline) = lookup.points.as_ref().filter(|_| technique.supports_points()) else {
            let reason = "it can look up pictures, but not lists of points".to_owned();
            return Err(RenderError::Technique { name: technique.name(), reason });
        };
        let mut factors = Vec::with_capacity(points.len());
        for chunk in points.chunks(most_points(gpu.max_binding_bytes)) {
            let bytes: Vec<u8> = chunk.iter().flat_map(PointQuery::bytes).collect();
            let asked = gpu.buffer("points", &bytes, BufferUsages::STORAGE);
            let answered = gpu.buffer(
                "factors",
                &vec![0; chunk.len() * 4],
                BufferUsages::STORAGE | BufferUsages::COPY_SRC,
            );
            let group = gpu.bind(
                "points",
                &self.points,
                vec![frame.as_entire_binding(), asked.as_entire_binding(), answered.as_entire_binding()],
            );
            let mut encoder = gpu.encoder("points");
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            bind_technique(&mut pass, technique);
            pass.dispatch_workgroups((chunk.len() as u32).div_ceil(LIST_GROUP), 1, 1);
            drop(pass);
            gpu.finish(encoder.finish())?;
            let bytes = read_buffer(gpu, &answered)?;
            factors.extend(bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)));
        }
        Ok(factors)
    }
}

/// Returns the maximum number of points in one dispatch, such that they fit into one binding of
/// `max_binding_bytes`.
fn most_points(max_binding_bytes: u64) -> usize {
    let fitting = max_binding_bytes.min(MAX_BYTES) as usize / PointQuery::SIZE;
    fitting.clamp(1, MAX_GROUPS * LIST_GROUP as usize)
}

fn bind_technique(pass: &mut wgpu::ComputePass<'_>, technique: &dyn Technique) {
    for (index, group) in (1..).zip(technique.groups()) {
        if let Some(group) = group {
            pass.set_bind_group(index, group, &[]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_one_dispatch_fit_the_binding() {
        for bytes in [96, 100, 1 << 16, 1 << 27, 1 << 31] {
            let points = most_points(bytes);
            assert!((points * PointQuery::SIZE) as u64 <= bytes, "{bytes}");
            assert!(points.div_ceil(LIST_GROUP as usize) <= MAX_GROUPS, "{bytes}");
        }
        assert_eq!((most_points(100), most_points(0)), (2, 1));
    }
}
