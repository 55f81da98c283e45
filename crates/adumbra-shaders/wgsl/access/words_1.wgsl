// Words of baked voxels from one storage buffer.

@group(1) @binding(1) var<storage, read> voxel_words: array<u32>;

fn voxel_word(index: u32) -> u32 {
    return voxel_words[index];
}
