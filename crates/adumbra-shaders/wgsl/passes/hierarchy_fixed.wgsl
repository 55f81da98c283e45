// Of a hierarchy for receivers in fixed point: lit taps, depth of the column, penumbra and 0; one thread a receiver.

@group(0) @binding(0) var<storage, read> receivers: array<VoxelQuery>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec4u>;

@compute @workgroup_size(LIST_GROUP)
fn count_taps(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&receivers)) {
        return;
    }
    let v = hierarchy.voxel;
    let r = VoxelReceiver(receivers[id.x].p_fixed.xyz, receivers[id.x].gradient.xy);
    let column = clamp(r.p_fixed.xy >> vec2u(FIXED_BITS), vec2i(0), v.grid.size.xy - 1);
    let soft = hierarchy_soft(v, r, hierarchy.sun.x, hierarchy.sun.y, disc_turn(vec2u(id.x, 0u)));
    answers[id.x] = vec4u(hierarchy_lit_taps(v, r), hierarchy_value(v, vec2u(column)), bitcast<u32>(soft), 0u);
}
