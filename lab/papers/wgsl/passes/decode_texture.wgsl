// Copies a texture's words into a storage buffer, one thread per word: the alternative to reading the texture
// in each look-up. Trees may need several buffers.

@group(0) @binding(0) var<uniform> decode: AdumbraDecodeParams;
@group(0) @binding(1) var<storage, read_write> decoded: array<u32>;

@compute @workgroup_size(ADUMBRA_LIST_GROUP)
fn decode_texture(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    // Workgroups are dispatched in rows, because one row holds at most 65535.
    let at = id.y * groups.x * ADUMBRA_LIST_GROUP + id.x;
    if (at < arrayLength(&decoded)) {
        decoded[at] = adumbra_voxel_word(decode.first_word + at);
    }
}
