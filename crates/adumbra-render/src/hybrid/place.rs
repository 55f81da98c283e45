//! The pass that puts texels to their places in a map. Same stems as passes/hybrid_place.wgsl and hybrid_place_paper.wgsl.

use adumbra_shaders::{assemble, source};
use wgpu::{BindingResource, BufferUsages, ShaderStages};

use super::settings::{HybridSettings, MergeTest};
use super::stored::Stored;
use crate::error::{RenderError, Result};
use crate::gpu::{Gpu, binding};

/// The pass, with bind group 1, which depends on the layout.
pub(super) struct PlacePass {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) group: wgpu::BindGroup,
    /// Packed normals of all levels but the finest, where the layout has normals.
    normals: Option<wgpu::Buffer>,
}

impl PlacePass {
    /// For maps in `stored`. `build` is the layout of bind group 0, `blocks` the texels of all levels but the finest,
    /// `start_normals` those of the shadow map: a `texture_2d_array` of one layer, which the paper's layout alone reads.
    ///
    /// # Errors
    /// [`RenderError::DepthImage`] where that layout is to be made without normals.
    pub(super) fn new(
        gpu: &Gpu,
        settings: &HybridSettings,
        build: &wgpu::BindGroupLayout,
        stored: &Stored,
        blocks: u64,
        start_normals: Option<&wgpu::TextureView>,
    ) -> Result<Self> {
        let out = binding::STORAGE_OUT;
        let (entry, files, kinds, resources, normals);
        match (stored, start_normals) {
            (Stored::Paper { texels, links }, Some(view)) => {
                let leaf = match settings.test {
                    MergeTest::Plane { .. } => source::HYBRID_PLANE,
                    MergeTest::Paper => source::HYBRID_MEAN,
                };
                entry = "hybrid_place_paper";
                files = vec![
                    leaf,
                    source::OCTAHEDRAL,
                    source::HYBRID_NORMALS,
                    source::HYBRID_BUILD,
                    source::HYBRID_PLACE_PAPER,
                ];
                kinds = vec![binding::LOADED_ARRAY, out, out, out];
                let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("hybrid::normals"),
                    size: 4 * blocks,
                    usage: BufferUsages::STORAGE,
                    mapped_at_creation: false,
                });
                normals = Some(buffer);
                resources = vec![
                    BindingResource::TextureView(view),
                    texels.as_entire_binding(),
                    links.as_entire_binding(),
                ];
            }
            (Stored::Paper { .. }, None) => {
                let what = "it has no normals, which layout=paper stores".to_owned();
                return Err(RenderError::DepthImage { what });
            }
            (Stored::Compact { words }, _) => {
                entry = "hybrid_place";
                files = vec![source::HYBRID_BUILD, source::HYBRID_PLACE];
                kinds = vec![out];
                normals = None;
                resources = vec![words.as_entire_binding()];
            }
        }
        let layout = gpu.layout(entry, ShaderStages::COMPUTE, &kinds);
        let resources = resources.into_iter().chain(normals.as_ref().map(wgpu::Buffer::as_entire_binding));
        let group = gpu.bind(entry, &layout, resources.collect());
        let pipeline = gpu.compute(entry, assemble(&files), entry, &[Some(build), Some(&layout)]);
        Ok(Self { pipeline, group, normals })
    }

    /// On the GPU.
    pub(super) fn bytes(&self) -> u64 {
        self.normals.as_ref().map_or(0, wgpu::Buffer::size)
    }
}
