// All results that a file in the layout "depths" gives for receivers in fixed point: lit taps, the column's
// switch depth, and penumbra. One thread per receiver.

struct DepthsAnswer {
    lit_taps: u32,
    value: u32,
    soft: f32,
}

@group(0) @binding(0) var<storage, read> receivers: array<AdumbraVoxelQuery>;
@group(0) @binding(1) var<storage, read_write> answers: array<DepthsAnswer>;

@compute @workgroup_size(ADUMBRA_LIST_GROUP)
fn count_taps(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&receivers)) {
        return;
    }
    let r = AdumbraVoxelReceiver(receivers[id.x].p_fixed, receivers[id.x].gradient);
    let column = clamp(r.p_fixed.xy >> vec2u(ADUMBRA_FIXED_BITS), vec2i(0), adumbra_voxel_params.grid.size.xy - 1);
    let soft = adumbra_depths_soft(adumbra_voxel_params, r, adumbra_disc_turn(vec2u(id.x, 0u)));
    answers[id.x] = DepthsAnswer(adumbra_voxel_lit_taps(adumbra_voxel_params, r), adumbra_depths_value(adumbra_voxel_params, vec2u(column)), soft);
}
