//! What the quick test and the fuzz target do to a file: break it, make the checksums right again, and see that the
//! reader either refuses it or gives a graph that answers everywhere.

mod damage;

use adumbra::dag::{Dag, LIT, SHADOWED, SLAB_NODE_LEVEL, STATE_LIT, STATE_MIXED, STATE_SHADOWED, Trail};
use adumbra::format::{FormatError, HEADER_BYTES, LightBody, ShadowFile};
use damage::Layout;

/// The light-aligned file: nodes are words, slabs eight bytes.
const LAYOUT: Layout = Layout {
    header_bytes: HEADER_BYTES,
    table: 280,
    resizable: [(1, 4), (2, 8)],
    values: &[0, 1, 0x5555, 0xAAAA, 0xFFFF, LIT, SHADOWED],
    step: 1,
};

/// The bytes that a fuzzer's input stands for, see [`damage::interpret`].
pub(crate) fn interpret(input: &[u8]) -> Vec<u8> {
    damage::interpret(input, &LAYOUT)
}

/// A deterministic source of mutations.
pub(crate) struct Mutator(damage::Mutator);

impl Mutator {
    pub(crate) fn new(seed: u64) -> Self {
        Self(damage::Mutator::new(seed, LAYOUT))
    }

    pub(crate) fn mutate(&mut self, valid: &[u8]) -> Vec<u8> {
        self.0.mutate(valid)
    }
}

/// Reads `bytes`; a file that is accepted must be written as the very same bytes, and must answer.
///
/// # Panics
/// When the library is wrong.
pub(crate) fn exercise(bytes: &[u8]) -> Result<ShadowFile, FormatError> {
    let file = ShadowFile::from_bytes(bytes);
    match &file {
        Ok(file) => {
            let again = encode(file);
            if bytes[8] == 1 {
                // Version 2 is written of what version 1 has said.
                assert_eq!(ShadowFile::from_bytes(&again).as_ref(), Ok(file));
            } else {
                assert_eq!(again, bytes, "an accepted file is the only one with its contents");
            }
            sweep(file, 512);
        }
        // A message must not fail either.
        Err(error) => assert!(!error.to_string().is_empty() && !error.kind().is_empty()),
    }
    file
}

pub(crate) fn encode(file: &ShadowFile) -> Vec<u8> {
    let mut bytes = Vec::new();
    let written = file.write_to(&mut bytes).expect("a valid file");
    assert_eq!((written, file.encoded_len()), (bytes.len() as u64, bytes.len() as u64));
    bytes
}

/// Looks up to about `most` voxels up, every one where there are so few, in every way there is; returns how many are lit.
///
/// # Panics
/// Where two ways give two answers.
pub(crate) fn sweep(file: &ShadowFile, most: u64) -> u64 {
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

/// The answer of a voxel: by itself, of its slab, and of the slabs that a walk along the light finds together.
fn is_lit_in_every_way(file: &ShadowFile, trail: &mut Trail, [i, j, k]: [u32; 3]) -> bool {
    let lit = is_lit(file, [i, j, k]);
    let slab = file.slabs().slab(i, j, k);
    assert_eq!(slab >> ((j & 7) * 8 + (i & 7)) & 1 == 1, lit, "slab of ({i}, {j}, {k})");
    let mut slabs = [0; 8];
    let known = file.slabs().fill_along(trail, [i, j, k], &mut slabs);
    assert_eq!((known >> (k & 7) & 1, slabs[k as usize & 7]), (1, slab), "walk to ({i}, {j}, {k})");
    for (other, &slab) in slabs.iter().enumerate().filter(|(other, _)| known >> other & 1 == 1) {
        let beside = k & !7 | other as u32;
        if beside < file.grid.size[2] {
            assert_eq!(file.slabs().slab(i, j, beside), slab, "({i}, {j}, {beside}) beside {k}");
        }
    }
    lit
}

/// The answer of a voxel; every index is checked by Rust, and the steps are counted.
pub(crate) fn is_lit(file: &ShadowFile, v: [u32; 3]) -> bool {
    match &file.body {
        LightBody::Plain(dag) => is_lit_in(dag, v),
        LightBody::Packed(packed) => packed.voxel(v[0], v[1], v[2]),
        LightBody::Hierarchy(hierarchy) => v[2] < hierarchy.value(v[0], v[1]),
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
    for level in (SLAB_NODE_LEVEL..=dag.root_level).rev() {
        let bit = |c: u32| c >> (level - 1) & 1;
        let child = if level == SLAB_NODE_LEVEL { z & 7 } else { bit(x) << 2 | bit(y) << 1 | bit(z) };
        let header = dag.nodes[at];
        match header >> (2 * child) & 3 {
            STATE_SHADOWED => return false,
            STATE_LIT => return true,
            state => assert_eq!(state, STATE_MIXED),
        }
        let before = (header & ((1 << (2 * child)) - 1) & 0xAAAA).count_ones() as usize;
        at = dag.nodes[at + 1 + before] as usize;
    }
    dag.slabs[at] >> ((y & 7) * 8 + (x & 7)) & 1 == 1
}
