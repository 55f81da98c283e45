// What the passes that build one level of a hybrid map share. A block is four texels of the level before; its word is a depth where they
// merge. Where they do not it is HYBRID_INDEX with, first, the block's rank among such blocks of its section, a run of HYBRID_SECTION
// blocks of its row, then, placed, the word at which its children begin. Ranks follow rows, so the map is the same in every run and
// however it is swept.
//
// What the map is made of is the place pass's, in bind group 1; below, a word is a texel where the paper's layout is stored.
//
// hybrid_counts: word 0 = next free word of the map; 1 to 3 = blocks of level 1 to 3 that did not merge; from HYBRID_FIRST_SECTION on, one a
// section: such blocks, then the word at which their children begin.

@group(0) @binding(0) var<uniform> level: HybridLevel;
@group(0) @binding(1) var start_depth: texture_depth_2d_array;
// All levels but the finest, one behind the other, row by row.
@group(0) @binding(2) var<storage, read_write> hybrid_levels: array<u32>;
@group(0) @binding(3) var<storage, read_write> hybrid_counts: array<u32>;

// Where a block's children go, whose word is HYBRID_INDEX and its rank.
fn block_room(block: vec2u, word: u32) -> u32 {
    let section = block.y * level_sections() + block.x / HYBRID_SECTION;
    return hybrid_counts[HYBRID_FIRST_SECTION + section] + (word ^ HYBRID_INDEX) * level.places.z;
}

fn level_sections() -> u32 {
    return (level.counts.z + HYBRID_SECTION - 1u) / HYBRID_SECTION;
}

fn start_at(texel: vec2u) -> f32 {
    let depth = abs(textureLoad(start_depth, texel, 0, 0));
    // Devices make floats of 16 bits by a product or a quotient, which may round apart.
    return select(depth, floor(depth * 65535.0 + 0.5) * DEPTH_16_STEP, level.places.w == 1u);
}

// Place of a block's word among the levels.
fn block_place(block: vec2u) -> u32 {
    return level.places.y + block.y * level.counts.z + block.x;
}

// A block's children in the level before, which is not the finest: left above, right above, left below, right below.
fn block_children(block: vec2u) -> vec4u {
    let row = 2u * level.counts.z;
    let first = level.places.x + 2u * block.y * row + 2u * block.x;
    return vec4u(hybrid_levels[first], hybrid_levels[first + 1u], hybrid_levels[first + row], hybrid_levels[first + row + 1u]);
}

// The same of finest texels.
fn block_depths(block: vec2u) -> vec4f {
    let t = 2u * block;
    return vec4f(start_at(t), start_at(t + vec2u(1u, 0u)), start_at(t + vec2u(0u, 1u)), start_at(t + vec2u(1u, 1u)));
}
