//! The light that pictures are drawn in, on the CPU and on the GPU alike: a plain sun, sky and ground.

/// Linear red, green and blue of sunlight at n·l = 1.
pub const SUN_COLOR: [f64; 3] = [1.55, 1.45, 1.28];
/// Linear red, green and blue of the light from above, and of the sky.
pub const SKY_COLOR: [f64; 3] = [0.36, 0.45, 0.60];
/// Linear red, green and blue of the light from below.
pub const GROUND_COLOR: [f64; 3] = [0.20, 0.18, 0.16];
