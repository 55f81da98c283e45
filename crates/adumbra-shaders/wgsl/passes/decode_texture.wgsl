// A texture's words into a storage buffer, one thread a word: the other way to read it in a shader. `decoded_from` is the number of this
// buffer's first word, for trees that need several.

// In x.
@group(0) @binding(0) var<uniform> decoded_from: vec4u;
@group(0) @binding(1) var<storage, read_write> decoded: array<u32>;

@compute @workgroup_size(LIST_GROUP)
fn decode_texture(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    // Rows of workgroups: one row holds at most 65535.
    let at = id.y * groups.x * 64u + id.x;
    if (at < arrayLength(&decoded)) {
        decoded[at] = voxel_word(decoded_from.x + at);
    }
}
