//! The truth at each pixel of a camera, by rays through the pixels' centres.
//!
//! First the [`Surfaces`] that the camera sees, then the sun's visibility there, hard or of a disc, or ambient occlusion's. The conventions
//! are those of the G-buffer: the geometric normal is turned to the viewer, a surface turned away from the sun is 0, the sky is 1. Further
//! rays start [`Tracer::lift_world`] along the normal. [`TruthTracer::picture`] shows it all, with nothing from a GPU in it.

mod ambient;
mod cache;
mod cameras;
mod edges;
mod street;

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use adumbra::camera::{Camera, View};
use adumbra::picture::{self, BaseColors, Picture};
use adumbra::scene::{Bounds, Scene};
use adumbra::trace::{Hit, Ray, TraceOptions, Tracer};
pub use ambient::standard_error;
pub use cache::{Cache, Key, scene_key};
pub use cameras::{TruthView, truth_camera};
pub use edges::EdgeProbe;
use rayon::prelude::*;
pub use street::{StreetOptions, street_camera};

use crate::vector::dot;

/// What a camera sees, one value a pixel, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Surfaces {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// World position of the first opaque surface; zero where there is none.
    pub position: Vec<[f64; 3]>,
    /// Its unit geometric normal turned to the viewer; zero where there is none.
    pub normal: Vec<[f32; 3]>,
    /// Distance along the camera's forward direction, world units; infinite where there is no surface.
    pub view_depth: Vec<f64>,
    /// How far along the normal further rays start, world units; zero where there is no surface.
    pub lift_world: Vec<f64>,
}

/// What shape the sun has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SunShape {
    /// A direction: one ray a pixel.
    Hard,
    /// A disc.
    Disc {
        /// Full angle, degrees.
        angle_degrees: f64,
        /// Rays a pixel.
        samples: u32,
    },
}

/// A scene ready for truth.
#[derive(Debug)]
pub struct TruthTracer<'s> {
    tracer: Tracer<'s>,
    bounds: Bounds,
    /// Made with the first picture.
    colors: OnceLock<BaseColors<'s>>,
}

impl Surfaces {
    /// Pixels.
    pub fn pixels(&self) -> usize {
        self.view_depth.len()
    }

    /// Whether there is a surface.
    pub fn is_valid(&self, pixel: usize) -> bool {
        self.view_depth[pixel].is_finite()
    }

    /// Where further rays start.
    pub fn lifted(&self, pixel: usize) -> [f64; 3] {
        let (p, n, lift) = (self.position[pixel], self.normal[pixel], self.lift_world[pixel]);
        std::array::from_fn(|a| p[a] + lift * f64::from(n[a]))
    }

    /// Cosine between the normal and the sun; 0 without a surface.
    pub fn n_dot_l(&self, pixel: usize, towards_sun: [f64; 3]) -> f64 {
        dot(self.normal[pixel].map(f64::from), towards_sun)
    }
}

impl<'s> TruthTracer<'s> {
    /// Makes a scene ready. Cost: that of [`Tracer::build`].
    pub fn build(scene: &'s Scene, ignore_alpha: bool) -> Self {
        let tracer = Tracer::build(scene, TraceOptions { ignore_alpha });
        Self { tracer, bounds: scene.bounds(), colors: OnceLock::new() }
    }

    /// The rays beneath.
    pub fn tracer(&self) -> &Tracer<'s> {
        &self.tracer
    }

    /// The scene's box.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// What `camera` sees. Cost: a ray a pixel, 1 µs or so; rows on the current rayon pool.
    pub fn surfaces(&self, camera: &Camera) -> Surfaces {
        self.surfaces_unless(camera, &AtomicBool::new(false))
    }

    /// As [`Self::surfaces`]; pixels that are not traced yet when `cancel` is set see nothing.
    pub fn surfaces_unless(&self, camera: &Camera, cancel: &AtomicBool) -> Surfaces {
        let view = camera.view();
        let rows: Vec<Vec<_>> = (0..camera.height)
            .into_par_iter()
            .map(|y| {
                let pixel = |x: u32| {
                    let nothing = ([0.0; 3], [0.0; 3], f64::INFINITY, 0.0);
                    if cancel.load(Ordering::Relaxed) {
                        return nothing;
                    }
                    let (origin, direction, hit) = self.seen(&view, [x, y]);
                    let Some(hit) = hit else { return nothing };
                    let side = if dot(hit.normal, direction) > 0.0 { -1.0 } else { 1.0 };
                    let p = std::array::from_fn(|a| origin[a] + hit.t * direction[a]);
                    (p, hit.normal.map(|c| (side * c) as f32), view.depth(p), self.tracer.lift_world(&hit, p))
                };
                (0..camera.width).map(pixel).collect()
            })
            .collect();
        let all = || rows.iter().flatten();
        Surfaces {
            width: camera.width,
            height: camera.height,
            position: all().map(|p| p.0).collect(),
            normal: all().map(|p| p.1).collect(),
            view_depth: all().map(|p| p.2).collect(),
            lift_world: all().map(|p| p.3).collect(),
        }
    }

    /// The picture of the same camera's `surfaces` under the sun's visibility `factors`: geometry, normals and colours are those that rays
    /// find, light and display those of the renderer (`adumbra::picture`). Base colours are rounded as a G-buffer's texels are: a mean
    /// FLIP of 0.02 would come of that alone. Cost: a ray a pixel, and once the mip levels of the textures.
    pub fn picture(
        &self,
        camera: &Camera,
        surfaces: &Surfaces,
        factors: &[f32],
        towards_sun: [f64; 3],
    ) -> Picture {
        let view = camera.view();
        let colors = self.colors.get_or_init(|| BaseColors::new(self.tracer.scene()));
        let width = camera.width as usize;
        let mut rgb = vec![0; width * camera.height as usize * 3];
        rgb.par_chunks_mut((width * 3).max(1)).zip(0..camera.height).for_each(|(row, y)| {
            for (shown, x) in row.as_chunks_mut::<3>().0.iter_mut().zip(0..) {
                let (_, direction, hit) = self.seen(&view, [x, y]);
                let pixel = y as usize * width + x as usize;
                *shown = picture::shown(match hit {
                    Some(hit) => picture::lit(
                        picture::in_8_bits(colors.at(&view, [x, y], &hit)),
                        surfaces.normal[pixel].map(f64::from),
                        surfaces.n_dot_l(pixel, towards_sun),
                        f64::from(factors[pixel]),
                    ),
                    None => picture::sky(direction),
                });
            }
        });
        Picture { width: camera.width, height: camera.height, rgb, difference_share: None }
    }

    /// The ray through a pixel's centre, and what it meets.
    fn seen(&self, view: &View, [x, y]: [u32; 2]) -> ([f64; 3], [f64; 3], Option<Hit>) {
        let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY };
        (origin, direction, self.tracer.nearest_surface(&ray))
    }

    /// The sun's visibility at each pixel: 1 without a surface, 0 on one turned away from the middle of the sun. The disc's samples
    /// are seeded by the pixel's number. Cost: 1 or `samples` rays a pixel that faces the sun.
    pub fn factors(&self, surfaces: &Surfaces, towards_sun: [f64; 3], shape: SunShape) -> Vec<f32> {
        self.factors_unless(surfaces, towards_sun, shape, &AtomicBool::new(false))
    }

    /// As [`Self::factors`]; pixels that are not traced yet when `cancel` is set are 1.
    pub fn factors_unless(
        &self,
        surfaces: &Surfaces,
        towards_sun: [f64; 3],
        shape: SunShape,
        cancel: &AtomicBool,
    ) -> Vec<f32> {
        let pixel = |i: usize| {
            if !surfaces.is_valid(i) || cancel.load(Ordering::Relaxed) {
                return 1.0;
            }
            if surfaces.n_dot_l(i, towards_sun) <= 0.0 {
                return 0.0;
            }
            self.sun(surfaces.lifted(i), towards_sun, shape, i as u64)
        };
        let width = surfaces.width as usize;
        let mut factors = vec![0.0; surfaces.pixels()];
        factors.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            row.iter_mut().enumerate().for_each(|(x, factor)| *factor = pixel(y * width + x));
        });
        factors
    }

    fn sun(&self, origin: [f64; 3], towards: [f64; 3], shape: SunShape, seed: u64) -> f32 {
        match shape {
            SunShape::Hard => f32::from(u8::from(self.tracer.sun_visible(origin, towards))),
            SunShape::Disc { angle_degrees, samples } => {
                self.tracer.sun_disc_visibility(origin, towards, angle_degrees, samples, seed)
            }
        }
    }
}
