//! A raised plate and a post over flat ground, with points of the ground and the part of a sun's disc that
//! each of them sees.

use adumbra_render::{Prepared, Renderer, SceneOptions, Shot, SurfacePoint};
use adumbra_scene::{Camera, Projection, Scene};
use adumbra_truth::trace::{TraceOptions, Tracer};

use super::boxes::boxes;

pub(crate) struct Penumbra {
    pub(crate) scene: Scene,
    pub(crate) renderer: Renderer,
    shot: Shot,
    points: Vec<SurfacePoint>,
    disc: Vec<f32>,
}

impl Penumbra {
    /// Traces the ground under a sun whose disc is `sun_degrees` wide.
    pub(crate) fn new(sun_degrees: f64) -> Self {
        let scene = boxes(&[
            ([-20.0, -1.0, -20.0], [20.0, 0.0, 20.0]),
            ([-4.0, 4.0, -4.0], [4.0, 4.2, 4.0]),
            ([6.0, 0.0, -3.0], [7.0, 6.0, -2.0]),
        ]);
        let renderer = Renderer::new(super::gpu(), &scene, SceneOptions::default()).unwrap();
        let towards_sun = super::sun();
        let projection = Projection::Perspective { fov_degrees: 60.0 };
        let camera =
            Camera { eye: [0.0, 30.0, 30.0], target: [0.0; 3], projection, width: 1280, height: 720 };
        let at = |i: u32| -10.0 + 0.11 * f64::from(i);
        let points: Vec<_> = (0..150_u32)
            .flat_map(|z| (0..150_u32).map(move |x| [at(x), 0.0, at(z)]))
            .map(|p_world| SurfacePoint { p_world, normal: [0.0, 1.0, 0.0] })
            .collect();
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let seen = |p: &SurfacePoint| {
            let p_world = [p.p_world[0], 1e-4, p.p_world[2]];
            tracer.sun_disc_visibility(p_world, towards_sun, sun_degrees, 64, 1)
        };
        let disc = points.iter().map(seen).collect();
        drop(tracer);
        Self { scene, renderer, shot: Shot { camera, towards_sun, number: 0 }, points, disc }
    }

    /// Returns the root mean square difference between a technique and the disc.
    pub(crate) fn error(&mut self, mut technique: Prepared) -> f64 {
        let factors = self.renderer.answer(&self.shot, &mut technique, &self.points).unwrap();
        let squares: f64 = factors.iter().zip(&self.disc).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        (squares / self.disc.len() as f64).sqrt()
    }
}
