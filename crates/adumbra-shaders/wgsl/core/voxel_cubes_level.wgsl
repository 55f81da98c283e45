// Level of the cube in which the look-up of a kernel's middle ends in a tree: all of it is lit or shadowed, and it spans 2^level voxels a
// side; -1 where the point's sun ray misses the cube. The twin of adumbra::query::TreeQuery::end_level. core/voxel_cubes_receiver.wgsl
// goes before it.

fn cubes_end_level(c: CubesParams, s: Surface) -> i32 {
    let place = cubes_place(c, s);
    if (!place.found) {
        return -1;
    }
    let r = place.receiver;
    let middle = ((r.p_fixed >> vec3u(FIXED_BITS + r.level)) << vec3u(r.level)) + ((1i << r.level) >> 1u);
    let leaf = cubes_walk(CubesNode(voxel_word(0u), c.kernel.x), middle, 0u);
    // A leaf of eight answers with one of them.
    return i32(leaf.level) - i32(leaf.word >= CUBES_MASK);
}
