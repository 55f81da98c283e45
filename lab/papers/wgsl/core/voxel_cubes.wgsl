// Look-up in a tree with 1, 3³ or 5³ cells; the counterpart of
// adumbra_papers::tree::query::TreeQuery::lit_weights, with the same result for every tap. Source: The
// Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm, 2021, §4.
// spec/adumbra-tree.md documents the tree and the kernel. The smallest cube that contains the whole kernel is
// looked up once. If it is uniform, nothing more is read. Otherwise cells are read in blocks of eight. Words
// are fetched by `fn adumbra_voxel_word(index: u32) -> u32` of an access/ file.

const ADUMBRA_CUBES_LEAF: u32 = 0x80000000u;
const ADUMBRA_CUBES_MASK: u32 = 0xc0000000u;

struct AdumbraCubesReceiver {
    // Position in voxels, fixed point, within the cube.
    p_fixed: vec3i,
    // Level of the cells.
    level: u32,
    // Fixed point, ADUMBRA_NORMAL_ONE = 1; zero if every tap counts.
    normal: vec3i,
    // Height above the plane of the receiver's surface in cells, fixed point, ADUMBRA_NORMAL_ONE = 1.
    height: i32,
}

// A word, and the number of levels below it.
struct AdumbraCubesNode {
    word: u32,
    level: u32,
}

fn adumbra_cubes_child(xyz: vec3i, level: u32) -> u32 {
    let bits = (vec3u(xyz) >> vec3u(level)) & vec3u(1u);
    return bits.x << 2u | bits.y << 1u | bits.z;
}

// Descends towards a voxel, down to a leaf or to the level `stop`.
fn adumbra_cubes_walk(from_node: AdumbraCubesNode, xyz: vec3i, stop: u32) -> AdumbraCubesNode {
    var node = from_node;
    while (node.word < ADUMBRA_CUBES_LEAF && node.level > stop) {
        node.level -= 1u;
        node.word = adumbra_voxel_word(node.word + adumbra_cubes_child(xyz, node.level));
    }
    return node;
}

// Returns the state of a voxel in a leaf: 1 = lit.
fn adumbra_cubes_leaf(node: AdumbraCubesNode, xyz: vec3i) -> u32 {
    if (node.word >= ADUMBRA_CUBES_MASK) {
        return (node.word >> adumbra_cubes_child(xyz, node.level - 1u)) & 1u;
    }
    return node.word & 1u;
}

// Returns the states of the eight cells of a block, bit i = child i. With several depths a cell may be
// subdivided further; its centre then decides.
fn adumbra_cubes_block(from_node: AdumbraCubesNode, block: vec3i, level: u32) -> u32 {
    let corner = block << vec3u(level + 1u);
    let node = adumbra_cubes_walk(from_node, corner, level + 1u);
    if (node.word >= ADUMBRA_CUBES_MASK && node.level == level + 1u) {
        return node.word & 255u;
    }
    if (node.word >= ADUMBRA_CUBES_LEAF) {
        return 255u * adumbra_cubes_leaf(node, corner);
    }
    var mask = 0u;
    let half = (1i << level) >> 1u;
    for (var i = 0u; i < 8u; i++) {
        let bits = vec3i(vec3u(i >> 2u, i >> 1u, i) & vec3u(1u));
        let middle = corner + (bits << vec3u(level)) + half;
        let cell = adumbra_cubes_walk(AdumbraCubesNode(adumbra_voxel_word(node.word + i), level), middle, 0u);
        mask |= adumbra_cubes_leaf(cell, middle) << i;
    }
    return mask;
}

// Returns the threshold at or above which normal · offset means that a tap is in front of the receiver's
// surface.
fn adumbra_cubes_plane(r: AdumbraCubesReceiver) -> i32 {
    let fraction = (r.p_fixed >> vec3u(r.level)) & vec3i(ADUMBRA_FIXED_ONE - 1);
    let along = r.normal * (ADUMBRA_FIXED_ONE / 2 - fraction);
    return -((r.height * ADUMBRA_FIXED_ONE + along.x + along.y + along.z) >> ADUMBRA_FIXED_BITS);
}

// Returns the weight of the lit taps and the weight of all taps that count. If all taps agree, these are 0 or
// 1, and 1.
fn adumbra_cubes_lit_weights(c: AdumbraCubesParams, r: AdumbraCubesReceiver) -> vec2u {
    let depth = c.depth;
    let reach = i32(c.reach);
    let cell = r.p_fixed >> vec3u(ADUMBRA_FIXED_BITS + r.level);
    let last = i32((1u << depth) >> r.level) - 1;
    let first_tap = cell - reach;
    let last_tap = cell + reach;
    // Outside the cube, the nearest cell is used.
    let low = clamp(first_tap, vec3i(0), vec3i(last));
    let high = clamp(last_tap, vec3i(0), vec3i(last));
    let differs = (low.x ^ high.x) | (low.y ^ high.y) | (low.z ^ high.z);
    let span = r.level + 32u - countLeadingZeros(u32(differs));
    let middle = (low << vec3u(r.level)) + ((1i << r.level) >> 1u);
    let stop = select(span, 0u, reach == 0);
    let ancestor = adumbra_cubes_walk(AdumbraCubesNode(adumbra_voxel_word(0u), depth), middle, stop);
    // A leaf of eight above the level of the span contains the whole kernel in one of its children.
    if (ancestor.word >= ADUMBRA_CUBES_LEAF && (reach == 0 || ancestor.word < ADUMBRA_CUBES_MASK || ancestor.level > span)) {
        return vec2u(adumbra_cubes_leaf(ancestor, middle), 1u);
    }
    let plane = adumbra_cubes_plane(r);
    var lit = 0u;
    var weights = 0u;
    for (var bx = first_tap.x >> 1u; bx <= last_tap.x >> 1u; bx++) {
        for (var by = first_tap.y >> 1u; by <= last_tap.y >> 1u; by++) {
            for (var bz = first_tap.z >> 1u; bz <= last_tap.z >> 1u; bz++) {
                let block = vec3i(bx, by, bz);
                let mask = adumbra_cubes_block(ancestor, clamp(block, vec3i(0), vec3i(last >> 1u)), r.level);
                let from_tap = max(2 * block, first_tap);
                let to_tap = min(2 * block + 1, last_tap);
                for (var x = from_tap.x; x <= to_tap.x; x++) {
                    for (var y = from_tap.y; y <= to_tap.y; y++) {
                        for (var z = from_tap.z; z <= to_tap.z; z++) {
                            let tap = vec3i(x, y, z);
                            let offset = tap - cell;
                            let along = r.normal * offset;
                            if (along.x + along.y + along.z >= plane || all(offset == vec3i(0))) {
                                let w = (vec3u(c.tap_weights) >> vec3u(4 * abs(offset))) & vec3u(15u);
                                let weight = w.x * w.y * w.z;
                                let child = adumbra_cubes_child(clamp(tap, vec3i(0), vec3i(last)), 0u);
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
