//! Bind group 1 of a look-up in baked voxels: its uniform at binding 0, its words from binding 1 on.

use adumbra_shaders::Source;
use wgpu::{BindingType, ShaderStages};

use super::WordBuffers;
use crate::gpu::{Gpu, binding};

/// The group, its layout, and the WGSL file that reads its words.
pub struct VoxelBindings {
    uniform: wgpu::Buffer,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    access: Source,
    bytes: u64,
}

impl VoxelBindings {
    /// Creates the group for words in storage buffers, which take 1 or 6 bindings.
    pub fn from_words(gpu: &Gpu, label: &str, uniform: &[u8], words: &WordBuffers) -> Self {
        let storage = vec![binding::STORAGE; words.buffers().len()];
        Self::new(gpu, label, uniform, (words.access(), words.bytes()), (&storage, words.resources()))
    }

    /// Creates the group for words in a texture, which takes 1 binding of type `kind` and `bytes` bytes on
    /// the device.
    pub fn from_texture(
        gpu: &Gpu,
        label: &str,
        uniform: &[u8],
        (access, bytes): (Source, u64),
        (kind, view): (BindingType, &wgpu::TextureView),
    ) -> Self {
        let resource = wgpu::BindingResource::TextureView(view);
        Self::new(gpu, label, uniform, (access, bytes), (&[kind], vec![resource]))
    }

    fn new(
        gpu: &Gpu,
        label: &str,
        uniform: &[u8],
        (access, bytes): (Source, u64),
        (kinds, resources): (&[BindingType], Vec<wgpu::BindingResource<'_>>),
    ) -> Self {
        let bindings: Vec<_> = [binding::UNIFORM].into_iter().chain(kinds.iter().copied()).collect();
        let layout = gpu.layout(label, ShaderStages::COMPUTE | ShaderStages::FRAGMENT, &bindings);
        let uniform = gpu.uniform(label, uniform);
        let all = [uniform.as_entire_binding()].into_iter().chain(resources).collect();
        let group = gpu.bind(label, &layout, all);
        Self { uniform, layout, group, access, bytes }
    }

    /// Rewrites the uniform.
    pub fn write(&self, gpu: &Gpu, uniform: &[u8]) {
        gpu.queue.write_buffer(&self.uniform, 0, uniform);
    }

    /// Layout of the group.
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// The group.
    pub fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// The WGSL file that defines `adumbra_voxel_word`.
    pub fn access(&self) -> Source {
        self.access
    }

    /// Bytes of the words on the device.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}
