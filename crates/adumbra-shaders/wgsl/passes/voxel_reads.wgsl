// Lit taps of `voxel` for receivers in fixed point, and the words that were read for them. One thread per
// receiver. access/words_logged.wgsl must precede this file.

@group(0) @binding(0) var<storage, read> receivers: array<AdumbraVoxelQuery>;

@compute @workgroup_size(ADUMBRA_LIST_GROUP)
fn count_taps(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&receivers)) {
        return;
    }
    let answer = id.x * (2u + ADUMBRA_MAX_READS);
    adumbra_reads_at = answer + 2u;
    let r = receivers[id.x];
    adumbra_reads[answer] = adumbra_voxel_lit_taps(adumbra_voxel_params, AdumbraVoxelReceiver(r.p_fixed, r.gradient));
    adumbra_reads[answer + 1u] = adumbra_read_count;
}
