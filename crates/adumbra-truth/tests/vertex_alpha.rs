//! Vertex alpha cuts masked materials: rays, the bake and its look-ups agree on where.

use adumbra::{Filter, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_scene::{AlphaMode, Instance, Material, Mesh, Scene};
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};

const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A square from -`half` to `half` at height `y`. If `faded`, alpha goes from 0 at its left side to 1 at its
/// right side.
fn square(name: &str, half: f32, y: f32, material: u32, faded: bool) -> Mesh {
    let colors = [[255, 255, 255, 0], [255; 4], [255; 4], [255, 255, 255, 0]];
    Mesh {
        name: name.to_owned(),
        positions: vec![[-half, y, half], [half, y, half], [half, y, -half], [-half, y, -half]],
        colors: if faded { colors.to_vec() } else { Vec::new() },
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![material; 2],
        ..Mesh::default()
    }
}

/// A ground, and above it a square that is opaque where alpha is at least a quarter: x >= -1.
fn scene() -> Scene {
    let place = |mesh| Instance { name: "place".to_owned(), mesh, world_from_mesh: IDENTITY, casts: true };
    let cut = Material { alpha: AlphaMode::Mask { cutoff: 0.25 }, ..Material::opaque("cut", [1.0; 4]) };
    Scene {
        meshes: vec![square("ground", 6.0, 0.0, 0, false), square("leaf", 2.0, 3.0, 1, true)],
        instances: vec![place(0), place(1)],
        materials: vec![Material::opaque("ground", [1.0; 4]), cut],
        ..Scene::default()
    }
}

#[test]
fn sun_passes_where_vertex_alpha_is_below_the_cutoff() {
    let scene = scene();
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(512));
    let baked = Bake::with_options(&scene, &options).in_memory().unwrap();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let texel = baked.grid.voxel_size;
    let sampler = baked.sampler(Filter::Nearest);
    for i in 0..400 {
        let x = -5.0 + 0.025 * f64::from(i);
        let p = [x, 0.0, 0.3];
        let shadowed = (-1.0..=2.0).contains(&x);
        let origin = [x, 0.001, 0.3];
        let ray = Ray { origin, direction: sun.towards(), t_min: 0.0, t_max: f64::INFINITY };
        assert_eq!(tracer.occluded(&ray), shadowed, "the ray at {x}");
        let near_edge = [-1.0, 2.0].iter().any(|edge| (x - edge).abs() < 1.5 * texel);
        if !near_edge {
            let visibility = sampler.visibility(p, Some([0.0, 1.0, 0.0]));
            assert_eq!(visibility, if shadowed { 0.0 } else { 1.0 }, "the file at {x}");
        }
    }
    let ignoring = Tracer::build(&scene, TraceOptions { ignore_alpha: true });
    let at_the_left =
        Ray { origin: [-1.9, 0.001, 0.0], direction: sun.towards(), t_min: 0.0, t_max: f64::INFINITY };
    assert!(ignoring.occluded(&at_the_left) && !tracer.occluded(&at_the_left));
}
