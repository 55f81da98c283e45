// Weights of the lit taps and of all taps of `voxel-cubes` and `voxel-texture` for receivers in fixed point.
// One thread per receiver.

@group(0) @binding(0) var<storage, read> receivers: array<AdumbraCubesQuery>;
@group(0) @binding(1) var<storage, read_write> lit_weights: array<vec2u>;

@compute @workgroup_size(ADUMBRA_LIST_GROUP)
fn count_taps(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&receivers)) {
        return;
    }
    let r = receivers[id.x];
    lit_weights[id.x] = adumbra_cubes_lit_weights(cubes.params, AdumbraCubesReceiver(r.p_fixed, r.level, r.normal, r.height));
}
