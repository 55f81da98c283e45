//! Code shared by the quick test and the fuzz target: damages a graph file, repairs its checksums, and checks
//! that the reader either refuses it or returns a graph in which every voxel can be looked up.

#[path = "../format_damage/mod.rs"]
mod format_damage;

use adumbra_papers::dag::plain::{Dag, LIT, SHADOWED, STATE_LIT, STATE_MIXED, STATE_SHADOWED};
use adumbra_papers::dag::roots::LEAF_NODE_LEVEL;
use adumbra_papers::dag::{DAG_HEADER_BYTES, DagBody, DagFile, DagFileError, Trail};
use format_damage::Layout;

/// Offsets and sizes of the graph file. Its nodes are words, and its leaf masks have eight bytes.
pub(crate) const LAYOUT: Layout = Layout {
    header_bytes: DAG_HEADER_BYTES,
    table: 280,
    resizable: [(1, 4), (2, 8)],
    values: &[0, 1, 0x5555, 0xAAAA, 0xFFFF, LIT, SHADOWED],
    step: 1,
};

/// Reads `bytes`. If the file is accepted, checks that it is written as exactly the same bytes and that its
/// voxels can be looked up.
///
/// # Panics
/// If the library is wrong.
pub(crate) fn exercise(bytes: &[u8]) -> Result<DagFile, DagFileError> {
    let file = DagFile::from_bytes(bytes);
    match &file {
        Ok(file) => {
            assert_eq!(encode(file), bytes, "an accepted file is the only one with its contents");
            sweep(file, 512);
        }
        // Formatting the message must not fail either.
        Err(error) => assert!(!error.to_string().is_empty() && !error.kind().is_empty()),
    }
    file
}

pub(crate) fn encode(file: &DagFile) -> Vec<u8> {
    let mut bytes = Vec::new();
    let written = file.write_to(&mut bytes).expect("a valid file");
    assert_eq!((written, file.encoded_len()), (bytes.len() as u64, bytes.len() as u64));
    bytes
}

/// Looks up about `most` voxels, or all if there are fewer, in every available way. Returns how many are lit.
///
/// # Panics
/// If two ways give different results.
pub(crate) fn sweep(file: &DagFile, most: u64) -> u64 {
    let mut trail = Trail::new();
    let size = file.grid.size;
    let all: u64 = size.iter().map(|&n| u64::from(n)).fold(1, u64::saturating_mul);
    let step = all.div_ceil(most).max(1) | 1;
    let mut lit = 0;
    let mut i = 0_u64;
    while i < all {
        let [sx, sy, _] = size.map(u64::from);
        let v = [(i % sx) as u32, (i / sx % sy) as u32, (i / (sx * sy)) as u32];
        lit += u64::from(is_lit_in_every_way(file, &mut trail, v));
        let Some(next) = i.checked_add(step) else { break };
        i = next;
    }
    lit
}

/// Returns whether a voxel is lit. Checks that its own look-up, its leaf mask, and the leaf masks that a walk
/// along the light finds together agree.
fn is_lit_in_every_way(file: &DagFile, trail: &mut Trail, [i, j, k]: [u32; 3]) -> bool {
    let voxels = file.body.leaf_masks();
    let lit = is_lit(file, [i, j, k]);
    let leaf_mask = voxels.look_up(i, j, k);
    assert_eq!(voxels.voxel(i, j, k), lit, "leaf mask of ({i}, {j}, {k})");
    let mut leaf_masks = [0; 8];
    let known = voxels.fill(trail, [i, j, k], &mut leaf_masks);
    assert_eq!((known >> (k & 7) & 1, leaf_masks[k as usize & 7]), (1, leaf_mask), "walk to ({i}, {j}, {k})");
    for (other, &leaf_mask) in leaf_masks.iter().enumerate().filter(|(other, _)| known >> other & 1 == 1) {
        let beside = k & !7 | other as u32;
        if beside < file.grid.size[2] {
            assert_eq!(voxels.look_up(i, j, beside), leaf_mask, "({i}, {j}, {beside}) beside {k}");
        }
    }
    lit
}

/// Returns whether a voxel is lit. All accesses are bounds-checked, and the number of steps is limited.
pub(crate) fn is_lit(file: &DagFile, [i, j, k]: [u32; 3]) -> bool {
    match &file.body {
        DagBody::Plain(dag) => is_lit_in(dag, [i, j, k]),
        DagBody::Packed(_) => file.body.leaf_masks().voxel(i, j, k),
    }
}

fn is_lit_in(dag: &Dag, [x, y, z]: [u32; 3]) -> bool {
    let [gx, gy, gz] = [x, y, z].map(|c| (c >> dag.root_level) as usize);
    let [dx, dy, _] = dag.top_dims.map(|d| d as usize);
    let mut at = match dag.top[(gz * dy + gy) * dx + gx] {
        LIT => return true,
        SHADOWED => return false,
        root => root as usize,
    };
    for level in (LEAF_NODE_LEVEL..=dag.root_level).rev() {
        let bit = |c: u32| c >> (level - 1) & 1;
        let child = if level == LEAF_NODE_LEVEL { z & 7 } else { bit(x) << 2 | bit(y) << 1 | bit(z) };
        let header = dag.nodes[at];
        match header >> (2 * child) & 3 {
            STATE_SHADOWED => return false,
            STATE_LIT => return true,
            state => assert_eq!(state, STATE_MIXED),
        }
        let before = (header & ((1 << (2 * child)) - 1) & 0xAAAA).count_ones() as usize;
        at = dag.nodes[at + 1 + before] as usize;
    }
    dag.leaf_masks[at] >> ((y & 7) * 8 + (x & 7)) & 1 == 1
}
