//! The pass that writes texels to their offsets in the map. Counterpart of passes/hybrid_place.wgsl and
//! hybrid_place_paper.wgsl.

use adumbra_shaders::{assemble, source};
use wgpu::{BindingResource, ShaderStages};

use super::settings::{HybridLayout, HybridSettings};
use super::stored::{Stored, buffer};
use crate::error::{RenderError, Result};
use crate::gpu::{Gpu, binding};

/// The pipeline and the layout of its bind group 1. Both depend on the map's layout.
#[derive(Clone)]
pub(super) struct PlacePipeline {
    pub(super) pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// Bind group 1 of one map.
pub(super) struct PlaceGroup {
    pub(super) group: wgpu::BindGroup,
    /// Packed normals of all levels but the finest, if the layout has normals.
    normals: Option<wgpu::Buffer>,
}

impl PlacePipeline {
    /// Creates the pipeline. `build` is the layout of bind group 0.
    pub(super) fn new(gpu: &Gpu, settings: &HybridSettings, build: &wgpu::BindGroupLayout) -> Self {
        let out = binding::STORAGE_OUT;
        let (entry, files, kinds) = match settings.layout {
            HybridLayout::Compact => {
                ("hybrid_place", vec![source::HYBRID_BUILD, source::HYBRID_PLACE], vec![out])
            }
            HybridLayout::Paper => (
                "hybrid_place_paper",
                vec![
                    settings.test.leaf(),
                    source::OCTAHEDRAL,
                    source::HYBRID_NORMALS,
                    source::HYBRID_BUILD,
                    source::HYBRID_PLACE_PAPER,
                ],
                vec![binding::LOADED_ARRAY, out, out, out],
            ),
        };
        let layout = gpu.layout(entry, ShaderStages::COMPUTE, &kinds);
        let pipeline = gpu.compute(entry, assemble(&files), entry, &[Some(build), Some(&layout)]);
        Self { pipeline, layout }
    }

    /// Creates the bind group of a map in `stored`. `blocks` is the number of texels of all levels but the
    /// finest. `start_normals` are the normals of the shadow map, a `texture_2d_array` of one layer; only the
    /// paper's layout reads them.
    ///
    /// # Errors
    /// Returns [`RenderError::DepthImage`] if the layout is the paper's and there are no normals.
    pub(super) fn group(
        &self,
        gpu: &Gpu,
        stored: &Stored,
        blocks: u64,
        start_normals: Option<&wgpu::TextureView>,
    ) -> Result<PlaceGroup> {
        let bind = |resources| gpu.bind("hybrid_place", &self.layout, resources);
        match (stored, start_normals) {
            (Stored::Compact { words }, _) => {
                Ok(PlaceGroup { group: bind(vec![words.as_entire_binding()]), normals: None })
            }
            (Stored::Paper { texels, links }, Some(view)) => {
                let normals = buffer(gpu, "hybrid::normals", 4 * blocks);
                let group = bind(vec![
                    BindingResource::TextureView(view),
                    texels.as_entire_binding(),
                    links.as_entire_binding(),
                    normals.as_entire_binding(),
                ]);
                Ok(PlaceGroup { group, normals: Some(normals) })
            }
            (Stored::Paper { .. }, None) => {
                let what = "it has no normals, which layout=paper stores".to_owned();
                Err(RenderError::DepthImage { what })
            }
        }
    }
}

impl PlaceGroup {
    /// Bytes on the GPU.
    pub(super) fn bytes(&self) -> u64 {
        self.normals.as_ref().map_or(0, wgpu::Buffer::size)
    }
}
