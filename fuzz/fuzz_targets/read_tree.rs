//! Any bytes: the reader refuses them, or gives a tree that answers everywhere and is written as the same
//! bytes.
//!
//! The first byte decides whether checksums are made right, see `Layout::interpret`; files as they are serve
//! as seeds.

#![no_main]

#[allow(dead_code, reason = "the mutator is for the quick test; libFuzzer has its own")]
#[path = "../../lab/papers/tests/tree_format_support/mod.rs"]
mod tree_format_support;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let _ = tree_format_support::exercise(&tree_format_support::LAYOUT.interpret(input));
});
