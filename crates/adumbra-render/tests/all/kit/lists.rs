//! A compute pass over a list: one thread per element, workgroups of 64, binding 0 for the input, binding 1
//! for the output.

use adumbra_render::Gpu;
use adumbra_render::gpu::binding;
use adumbra_render::readback::read_buffer;
use adumbra_shaders::{Source, assemble};
use wgpu::{BufferUsages, ShaderStages};

/// Runs the entry point `main` of `texts` on `count` elements, a multiple of 64, and returns `bytes` bytes
/// per element.
pub(crate) fn run(gpu: &Gpu, texts: &[Source], given: &[u8], count: u32, bytes: usize) -> Vec<u8> {
    let given = gpu.buffer("test::given", given, BufferUsages::STORAGE);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let found = gpu.buffer("test::found", &vec![0; bytes * count as usize], usage);
    let layout = gpu.layout("test", ShaderStages::COMPUTE, &[binding::STORAGE, binding::STORAGE_OUT]);
    let pipeline = gpu.compute("test", assemble(texts), "main", &[Some(&layout)]);
    let group = gpu.bind("test", &layout, vec![given.as_entire_binding(), found.as_entire_binding()]);
    let mut encoder = gpu.encoder("test");
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(count / 64, 1, 1);
    drop(pass);
    gpu.finish(encoder.finish()).unwrap();
    read_buffer(gpu, &found).unwrap()
}
