// Words of baked voxels from one storage buffer.

@group(1) @binding(1) var<storage, read> adumbra_voxel_words: array<u32>;

fn adumbra_voxel_word(index: u32) -> u32 {
    return adumbra_voxel_words[index];
}
