// Lit taps of `voxel` for receivers in fixed point. One thread per receiver.

@group(0) @binding(0) var<storage, read> receivers: array<AdumbraVoxelQuery>;
@group(0) @binding(1) var<storage, read_write> lit_taps: array<u32>;

@compute @workgroup_size(ADUMBRA_LIST_GROUP)
fn count_taps(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&receivers)) {
        return;
    }
    let r = receivers[id.x];
    lit_taps[id.x] = adumbra_voxel_lit_taps(adumbra_voxel_params, AdumbraVoxelReceiver(r.p_fixed, r.gradient));
}
