// Words of baked voxels from six storage buffers, for what is larger than one binding may be: all but the last in use hold as many words
// as the first, a power of two. Six and the two of passes/points.wgsl are the eight that every device has.

@group(1) @binding(1) var<storage, read> voxel_words_0: array<u32>;
@group(1) @binding(2) var<storage, read> voxel_words_1: array<u32>;
@group(1) @binding(3) var<storage, read> voxel_words_2: array<u32>;
@group(1) @binding(4) var<storage, read> voxel_words_3: array<u32>;
@group(1) @binding(5) var<storage, read> voxel_words_4: array<u32>;
@group(1) @binding(6) var<storage, read> voxel_words_5: array<u32>;

fn voxel_word(index: u32) -> u32 {
    let words = arrayLength(&voxel_words_0);
    let at = index & (words - 1u);
    switch index >> firstTrailingBit(words) {
        case 0u: {
            return voxel_words_0[at];
        }
        case 1u: {
            return voxel_words_1[at];
        }
        case 2u: {
            return voxel_words_2[at];
        }
        case 3u: {
            return voxel_words_3[at];
        }
        case 4u: {
            return voxel_words_4[at];
        }
        default: {
            return voxel_words_5[at];
        }
    }
}
