// Code shared by the passes that build one level of a hybrid map. A block is four texels of the previous
// level. If they merge, the block's word is a depth. Otherwise it is ADUMBRA_HYBRID_INDEX combined with a
// number: first the block's rank among the unmerged blocks of its section, later, once placed, the word at
// which its children begin. A section is a run of ADUMBRA_HYBRID_SECTION blocks of one row. Ranks follow
// rows, so the map is the same in every run and for every way to sweep it.
//
// The contents of the map belong to the place pass, in bind group 1. For the paper's layout, "word" below
// means a texel.
//
// hybrid_counts: word 0 = next free word of the map; words 1 to 3 = number of unmerged blocks of levels 1 to
// 3; from ADUMBRA_HYBRID_FIRST_SECTION on, one word per section: first its number of unmerged blocks, then
// the word at which their children begin.

@group(0) @binding(0) var<uniform> level: AdumbraHybridLevel;
@group(0) @binding(1) var start_depth: texture_depth_2d_array;
// All levels but the finest, concatenated, row by row.
@group(0) @binding(2) var<storage, read_write> hybrid_levels: array<u32>;
@group(0) @binding(3) var<storage, read_write> hybrid_counts: array<u32>;

// Returns where the children of a block go; the block's word is ADUMBRA_HYBRID_INDEX combined with its rank.
fn block_room(block: vec2u, word: u32) -> u32 {
    let section = block.y * level_sections() + block.x / ADUMBRA_HYBRID_SECTION;
    return hybrid_counts[ADUMBRA_HYBRID_FIRST_SECTION + section] + (word ^ ADUMBRA_HYBRID_INDEX) * level.split_size;
}

fn level_sections() -> u32 {
    return (level.side_texels + ADUMBRA_HYBRID_SECTION - 1u) / ADUMBRA_HYBRID_SECTION;
}

fn start_at(texel: vec2u) -> f32 {
    let depth = abs(textureLoad(start_depth, texel, 0, 0));
    // Devices convert 16 bits to floats by a product or by a quotient, which may round differently.
    return select(depth, floor(depth * 65535.0 + 0.5) * ADUMBRA_DEPTH_16_STEP, level.has_16_bit_depth == 1u);
}

// Returns the position of a block's word among the words of all levels.
fn block_offset(block: vec2u) -> u32 {
    return level.offset + block.y * level.side_texels + block.x;
}

// Returns a block's children in the previous level, which is not the finest: upper left, upper right, lower
// left, lower right.
fn block_children(block: vec2u) -> vec4u {
    let row = 2u * level.side_texels;
    let first = level.finer_offset + 2u * block.y * row + 2u * block.x;
    return vec4u(hybrid_levels[first], hybrid_levels[first + 1u], hybrid_levels[first + row], hybrid_levels[first + row + 1u]);
}

// Returns the depths of a block of finest texels.
fn block_depths(block: vec2u) -> vec4f {
    let t = 2u * block;
    return vec4f(start_at(t), start_at(t + vec2u(1u, 0u)), start_at(t + vec2u(0u, 1u)), start_at(t + vec2u(1u, 1u)));
}
