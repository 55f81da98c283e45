// Weights of lit and of all taps of `voxel-cubes` and `voxel-texture` for receivers in fixed point; one thread a receiver.

@group(0) @binding(0) var<storage, read> receivers: array<CubesQuery>;
@group(0) @binding(1) var<storage, read_write> lit_weights: array<vec2u>;

@compute @workgroup_size(LIST_GROUP)
fn count_taps(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&receivers)) {
        return;
    }
    let r = receivers[id.x];
    let receiver = CubesReceiver(r.p_fixed.xyz, u32(r.p_fixed.w), r.normal.xyz, r.normal.w);
    lit_weights[id.x] = cubes_lit_weights(cubes.params, receiver);
}
