// Words of baked voxels from one storage buffer, each logged as it is read, for passes/voxel_reads.wgsl.

// Per thread: lit taps, number of reads, and the words read, in order, as long as there is room.
@group(0) @binding(1) var<storage, read_write> adumbra_reads: array<u32>;
@group(1) @binding(1) var<storage, read> adumbra_voxel_words: array<u32>;

// Start of the thread's words, and the number of words it has read.
var<private> adumbra_reads_at: u32;
var<private> adumbra_read_count: u32;

fn adumbra_voxel_word(index: u32) -> u32 {
    if (adumbra_read_count < ADUMBRA_MAX_READS) {
        adumbra_reads[adumbra_reads_at + adumbra_read_count] = index;
    }
    adumbra_read_count++;
    return adumbra_voxel_words[index];
}
