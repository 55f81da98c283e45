// Turns each section's number of unmerged blocks into the word at which their children begin. One workgroup.

const SCAN_GROUP: u32 = 256u;

var<workgroup> scan_sums: array<u32, SCAN_GROUP>;

@compute @workgroup_size(SCAN_GROUP)
fn hybrid_scan(@builtin(local_invocation_index) local: u32) {
    let sections = level.side_texels * level_sections();
    let share = (sections + SCAN_GROUP - 1u) / SCAN_GROUP;
    let first = ADUMBRA_HYBRID_FIRST_SECTION + min(local * share, sections);
    let last = ADUMBRA_HYBRID_FIRST_SECTION + min((local + 1u) * share, sections);
    var sum = 0u;
    for (var i = first; i < last; i++) {
        sum += hybrid_counts[i];
    }
    scan_sums[local] = sum;
    workgroupBarrier();
    if (local == 0u) {
        // The coarsest level comes first in the map, and each level begins at a multiple of four words.
        let coarsest = level.start_texels >> level.merges;
        let free = select(hybrid_counts[0], coarsest * coarsest, level.number == 1u);
        let begin = (free + 3u) & ~3u;
        var blocks = 0u;
        for (var i = 0u; i < SCAN_GROUP; i++) {
            let next = blocks + scan_sums[i];
            scan_sums[i] = begin + blocks * level.split_size;
            blocks = next;
        }
        hybrid_counts[0] = begin + blocks * level.split_size;
        hybrid_counts[level.number] = blocks;
    }
    workgroupBarrier();
    var word = scan_sums[local];
    for (var i = first; i < last; i++) {
        let blocks = hybrid_counts[i];
        hybrid_counts[i] = word;
        word += blocks * level.split_size;
    }
}
