//! The paper's models on their ground planes, and their cameras.

use std::path::Path;

use adumbra_program::scene::load_scene;
use adumbra_scene::{Camera, GeneratedKind, LoadOptions, Projection, Scene, generate};

use crate::bench::peers::scene_file;
use adumbra_compare::Result;

/// START resolutions of the paper's tables.
pub(super) const PAPER_STARTS: [u32; 3] = [1024, 2048, 4096];
/// Direction towards the sun.
pub(super) const SUN: [f64; 3] = [0.5, 0.8, 0.35];
/// Side length of the ground, in multiples of the model's longest extent.
const GROUND: f64 = 4.0;
/// Direction from the picture's middle to the eye.
///
/// The eye is above and to one side of the sun, so that the shadow falls across the view.
const EYE_DIRECTION: [f64; 3] = [-0.42, 0.62, 0.66];
const FOV_DEGREES: f64 = 40.0;
/// Share of the picture's width or height that the model and its shadow fill.
const FILL: f64 = 0.94;
/// Distance from the tip of a shadow to the picture's middle, as a share of the picture's width.
const INWARD: f64 = 0.3;
const SEED: u64 = 1;

/// The source of a model.
enum Source {
    /// A file name without its extension, and the number of triangles to subdivide it to.
    File(&'static str, Option<usize>),
    Generated(GeneratedKind),
}

/// A model to measure.
pub(super) struct Model {
    /// Name used in options.
    pub(super) name: &'static str,
    /// Name used in the paper.
    pub(super) title: &'static str,
    source: Source,
    /// Whether this is the paper's known failure, which is exempt from the requirements.
    pub(super) foliage: bool,
    /// The paper's milliseconds with a shadow map and with a hybrid one, at each of [`PAPER_STARTS`].
    pub(super) paper: [Option<[f64; 2]>; PAPER_STARTS.len()],
}

/// All models except the wires, which are drawn but not measured.
pub(super) const MODELS: [Model; 5] = [
    Model {
        name: "dragon",
        title: "Dragon",
        source: Source::File("dragon_202k", Some(2_400_000)),
        foliage: false,
        paper: [Some([32.6, 29.5]), Some([34.9, 30.8]), Some([62.9, 51.5])],
    },
    Model {
        name: "bunny",
        title: "Bunny",
        source: Source::File("bunny_69k", Some(1_671_984)),
        foliage: false,
        paper: [Some([23.5, 20.6]), Some([28.2, 27.3]), None],
    },
    Model {
        name: "ball",
        title: "Ball model",
        source: Source::Generated(GeneratedKind::Ball),
        foliage: false,
        paper: [Some([9.8, 8.5]), Some([12.9, 11.2]), None],
    },
    Model {
        name: "spheres",
        title: "Spheres",
        source: Source::Generated(GeneratedKind::SphereGrid),
        foliage: false,
        paper: [Some([5.3, 5.0]), Some([7.2, 6.3]), None],
    },
    Model {
        name: "oak",
        title: "Oak",
        source: Source::File("oak_medium", None),
        foliage: true,
        paper: [None; 3],
    },
];

pub(super) const WIRES: Model = Model {
    name: "wires",
    title: "Wires",
    source: Source::Generated(GeneratedKind::Wires),
    foliage: false,
    paper: [None; 3],
};

/// A model on its ground.
pub(super) struct PlacedModel {
    pub(super) scene: Scene,
    /// Triangles of the model alone.
    pub(super) triangles: u64,
    /// The model's vertices in world space.
    points: Vec<[f64; 3]>,
    /// Height of the ground in world units.
    ground_world: f64,
}

impl Model {
    /// Loads or generates the model and places it on a ground.
    pub(super) fn stand(&self, scenes: &Path) -> Result<PlacedModel> {
        let mut scene = match self.source {
            Source::Generated(kind) => generate(kind, SEED),
            Source::File(name, triangles) => {
                let options = LoadOptions { color_textures: true, ..LoadOptions::default() };
                let mut scene = load_scene(&scene_file(scenes, name)?, &options)?;
                if let (Some(wanted), Some(mesh)) = (triangles, scene.meshes.first_mut()) {
                    mesh.subdivide_to(wanted);
                }
                scene
            }
        };
        let triangles = scene.instanced_triangles();
        let mut points = Vec::new();
        for instance in &scene.instances {
            let positions = scene.meshes.get(instance.mesh as usize).map_or(&[][..], |m| &m.positions);
            points.extend(positions.iter().map(|p| {
                instance.world_from_mesh.map(|r| (0..3).map(|a| r[a] * f64::from(p[a])).sum::<f64>() + r[3])
            }));
        }
        scene.stand_on_ground(GROUND)?;
        let ground_world = scene.instances.last().map_or(0.0, |ground| ground.world_from_mesh[1][3]);
        Ok(PlacedModel { scene, triangles, points, ground_world })
    }
}

impl PlacedModel {
    /// Returns the point at which a point's shadow falls on the ground.
    fn shadow(&self, p: [f64; 3], towards_sun: [f64; 3]) -> [f64; 3] {
        let t = (p[1] - self.ground_world).max(0.0) / towards_sun[1];
        std::array::from_fn(|a| p[a] - t * towards_sun[a])
    }

    /// Returns a camera in whose picture the model and its shadow on the ground fill [`FILL`].
    pub(super) fn whole(&self, towards_sun: [f64; 3], size: [u32; 2]) -> Camera {
        let shadows = self.points.iter().map(|&p| self.shadow(p, towards_sun));
        let points: Vec<[f64; 3]> = self.points.iter().copied().chain(shadows).collect();
        fitted(&points, EYE_DIRECTION, size)
    }

    /// Returns a camera on the outline of the shadow on the ground that is furthest from the sun.
    ///
    /// The picture is `width` times the model's longest extent wide.
    pub(super) fn outline(&self, towards_sun: [f64; 3], width: f64, size: [u32; 2]) -> Camera {
        let level = [towards_sun[0], 0.0, towards_sun[2]];
        let along = |p: &[f64; 3]| dot(*p, level);
        let shadows = self.points.iter().map(|&p| self.shadow(p, towards_sun));
        let tip = shadows.min_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or_default();
        // The tip is on one side of the picture, the shadow fills the other.
        let inward = INWARD * width * self.extent() / dot(level, level).sqrt();
        let target = std::array::from_fn(|a| tip[a] + inward * level[a]);
        self.near(target, EYE_DIRECTION, width, size)
    }

    /// Returns a camera on a part of the model around `at`, in shares of its bounding box, seen from
    /// `direction`.
    pub(super) fn part(&self, at: [f64; 3], direction: [f64; 3], width: f64, size: [u32; 2]) -> Camera {
        let [least, most] = self.ends();
        let target = std::array::from_fn(|a| least[a] + at[a] * (most[a] - least[a]));
        self.near(target, direction, width, size)
    }

    fn near(&self, target: [f64; 3], direction: [f64; 3], width: f64, [w, h]: [u32; 2]) -> Camera {
        let projection = Projection::Perspective { fov_degrees: FOV_DEGREES };
        let camera = Camera { eye: direction, target: [0.0; 3], projection, width: w, height: h };
        let distance = 0.5 * width * self.extent() / camera.view().half[0] / dot(direction, direction).sqrt();
        let eye = std::array::from_fn(|a| target[a] + distance * direction[a]);
        Camera { eye, target, ..camera }
    }

    /// Returns the model's longest extent along an axis.
    fn extent(&self) -> f64 {
        let [least, most] = self.ends();
        (0..3).map(|a| most[a] - least[a]).fold(0.0, f64::max)
    }

    fn ends(&self) -> [[f64; 3]; 2] {
        let fold = |f: fn(f64, f64) -> f64, first: f64| {
            std::array::from_fn(|a| self.points.iter().map(|p| p[a]).fold(first, f))
        };
        [fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY)]
    }
}

/// Returns the nearest camera on the side of `direction` that sees all points.
fn fitted(points: &[[f64; 3]], direction: [f64; 3], [width, height]: [u32; 2]) -> Camera {
    let projection = Projection::Perspective { fov_degrees: FOV_DEGREES };
    let view = Camera { eye: direction, target: [0.0; 3], projection, width, height }.view();
    // A point `p` is within one side of the view if `side·p - half·forward·p` is at most its value at the
    // eye.
    let furthest = |side: [f64; 3], half: f64| {
        let plane: [f64; 3] = std::array::from_fn(|a| side[a] - half * view.forward[a]);
        points.iter().map(|p| dot(plane, *p)).fold(f64::NEG_INFINITY, f64::max)
    };
    let axis = |side: [f64; 3], half: f64| {
        let (plus, minus) = (furthest(side, half), furthest(side.map(|c| -c), half));
        (0.5 * (plus - minus), -(plus + minus) / (2.0 * half))
    };
    let ((x, near_x), (y, near_y)) =
        (axis(view.right, FILL * view.half[0]), axis(view.up, FILL * view.half[1]));
    let z = near_x.min(near_y);
    let eye: [f64; 3] = std::array::from_fn(|a| x * view.right[a] + y * view.up[a] + z * view.forward[a]);
    let farthest = points.iter().map(|p| dot(view.forward, *p)).fold(z, f64::max);
    let target = std::array::from_fn(|a| eye[a] + 0.5 * (farthest - z) * view.forward[a]);
    Camera { eye, target, projection, width, height }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hybrid_paper_times_match_papers_json() {
        let data: serde_json::Value =
            serde_json::from_str(include_str!("../../../data/papers.json")).unwrap();
        let papers = data["papers"].as_array().unwrap();
        let hybrid = papers.iter().find(|p| p["key"] == "hybrid-2016").unwrap();
        let rows = |table: usize| hybrid["tables"][table]["rows"].as_array().unwrap();
        for row in rows(1) {
            let model = MODELS.iter().find(|m| row[0] == m.title).unwrap();
            for start in 0..2 {
                let times = model.paper[start].unwrap();
                assert!(row[3 + start] == times[0] && row[5 + start] == times[1], "{row}");
            }
        }
        for (row, times) in rows(0).iter().zip(MODELS[0].paper) {
            let times = times.unwrap();
            assert!(row[1] == times[0] && row[2] == times[1], "{row}");
        }
    }

    #[test]
    fn whole_camera_fills_picture_with_model_and_shadow() {
        let standing = MODELS[3].stand(Path::new("")).unwrap();
        assert_eq!(standing.triangles, 12_000);
        let camera = standing.whole(adumbra::Sun::from_direction(SUN).unwrap().towards(), [320, 180]);
        let view = camera.view();
        let towards = adumbra::Sun::from_direction(SUN).unwrap().towards();
        let both = standing.points.iter().flat_map(|&p| [p, standing.shadow(p, towards)]);
        let pixels: Vec<[f64; 2]> = both.map(|p| view.pixel(p).unwrap()).collect();
        let reach = |a: usize, size: f64| {
            let most = pixels.iter().map(|p| p[a]).fold(0.0, f64::max);
            let least = pixels.iter().map(|p| p[a]).fold(size, f64::min);
            assert!(least >= 0.0 && most <= size, "{least} {most}");
            (most - least) / size
        };
        assert!((reach(0, 320.0).max(reach(1, 180.0)) - FILL).abs() < 0.02);
    }
}
