//! Compares Bevy's pictures with baked shadows with look-ups on the CPU. Needs a GPU or a software adapter,
//! and the features `bake`, `gltf` and `processor`.

mod baking;
mod everyday;
mod files;
mod fog;
mod follow;
mod glass;
mod placing;
mod points;
mod processing;
mod stage;
mod streaming;
mod truth;
