//! Points as a table: comma-separated values.

use std::fmt::Write as _;

use adumbra_sunlight::{Receiver, SkyView};

use super::json::hex;
use super::traced::Traced;

/// Returns the table of hours. Spans are by the local clock, `07:00-09:12 10:30-19:00`.
pub(super) fn hours(traced: &Traced) -> String {
    let mut text = "x,y,z,nx,ny,nz,hours,intervals\n".to_owned();
    for (number, point) in traced.receivers() {
        let spans = traced.clock_spans(number);
        let spans: Vec<String> = spans.iter().map(|[begin, end]| format!("{begin}-{end}")).collect();
        // Writing to a String does not fail.
        let _ = writeln!(text, "{},{:.4},{}", place(point), traced.hours_of(number), spans.join(" "));
    }
    text
}

/// Returns the table of skies.
pub(super) fn skies(receivers: &[Receiver], views: &[SkyView]) -> String {
    let mut text = "x,y,z,nx,ny,nz,sky_view_factor,shade_fraction,patches\n".to_owned();
    for (point, view) in receivers.iter().zip(views) {
        let _ = writeln!(
            text,
            "{},{:.6},{:.6},{}",
            place(point),
            view.sky_view_factor,
            view.shade_fraction,
            hex(&view.bits)
        );
    }
    text
}

/// Position and normal. Without a normal its columns are empty.
fn place(point: &Receiver) -> String {
    let position = rounded(point.p_world);
    point.normal().map_or_else(|| format!("{position},,,"), |n| format!("{position},{}", rounded(n)))
}

/// Numbers to a millionth, without trailing zeros.
fn rounded(numbers: [f64; 3]) -> String {
    let [x, y, z] = numbers.map(|n| (n * 1e6).round() / 1e6 + 0.0);
    format!("{x},{y},{z}")
}

#[cfg(test)]
mod tests {
    use adumbra_sunlight::points::Facing;

    use super::*;

    #[test]
    fn table_of_skies_has_a_line_for_each_point() {
        let point = Receiver { p_world: [0.1 + 0.2, -0.0, 1e6], facing: Facing::Space, lift_world: 0.0 };
        let wall = Receiver { facing: Facing::Front([0.0, 0.0, -1.0]), ..point };
        let view = SkyView { bits: vec![0x0f, 0xa0], sky_view_factor: 0.25, shade_fraction: 1.0 };
        assert_eq!(
            skies(&[point, wall], &[view.clone(), view]),
            "x,y,z,nx,ny,nz,sky_view_factor,shade_fraction,patches\n\
             0.3,0,1000000,,,,0.250000,1.000000,0fa0\n0.3,0,1000000,0,0,-1,0.250000,1.000000,0fa0\n"
        );
    }
}
