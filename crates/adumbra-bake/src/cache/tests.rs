//! Entries as bytes.

use adumbra::layout::depths::UNIFORM;
use adumbra::layout::depths::page::IN_PAGE;
use adumbra_scene::random::Random;
use blake3::Hasher;

use super::entry::{from_bytes, to_bytes};
use super::{CacheKey, PartGrid};
use crate::pages::OwnedPage;

fn key(byte: u8) -> CacheKey {
    CacheKey::new([byte; 32])
}

fn bytes_of(key: &CacheKey, pages: &[OwnedPage]) -> Vec<u8> {
    to_bytes(key, pages.iter().map(|page| (page.root, page.base, &*page.words)))
}

/// A page with a leaf of two depths in its corner, and a uniform page.
fn pages() -> Vec<OwnedPage> {
    use adumbra::layout::depths::child::Child;
    use adumbra::layout::depths::shapes::ShapeSet;
    let mut draft = ShapeSet::new(true);
    let mut index = draft.leaf(&LEAF);
    for level in [5, 7, 9] {
        let mut children = [Child::Never; 16];
        children[0] = Child::Shape { delta: 0, shape: index };
        children[5] = Child::Uniform(3);
        index = draft.node(level, &children);
    }
    let (words, root) = crate::pages::page(draft.list()).expect("a small page");
    vec![OwnedPage { root, base: 9, words }, OwnedPage { root: UNIFORM, base: 7, words: Vec::new() }]
}

/// A leaf whose columns have one of two depths: a head, a difference, and a bit for each column.
const LEAF: [u16; 6] = [1, 4, 0x00ff, 0x00ff, 0x00ff, 0x00ff];

#[test]
fn uniform_page_is_three_words() {
    let page = OwnedPage { root: UNIFORM, base: 7, words: Vec::new() };
    let bytes = bytes_of(&key(1), std::slice::from_ref(&page));
    assert_eq!(&bytes[..8], b"ADUMENT1");
    assert_eq!(bytes[40..], [0xff, 0xff, 0xff, 0xff, 7, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(from_bytes(&key(1), &bytes, [1, 1]), Some(vec![page]));
}

#[test]
fn entries_are_read_as_written_and_only_under_their_own_key() {
    let pages = pages();
    let bytes = bytes_of(&key(1), &pages);
    assert_eq!(from_bytes(&key(1), &bytes, [2, 1]), Some(pages));
    assert_eq!(from_bytes(&key(2), &bytes, [2, 1]), None);
    for dims in [[1, 1], [3, 1], [2, 2]] {
        assert_eq!(from_bytes(&key(1), &bytes, dims), None, "{dims:?}");
    }
    for length in 0..bytes.len() {
        assert_eq!(from_bytes(&key(1), &bytes[..length], [2, 1]), None);
    }
    for bit in 0..8 * bytes.len() {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(from_bytes(&key(1), &damaged, [2, 1]), None, "{bit}");
    }
}

/// Anyone can compute a checksum, so bytes with a correct one may still be invalid pages.
#[test]
fn forged_entries_are_rejected_or_readable() {
    let pages = pages();
    let bytes = bytes_of(&key(1), &pages);
    let mut random = Random::for_batch(11, 0);
    let mut refused = 0;
    for _ in 0..20_000 {
        let mut forged = bytes.clone();
        for _ in 0..1 + (random.unit() * 4.0) as usize {
            let at = 40 + (random.unit() * (bytes.len() - 40) as f64) as usize;
            forged[at] = (random.unit() * 256.0) as u8;
        }
        match from_bytes(&key(1), &signed(forged), [2, 1]) {
            None => refused += 1,
            Some(pages) => {
                let mut reader = crate::pages::Reader::default();
                for page in pages.iter().filter(|page| page.root != UNIFORM) {
                    reader.read(&page.words, page.root);
                }
            }
        }
    }
    assert!(refused > 10_000, "{refused}");
}

/// The root of a page is the address of a half-word in it, without the bit that a file adds to it.
#[test]
fn forged_roots_outside_their_page_are_rejected() {
    let pages = pages();
    let end = 2 * pages[0].words.len() as u32;
    for root in [end, UNIFORM & !IN_PAGE, IN_PAGE, pages[0].root | IN_PAGE, UNIFORM] {
        let mut forged = bytes_of(&key(1), &pages);
        forged[40..44].copy_from_slice(&root.to_le_bytes());
        assert_eq!(from_bytes(&key(1), &signed(forged), [2, 1]), None, "{root:#x}");
    }
}

/// Returns the bytes of an entry with a correct checksum.
fn signed(mut entry: Vec<u8>) -> Vec<u8> {
    let sum = Hasher::new().update(key(1).as_bytes()).update(&entry[40..]).finalize();
    entry[8..40].copy_from_slice(sum.as_bytes());
    entry
}

#[test]
fn key_has_one_text() {
    let text = key(0xab).to_string();
    assert_eq!(text.parse::<CacheKey>(), Ok(key(0xab)));
    for other in [text.to_uppercase(), text[2..].to_owned(), format!("{text}ab"), text.replace('b', "g")] {
        assert_eq!(other.parse::<CacheKey>(), Err(()), "{other}");
    }
}

#[test]
fn parts_have_each_root_block_and_each_page_once() {
    for (size, level) in [([1500, 700, 9], 5), ([1500, 700, 9], 9), ([9000, 5000, 9], 11), ([40, 40, 4], 5)] {
        let parts = PartGrid::new(size, level);
        let root_blocks = [0, 1].map(|a| size[a].div_ceil(1 << level));
        let mut seen_root_blocks = vec![0; (root_blocks[0] * root_blocks[1]) as usize];
        let dims = adumbra::layout::depths::page::page_dims(size);
        let mut seen_pages = vec![0; (dims[0] * dims[1]) as usize];
        for part in 0..parts.count() {
            for root_block in parts.root_blocks(part) {
                assert_eq!(parts.of_root_block(root_block), part);
                seen_root_blocks[root_block] += 1;
            }
            for page in parts.pages(part) {
                assert_eq!(parts.at_page(page), part);
                seen_pages[(page[1] * dims[0] + page[0]) as usize] += 1;
            }
            let [across, down] = parts.page_dims(part);
            assert_eq!(parts.pages(part).count(), (across * down) as usize);
        }
        assert!(seen_root_blocks.iter().chain(&seen_pages).all(|&n| n == 1), "{size:?} {level}");
    }
}
