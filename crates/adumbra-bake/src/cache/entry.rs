//! The bytes of an entry.
//!
//! | offset | bytes | contents |
//! |---|---|---|
//! | 0 | 8 | `ADUMENT1` |
//! | 8 | 32 | BLAKE3 of the key and of all bytes from 40 on |
//! | 40 | 12 n | root, base and number of words of each of the part's n pages, x fastest |
//! | 40 + 12 n | | the words of the pages, in this order |
//!
//! All numbers are little-endian words of 32 bits. A page has the number of words 0 and the root `UNIFORM`,
//! 0xffffffff, if it has no shapes. The entry of one uniform page with the base 7 ends in `ffffffff 07000000
//! 00000000`.

use adumbra::layout::depths::page::{IN_PAGE, PAGE_LEVEL, Page, bundles, pages_of};
use adumbra::layout::depths::{TreeBuilder, UNIFORM};
use blake3::Hasher;

use super::CacheKey;
use crate::pages::OwnedPage;

/// The first bytes of an entry.
pub const ENTRY_MAGIC: &[u8; 8] = b"ADUMENT1";
const HEAD: usize = 40;
const PAGE_HEAD: usize = 12;
/// The most half-words of a page: 64 × 64 leaves, each with a head, a gradient, 63 differences of 32 bits and
/// six planes of 64 bits, and 16 × 16 + 4 × 4 + 1 nodes, each with three half-words and 16 fields of two.
const MOST_PAGE_HALVES: u64 = 4096 * (2 + 126 + 24) + 273 * (3 + 32);

/// Returns the bytes of an entry.
pub(super) fn to_bytes<'p>(
    key: &CacheKey,
    pages: impl Iterator<Item = (u32, u32, &'p [u32])> + Clone,
) -> Vec<u8> {
    let mut bytes = vec![0; HEAD];
    for (root, base, words) in pages.clone() {
        bytes.extend([root, base, words.len() as u32].into_iter().flat_map(u32::to_le_bytes));
    }
    pages.for_each(|(_, _, words)| words.iter().for_each(|word| bytes.extend(word.to_le_bytes())));
    bytes[..8].copy_from_slice(ENTRY_MAGIC);
    let sum = checksum(key, &bytes);
    bytes[8..HEAD].copy_from_slice(&sum);
    bytes
}

/// Returns the most bytes that an entry with `dims` pages along x and y can have.
pub(super) fn most_bytes(dims: [u32; 2]) -> u64 {
    let pages = u64::from(dims[0]) * u64::from(dims[1]);
    HEAD as u64 + pages * (PAGE_HEAD as u64 + 4 * MOST_PAGE_HALVES.div_ceil(2))
}

/// Returns the pages of an entry with `dims` pages along x and y. `None` if no bake has written these bytes
/// under this key.
pub(super) fn from_bytes(key: &CacheKey, bytes: &[u8], dims: [u32; 2]) -> Option<Vec<OwnedPage>> {
    let found = bytes.get(8..HEAD)?;
    if &bytes[..8] != ENTRY_MAGIC || checksum(key, bytes) != *found {
        return None;
    }
    from_own_bytes(bytes, dims).filter(|pages| is_valid(pages, dims))
}

/// Returns the pages of an entry that this process has made.
pub(super) fn from_own_bytes(bytes: &[u8], dims: [u32; 2]) -> Option<Vec<OwnedPage>> {
    let count = (dims[0] * dims[1]) as usize;
    let heads = bytes.get(HEAD..HEAD + PAGE_HEAD * count)?;
    let (words, []) = bytes[HEAD + PAGE_HEAD * count..].as_chunks::<4>() else { return None };
    let mut words = words.iter().map(|&b| u32::from_le_bytes(b));
    let pages: Vec<OwnedPage> = heads
        .as_chunks::<PAGE_HEAD>()
        .0
        .iter()
        .map(|head| {
            let number = |i: usize| u32::from_le_bytes([head[i], head[i + 1], head[i + 2], head[i + 3]]);
            let words = words.by_ref().take(number(8) as usize).collect();
            OwnedPage { root: number(0), base: number(4), words }
        })
        .collect();
    words.next().is_none().then_some(pages)
}

fn checksum(key: &CacheKey, bytes: &[u8]) -> [u8; 32] {
    *Hasher::new().update(key.as_bytes()).update(&bytes[HEAD..]).finalize().as_bytes()
}

/// Whether the pages are valid. A correct checksum does not prove it, because anyone can compute one.
fn is_valid(pages: &[OwnedPage], dims: [u32; 2]) -> bool {
    // Below, a uniform root has the bit too, so an address must not become one.
    let has_its_root = |page: &OwnedPage| match page.root {
        UNIFORM => page.words.is_empty(),
        root => (root as usize) < 2 * page.words.len(),
    };
    if !pages.iter().all(has_its_root) {
        return false;
    }
    let size = dims.map(|n| n << PAGE_LEVEL);
    let mut tree = TreeBuilder::new([size[0], size[1], 1], Vec::new());
    let page = |place: Option<[u32; 2]>| {
        place.map_or(Page::OUTSIDE, |[x, y]| {
            let OwnedPage { root, base, words } = &pages[(y * dims[0] + x) as usize];
            Page { root: root | IN_PAGE, base: *base, words }
        })
    };
    bundles(dims).into_iter().for_each(|at| tree.add(at, &pages_of(at, dims).map(page)));
    tree.finish().is_ok()
}
