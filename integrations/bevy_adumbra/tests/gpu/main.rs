//! What Bevy draws with baked shadows, compared with look-ups on the CPU. Needs a GPU or a software adapter,
//! and the features `bake` and `gltf`.

mod baking;
mod files;
mod fog;
mod points;
mod stage;
mod truth;
