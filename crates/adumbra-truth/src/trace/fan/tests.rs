//! Tests of fans against rays and against shadows that are known.

use adumbra::grid::vec3::{dot, normalize};
use adumbra_scene::{AlphaMode, Instance, Material, Mesh, Pixels, Scene, Texture, Wrap, icosphere};

use crate::trace::{Cover, Fan, Ray, TraceOptions, Tracer};

const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Deterministic random numbers in 0 .. 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }

    fn point(&mut self, size: f64) -> [f64; 3] {
        std::array::from_fn(|_| size * (2.0 * self.next() - 1.0))
    }
}

fn scene_of(meshes: Vec<Mesh>, places: &[(u32, [[f64; 4]; 3])]) -> Scene {
    let instance =
        |&(mesh, world_from_mesh)| Instance { name: String::new(), mesh, world_from_mesh, casts: true };
    Scene {
        meshes,
        instances: places.iter().map(instance).collect(),
        materials: vec![Material::opaque("stone", [1.0; 4])],
        ..Scene::default()
    }
}

fn mesh_of(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    let triangle_materials = vec![0; triangles.len()];
    Mesh { positions, triangles, triangle_materials, ..Mesh::default() }
}

fn soup(random: &mut Random, count: u32, size: f64) -> Mesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let middle = random.point(1.0);
        for _ in 0..3 {
            let offset = random.point(size);
            positions.push(std::array::from_fn(|a| (middle[a] + offset[a]) as f32));
        }
    }
    mesh_of(positions, (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// A path such as the sun's: `chords` chords of `degrees` on a circle about a random axis.
fn path(random: &mut Random, chords: usize, degrees: f64) -> Vec<[f64; 3]> {
    let axis = normalize(random.point(1.0));
    let start = normalize(random.point(1.0));
    let along = dot(axis, start);
    let flat: [f64; 3] = std::array::from_fn(|a| start[a] - along * axis[a]);
    let side = adumbra::grid::vec3::cross(axis, flat);
    let turned = |k: usize| {
        let (sin, cos) = libm::sincos((k as f64 * degrees).to_radians());
        std::array::from_fn(|a| along * axis[a] + cos * flat[a] + sin * side[a])
    };
    (0..=chords).map(turned).collect()
}

fn hidden(tracer: &Tracer<'_>, origin: [f64; 3], knots: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let mut cover = Cover::default();
    tracer.hide(origin, &Fan::new(knots.to_vec(), 1.0 / 60.0), &mut cover);
    cover.spans().to_vec()
}

/// Compares a fan with rays along it, except near the ends of spans.
fn compare(tracer: &Tracer<'_>, origin: [f64; 3], knots: &[[f64; 3]], rays: u32, margin: f64) -> u32 {
    let spans = hidden(tracer, origin, knots);
    assert!(spans.windows(2).all(|pair| pair[0][1] < pair[1][0]), "{spans:?}");
    let mut hits = 0;
    for ray in 0..=rays {
        let place = f64::from(ray) / f64::from(rays) * (knots.len() - 1) as f64;
        if spans.iter().flatten().any(|end| (end - place).abs() < margin) {
            continue;
        }
        let chord = (place as usize).min(knots.len() - 2);
        let u = place - chord as f64;
        let direction = std::array::from_fn(|a| (1.0 - u) * knots[chord][a] + u * knots[chord + 1][a]);
        let is_hidden = tracer.occluded(&Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY });
        let expected = spans.iter().any(|span| span[0] <= place && place <= span[1]);
        assert_eq!(is_hidden, expected, "{origin:?} {direction:?} at {place} in {spans:?}");
        hits += u32::from(is_hidden);
    }
    hits
}

#[test]
fn fans_agree_with_rays_through_random_triangles() {
    let mut random = Random(1);
    let (mut hits, mut rays) = (0, 0);
    for round in 0..60 {
        let size = [0.1, 0.3, 0.9][round % 3];
        let mesh = soup(&mut random, [400, 60, 12][round % 3], size);
        let places: Vec<_> = (0..[1, 2, 9][round / 3 % 3])
            .map(|_| {
                let turn: [[f64; 3]; 3] = [random.point(1.0), random.point(1.0), random.point(1.0)];
                let offset = random.point(1.0);
                (0, std::array::from_fn(|r| [turn[r][0], turn[r][1], turn[r][2], offset[r]]))
            })
            .collect();
        let scene = scene_of(vec![mesh], &places);
        let tracer = Tracer::build(&scene, TraceOptions::default());
        for _ in 0..10 {
            let (origin, chords) = (random.point(1.0), 1 + (random.next() * 31.0) as usize);
            let degrees = 80.0 * random.next() / chords as f64;
            let knots = path(&mut random, chords, degrees);
            hits += compare(&tracer, origin, &knots, 60, 1e-9);
            rays += 61;
        }
    }
    assert!(hits > rays / 20 && hits < rays * 19 / 20, "{hits} of {rays}");
}

#[test]
fn fans_pass_no_edge_of_a_closed_surface() {
    let (directions, triangles) = icosphere(3);
    let ball = mesh_of(directions.iter().map(|d| d.map(|c| c as f32)).collect(), triangles);
    let scene = scene_of(vec![ball], &[(0, IDENTITY)]);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let mut random = Random(2);
    for _ in 0..300 {
        let knots = path(&mut random, 16, 0.25);
        assert_eq!(hidden(&tracer, random.point(0.5), &knots), [[0.0, 16.0]]);
    }
}

/// A pole 1 mm wide, 100 m away, hides 0.0006°, some 140 ms of a sun's path, and is found.
#[test]
fn fans_find_what_is_far_narrower_than_a_chord() {
    let pole = mesh_of(
        vec![[100.0, -9.0, 0.0], [100.0, -9.0, 0.001], [100.0, 9.0, 0.001], [100.0, 9.0, 0.0]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let scene = scene_of(vec![pole], &[(0, IDENTITY)]);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    // Chords from z = -1.6 to 1.6 at x = 100.
    let knots: Vec<[f64; 3]> = (-8..=8).map(|k| [100.0, 0.0, 0.2 * f64::from(k)]).collect();
    let spans = hidden(&tracer, [0.0; 3], &knots);
    let [[begin, end]] = spans[..] else { panic!("{spans:?}") };
    assert!((begin - 8.0).abs() < 1e-12 && (end - 8.005).abs() < 1e-9, "{spans:?}");
}

#[test]
fn fans_see_through_holes_of_masks_and_what_casts_nothing() {
    // A square of 16 × 16 texels at y = 1, every other column of which is a hole.
    let mut square = mesh_of(
        vec![[-8.0, 1.0, -8.0], [-8.0, 1.0, 8.0], [8.0, 1.0, 8.0], [8.0, 1.0, -8.0]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    square.uvs = vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let mut scene = scene_of(vec![square], &[(0, IDENTITY)]);
    let texels = (0..16 * 16).map(|i| if i % 2 == 0 { 255 } else { 0 }).collect();
    scene.textures.push(Texture {
        name: String::new(),
        width: 16,
        height: 16,
        pixels: Pixels::Alpha(texels),
        wrap: [Wrap::Repeat; 2],
        nearest: true,
    });
    scene.materials[0].alpha = AlphaMode::Mask { cutoff: 0.5 };
    scene.materials[0].texture = Some(0);
    // From x = -3.5 to 3.5 at y = 1, where columns that begin at an even number are opaque.
    let knots: Vec<[f64; 3]> = (0..8).map(|k| [f64::from(k) - 3.5, 1.0, 0.3]).collect();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let spans = hidden(&tracer, [0.0; 3], &knots);
    let expected = [[0.0, 0.5], [1.5, 2.5], [3.5, 4.5], [5.5, 6.5]];
    assert_eq!(spans.len(), expected.len(), "{spans:?}");
    let off = spans.as_flattened().iter().zip(expected.as_flattened()).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-3, "{spans:?}");
    // The number of samples is limited, and there is one at least.
    let mut cover = Cover::default();
    for (mask_step, expected) in [(1e-300, 1), (0.0, 0), (-1.0, 0), (f64::NAN, 0)] {
        cover.clear();
        tracer.hide([0.0; 3], &Fan::new(knots[..2].to_vec(), mask_step), &mut cover);
        assert_eq!(cover.spans().len(), expected, "{mask_step}");
    }
    scene.materials[0].casts = false;
    assert!(hidden(&Tracer::build(&scene, TraceOptions::default()), [0.0; 3], &knots).is_empty());
}

#[test]
fn fans_of_nothing_have_no_shadows() {
    let scene = scene_of(vec![soup(&mut Random(3), 5, 0.5)], &[(0, IDENTITY)]);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    for knots in [&[][..], &[[1.0, 0.0, 0.0]], &[[1.0, 0.0, 0.0], [f64::NAN; 3]]] {
        assert!(hidden(&tracer, [0.0; 3], knots).is_empty());
    }
    let empty = Scene::default();
    let knots = [[1.0, 0.0, 0.0], [1.0, 0.1, 0.0]];
    assert!(hidden(&Tracer::build(&empty, TraceOptions::default()), [0.0; 3], &knots).is_empty());
}
