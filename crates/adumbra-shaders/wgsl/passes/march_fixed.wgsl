// Marches in both keys of a path from starts in fixed point. One thread per start.

@group(0) @binding(0) var<storage, read> starts: array<AdumbraVoxelQuery>;
@group(0) @binding(1) var<storage, read_write> marched: array<vec2u>;

@compute @workgroup_size(ADUMBRA_LIST_GROUP)
fn count_taps(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&starts)) {
        return;
    }
    let start = starts[id.x].p_fixed;
    marched[id.x] = vec2u(
        adumbra_march(adumbra_path.keys[0], adumbra_path.ways[0].xy, start),
        adumbra_march(adumbra_path.keys[1], adumbra_path.ways[1].xy, start),
    );
}
