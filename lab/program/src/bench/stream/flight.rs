//! The flight, and the points that its frames see.

use adumbra::ShadowFile;
use adumbra::grid::vec3::dot;
use adumbra_compare::Result;
use adumbra_compare::truth::{StreetOptions, Surfaces, TruthTracer, street_camera};
use adumbra_render::voxel::view_of;
use adumbra_scene::Camera;

use crate::args::BenchStream;

/// A visible point that faces the sun.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenPoint {
    pub(super) p_world: [f64; 3],
    pub(super) normal: [f64; 3],
    /// Where a ray to the sun begins.
    pub(super) lifted: [f64; 3],
    /// The coarsest level whose texels are no larger than a pixel there.
    pub(super) wanted_level: u32,
}

/// Cameras, and some points that each of them sees.
pub(super) struct Flight {
    pub(super) cameras: Vec<Camera>,
    pub(super) seen: Vec<Vec<SeenPoint>>,
    texels_world: Vec<f64>,
    towards_sun: [f64; 3],
}

/// In every frame, one pixel in this many along each axis is examined.
const EVERY: u32 = 30;
/// Where answers are compared with rays, one pixel in this many along each axis is examined.
const EVERY_AT_STOPS: u32 = 4;

impl Flight {
    /// Flies ahead from the street camera, up to a few tens of metres and down again, with slow turns to both
    /// sides.
    pub(super) fn new(tracer: &TruthTracer<'_>, file: &ShadowFile, args: &BenchStream) -> Result<Self> {
        let towards_sun = file.sun().towards();
        let [width, height] = args.size;
        let options = StreetOptions { width, height, ..StreetOptions::default() };
        let street = street_camera(tracer, towards_sun, &options)?;
        let ahead: [f64; 3] = [0, 1, 2].map(|a| street.target[a] - street.eye[a]);
        let mut heading = f64::atan2(ahead[2], ahead[0]);
        let mut eye = street.eye;
        let step = args.speed / 60.0;
        let cameras: Vec<Camera> = (0..args.frames)
            .map(|frame| {
                let share = f64::from(frame) / f64::from(args.frames.max(2) - 1);
                heading += 0.01 * (std::f64::consts::TAU * share).sin();
                eye = [eye[0] + step * heading.cos(), eye[1], eye[2] + step * heading.sin()];
                let up = 30.0 * (std::f64::consts::PI * share).sin();
                let here = [eye[0], street.eye[1] + up, eye[2]];
                let down = 0.02 + 0.012 * up;
                let target = [here[0] + heading.cos(), here[1] - down, here[2] + heading.sin()];
                Camera { eye: here, target, ..street }
            })
            .collect();
        let texels_world = (0..file.level_count())
            .filter_map(|n| file.level(n))
            .map(|level| level.grid.voxel_size)
            .collect();
        let mut flight = Self { cameras, seen: Vec::new(), texels_world, towards_sun };
        flight.seen = flight.cameras.iter().map(|camera| flight.points_of(tracer, camera, EVERY)).collect();
        Ok(flight)
    }

    /// Returns many points of a frame.
    pub(super) fn points(&self, tracer: &TruthTracer<'_>, frame: usize) -> Vec<SeenPoint> {
        self.points_of(tracer, &self.cameras[frame], EVERY_AT_STOPS)
    }

    fn points_of(&self, tracer: &TruthTracer<'_>, camera: &Camera, every: u32) -> Vec<SeenPoint> {
        let fewer = Camera { width: camera.width / every, height: camera.height / every, ..*camera };
        let view = view_of(camera);
        let Surfaces { position, normal, view_depth, lift_world, .. } = tracer.surfaces(&fewer);
        let seen = (0..position.len()).filter(|&i| view_depth[i].is_finite());
        let point = |i: usize| {
            let (p_world, normal) = (position[i], normal[i].map(f64::from));
            let away: [f64; 3] = [0, 1, 2].map(|a| p_world[a] - camera.eye[a]);
            let pixel_world = view.pixel_world + view.pixel_per_distance * dot(away, away).sqrt();
            let is_enough = |texel: &f64| *texel <= pixel_world;
            let wanted_level = self.texels_world.iter().rposition(is_enough).unwrap_or(0) as u32;
            let lifted = [0, 1, 2].map(|a| p_world[a] + lift_world[i] * normal[a]);
            SeenPoint { p_world, normal, lifted, wanted_level }
        };
        seen.map(point).filter(|point| dot(point.normal, self.towards_sun) > 0.05).collect()
    }
}
