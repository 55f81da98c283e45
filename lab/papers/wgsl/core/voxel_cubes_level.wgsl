// Level of the cube in which the look-up of a kernel's centre ends in a tree. The whole cube is lit or
// shadowed, and it spans 2^level voxels a side. -1 means that the point's sun ray misses the tree's cube.
// This is the counterpart of adumbra_papers::tree::query::TreeQuery::end_level.
// core/voxel_cubes_receiver.wgsl must precede this file.

fn adumbra_cubes_end_level(c: AdumbraCubesParams, s: AdumbraSurface) -> i32 {
    let place = adumbra_cubes_place(c, s);
    if (!place.found) {
        return -1;
    }
    let r = place.receiver;
    let middle = ((r.p_fixed >> vec3u(ADUMBRA_FIXED_BITS + r.level)) << vec3u(r.level)) + ((1i << r.level) >> 1u);
    let leaf = adumbra_cubes_walk(AdumbraCubesNode(adumbra_voxel_word(0u), c.depth), middle, 0u);
    // In a leaf of eight, the look-up ends in one of its children.
    return i32(leaf.level) - i32(leaf.word >= ADUMBRA_CUBES_MASK);
}
