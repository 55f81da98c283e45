//! Tests of the program, as a user runs it.

mod bake_watch;
mod cache;
mod compare;
mod compressed;
mod convert;
mod device;
#[cfg(feature = "view")]
mod display;
mod farm;
mod glance;
mod ground;
#[cfg(target_os = "linux")]
mod interrupts;
mod levels;
mod memory;
mod movers;
mod nothing_lost;
mod occlusion;
mod options;
#[cfg(target_os = "linux")]
mod outputs;
mod path;
mod program;
mod regions;
mod scenes;
mod sunlight;
mod suns;
mod sweep;
mod up;
mod view;
mod view_refuses;
