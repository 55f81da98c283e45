// Look-up in a tree with 1, 3³ or 5³ cells; the twin of adumbra::query::TreeQuery::lit_weights, and the same to the last tap. Source:
// The Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm, 2021, §4; spec/adumbra-tree.md has tree and
// kernel. The kernel's smallest common cube is found once; where that is uniform nothing more is read. Else cells are read eight a
// block. Words come through `fn voxel_word(index: u32) -> u32` of an access/ file.

const CUBES_LEAF: u32 = 0x80000000u;
const CUBES_MASK: u32 = 0xc0000000u;

struct CubesReceiver {
    // Voxels, fixed point, within the cube.
    p_fixed: vec3i,
    // Of the cells.
    level: u32,
    // NORMAL_ONE = 1; zero where every tap counts.
    normal: vec3i,
    // Over the plane of the receiver's surface, cells, NORMAL_ONE = 1.
    height: i32,
}

// A word, and how many levels lie below it.
struct CubesNode {
    word: u32,
    level: u32,
}

fn cubes_child(xyz: vec3i, level: u32) -> u32 {
    let bits = (vec3u(xyz) >> vec3u(level)) & vec3u(1u);
    return bits.x << 2u | bits.y << 1u | bits.z;
}

// Towards a voxel, down to a leaf or to the level `stop`.
fn cubes_walk(from_node: CubesNode, xyz: vec3i, stop: u32) -> CubesNode {
    var node = from_node;
    while (node.word < CUBES_LEAF && node.level > stop) {
        node.level -= 1u;
        node.word = voxel_word(node.word + cubes_child(xyz, node.level));
    }
    return node;
}

// Of a leaf, and a voxel in it: 1 = lit.
fn cubes_leaf(node: CubesNode, xyz: vec3i) -> u32 {
    if (node.word >= CUBES_MASK) {
        return (node.word >> cubes_child(xyz, node.level - 1u)) & 1u;
    }
    return node.word & 1u;
}

// Of the eight cells of a block, bit i = child i. With several depths a cell may go on below; its middle counts.
fn cubes_block(from_node: CubesNode, block: vec3i, level: u32) -> u32 {
    let corner = block << vec3u(level + 1u);
    let node = cubes_walk(from_node, corner, level + 1u);
    if (node.word >= CUBES_MASK && node.level == level + 1u) {
        return node.word & 255u;
    }
    if (node.word >= CUBES_LEAF) {
        return 255u * cubes_leaf(node, corner);
    }
    var mask = 0u;
    let half = (1i << level) >> 1u;
    for (var i = 0u; i < 8u; i++) {
        let bits = vec3i(vec3u(i >> 2u, i >> 1u, i) & vec3u(1u));
        let middle = corner + (bits << vec3u(level)) + half;
        let cell = cubes_walk(CubesNode(voxel_word(node.word + i), level), middle, 0u);
        mask |= cubes_leaf(cell, middle) << i;
    }
    return mask;
}

// A tap of this offset lies before the receiver's surface where normal · offset is at least this.
fn cubes_plane(r: CubesReceiver) -> i32 {
    let fraction = (r.p_fixed >> vec3u(r.level)) & vec3i(FIXED_ONE - 1);
    let along = r.normal * (FIXED_ONE / 2 - fraction);
    return -((r.height * FIXED_ONE + along.x + along.y + along.z) >> FIXED_BITS);
}

// Weight of the lit taps, and of all that count; or 0 or 1, and 1, where all agree.
fn cubes_lit_weights(c: CubesParams, r: CubesReceiver) -> vec2u {
    let depth = c.kernel.x;
    let reach = i32(c.kernel.z);
    let cell = r.p_fixed >> vec3u(FIXED_BITS + r.level);
    let last = i32((1u << depth) >> r.level) - 1;
    let first_tap = cell - reach;
    let last_tap = cell + reach;
    // Beside the cube the nearest cell answers.
    let low = clamp(first_tap, vec3i(0), vec3i(last));
    let high = clamp(last_tap, vec3i(0), vec3i(last));
    let differs = (low.x ^ high.x) | (low.y ^ high.y) | (low.z ^ high.z);
    let span = r.level + 32u - countLeadingZeros(u32(differs));
    let middle = (low << vec3u(r.level)) + ((1i << r.level) >> 1u);
    let stop = select(span, 0u, reach == 0);
    let ancestor = cubes_walk(CubesNode(voxel_word(0u), depth), middle, stop);
    // A leaf of eight one level above the span's cubes holds the kernel in one of its children.
    if (ancestor.word >= CUBES_LEAF && (reach == 0 || ancestor.word < CUBES_MASK || ancestor.level > span)) {
        return vec2u(cubes_leaf(ancestor, middle), 1u);
    }
    let plane = cubes_plane(r);
    var lit = 0u;
    var weights = 0u;
    for (var bx = first_tap.x >> 1u; bx <= last_tap.x >> 1u; bx++) {
        for (var by = first_tap.y >> 1u; by <= last_tap.y >> 1u; by++) {
            for (var bz = first_tap.z >> 1u; bz <= last_tap.z >> 1u; bz++) {
                let block = vec3i(bx, by, bz);
                let mask = cubes_block(ancestor, clamp(block, vec3i(0), vec3i(last >> 1u)), r.level);
                let from_tap = max(2 * block, first_tap);
                let to_tap = min(2 * block + 1, last_tap);
                for (var x = from_tap.x; x <= to_tap.x; x++) {
                    for (var y = from_tap.y; y <= to_tap.y; y++) {
                        for (var z = from_tap.z; z <= to_tap.z; z++) {
                            let tap = vec3i(x, y, z);
                            let offset = tap - cell;
                            let along = r.normal * offset;
                            if (along.x + along.y + along.z >= plane || all(offset == vec3i(0))) {
                                let w = (vec3u(c.kernel.w) >> vec3u(4 * abs(offset))) & vec3u(15u);
                                let weight = w.x * w.y * w.z;
                                let child = cubes_child(clamp(tap, vec3i(0), vec3i(last)), 0u);
                                weights += weight;
                                lit += weight * ((mask >> child) & 1u);
                            }
                        }
                    }
                }
            }
        }
    }
    return vec2u(lit, weights);
}
