//! Pictures drawn on the CPU: primary rays, a sun with shadows from the file or from rays, and a plain sky.
//!
//! They are for visual checks and are not optimised for speed. Colours are linear internally and sRGB in the
//! output.

mod base_color;
mod shading;

pub use base_color::BaseColors;
use rayon::prelude::*;
pub use shading::{encoded, in_8_bits, lit, shown, sky};

use crate::trace::{Hit, Ray, Tracer};
use adumbra::grid::vec3::dot;
use adumbra::query::PointVisibility;
use adumbra_scene::Scene;
use adumbra_scene::{Camera, View};
use shading::toned;

/// The source of the sun's visibility.
pub enum Shadows<'a> {
    /// Looked up in a baked file.
    File(&'a dyn PointVisibility),
    /// Traced with rays.
    Truth,
    /// Both, marked where they differ: red = a lit point that the file calls shadowed, blue = a shadowed
    /// point that it calls lit.
    Difference(&'a dyn PointVisibility),
}

/// 8-bit sRGB pixels, row 0 at the top.
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Three bytes per pixel.
    pub rgb: Vec<u8>,
    /// Share of the lit-side samples (n·l > 0) on which file and rays differ; only for
    /// [`Shadows::Difference`].
    pub difference_share: Option<f64>,
}

/// Grey level of surfaces that face away from the sun, in a difference picture.
const UNLIT_GREY: f64 = 0.08;
const ACNE_COLOR: [f64; 3] = [1.0, 0.05, 0.03];
const LEAK_COLOR: [f64; 3] = [0.05, 0.2, 1.0];

/// Draws `scene` with `samples` × `samples` rays per pixel. Runs on the current rayon pool. Cost: one or two
/// rays per sample, and the mip levels of the scene's textures.
pub fn draw(
    scene: &Scene,
    tracer: &Tracer<'_>,
    camera: &Camera,
    towards_sun: [f64; 3],
    shadows: &Shadows<'_>,
    samples: u32,
) -> Picture {
    let view = Camera { width: camera.width * samples, height: camera.height * samples, ..*camera }.view();
    let width = camera.width as usize;
    let mut rgb = vec![0; width * camera.height as usize * 3];
    let shader = Shader { view, colors: BaseColors::new(scene), tracer, towards_sun, shadows };
    let (compared, different) = rgb
        .par_chunks_mut(width * 3)
        .zip(0..camera.height)
        .map(|(line, row)| {
            let mut counts = (0, 0);
            for (pixel, column) in line.as_chunks_mut::<3>().0.iter_mut().zip(0..) {
                let mut sum = [0.0; 3];
                for s in 0..samples * samples {
                    let sample = [column * samples + s % samples, row * samples + s / samples];
                    let color = toned(shader.shade(sample, &mut counts));
                    for a in 0..3 {
                        sum[a] += color[a];
                    }
                }
                *pixel = encoded(sum.map(|c| c / f64::from(samples * samples)));
            }
            counts
        })
        .reduce(|| (0_u64, 0_u64), |a, b| (a.0 + b.0, a.1 + b.1));
    let difference_share = matches!(shadows, Shadows::Difference(_))
        .then(|| if compared == 0 { 0.0 } else { different as f64 / compared as f64 });
    Picture { width: camera.width, height: camera.height, rgb, difference_share }
}

struct Shader<'a> {
    /// The camera at sample resolution: each sample is one of its pixels.
    view: View,
    colors: BaseColors<'a>,
    tracer: &'a Tracer<'a>,
    towards_sun: [f64; 3],
    shadows: &'a Shadows<'a>,
}

impl Shader<'_> {
    fn shade(&self, sample: [u32; 2], counts: &mut (u64, u64)) -> [f64; 3] {
        let [x, y] = sample.map(|c| f64::from(c) + 0.5);
        let (origin, direction) = self.view.ray(x, y);
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY };
        let Some(hit) = self.tracer.nearest_surface(&ray) else { return sky(direction) };
        let facing = if dot(hit.normal, direction) > 0.0 { -1.0 } else { 1.0 };
        let normal = hit.normal.map(|c| c * facing);
        let p: [f64; 3] = std::array::from_fn(|a| origin[a] + hit.t * direction[a]);
        let n_dot_l = dot(normal, self.towards_sun);
        let traced = || if self.sun_visible(&hit, p, normal) { 1.0 } else { 0.0 };
        let visibility = match self.shadows {
            Shadows::Difference(query) => {
                return Self::difference(|| query.visibility(p, Some(normal)), traced, n_dot_l, counts);
            }
            _ if n_dot_l <= 0.0 => 0.0,
            Shadows::File(query) => f64::from(query.visibility(p, Some(normal))),
            Shadows::Truth => traced(),
        };
        lit(self.colors.at(&self.view, sample, &hit), normal, n_dot_l, visibility)
    }

    fn difference(
        file: impl Fn() -> f32,
        traced: impl Fn() -> f64,
        n_dot_l: f64,
        counts: &mut (u64, u64),
    ) -> [f64; 3] {
        if n_dot_l <= 0.0 {
            return [UNLIT_GREY; 3];
        }
        let (file, truth) = (f64::from(file()), traced());
        counts.0 += 1;
        if (file > 0.5) != (truth > 0.5) {
            counts.1 += 1;
            return if truth > 0.5 { ACNE_COLOR } else { LEAK_COLOR };
        }
        [0.15 + 0.5 * truth * n_dot_l; 3]
    }

    fn sun_visible(&self, hit: &Hit, p: [f64; 3], normal: [f64; 3]) -> bool {
        let lift = self.tracer.lift_world(hit, p);
        let origin = std::array::from_fn(|a| p[a] + normal[a] * lift);
        let ray = Ray { origin, direction: self.towards_sun, t_min: 0.0, t_max: f64::INFINITY };
        !self.tracer.occluded(&ray)
    }
}
