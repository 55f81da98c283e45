//! The filters on the CPU.

use adumbra_shaders::layout::{Frame, OcclusionFilterParams};

use super::{Ambient, index, texels};
use crate::occlusion::settings::{Filter, OcclusionSettings};

/// Runs all passes of the filter on a picture.
pub(super) fn filter(settings: &OcclusionSettings, frame: &Frame, from: Vec<Ambient>) -> Vec<Ambient> {
    (0..settings.filter_passes()).fold(from, |from, axis| {
        let pass = Pass { params: settings.filter_params(frame, axis), from: &from };
        texels(pass.size())
            .map(|texel| match settings.filter {
                Filter::BilateralSquare => pass.square(texel),
                Filter::Gauss => pass.line(texel, false),
                _ => pass.line(texel, true),
            })
            .collect()
    })
}

/// Share of the filter's work on surfaces that its edge test saves: skipped texels over all texels, summed
/// over the filter's passes. `from` is the estimate.
pub fn skipped(settings: &OcclusionSettings, frame: &Frame, from: &[Ambient]) -> f64 {
    let tested = OcclusionSettings { edge_test: true, ..*settings };
    let (mut left, mut all) = (0_u32, 0_u32);
    let mut picture = from.to_vec();
    for axis in 0..tested.filter_passes() {
        let pass = Pass { params: tested.filter_params(frame, axis), from: &picture };
        for texel in texels(pass.size()) {
            let [visibility, z] = pass.at(texel);
            let even = match tested.filter {
                Filter::BilateralSquare => pass.is_even_square(texel, visibility),
                _ => pass.is_even_line(texel, visibility),
            };
            left += u32::from(z > 0.0 && even);
            all += u32::from(z > 0.0);
        }
        if tested.filter_passes() == 2 {
            let seeing = tested.filter != Filter::Gauss;
            picture = texels(pass.size()).map(|texel| pass.line(texel, seeing)).collect();
        }
    }
    f64::from(left) / f64::from(all.max(1))
}

/// Twin of `adumbra_occlusion_run`.
pub(super) fn run(before: f32, own: f32, after: f32, kind: [f32; 2], inverse_width: f32) -> [f32; 2] {
    let (back, on) = (before - own, after - own);
    let is_before = before > 0.0 && (after <= 0.0 || back.abs() < on.abs());
    let other = if is_before { before } else { after };
    let step = other - own;
    let is_steep = step.abs() * inverse_width > 1.0;
    let goes_on = before > 0.0 && after > 0.0 && back * on < 0.0;
    if other <= 0.0 || (is_steep && !goes_on) {
        return [0.0; 2];
    }
    let side = if is_before { -1.0 } else { 1.0 };
    [side * kind[0] * (own / other - 1.0), side * kind[1] * step]
}

struct Pass<'a> {
    params: OcclusionFilterParams,
    from: &'a [Ambient],
}

impl Pass<'_> {
    fn size(&self) -> [u32; 2] {
        self.params.size
    }

    fn side(&self) -> i32 {
        self.params.taps_per_side as i32
    }

    /// The texel, clamped to the border.
    fn at(&self, texel: [i32; 2]) -> Ambient {
        let [width, height] = self.size().map(|s| s as i32);
        self.from[(texel[1].clamp(0, height - 1) * width + texel[0].clamp(0, width - 1)) as usize]
    }

    fn axis(&self) -> [i32; 2] {
        if self.params.axis == 1 { [0, 1] } else { [1, 0] }
    }

    fn weight_of(&self, squared: i32, z: f32, other_z: f32, run: [f32; 2]) -> f32 {
        let d = (other_z * (1.0 + run[0]) - (z + run[1])) * self.params.inverse_depth_width;
        if other_z > 0.0 { (-d * d - squared as f32 * self.params.inverse_distance_width).exp() } else { 0.0 }
    }

    fn run(&self, texel: [i32; 2], axis: [i32; 2], z: f32) -> [f32; 2] {
        let depth_at = |texel| index(self.size(), texel).map_or(0.0, |i| self.from[i][1]);
        let [before, after] = [-1, 1].map(|side| depth_at(along(texel, axis, side)));
        run(before, z, after, self.params.plane_kind, self.params.inverse_depth_width)
    }

    fn line(&self, texel: [i32; 2], sees_depth: bool) -> Ambient {
        let [own, z] = self.at(texel);
        if z <= 0.0 || (self.params.edge_tolerance >= 0.0 && self.is_even_line(texel, own)) {
            return [own, z];
        }
        let axis = self.axis();
        let run = if sees_depth { self.run(texel, axis, z) } else { [0.0; 2] };
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in -self.side()..=self.side() {
            let Some(at) = index(self.size(), along(texel, axis, i)) else { continue };
            let [other, other_z] = self.from[at];
            let weight = if sees_depth {
                self.weight_of(i * i, z, other_z, run.map(|r| i as f32 * r))
            } else if other_z > 0.0 {
                ((-i * i) as f32 * self.params.inverse_distance_width).exp()
            } else {
                0.0
            };
            sum += weight * other;
            weights += weight;
        }
        [sum / weights, z]
    }

    fn square(&self, texel: [i32; 2]) -> Ambient {
        let [own, z] = self.at(texel);
        if z <= 0.0 || (self.params.edge_tolerance >= 0.0 && self.is_even_square(texel, own)) {
            return [own, z];
        }
        let (run_x, run_y) = (self.run(texel, [1, 0], z), self.run(texel, [0, 1], z));
        let (mut sum, mut weights) = (0.0, 0.0);
        for j in -self.side()..=self.side() {
            for i in -self.side()..=self.side() {
                let Some(at) = index(self.size(), [texel[0] + i, texel[1] + j]) else { continue };
                let [other, other_z] = self.from[at];
                let run = [0, 1].map(|a| i as f32 * run_x[a] + j as f32 * run_y[a]);
                let weight = self.weight_of(i * i + j * j, z, other_z, run);
                sum += weight * other;
                weights += weight;
            }
        }
        [sum / weights, z]
    }

    fn agrees(&self, texel: [i32; 2], visibility: f32) -> bool {
        (self.at(texel)[0] - visibility).abs() <= self.params.edge_tolerance
    }

    fn is_even_line(&self, texel: [i32; 2], visibility: f32) -> bool {
        let middle = (self.side() + 1) / 2;
        [-self.side(), self.side(), -middle, middle]
            .into_iter()
            .all(|i| self.agrees(along(texel, self.axis(), i), visibility))
    }

    fn is_even_square(&self, [x, y]: [i32; 2], visibility: f32) -> bool {
        let (tip, m) = (self.side(), (self.side() + 1) / 2);
        [[-tip, 0], [tip, 0], [0, -tip], [0, tip], [-m, -m], [m, m], [-m, m], [m, -m]]
            .into_iter()
            .all(|d| self.agrees([x + d[0], y + d[1]], visibility))
    }
}

pub(super) fn along(texel: [i32; 2], axis: [i32; 2], i: i32) -> [i32; 2] {
    [texel[0] + i * axis[0], texel[1] + i * axis[1]]
}

#[cfg(test)]
mod tests {
    use super::run;

    /// Largest distance of a line's taps from the surface that `run` predicts, relative to the view depth.
    /// `depth` is a function of the texel.
    fn miss(depth: impl Fn(f32) -> f32, kind: [f32; 2]) -> f32 {
        let own = depth(0.0);
        let [s, t] = run(depth(-1.0), own, depth(1.0), kind, 10.0);
        let off = |i: i32| (depth(i as f32) * (1.0 + s * i as f32) - (own + t * i as f32)).abs() / own;
        (-4..=4).map(off).fold(0.0, f32::max)
    }

    #[test]
    fn run_follows_planes_at_any_angle() {
        for slope in [-0.12, -0.01, 0.0, 0.003, 0.1] {
            // In perspective, inverse view depth is linear. The steepest plane ranges from 0.68 to 1.92 times
            // its view depth at the centre.
            assert!(miss(|i| 20.0 / (1.0 + slope * i), [1.0, 0.0]) < 1e-5, "{slope}");
            assert!(miss(|i| 20.0 + 30.0 * slope * i, [0.0, 1.0]) < 1e-5, "{slope}");
        }
        // With plain differences, the taps miss the same plane.
        assert!(miss(|i| 20.0 / (1.0 + 0.1 * i), [0.0, 0.0]) > 0.1);
    }

    #[test]
    fn run_stays_within_a_surface_at_its_edges() {
        let kind = [1.0, 0.0];
        // In order: one texel wide in front of other surfaces; between the sky and a surface; at an edge,
        // beside a neighbour of equal depth; surrounded by sky.
        assert_eq!(run(30.0, 20.0, 40.0, kind, 10.0), [0.0; 2]);
        assert_eq!(run(0.0, 20.0, 40.0, kind, 10.0), [0.0; 2]);
        assert_eq!(run(20.0, 20.0, 40.0, kind, 10.0), [0.0; 2]);
        assert_eq!(run(0.0, 20.0, 0.0, kind, 10.0), [0.0; 2]);
        let [s, _] = run(19.99, 20.0, 40.0, kind, 10.0);
        assert!((s + 20.0 / 19.99 - 1.0).abs() < 1e-6, "{s}");
    }
}
