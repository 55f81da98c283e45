//! Points as a binary PLY file, coloured by their hours.

use super::traced::Traced;
use crate::cmd::scale::color;

/// Returns the file: position, normal (zero without one), colour and hours of each point.
pub(super) fn hours(traced: &Traced) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment hours of direct sun, {}\nelement vertex {}\n\
         property double x\nproperty double y\nproperty double z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         property float hours\nend_header\n",
        traced.when(),
        traced.hours.len()
    )
    .into_bytes();
    for (number, point) in traced.receivers() {
        let hours = traced.hours_of(number);
        point.p_world.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        point.normal().unwrap_or_default().iter().for_each(|&c| bytes.extend((c as f32).to_le_bytes()));
        bytes.extend(color(hours / traced.most_hours.max(f64::MIN_POSITIVE)));
        bytes.extend((hours as f32).to_le_bytes());
    }
    bytes
}
