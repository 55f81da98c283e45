// Merging with one thread per block and one workgroup per section. The resulting words equal those of the
// sweep.

var<workgroup> section_split: array<atomic<u32>, 2>;

@compute @workgroup_size(ADUMBRA_HYBRID_SECTION)
fn hybrid_blocks(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    let block = id.xy;
    let inside = block.x < level.side_texels;
    var word = 0u;
    if (inside) {
        word = block_merged(block);
    }
    let splits = word == ADUMBRA_HYBRID_INDEX;
    if (splits) {
        atomicOr(&section_split[local / 32u], 1u << (local % 32u));
    }
    workgroupBarrier();
    let low = atomicLoad(&section_split[0]);
    let high = atomicLoad(&section_split[1]);
    let before = (1u << (local % 32u)) - 1u;
    let rank = select(countOneBits(low & before), countOneBits(low) + countOneBits(high & before), local >= 32u);
    if (inside) {
        hybrid_levels[block_offset(block)] = select(word, ADUMBRA_HYBRID_INDEX | rank, splits);
    }
    if (local == 0u) {
        let section = block.y * level_sections() + block.x / ADUMBRA_HYBRID_SECTION;
        hybrid_counts[ADUMBRA_HYBRID_FIRST_SECTION + section] = countOneBits(low) + countOneBits(high);
    }
}
