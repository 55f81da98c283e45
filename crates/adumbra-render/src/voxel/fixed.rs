//! Runs passes such as `voxel_fixed` and `depths_fixed` on lists of receivers in fixed point, for the exact
//! tests of the twins.

use adumbra_shaders::constants::LIST_GROUP;
use adumbra_shaders::layout::GpuType;
use adumbra_shaders::{Source, assemble};
use wgpu::{BufferUsages, ShaderStages};

use super::VoxelBindings;
use crate::error::Result;
use crate::gpu::{Gpu, binding};
use crate::readback::read_buffer;

/// Threads per workgroup.
const GROUP: usize = LIST_GROUP as usize;
/// Largest number of receivers per dispatch: one row of workgroups.
const CHUNK: usize = 65535 * GROUP;

/// Returns an answer of `BYTES` bytes per query, from the entry point `count_taps` of the last of `files`.
///
/// # Errors
/// Returns any error that the device reports.
pub fn answer<Q: GpuType, const BYTES: usize>(
    gpu: &Gpu,
    bindings: &VoxelBindings,
    files: &[Source],
    queries: &[Q],
) -> Result<Vec<[u8; BYTES]>> {
    let layout = gpu.layout("count_taps", ShaderStages::COMPUTE, &[binding::STORAGE, binding::STORAGE_OUT]);
    let layouts = [Some(&layout), Some(bindings.layout())];
    let pipeline = gpu.compute("count_taps", assemble(files), "count_taps", &layouts);
    let max_queries = gpu.device.limits().max_storage_buffer_binding_size as usize / Q::SIZE;
    let mut answers = Vec::with_capacity(queries.len());
    for chunk in queries.chunks(max_queries.clamp(1, CHUNK)) {
        let mut bytes = Vec::with_capacity(chunk.len() * Q::SIZE);
        chunk.iter().for_each(|q| q.put(&mut bytes));
        let asked = gpu.buffer("count_taps::receivers", &bytes, BufferUsages::STORAGE);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let answered = gpu.buffer("count_taps::answers", &vec![0; chunk.len() * BYTES], usage);
        let group =
            gpu.bind("count_taps", &layout, vec![asked.as_entire_binding(), answered.as_entire_binding()]);
        let mut encoder = gpu.encoder("count_taps");
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_bind_group(1, bindings.group(), &[]);
        pass.dispatch_workgroups(chunk.len().div_ceil(GROUP) as u32, 1, 1);
        drop(pass);
        gpu.finish(encoder.finish())?;
        answers.extend_from_slice(read_buffer(gpu, &answered)?.as_chunks::<BYTES>().0);
    }
    Ok(answers)
}
