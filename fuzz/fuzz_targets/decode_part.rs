//! Any bytes as a coded part, without the checks of a file around it: the decoder refuses them, or gives as
//! many bytes as it was asked for.
//!
//! The first byte decides: odd, the part is a bundle behind the common section of a test vector; even, it is
//! a common section, and the bundle of no bytes behind it. The next four are the raw length, which is limited
//! as in a file.

#![no_main]

use adumbra::Encoding;
use adumbra::file::{CommonSection, Contents};
use libfuzzer_sys::fuzz_target;

/// Largest ratio of the bytes of a part's shapes to its stored bytes in a file.
const LARGEST_RATIO: u32 = 16;
/// Bytes of a bundle before its shapes.
const HEAD_BYTES: u32 = 192;

const FILE: &[u8] = include_bytes!("../../test_vectors/valid/many_pages_coded_depths.adumbra");

thread_local! {
    static COMMON: CommonSection = common_of_vector();
}

fn name() -> String {
    "the part".to_owned()
}

fn common_of_vector() -> CommonSection {
    let contents = Contents::parse(FILE).expect("a valid vector");
    let grid = &contents.grids[0];
    let stored = &FILE[grid.common.offset as usize..grid.common.end() as usize];
    CommonSection::parse(stored, grid.common_raw_bytes, Encoding::Coded, name).expect("a valid vector")
}

fuzz_target!(|input: &[u8]| {
    let Some((&[kind, a, b, c, d], stored)) = input.split_first_chunk() else { return };
    let most = LARGEST_RATIO.saturating_mul(stored.len() as u32) + (kind & 1) as u32 * HEAD_BYTES;
    let raw_bytes = u32::from_le_bytes([a, b, c, d]) % most.saturating_add(1) / 4 * 4;
    let length = |words: usize| assert_eq!(4 * words, raw_bytes as usize);
    if kind & 1 == 1 {
        COMMON.with(|common| {
            if let Ok(words) = common.parse_bundle(stored, raw_bytes, name) {
                length(words.len());
            }
        });
    } else if !stored.is_empty()
        && let Ok(common) = CommonSection::parse(stored, raw_bytes.into(), Encoding::Coded, name)
    {
        length(common.words().len());
        assert!(common.parse_bundle(&[], raw_bytes, name).is_err());
    }
});
