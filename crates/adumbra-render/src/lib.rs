//! Draws a scene with baked and real-time shadows on any wgpu adapter.
