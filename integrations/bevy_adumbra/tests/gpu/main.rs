//! What Bevy draws with baked shadows, compared with look-ups on the CPU. Needs a GPU or a software adapter.

mod files;
mod points;
mod stage;
mod truth;
