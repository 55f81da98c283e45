//! Tests of the program, as a user runs it.

mod cache;
mod compare;
mod compressed;
mod convert;
mod device;
#[cfg(feature = "view")]
mod display;
mod export;
mod levels;
mod memory;
mod movers;
mod nothing_lost;
mod occlusion;
mod options;
mod program;
mod scenes;
mod suns;
mod view;
