//! Shared code of the quick test and the fuzz target. It damages a file, repairs the checksums, and checks
//! that the reader either refuses the file or returns a quadtree in which every voxel can be looked up.

mod damage;

use adumbra::layout::depths::code::ColumnNode;
use adumbra::{Encoding, FormatError, ShadowFile};
pub(crate) use damage::{interpret, mutate};

/// Reads `bytes`. If the file is accepted, checks that it is written as exactly the same bytes if it is raw,
/// that both ways of writing it give the same file, and that its voxels can be looked up.
///
/// # Panics
/// If the library is wrong.
pub(crate) fn exercise(bytes: &[u8]) -> Result<ShadowFile, FormatError> {
    let file = ShadowFile::from_bytes(bytes);
    match &file {
        Ok(file) => {
            let raw = encode(file);
            if bytes[ENCODING] == 0 {
                assert_eq!(raw, bytes, "an accepted raw file is the only one with its contents");
            } else {
                assert_eq!(ShadowFile::from_bytes(&raw).as_ref(), Ok(file));
            }
            // A coder may leave equal shapes unmerged. Such a file is not coded again.
            match file.to_bytes(Encoding::Coded) {
                Ok(coded) => assert_eq!(ShadowFile::from_bytes(&coded).as_ref(), Ok(file)),
                Err(error) => assert_eq!(error.kind(), "Uncodable"),
            }
            for level in (0..file.level_count()).filter_map(|level| file.level(level)) {
                sweep(&level, 512);
            }
        }
        // Formatting the message must not fail either.
        Err(error) => assert!(!error.to_string().is_empty() && !error.kind().is_empty()),
    }
    file
}

/// Offset of the header's field `encoding`.
const ENCODING: usize = 28;

/// Returns the bytes of the raw file.
pub(crate) fn encode(file: &ShadowFile) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let written = file.write_to(&mut bytes, Encoding::Raw).expect("a valid file");
    let bytes = bytes.into_inner();
    assert_eq!((written, file.encoded_len()), (bytes.len() as u64, bytes.len() as u64));
    bytes
}

/// Looks up about `most` voxels, or all if there are fewer, in every available way. Returns how many are lit.
///
/// # Panics
/// If two ways give different results.
pub(crate) fn sweep(file: &ShadowFile, most: u64) -> u64 {
    let size = file.grid.size;
    let all: u64 = size.iter().map(|&n| u64::from(n)).fold(1, u64::saturating_mul);
    let step = all.div_ceil(most).max(1) | 1;
    let mut lit = 0;
    let mut i = 0_u64;
    while i < all {
        let [sx, sy, _] = size.map(u64::from);
        let v = [(i % sx) as u32, (i / sx % sy) as u32, (i / (sx * sy)) as u32];
        lit += u64::from(is_lit_in_every_way(file, v));
        let Some(next) = i.checked_add(step) else { break };
        i = next;
    }
    lit
}

/// Returns whether a voxel is lit. Checks that its column's depth, and the depths and bounds of its block
/// agree.
fn is_lit_in_every_way(file: &ShadowFile, [i, j, k]: [u32; 3]) -> bool {
    let tree = &file.tree;
    let depth = tree.value(i, j);
    let lit = tree.voxel(i, j, k);
    assert_eq!(lit, k < depth, "({i}, {j}, {k})");
    match tree.place(i, j).0 {
        ColumnNode::Uniform(value) => assert_eq!(value, depth, "({i}, {j})"),
        ColumnNode::Leaf { at, base } => {
            let leaf = tree.shapes().leaf(at, base);
            let [nearest, farthest] = leaf.bounds();
            assert!((nearest..=farthest).contains(&depth), "{nearest} to {farthest}: ({i}, {j})");
            assert_eq!(leaf.values()[((j & 7) * 8 + (i & 7)) as usize], depth, "({i}, {j})");
        }
    }
    lit
}
