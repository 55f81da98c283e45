// The visibility of points for a sun between those of two keys, and the number of words that were read for
// it. One thread per point. access/words_logged.wgsl must precede this file.

@group(0) @binding(0) var<storage, read> points: array<AdumbraPointQuery>;

@compute @workgroup_size(ADUMBRA_LIST_GROUP)
fn count_taps(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&points)) {
        return;
    }
    let answer = id.x * (2u + ADUMBRA_MAX_READS);
    adumbra_reads_at = answer + 2u;
    let p = points[id.x];
    var s: AdumbraSurface;
    s.p_relative = p.p_relative;
    s.normal = p.normal;
    s.view_depth = p.view_depth;
    s.pixel = p.pixel;
    adumbra_reads[answer] = bitcast<u32>(adumbra_file_factor(s));
    adumbra_reads[answer + 1u] = adumbra_read_count;
}
