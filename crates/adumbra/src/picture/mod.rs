//! Pictures drawn on the CPU: primary rays, a sun with the file's shadows or with rays, and a plain sky.
//!
//! It is the check that a person makes with the eyes; speed is not its aim. Colours are linear inside and sRGB outside.

mod nodes;

pub use nodes::{MAX_NODES_SIDE, nodes_by_size};
use rayon::prelude::*;

use crate::camera::Camera;
use crate::light::dot;
use crate::query::PointVisibility;
use crate::scene::Scene;
use crate::trace::{Hit, Ray, Tracer};

/// Where the sun's visibility comes from.
pub enum Shadows<'a> {
    /// Looked up in a baked file.
    File(&'a dyn PointVisibility),
    /// Traced.
    Truth,
    /// Both, marked where they differ: red = lit called shadowed, blue = shadowed called lit.
    Difference(&'a dyn PointVisibility),
}

/// 8-bit sRGB pixels, row 0 at the top.
pub struct Picture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Three bytes a pixel.
    pub rgb: Vec<u8>,
    /// Share of lit-side samples (n·l > 0) on which file and rays differ; only for [`Shadows::Difference`].
    pub difference_share: Option<f64>,
}

/// Linear red, green and blue of sunlight, at n·l = 1.
pub const SUN_COLOR: [f64; 3] = [1.55, 1.45, 1.28];
/// Linear red, green and blue of the light from above, and of the sky.
pub const SKY_COLOR: [f64; 3] = [0.36, 0.45, 0.60];
/// Linear red, green and blue of the light from below.
pub const GROUND_COLOR: [f64; 3] = [0.20, 0.18, 0.16];
/// What faces away from the sun, in a picture of differences.
const UNLIT_GREY: f64 = 0.08;
const ACNE_COLOR: [f64; 3] = [1.0, 0.05, 0.03];
const LEAK_COLOR: [f64; 3] = [0.05, 0.2, 1.0];

/// Draws `scene` with `samples` × `samples` rays a pixel. Runs on the current rayon pool.
pub fn draw(
    scene: &Scene,
    tracer: &Tracer<'_>,
    camera: &Camera,
    towards_sun: [f64; 3],
    shadows: &Shadows<'_>,
    samples: u32,
) -> Picture {
    let view = camera.view();
    let width = camera.width as usize;
    let mut rgb = vec![0; width * camera.height as usize * 3];
    let shader = Shader { scene, tracer, towards_sun, shadows };
    let (compared, different) = rgb
        .par_chunks_mut(width * 3)
        .enumerate()
        .map(|(row, line)| {
            let mut counts = (0, 0);
            for (column, pixel) in line.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let mut sum = [0.0; 3];
                for s in 0..samples * samples {
                    let dx = (f64::from(s % samples) + 0.5) / f64::from(samples);
                    let dy = (f64::from(s / samples) + 0.5) / f64::from(samples);
                    let (origin, direction) = view.ray(column as f64 + dx, row as f64 + dy);
                    let color = shader.shade(origin, direction, &mut counts);
                    for a in 0..3 {
                        sum[a] += tone(color[a]);
                    }
                }
                *pixel = sum.map(|c| srgb8(c / f64::from(samples * samples)));
            }
            counts
        })
        .reduce(|| (0_u64, 0_u64), |a, b| (a.0 + b.0, a.1 + b.1));
    let difference_share = matches!(shadows, Shadows::Difference(_))
        .then(|| if compared == 0 { 0.0 } else { different as f64 / compared as f64 });
    Picture { width: camera.width, height: camera.height, rgb, difference_share }
}

struct Shader<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer<'a>,
    towards_sun: [f64; 3],
    shadows: &'a Shadows<'a>,
}

impl Shader<'_> {
    fn shade(&self, eye: [f64; 3], direction: [f64; 3], counts: &mut (u64, u64)) -> [f64; 3] {
        let ray = Ray { origin: eye, direction, t_min: 0.0, t_max: f64::INFINITY };
        let Some(hit) = self.tracer.nearest_surface(&ray) else {
            let height = (direction[1] * 0.5 + 0.5).clamp(0.0, 1.0);
            return std::array::from_fn(|a| SKY_COLOR[a] * (1.25 - 0.5 * height));
        };
        let facing = if dot(hit.normal, direction) > 0.0 { -1.0 } else { 1.0 };
        let normal = hit.normal.map(|c| c * facing);
        let p: [f64; 3] = std::array::from_fn(|a| eye[a] + hit.t * direction[a]);
        let albedo = self.albedo(&hit);
        let n_dot_l = dot(normal, self.towards_sun);
        let up = normal[1] * 0.5 + 0.5;
        let ambient = |a: usize| SKY_COLOR[a] * up + GROUND_COLOR[a] * (1.0 - up);
        if n_dot_l <= 0.0 {
            if matches!(self.shadows, Shadows::Difference(_)) {
                return [UNLIT_GREY; 3];
            }
            return std::array::from_fn(|a| albedo[a] * ambient(a));
        }
        let traced = || if self.sun_visible(&hit, p, normal) { 1.0 } else { 0.0 };
        let visibility = match self.shadows {
            Shadows::File(query) => f64::from(query.visibility(p, Some(normal))),
            Shadows::Truth => traced(),
            Shadows::Difference(query) => {
                let (file, truth) = (f64::from(query.visibility(p, Some(normal))), traced());
                counts.0 += 1;
                if (file > 0.5) != (truth > 0.5) {
                    counts.1 += 1;
                    return if truth > 0.5 { ACNE_COLOR } else { LEAK_COLOR };
                }
                let grey = 0.15 + 0.5 * truth * n_dot_l;
                return [grey; 3];
            }
        };
        std::array::from_fn(|a| albedo[a] * (ambient(a) + SUN_COLOR[a] * n_dot_l * visibility))
    }

    fn albedo(&self, hit: &Hit) -> [f64; 3] {
        let material = &self.scene.materials[hit.material as usize];
        let texel = match material.texture {
            Some(t) => self.scene.textures[t as usize].color(hit.uv),
            None => [1.0; 4],
        };
        std::array::from_fn(|a| f64::from(material.base_color[a] * texel[a]))
    }

    fn sun_visible(&self, hit: &Hit, p: [f64; 3], normal: [f64; 3]) -> bool {
        let lift = self.tracer.lift_world(hit, p);
        let origin = std::array::from_fn(|a| p[a] + normal[a] * lift);
        let ray = Ray { origin, direction: self.towards_sun, t_min: 0.0, t_max: f64::INFINITY };
        !self.tracer.occluded(&ray)
    }
}

/// A gentle shoulder, so that sunlit white stays below white.
fn tone(c: f64) -> f64 {
    c * (1.0 + c / 4.0) / (1.0 + c)
}

fn srgb8(linear: f64) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * libm::pow(c, 1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}
