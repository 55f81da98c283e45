//! Ambient occlusion on the CPU: the same passes on pictures in memory.

mod alchemy;
mod gtao;
mod hbao;
mod issao;
mod march;
mod ssao;

use adumbra_shaders::constants::OCCLUSION_MAX_TAPS;
use adumbra_shaders::layout::{Frame, OcclusionFilterParams, OcclusionParams, OcclusionTaps};

use super::estimator::Estimator;
use super::settings::{Filter, OcclusionSettings};
use super::taps::taps;

/// What the camera sees, as the G-buffer holds it; row 0 at the top.
pub struct Surfaces<'a> {
    /// The frame's uniform.
    pub frame: Frame,
    /// Stored depth, 0 where nothing is.
    pub depth: &'a [f32],
    /// World normals, zero where nothing is.
    pub normal: &'a [[f32; 3]],
}

/// Ambient visibility with view depth, 0 where nothing is.
pub type Ambient = [f32; 2];

/// Ambient visibility as the GPU has it. Cost: as many operations as the GPU's, on one thread.
pub fn ambient(settings: &OcclusionSettings, surfaces: &Surfaces<'_>) -> Vec<Ambient> {
    let estimate = estimate(settings, surfaces);
    let size = settings.size([surfaces.frame.size[0], surfaces.frame.size[1]]);
    match settings.filter {
        Filter::None => estimate,
        _ => [0, 1]
            .into_iter()
            .fold(estimate, |from, axis| bilateral_line(&settings.filter_params(size, axis), &from)),
    }
}

/// The estimator alone.
pub fn estimate(settings: &OcclusionSettings, surfaces: &Surfaces<'_>) -> Vec<Ambient> {
    let params = settings.params(&surfaces.frame);
    let pass = Pass {
        view_depth: view_depth(&params, surfaces),
        taps: taps(settings),
        frame_width: surfaces.frame.size[0],
        normals: surfaces.normal,
        params,
    };
    let [width, height, ..] = params.size;
    (0..height)
        .flat_map(|y| (0..width).map(move |x| [x, y]))
        .map(|texel| pass.occlude(settings, texel))
        .collect()
}

fn view_depth(params: &OcclusionParams, surfaces: &Surfaces<'_>) -> Vec<f32> {
    let [width, height, scale, _] = params.size;
    let k = params.depth_to_z;
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    texels
        .map(|[x, y]| {
            let depth = surfaces.depth[(y * scale * surfaces.frame.size[0] + x * scale) as usize];
            if depth == 0.0 { 0.0 } else { (k[0] + k[1] * depth) / (k[2] + k[3] * depth) }
        })
        .collect()
}

/// The pass around an estimator.
struct Pass<'a> {
    params: OcclusionParams,
    taps: OcclusionTaps,
    view_depth: Vec<f32>,
    frame_width: u32,
    normals: &'a [[f32; 3]],
}

/// `OcclusionCenter` of the shaders.
struct Center {
    texel: [i32; 2],
    p: [f32; 3],
    n: [f32; 3],
    radius_world: f32,
    radius_texels: f32,
    first_tap: usize,
}

impl Pass<'_> {
    fn occlude(&self, settings: &OcclusionSettings, texel: [u32; 2]) -> Ambient {
        let z = self.z_at(texel.map(|c| c as i32)).unwrap_or(0.0);
        if z <= 0.0 {
            return [1.0, z];
        }
        let c = self.center(texel, z);
        if c.radius_texels < 0.5 {
            return [1.0, z];
        }
        let visibility = match settings.estimator {
            Estimator::Ssao => ssao::visibility(self, &c),
            Estimator::Hbao => hbao::visibility(self, &c),
            Estimator::Alchemy => alchemy::visibility(self, &c),
            Estimator::Issao => issao::visibility(self, &c),
            Estimator::Gtao => gtao::visibility(self, &c),
        };
        [visibility, z]
    }

    /// View depth, 0 where nothing is; none beyond the picture.
    fn z_at(&self, [x, y]: [i32; 2]) -> Option<f32> {
        let [width, height] = [self.params.size[0] as i32, self.params.size[1] as i32];
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        inside.then(|| self.view_depth[(y * width + x) as usize])
    }

    fn point(&self, texel: [i32; 2], z: f32) -> [f32; 3] {
        let o = &self.params;
        let at = |a: usize| {
            let ndc = o.ndc_from_texel[a] * texel[a] as f32 + o.ndc_from_texel[a + 2];
            ndc * (o.half_view[a] + o.half_view[a + 2] * z)
        };
        [at(0), at(1), z]
    }

    /// Where a view-space point lies, in texels; whole numbers are centres.
    fn texel(&self, p: [f32; 3]) -> [f32; 2] {
        let o = &self.params;
        [0, 1].map(|a| {
            let ndc = p[a] / (o.half_view[a] + o.half_view[a + 2] * p[2]);
            (ndc - o.ndc_from_texel[a + 2]) / o.ndc_from_texel[a]
        })
    }

    /// From P to what is seen at a texel, in radii.
    fn reach(&self, c: &Center, texel: [i32; 2], z: f32, inverse_radius: f32) -> [f32; 3] {
        let s = self.point(texel, z);
        std::array::from_fn(|a| (s[a] - c.p[a]) * inverse_radius)
    }

    fn center(&self, texel: [u32; 2], z: f32) -> Center {
        let o = &self.params;
        let scale = o.size[3];
        let n = self.normals[(texel[1] * scale * self.frame_width + texel[0] * scale) as usize];
        let axis = |a: [f32; 4]| dot(n, [a[0], a[1], a[2]]);
        let n = [axis(o.right), axis(o.up), axis(o.forward)];
        let length = dot(n, n).sqrt();
        let texels = o.region[0] / (o.region[2] + o.region[3] * z);
        let share = (o.region[1] / texels).min(1.0);
        let place = (place(texel) + o.counts[2]) & 15;
        let texel = texel.map(|c| c as i32);
        Center {
            texel,
            p: self.point(texel, z),
            n: n.map(|c| c / length),
            radius_world: o.region[0] * share,
            radius_texels: texels * share,
            first_tap: (place * OCCLUSION_MAX_TAPS) as usize,
        }
    }
}

/// A texel's place in the tile of noise.
fn place(texel: [u32; 2]) -> u32 {
    let [x, y] = texel.map(|c| c & 3);
    let d = x ^ y;
    (d & 1) << 3 | (y & 1) << 2 | d & 2 | y >> 1
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// One line of the bilateral filter.
fn bilateral_line(params: &OcclusionFilterParams, from: &[Ambient]) -> Vec<Ambient> {
    let [width, height, side, axis] = params.counts.map(|c| c as i32);
    let line = |[x, y]: [i32; 2]| {
        let [own, z] = from[(y * width + x) as usize];
        let (mut sum, mut weights) = (own, 1.0);
        for i in (-side..=side).filter(|i| *i != 0 && z > 0.0) {
            let [x, y] = if axis == 1 { [x, y + i] } else { [x + i, y] };
            if !(0..width).contains(&x) || !(0..height).contains(&y) {
                continue;
            }
            let [other, other_z] = from[(y * width + x) as usize];
            if other_z > 0.0 {
                let d = (other_z - z) / params.shape[1];
                let near = i.unsigned_abs() as usize;
                let weight = params.weights.0[near / 4][near % 4] * (-0.5 * d * d).exp();
                sum += weight * other;
                weights += weight;
            }
        }
        [sum / weights, z]
    };
    (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).map(line).collect()
}
