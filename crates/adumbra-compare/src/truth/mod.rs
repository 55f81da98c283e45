//! Ray-traced truth at each pixel of a camera, by rays through the pixel centres.
//!
//! The first step finds the [`Surfaces`] that the camera sees. The second computes the visibility of the sun
//! there, as a point or a disc, or the ambient visibility. The conventions are those of the G-buffer: the
//! geometric normal faces the viewer, the sun's visibility is 0 on surfaces that face away from it, and the
//! sky is 1. Secondary rays start [`Tracer::lift_world`] along the normal. [`TruthTracer::picture`] renders
//! the result without a GPU.

mod ambient;
mod cache;
mod cameras;
mod edges;
mod street;

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use adumbra::Bounds;
use adumbra_scene::{Camera, Scene, View};
use adumbra_truth::picture;
use adumbra_truth::picture::{BaseColors, Picture};
use adumbra_truth::trace::{Hit, Ray, TraceOptions, Tracer};
pub use ambient::standard_error;
pub use cache::{Cache, Key, scene_key};
pub use cameras::{TruthView, truth_camera};
pub use edges::EdgeProbe;
use rayon::prelude::*;
pub use street::{StreetOptions, street_camera};

use crate::vector::dot;

/// The surfaces that a camera sees, with one value per pixel and row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Surfaces {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// World-space position of the nearest opaque surface; zero without a surface.
    pub position: Vec<[f64; 3]>,
    /// Unit geometric normal of that surface, facing the viewer; zero without a surface.
    pub normal: Vec<[f32; 3]>,
    /// Distance along the camera's forward direction in world units; infinite without a surface.
    pub view_depth: Vec<f64>,
    /// Offset of the origins of secondary rays along the normal in world units; zero without a surface.
    pub lift_world: Vec<f64>,
}

/// The shape of the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SunShape {
    /// A direction: one ray per pixel.
    Hard,
    /// A disc.
    Disc {
        /// Angular diameter in degrees.
        sun_degrees: f64,
        /// Rays per pixel.
        samples: u32,
    },
}

/// Traces the truth of a scene.
#[derive(Debug)]
pub struct TruthTracer<'s> {
    tracer: Tracer<'s>,
    bounds: Bounds,
    /// Base colours, created with the first picture.
    colors: OnceLock<BaseColors<'s>>,
}

impl Surfaces {
    /// Returns the number of pixels.
    pub fn pixels(&self) -> usize {
        self.view_depth.len()
    }

    /// Whether a pixel has a surface.
    pub fn is_valid(&self, pixel: usize) -> bool {
        self.view_depth[pixel].is_finite()
    }

    /// Returns the origin of secondary rays of a pixel.
    pub fn lifted(&self, pixel: usize) -> [f64; 3] {
        let (p, n, lift) = (self.position[pixel], self.normal[pixel], self.lift_world[pixel]);
        std::array::from_fn(|a| p[a] + lift * f64::from(n[a]))
    }

    /// Returns the cosine between the normal and the sun, 0 without a surface.
    pub fn n_dot_l(&self, pixel: usize, towards_sun: [f64; 3]) -> f64 {
        dot(self.normal[pixel].map(f64::from), towards_sun)
    }
}

impl<'s> TruthTracer<'s> {
    /// Prepares a scene for tracing. Cost: that of [`Tracer::build`].
    pub fn build(scene: &'s Scene, ignore_alpha: bool) -> Self {
        let tracer = Tracer::build(scene, TraceOptions { ignore_alpha });
        Self { tracer, bounds: scene.bounds(), colors: OnceLock::new() }
    }

    /// Returns the underlying ray tracer.
    pub fn tracer(&self) -> &Tracer<'s> {
        &self.tracer
    }

    /// Returns the bounding box of the scene.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Returns the surfaces that `camera` sees.
    ///
    /// Cost: one ray per pixel, about 1 µs each. Rows run in parallel on the current rayon pool.
    pub fn surfaces(&self, camera: &Camera) -> Surfaces {
        self.surfaces_unless(camera, &AtomicBool::new(false))
    }

    /// Computes [`Self::surfaces`], without a surface at pixels that are not traced yet when `cancel` is set.
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

    /// Renders the `surfaces` of the same camera with `factors` as the visibility of the sun.
    ///
    /// Geometry, normals and colours come from rays. Lighting and display are those of the renderer
    /// (`adumbra_truth::picture`). Base colours are rounded like the texels of a G-buffer. Otherwise that
    /// rounding alone would cause a mean FLIP of 0.02.
    ///
    /// Cost: one ray per pixel, plus the mip levels of the textures on the first call.
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

    /// Returns origin and direction of the ray through a pixel's centre, and its nearest hit.
    fn seen(&self, view: &View, [x, y]: [u32; 2]) -> ([f64; 3], [f64; 3], Option<Hit>) {
        let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY };
        (origin, direction, self.tracer.nearest_surface(&ray))
    }

    /// Returns the visibility of the sun at each pixel: 1 without a surface, 0 on surfaces that face away
    /// from the sun's centre. The samples of a disc are seeded by the pixel's index.
    ///
    /// Cost: 1 or `samples` rays per pixel that faces the sun.
    pub fn factors(&self, surfaces: &Surfaces, towards_sun: [f64; 3], shape: SunShape) -> Vec<f32> {
        self.factors_unless(surfaces, towards_sun, shape, &AtomicBool::new(false))
    }

    /// Computes [`Self::factors`], with 1 at pixels that are not traced yet when `cancel` is set.
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
            SunShape::Disc { sun_degrees, samples } => {
                self.tracer.sun_disc_visibility(origin, towards, sun_degrees, samples, seed)
            }
        }
    }
}
