//! Lighting and tone mapping of a surface: the CPU counterpart of `wgsl/passes/composite.wgsl`.

use adumbra_scene::daylight::{GROUND_COLOR, SKY_COLOR, SUN_COLOR};
use adumbra_scene::{linear_to_srgb, srgb_to_linear};

/// Linear colour of the sky in a unit direction.
pub fn sky(direction: [f64; 3]) -> [f64; 3] {
    let height = (direction[1] * 0.5 + 0.5).clamp(0.0, 1.0);
    SKY_COLOR.map(|c| c * (1.25 - 0.5 * height))
}

/// Linear colour of a surface: its base colour lit by the ambient light of sky and ground and by the sun.
/// Sunlight is scaled by n·l and by the sun's `visibility`, 0 to 1.
pub fn lit(base_color: [f64; 3], normal: [f64; 3], n_dot_l: f64, visibility: f64) -> [f64; 3] {
    let up = normal[1] * 0.5 + 0.5;
    std::array::from_fn(|a| {
        let ambient = SKY_COLOR[a] * up + GROUND_COLOR[a] * (1.0 - up);
        base_color[a] * (ambient + SUN_COLOR[a] * n_dot_l.max(0.0) * visibility)
    })
}

/// The sRGB pixel that displays a linear colour, tone mapped with a gentle shoulder so that sunlit white
/// stays below white.
pub fn shown(color: [f64; 3]) -> [u8; 3] {
    encoded(toned(color))
}

/// Quantises a linear colour as an 8-bit sRGB texel does, for example in a G-buffer.
pub fn in_8_bits(color: [f64; 3]) -> [f64; 3] {
    encoded(color).map(|byte| f64::from(srgb_to_linear(byte)))
}

pub(super) fn toned(color: [f64; 3]) -> [f64; 3] {
    color.map(|c| c * (1.0 + c / 4.0) / (1.0 + c))
}

/// Returns a linear colour in 8-bit sRGB.
pub fn encoded(linear: [f64; 3]) -> [u8; 3] {
    linear.map(|c| linear_to_srgb(c as f32))
}
