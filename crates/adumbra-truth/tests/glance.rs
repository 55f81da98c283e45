//! What a person would notice in a scene at a glance: skies that hide the sun, strays that make a scene wide,
//! and shares of shadow that agree with rays.

use adumbra::Sun;
use adumbra_scene::{GeneratedKind, Instance, Material, Mesh, Scene, generate, icosphere};
use adumbra_truth::glance::{Glance, LitPoint, shadowed_share};
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};

fn sun(elevation_degrees: f64) -> [f64; 3] {
    Sun::from_angles(200.0, elevation_degrees).unwrap().towards()
}

fn look(scene: &Scene, towards_sun: [f64; 3]) -> Glance {
    Glance::of(scene, towards_sun, false)
}

fn names(scene: &Scene) -> Vec<String> {
    look(scene, sun(50.0)).hider.map(|hider| hider.names).unwrap_or_default()
}

/// Adds triangles as a separate node named `name`, with a material named `material`.
fn add(scene: &mut Scene, name: &str, material: &str, triangles: &[[[f64; 3]; 3]]) {
    let index = scene.materials.iter().position(|m| m.name == material).unwrap_or_else(|| {
        scene.materials.push(Material::opaque(material, [1.0; 4]));
        scene.materials.len() - 1
    });
    let corners = triangles.iter().flatten().map(|p| p.map(|c| c as f32));
    scene.meshes.push(Mesh {
        name: format!("{name} mesh"),
        positions: corners.collect(),
        triangles: (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        triangle_materials: vec![index as u32; triangles.len()],
        ..Mesh::default()
    });
    scene.instances.push(Instance {
        name: name.to_owned(),
        mesh: scene.meshes.len() as u32 - 1,
        world_from_mesh: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        casts: true,
    });
}

fn turned_inside_out(triangles: Vec<[[f64; 3]; 3]>, inside_out: bool) -> Vec<[[f64; 3]; 3]> {
    let turned = |[a, b, c]: [[f64; 3]; 3]| if inside_out { [a, c, b] } else { [a, b, c] };
    triangles.into_iter().map(turned).collect()
}

/// A ball around the scene, or its upper half.
fn ball(radius: f64, is_half: bool) -> Vec<[[f64; 3]; 3]> {
    let (points, triangles) = icosphere(3);
    let all = triangles.iter().map(|t| t.map(|v| points[v as usize].map(|c| radius * c)));
    all.filter(|t| !is_half || t.iter().all(|p| p[1] > -0.1 * radius)).collect()
}

/// The six sides of a box around the scene.
fn sides(half: f64) -> [Vec<[[f64; 3]; 3]>; 6] {
    std::array::from_fn(|side| {
        let (axis, end) = (side / 2, if side % 2 == 0 { -half } else { half });
        let corner = |u: f64, v: f64| {
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (end, u * half, v * half);
            p
        };
        let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        turned_inside_out(vec![[a, b, c], [a, c, d]], end < 0.0)
    })
}

#[test]
fn skies_of_all_shapes_are_detected_and_named() {
    assert!(names(&generate(GeneratedKind::City, 1)).is_empty());
    for kind in [GeneratedKind::Primitives, GeneratedKind::Landscape] {
        let plain = generate(kind, 1);
        assert!(names(&plain).is_empty(), "{kind:?}: {:?}", names(&plain));
        let radius = 1.5 * plain.bounds().diagonal();
        for inside_out in [false, true] {
            for is_half in [false, true] {
                let mut scene = plain.clone();
                add(&mut scene, "Sky", "sky", &turned_inside_out(ball(radius, is_half), inside_out));
                assert_eq!(names(&scene), ["Sky"], "{kind:?} {inside_out} {is_half}");
            }
            let mut scene = plain.clone();
            let sides = sides(radius).map(|side| turned_inside_out(side, inside_out));
            add(&mut scene, "Skybox", "sky", &sides.concat());
            assert_eq!(names(&scene), ["Skybox"]);
            // With six nodes, the sides through which the sun would shine are named.
            let mut scene = plain.clone();
            for (i, side) in sides.iter().enumerate() {
                add(&mut scene, &format!("side {i}"), "sky", side);
            }
            let parts = names(&scene);
            assert!(!parts.is_empty() && parts.iter().all(|name| name.starts_with("side ")), "{parts:?}");
        }
    }
}

#[test]
fn sky_within_a_mesh_is_named_by_its_material() {
    let city = generate(GeneratedKind::City, 1);
    let town: Vec<[[f64; 3]; 3]> = city
        .instances
        .iter()
        .flat_map(|i| {
            let mesh = &city.meshes[i.mesh as usize];
            mesh.triangles.iter().map(|t| t.map(|v| i.to_world(mesh.positions[v as usize])))
        })
        .collect();
    let mut scene = Scene::default();
    add(&mut scene, "Scene", "walls", &town);
    assert!(names(&scene).is_empty());
    scene.materials.push(Material::opaque("sky", [1.0; 4]));
    let mesh = &mut scene.meshes[0];
    for triangle in ball(2.0 * city.bounds().diagonal(), false) {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(triangle.map(|p| p.map(|c| c as f32)));
        mesh.triangles.push([first, first + 1, first + 2]);
        mesh.triangle_materials.push(1);
    }
    assert_eq!(names(&scene), ["sky"]);
    // A sky that casts no shadow hides nothing, and the shares in shadow stay about the same.
    scene.materials[1].casts = false;
    assert!(names(&scene).is_empty());
    let [with, without] = [&scene, &city].map(|scene| look(scene, sun(50.0)));
    let within = |seen: &&LitPoint| seen.p_world[0].abs() < 190.0 && seen.p_world[2].abs() < 190.0;
    for [with, without] in [[&with.ground, &without.ground], [&with.standing, &without.standing]] {
        let share = |all: &[LitPoint]| {
            let all: Vec<LitPoint> = all.iter().filter(within).copied().collect();
            (all.len() as f64, shadowed_share(&all).unwrap())
        };
        let ((count, dark), (expected, dark_expected)) = (share(with), share(without));
        assert!(
            count > 20.0 && (dark - dark_expected).abs() < 0.2,
            "{count} {expected} {dark} {dark_expected}"
        );
    }
}

#[test]
fn lit_points_agree_with_rays() {
    for kind in
        [GeneratedKind::City, GeneratedKind::Landscape, GeneratedKind::Primitives, GeneratedKind::Spheres]
    {
        let scene = generate(kind, 2);
        let tracer = Tracer::build(&scene, TraceOptions::default());
        for elevation in [15.0, 60.0] {
            let (towards, glance) = (sun(elevation), look(&scene, sun(elevation)));
            let is_right = |seen: &&LitPoint| {
                let ray = Ray { origin: seen.p_world, direction: towards, t_min: 0.0, t_max: f64::INFINITY };
                seen.is_lit != tracer.occluded(&ray)
            };
            for points in [&glance.ground, &glance.standing] {
                let right = points.iter().filter(is_right).count();
                assert!(points.len() > 700, "{kind:?}: {}", points.len());
                // Rays that graze a corner may go either way.
                assert!(right * 1000 >= points.len() * 998, "{kind:?}: {right} of {}", points.len());
            }
        }
    }
}

#[test]
fn ground_points_are_in_streets_and_not_inside_walls() {
    let mut scene = Scene::default();
    let quad = |[x0, x1]: [f64; 2], [z0, z1]: [f64; 2], y: f64| {
        let [a, b, c, d] = [[x0, y, z0], [x0, y, z1], [x1, y, z1], [x1, y, z0]];
        vec![[a, b, c], [a, c, d]]
    };
    add(&mut scene, "ground", "a", &quad([-50.0, 50.0], [-50.0, 50.0], 0.0));
    // Half of the town is a block of 20 m on a slab. The top of the slab is the bottom of the block. A tower
    // intersects both.
    let solid = |[x0, x1]: [f64; 2], [z0, z1]: [f64; 2], [low, high]: [f64; 2]| {
        let ring = [[x0, z0], [x0, z1], [x1, z1], [x1, z0]];
        let mut all = quad([x0, x1], [z0, z1], high);
        all.extend(turned_inside_out(quad([x0, x1], [z0, z1], low), true));
        for (i, [x, z]) in ring.into_iter().enumerate() {
            let [u, w] = ring[(i + 1) % 4];
            let [a, b, c, d] = [[x, low, z], [u, low, w], [u, high, w], [x, high, z]];
            all.extend([[a, b, c], [a, c, d]]);
        }
        all
    };
    let town = [[-50.0, 0.0], [-50.0, 50.0]];
    add(&mut scene, "slab", "b", &solid(town[0], town[1], [0.0, 0.2]));
    add(&mut scene, "block", "b", &solid(town[0], town[1], [0.2, 20.0]));
    add(&mut scene, "tower", "b", &solid([-10.0, -5.0], town[1], [-1.0, 20.0]));
    // A road lies just above the street. People stand on the street below it.
    add(&mut scene, "road", "c", &quad([10.0, 20.0], [-50.0, 50.0], 0.01));
    scene.instances[4].casts = false;
    add(&mut scene, "awning", "d", &quad([40.0, 45.0], [-50.0, 50.0], 5.0));
    scene.instances[5].casts = false;
    let glance = look(&scene, [0.0, 1.0, 0.0]);
    assert!(glance.ground.len() > 940 && glance.ground.len() < 1080, "{}", glance.ground.len());
    assert!(
        glance.ground.iter().all(|seen| seen.p_world[0] > 0.0 && seen.p_world[1].abs() < 1e-3 && seen.is_lit)
    );
    assert_eq!(shadowed_share(&glance.ground), Some(0.0));
    // The sun is above the block: the block's shadow is 30 m long, and 2.55 m shorter at eye level.
    let elevation = (20.0_f64 / 30.0).atan().to_degrees();
    let west = look(&scene, Sun::from_angles(270.0, elevation).unwrap().towards());
    let [ground, standing] = [&west.ground, &west.standing].map(|points| shadowed_share(points).unwrap());
    assert!((ground - 0.6).abs() < 0.03 && (standing - 0.549).abs() < 0.03, "{ground} {standing}");
}

#[test]
fn strays_are_named_and_excluded_from_the_box() {
    for kind in [GeneratedKind::Landscape, GeneratedKind::Primitives] {
        let plain = generate(kind, 1);
        let bounds = plain.bounds();
        let spread = look(&plain, sun(50.0)).spread;
        assert!(spread.stray.is_none(), "{kind:?}: {:?}", spread.stray);
        // A triangle, a quad, a cube.
        for count in [1, 2, 12] {
            let mut scene = plain.clone();
            add(
                &mut scene,
                "lost",
                "a",
                &vec![[[2e5, 0.0, 5.0], [2e5 + 1.0, 0.0, 5.0], [2e5, 1.0, 6.0]]; count],
            );
            let spread = look(&scene, sun(50.0)).spread;
            let stray = spread.stray.clone().expect("a stray");
            assert!(stray.name == "lost" && stray.reaches[0] > 1.9e5 && !stray.is_around, "{stray:?}");
            let given = spread.bounds_to_give();
            for a in 0..3 {
                let (side, whole) = (given.max[a] - given.min[a], bounds.max[a] - bounds.min[a]);
                assert!(
                    side > 0.4 * whole && side < 1.3 * bounds.diagonal(),
                    "{kind:?}: {given:?} for {bounds:?}"
                );
            }
        }
        // A ground that extends far beyond the rest.
        let mut scene = plain.clone();
        let [a, b, c, d] = [[-1e5, -1.0, -1e5], [-1e5, -1.0, 1e5], [1e5, -1.0, 1e5], [1e5, -1.0, -1e5]];
        add(&mut scene, "land", "a", &[[a, b, c], [a, c, d]]);
        let stray = look(&scene, sun(50.0)).spread.stray.expect("a stray");
        assert!(stray.name == "land" && stray.is_around, "{stray:?}");
    }
}

#[test]
fn tower_shadows_a_small_share_of_a_wide_ground() {
    let ground = [[-100.0, 0.0, -100.0], [-100.0, 0.0, 100.0], [100.0, 0.0, 100.0], [100.0, 0.0, -100.0]];
    let ground = vec![[ground[0], ground[1], ground[2]], [ground[0], ground[2], ground[3]]];
    // A tower 16 m wide and 40 m high, without a floor, in one mesh with its ground or in a separate mesh.
    let tower: Vec<[[f64; 3]; 3]> = sides(8.0)
        .into_iter()
        .enumerate()
        .filter(|(side, _)| *side != 2)
        .flat_map(|(_, triangles)| triangles)
        .map(|t| t.map(|[x, y, z]| [x, 2.5 * (y + 8.0), z]))
        .collect();
    for parts in [vec![[ground.clone(), tower.clone()].concat()], vec![ground, tower]] {
        let mut scene = Scene::default();
        for (i, part) in parts.iter().enumerate() {
            add(&mut scene, &format!("part {i}"), "a", part);
        }
        let glance = look(&scene, sun(45.0));
        let share = shadowed_share(&glance.ground).unwrap();
        assert!(share > 0.01 && share < 0.25, "{} parts: {share}", parts.len());
        let standing = shadowed_share(&glance.standing).unwrap();
        assert!(standing > 0.01 && standing < 0.25, "{} parts: {standing}", parts.len());
    }
}

#[test]
fn empty_scene_has_no_hider_and_no_stray() {
    let scene = generate(GeneratedKind::City, 1);
    let nothing = look(&Scene { instances: Vec::new(), ..scene.clone() }, sun(50.0));
    assert!(nothing.hider.is_none() && nothing.spread.stray.is_none());
    let mut bare = scene;
    bare.meshes[0].triangles.clear();
    bare.meshes[0].triangle_materials.clear();
    assert!(look(&bare, sun(50.0)).hider.is_none());
}
