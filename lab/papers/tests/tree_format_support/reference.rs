//! A slow reader of the tree file, written from `spec/adumbra-tree.md` alone. It works on the bytes of the
//! file and shares nothing with the library. It checks nothing, so it must be given valid files. Their body
//! must be words, except for [`symmetric_voxel`].

use adumbra_testing::{f64_at, u32_at, u64_at};

fn word(file: &[u8], index: u32) -> u32 {
    u32_at(file, u64_at(file, 248) + 4 * u64::from(index))
}

/// Returns the voxel that contains a world point, if the point is in the cube.
pub(crate) fn voxel_of(file: &[u8], world: [f64; 3]) -> Option<[u32; 3]> {
    let side = 2_f64.powi(u32_at(file, 20) as i32);
    let mut voxel = [0; 3];
    for (a, v) in (0_u64..).zip(&mut voxel) {
        let at = (world[a as usize] - f64_at(file, 40 + 8 * a)) / f64_at(file, 64);
        if !(at >= 0.0 && at < side) {
            return None;
        }
        *v = at.floor() as u32;
    }
    Some(voxel)
}

/// Returns the visibility of a world point: 1 = lit, 0 = shadowed.
pub(crate) fn visibility(file: &[u8], world: [f64; 3]) -> u8 {
    voxel_of(file, world).map_or(1, |v| voxel(file, v).0)
}

/// Returns the visibility of a voxel, and its attribute byte if the file has an attribute and the voxel is in
/// a leaf of eight.
pub(crate) fn voxel(file: &[u8], [x, y, z]: [u32; 3]) -> (u8, Option<u8>) {
    let mut level = u32_at(file, 20);
    let mut node = word(file, 0);
    let mut before = 0;
    loop {
        if node >> 30 == 2 {
            return ((node & 1) as u8, None);
        }
        level -= 1;
        let child = (x >> level & 1) * 4 + (y >> level & 1) * 2 + (z >> level & 1);
        if node >> 30 == 3 {
            let there = u32_at(file, 36) == 1;
            let byte = || file[(u64_at(file, 272) + before + u64::from(child)) as usize];
            return ((node >> child & 1) as u8, there.then(byte));
        }
        if u32_at(file, 36) == 1 {
            before += (0..child).map(|c| leaf_voxels(file, word(file, node + c))).sum::<u64>();
        }
        node = word(file, node + child);
    }
}

/// Returns the number of voxels of the leaves of eight in and below a node, with a walk that enters shared
/// blocks each time.
pub(crate) fn leaf_voxels(file: &[u8], node: u32) -> u64 {
    match node >> 30 {
        2 => 0,
        3 => 8,
        _ => (0..8).map(|c| leaf_voxels(file, word(file, node + c))).sum(),
    }
}

/// Returns the root of the tree.
pub(crate) fn root(file: &[u8]) -> u32 {
    word(file, 0)
}

/// Returns the visibility of a voxel of a file with a symmetric body.
pub(crate) fn symmetric_voxel(file: &[u8], [x, y, z]: [u32; 3]) -> u32 {
    let body = u64_at(file, 248);
    let u32_in = |at: u32| u32_at(file, body + u64::from(at));
    let octant = |level: u32| (x >> level & 1) << 2 | (y >> level & 1) << 1 | z >> level & 1;
    // Total bytes of the children in the low bits of a header.
    let bytes = |header: u32| -> u32 {
        (0..8).map(|child| [0, 0, 0, 1, 1, 2, 3, 4][(header >> (3 * child) & 7) as usize]).sum()
    };
    let mirrors = u32_in(0) & 1 == 1;
    let (root, mut level, mut mirror) = (u32_in(4), u32_at(file, 20), 0);
    if root >> 30 == 3 {
        return root >> octant(level - 1) & 1;
    }
    if root >> 30 == 2 {
        return root & 1;
    }
    let mut at = root;
    loop {
        level -= 1;
        let child = octant(level) ^ mirror;
        let header = u32_in(at) & 0xff_ffff;
        let here = at + 3 + bytes(header & ((1 << (3 * child)) - 1));
        let value = u32_in(here);
        let kind = header >> (3 * child) & 7;
        at = match kind {
            0 | 1 => return kind,
            2 => at + 3 + bytes(header),
            3 => return value >> (octant(level - 1) ^ mirror) & 1,
            4 => here + 1 + (value & 0xff),
            5 => value & 0xffff,
            _ => {
                let value = if kind == 6 { value & 0xff_ffff } else { value };
                if mirrors {
                    mirror ^= value & 7;
                    value >> 3
                } else {
                    value
                }
            }
        };
    }
}
