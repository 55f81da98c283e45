// Lit taps of `voxel` for receivers in fixed point; one thread a receiver.

@group(0) @binding(0) var<storage, read> receivers: array<VoxelQuery>;
@group(0) @binding(1) var<storage, read_write> lit_taps: array<u32>;

@compute @workgroup_size(LIST_GROUP)
fn count_taps(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&receivers)) {
        return;
    }
    let r = receivers[id.x];
    lit_taps[id.x] = voxel_lit_taps(voxel, VoxelReceiver(r.p_fixed.xyz, r.gradient.xy));
}
