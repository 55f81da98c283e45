// Words of baked voxels from six storage buffers, for data larger than one binding may be. All buffers but
// the last one in use hold the same number of words as the first, a power of two. These six and the two of
// passes/points.wgsl make up the eight storage buffers that every device supports.

@group(1) @binding(1) var<storage, read> adumbra_voxel_words_0: array<u32>;
@group(1) @binding(2) var<storage, read> adumbra_voxel_words_1: array<u32>;
@group(1) @binding(3) var<storage, read> adumbra_voxel_words_2: array<u32>;
@group(1) @binding(4) var<storage, read> adumbra_voxel_words_3: array<u32>;
@group(1) @binding(5) var<storage, read> adumbra_voxel_words_4: array<u32>;
@group(1) @binding(6) var<storage, read> adumbra_voxel_words_5: array<u32>;

fn adumbra_voxel_word(index: u32) -> u32 {
    let words = arrayLength(&adumbra_voxel_words_0);
    let at = index & (words - 1u);
    switch index >> firstTrailingBit(words) {
        case 0u: {
            return adumbra_voxel_words_0[at];
        }
        case 1u: {
            return adumbra_voxel_words_1[at];
        }
        case 2u: {
            return adumbra_voxel_words_2[at];
        }
        case 3u: {
            return adumbra_voxel_words_3[at];
        }
        case 4u: {
            return adumbra_voxel_words_4[at];
        }
        default: {
            return adumbra_voxel_words_5[at];
        }
    }
}
