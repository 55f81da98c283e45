//! Any bytes: the reader refuses them, or gives a quadtree that answers everywhere and, if the file is raw,
//! is written as the same bytes.
//!
//! The first byte decides whether checksums are made right, see `interpret`; files as they are serve as
//! seeds.

#![no_main]

#[allow(dead_code, unused_imports, reason = "the mutator is for the quick test; libFuzzer has its own")]
#[path = "../../crates/adumbra/tests/format_support/mod.rs"]
mod format_support;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let _ = format_support::exercise(&format_support::interpret(input));
});
