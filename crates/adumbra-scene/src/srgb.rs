//! The sRGB transfer function (IEC 61966-2-1) in 8 bits, bit-identical on every machine.

use std::sync::LazyLock;

/// Linear value of each 8-bit sRGB value.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| decode(i as f64) as f32));

/// For each 8-bit sRGB value except 0, the smallest linear value that rounds to it.
static STEPS: LazyLock<[f32; 255]> = LazyLock::new(|| std::array::from_fn(|i| decode(i as f64 + 0.5) as f32));

fn decode(value_of_255: f64) -> f64 {
    let s = value_of_255 / 255.0;
    if s <= 0.04045 { s / 12.92 } else { libm::pow((s + 0.055) / 1.055, 2.4) }
}

/// The linear value, 0 to 1, of an sRGB byte.
pub fn srgb_to_linear(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

/// The sRGB byte nearest to a linear value. Values outside 0 to 1 are clamped; NaN gives 0.
pub fn linear_to_srgb(linear: f32) -> u8 {
    STEPS.partition_point(|&step| step <= linear) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_bytes_survive_a_round_trip_through_linear() {
        for byte in 0..=255 {
            assert_eq!(linear_to_srgb(srgb_to_linear(byte)), byte);
        }
        for (linear, byte) in
            [(-1.0, 0), (0.0, 0), (0.214_041, 127), (0.5, 188), (1.0, 255), (7.0, 255), (f32::NAN, 0)]
        {
            assert_eq!(linear_to_srgb(linear), byte, "{linear}");
        }
    }
}
