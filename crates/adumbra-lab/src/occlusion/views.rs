//! The eight scenes that ambient occlusion is measured on: what each is, where it is seen from, how far what occludes may be, and the
//! path for flicker.
//!
//! The scanned models stand on a ground, and their lengths are shares of their longest extent, as their files' units say nothing; all
//! others are in the scene's units. Two scenes are seen as the truth files of `bench peers` see them.

use std::path::Path;

use adumbra::camera::{Camera, Projection};
use adumbra::scene::{GeneratedKind, LoadOptions, Scene, generate, load};
use serde::{Deserialize, Serialize};

use crate::error::Result;

/// Frames of a path.
pub const PATH_FRAMES: u32 = 16;
/// How far what is at the target's distance moves from one frame of a path to the next, pixels of a picture of [`STEP_HEIGHT`].
const STEP_PIXELS: f64 = 4.0;
const STEP_HEIGHT: f64 = 360.0;
/// Sides of a model's ground, in its longest extents.
const GROUND: f64 = 12.0;
/// A model's radius, in its longest extents.
const MODEL_RADIUS: f64 = 0.12;
const SEED: u64 = 1;

/// Half of the scenes: a setting that is judged on one half was tuned on the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fold {
    /// The first half.
    A,
    /// The second half.
    B,
}

/// Where a scene comes from, and so in what units its view is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// A scanned model's file: shares of its longest extent, from the middle of its box.
    Model(&'static str),
    /// A file: world units.
    File(&'static str),
    /// Made by the library: world units.
    Generated(GeneratedKind),
}

/// One of the eight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OcclusionScene {
    /// As options call it.
    pub name: &'static str,
    /// As tables call it.
    pub title: &'static str,
    /// Which half it is in.
    pub fold: Fold,
    source: Source,
    eye: [f64; 3],
    target: [f64; 3],
    fov_degrees: f64,
    radius: f64,
}

/// A scene in memory, and how it is seen.
#[derive(Clone, Debug)]
pub struct OcclusionView {
    /// With its ground, for a model.
    pub scene: Scene,
    /// How far what occludes may be, world units.
    pub radius_world: f64,
    eye: [f64; 3],
    target: [f64; 3],
    fov_degrees: f64,
}

/// The eight, in the tables' order.
pub const SCENES: [OcclusionScene; 8] = [
    OcclusionScene {
        name: "dragon",
        title: "Dragon",
        fold: Fold::A,
        source: Source::Model("dragon_202k.ply"),
        eye: [-0.25, 0.62, 1.4],
        target: [0.0, -0.03, 0.0],
        fov_degrees: 30.0,
        radius: MODEL_RADIUS,
    },
    OcclusionScene {
        name: "bunny",
        title: "Bunny",
        fold: Fold::B,
        source: Source::Model("bunny_69k.ply"),
        eye: [-0.25, 0.68, 2.05],
        target: [-0.02, -0.06, 0.0],
        fov_degrees: 31.0,
        radius: MODEL_RADIUS,
    },
    OcclusionScene {
        name: "armadillo",
        title: "Armadillo (for Hebe)",
        fold: Fold::B,
        source: Source::Model("armadillo.ply"),
        eye: [0.3, 0.74, 1.85],
        target: [0.0, -0.04, 0.0],
        fov_degrees: 29.5,
        radius: MODEL_RADIUS,
    },
    OcclusionScene {
        name: "dream_apartment",
        title: "Apartment",
        fold: Fold::A,
        source: Source::File("dream_apartment.glb"),
        eye: [7.9, 1.75, -7.5],
        target: [10.2, 0.75, -4.6],
        fov_degrees: 60.0,
        radius: 0.6,
    },
    OcclusionScene {
        name: "zdm2",
        title: "zdm2",
        fold: Fold::B,
        source: Source::File("zdm2.glb"),
        eye: [0.0, 25.0, 45.0],
        target: [0.0, 8.0, 0.0],
        fov_degrees: 40.0,
        radius: 3.0,
    },
    OcclusionScene {
        name: "kaykit_city_21",
        title: "KayKit city",
        fold: Fold::A,
        source: Source::File("kaykit_city_21.glb"),
        eye: [0.0, 60.0, 140.0],
        target: [0.0; 3],
        fov_degrees: 40.0,
        radius: 10.0,
    },
    OcclusionScene {
        name: "bridge_garden",
        title: "Bridge garden",
        fold: Fold::B,
        source: Source::File("bridge_garden.glb"),
        eye: [5.5, 4.8, 4.0],
        target: [-0.8, 1.0, -0.8],
        fov_degrees: 42.0,
        radius: 1.0,
    },
    OcclusionScene {
        name: "cornell",
        title: "Cornell box",
        fold: Fold::A,
        source: Source::Generated(GeneratedKind::Cornell),
        eye: [-0.6, 3.4, 6.0],
        target: [-0.2, 1.9, 0.0],
        fov_degrees: 50.0,
        radius: 1.0,
    },
];

/// The scene of that name.
pub fn scene_named(name: &str) -> Option<&'static OcclusionScene> {
    SCENES.iter().find(|s| s.name == name)
}

impl OcclusionScene {
    /// Loads the scene from a file in `scenes`, or makes it; stands a model on its ground.
    ///
    /// # Errors
    /// [`crate::Error::Library`] where the file is absent or not readable.
    pub fn open(&self, scenes: &Path) -> Result<OcclusionView> {
        let file = |name: &str| {
            let options = LoadOptions { color_textures: true, ..LoadOptions::default() };
            load(&scenes.join(name), &options)
        };
        let (mut scene, mut middle, mut unit) = match self.source {
            Source::Model(name) | Source::File(name) => (file(name)?, [0.0; 3], 1.0),
            Source::Generated(kind) => (generate(kind, SEED), [0.0; 3], 1.0),
        };
        if let Source::Model(_) = self.source {
            let bounds = scene.bounds();
            middle = std::array::from_fn(|a| 0.5 * (bounds.min[a] + bounds.max[a]));
            unit = (0..3).map(|a| bounds.max[a] - bounds.min[a]).fold(0.0, f64::max);
            scene.stand_on_ground(GROUND)?;
        }
        let world = |p: [f64; 3]| std::array::from_fn(|a| middle[a] + unit * p[a]);
        Ok(OcclusionView {
            scene,
            radius_world: unit * self.radius,
            eye: world(self.eye),
            target: world(self.target),
            fov_degrees: self.fov_degrees,
        })
    }
}

impl OcclusionView {
    /// The camera of the still picture.
    pub fn camera(&self, [width, height]: [u32; 2]) -> Camera {
        let projection = Projection::Perspective { fov_degrees: self.fov_degrees };
        Camera { eye: self.eye, target: self.target, projection, width, height }
    }

    /// The cameras of the path: from the still picture's sideways to the right, [`PATH_FRAMES`] of them, what is at the target's
    /// distance moving by a ninetieth of the picture's height a frame.
    pub fn path(&self, size: [u32; 2]) -> Vec<Camera> {
        let still = self.camera(size);
        let view = still.view();
        let step = STEP_PIXELS / STEP_HEIGHT * 2.0 * view.half[1] * view.depth(self.target);
        let camera = |frame: u32| {
            let aside = |p: [f64; 3]| std::array::from_fn(|a| p[a] + step * f64::from(frame) * view.right[a]);
            Camera { eye: aside(self.eye), target: aside(self.target), ..still }
        };
        (0..PATH_FRAMES).map(camera).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::TruthTracer;

    #[test]
    fn occlusion_scenes_are_eight_in_two_halves() {
        let count = |fold| SCENES.iter().filter(|s| s.fold == fold).count();
        assert_eq!((count(Fold::A), count(Fold::B)), (4, 4));
        for (i, scene) in SCENES.iter().enumerate() {
            assert!(SCENES[..i].iter().all(|s| s.name != scene.name && s.title != scene.title));
            assert_eq!(scene_named(scene.name), Some(scene));
        }
        assert_eq!(scene_named("teapot"), None);
    }

    #[test]
    fn occlusion_path_goes_sideways_a_few_pixels_a_frame() {
        let view = scene_named("cornell").unwrap().open(Path::new("")).unwrap();
        let path = view.path([640, 360]);
        assert_eq!(path.len(), PATH_FRAMES as usize);
        assert_eq!(path[0], view.camera([640, 360]));
        for pair in path.windows(2) {
            let [before, after] = [pair[0], pair[1]].map(|c| c.view().pixel(pair[0].target).unwrap());
            assert!((before[0] - after[0] - STEP_PIXELS).abs() < 1e-6, "{before:?} {after:?}");
            assert!((before[1] - after[1]).abs() < 1e-6);
        }
    }

    #[test]
    fn occlusion_of_the_cornell_box_has_corners_and_open_walls() {
        let view = scene_named("cornell").unwrap().open(Path::new("")).unwrap();
        let truth = TruthTracer::build(&view.scene, false);
        let surfaces = truth.surfaces(&view.camera([96, 54]));
        let ambient = truth.ambient(&surfaces, view.radius_world, 32);
        let share = |least: f32, most: f32| {
            let between = ambient.iter().filter(|v| (least..=most).contains(*v)).count();
            between as f64 / ambient.len() as f64
        };
        let valid = (0..surfaces.pixels()).filter(|&i| surfaces.is_valid(i)).count();
        assert!(valid as f64 > 0.95 * surfaces.pixels() as f64, "the room fills the picture: {valid}");
        assert!(share(0.0, 0.6) > 0.02 && share(0.99, 1.0) > 0.2, "{} {}", share(0.0, 0.6), share(0.99, 1.0));
    }
}
