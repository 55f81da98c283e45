//! Generated scenes: the same bytes for the same seed, and closed solids that are sunk into the ground.

use std::collections::BTreeSet;

use adumbra_scene::Error;
use adumbra_scene::topology::{Component, analyse};
use adumbra_scene::{AlphaMode, GeneratedKind, Instance, Mesh, Scene, generate, to_glb};
use adumbra_testing::full;
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};

const KINDS: [GeneratedKind; 10] = [
    GeneratedKind::Spheres,
    GeneratedKind::Primitives,
    GeneratedKind::Landscape,
    GeneratedKind::City,
    GeneratedKind::Ball,
    GeneratedKind::SphereGrid,
    GeneratedKind::Wires,
    GeneratedKind::Cornell,
    GeneratedKind::Forest,
    GeneratedKind::Pylons,
];
/// The kinds that rest on y = 0 and include no ground.
const WITHOUT_GROUND: [GeneratedKind; 3] =
    [GeneratedKind::Ball, GeneratedKind::SphereGrid, GeneratedKind::Wires];

/// FNV-1a: sufficient to detect that bytes changed.
fn fingerprint(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xCBF2_9CE4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01B3))
}

#[test]
fn same_seed_gives_same_bytes_and_another_seed_others() {
    for kind in KINDS {
        let first = to_glb(&generate(kind, 7));
        assert!(first == to_glb(&generate(kind, 7)), "{kind:?}");
        assert!(first != to_glb(&generate(kind, 8)), "{kind:?}");
    }
}

#[test]
fn bytes_are_the_same_on_every_machine() {
    // Change these only together with the generator.
    let expected = [
        0x9498_B367_C9CF_57A1,
        0x1755_3006_93F1_C730,
        0x487C_97EC_FD4D_E314,
        0x2EA8_F41C_50ED_9D84,
        0x9E3F_6569_2C66_4032,
        0x1AAC_89B9_18A0_6B13,
        0x43EC_C479_4C0C_8FE8,
        0x82E8_F1BE_BDDA_0205,
        0xEE5C_AC29_02C8_1CDA,
        0x118E_493A_126C_9296,
    ];
    let found = KINDS.map(|kind| fingerprint(&to_glb(&generate(kind, 1))));
    assert_eq!(found, expected, "{found:#018X?}");
}

#[test]
fn scenes_satisfy_the_invariants_of_their_types() {
    for (kind, seed) in KINDS.into_iter().flat_map(|k| [0, 1, u64::MAX].map(|s| (k, s))) {
        let scene = generate(kind, seed);
        for instance in &scene.instances {
            assert!((instance.mesh as usize) < scene.meshes.len());
            assert!(instance.determinant() > 0.0);
            // A file stores the transform exactly.
            assert!(instance.world_from_mesh.iter().flatten().all(|&m| f64::from(m as f32) == m));
        }
        let placed: BTreeSet<u32> = scene.instances.iter().map(|i| i.mesh).collect();
        for (m, mesh) in scene.meshes.iter().enumerate() {
            assert!(placed.contains(&(m as u32)), "{kind:?} {seed}: {} is nowhere", mesh.name);
            assert_eq!(mesh.triangles.len(), mesh.triangle_materials.len());
            assert!(mesh.triangle_materials.iter().all(|&m| (m as usize) < scene.materials.len()));
            assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()));
            for t in 0..mesh.triangles.len() {
                assert!(area(mesh, t) > 1e-9, "{kind:?} {seed}: {} triangle {t} has no area", mesh.name);
            }
        }
    }
}

fn area(mesh: &Mesh, triangle: usize) -> f64 {
    let [a, b, c] = mesh.triangles[triangle].map(|v| mesh.positions[v as usize].map(f64::from));
    let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    n.iter().map(|c| c * c).sum::<f64>().sqrt() / 2.0
}

#[test]
fn everything_except_terrain_and_cards_is_solid() {
    let seeds = if full() { 0..3 } else { 0..1 };
    let solid = KINDS.into_iter().filter(|&kind| kind != GeneratedKind::Forest);
    for (kind, seed) in solid.flat_map(|k| seeds.clone().map(move |s| (k, s))) {
        let scene = generate(kind, seed);
        for mesh in scene.meshes.iter().filter(|m| m.name != "terrain") {
            let topology = analyse(mesh, &scene.materials);
            let odd = |c: &&Component| !(c.closed && c.solid && c.signed_volume > 0.0);
            assert_eq!(topology.components.iter().find(odd), None, "{kind:?} {seed}: {}", mesh.name);
            assert_eq!(topology.solid_share(), 1.0);
        }
    }
}

#[test]
fn scenes_have_their_documented_sizes() {
    let count = |s: &Scene, what: &str| s.instances.iter().filter(|i| i.name.starts_with(what)).count();
    for seed in 0..if full() { 6 } else { 1 } {
        let spheres = generate(GeneratedKind::Spheres, seed);
        assert_eq!((spheres.instances.len(), spheres.meshes.len()), (226, 2));
        let primitives = generate(GeneratedKind::Primitives, seed);
        assert_eq!(primitives.instances.len(), 9);
        let landscape = generate(GeneratedKind::Landscape, seed);
        assert!(landscape.meshes[0].triangles.len() >= 20_000);
        let found = ["tree", "rock", "house"].map(|what| count(&landscape, what));
        assert!(found[0] >= 500 && found[1] >= 100 && found[2] >= 4, "seed {seed}: {found:?}");
        let city = generate(GeneratedKind::City, seed);
        assert!((10_000..28_000).contains(&city.stored_triangles()), "{}", city.stored_triangles());
        let ball = generate(GeneratedKind::Ball, seed);
        assert_eq!((ball.instances.len(), ball.stored_triangles()), (1, 268_800));
        let grid = generate(GeneratedKind::SphereGrid, seed);
        assert_eq!((grid.instances.len(), grid.stored_triangles()), (25, 480));
        assert_eq!(grid.instanced_triangles(), 12_000);
        let wires = generate(GeneratedKind::Wires, seed);
        assert!((4_000..12_000).contains(&wires.stored_triangles()), "{}", wires.stored_triangles());
        let cornell = generate(GeneratedKind::Cornell, seed);
        assert_eq!((cornell.instances.len(), cornell.stored_triangles()), (3, 28 + 2 * 12));
        let pylons = generate(GeneratedKind::Pylons, seed);
        let found = ["pylon", "cables", "lamp", "fence"].map(|what| count(&pylons, what));
        assert_eq!(found, [20, 20, 50, 100], "seed {seed}");
        let towers = pylons.instances.iter().filter(|instance| instance.name.contains("pylon"));
        let xs: Vec<f64> = towers.map(|tower| tower.world_from_mesh[0][3]).collect();
        assert!(xs.len() == 21 && xs.is_sorted() && xs[20] - xs[0] == 2000.0, "{xs:?}");
        for scene in [landscape, city] {
            let bounds = scene.bounds();
            assert!([0, 2].into_iter().all(|a| (399.0..410.0).contains(&(bounds.max[a] - bounds.min[a]))));
        }
    }
}

#[test]
fn forest_has_a_million_cards_on_a_thousand_solid_trunks() {
    for seed in 0..if full() { 3 } else { 1 } {
        let forest = generate(GeneratedKind::Forest, seed);
        let is_card = |&&m: &&u32| forest.materials[m as usize].alpha != AlphaMode::Opaque;
        let cards = |i: &Instance| {
            forest.meshes[i.mesh as usize].triangle_materials.iter().filter(is_card).count() / 2
        };
        assert_eq!(forest.instances.iter().map(cards).sum::<usize>(), 1_000_000);
        assert_eq!(forest.instances.iter().filter(|i| i.name.starts_with("tree")).count(), 1000);
        for mesh in &forest.meshes {
            let topology = analyse(mesh, &forest.materials);
            assert_eq!(topology.components.iter().filter(|c| c.solid).count(), 1, "{}", mesh.name);
            assert!(mesh.uvs.is_empty() || mesh.uvs.len() == mesh.positions.len(), "{}", mesh.name);
        }
    }
}

#[test]
fn scenes_without_a_ground_rest_on_zero() {
    let seeds = if full() { 1..4 } else { 1..2 };
    for (kind, seed) in WITHOUT_GROUND.into_iter().flat_map(|kind| seeds.clone().map(move |s| (kind, s))) {
        let scene = generate(kind, seed);
        assert_eq!(scene.bounds().min[1], 0.0, "{kind:?} {seed}");
        assert!(scene.instances.iter().all(|i| i.name != "ground"));
    }
}

#[test]
fn ball_is_a_unit_ball_with_dimples() {
    let ball = generate(GeneratedKind::Ball, 1);
    assert_eq!(ball.bounds().max[1], 2.0);
    let radius = |p: &[f32; 3]| {
        let [x, y, z] = p.map(f64::from);
        (x * x + (y - 1.0).powi(2) + z * z).sqrt()
    };
    let radii: Vec<f64> = ball.meshes[0].positions.iter().map(radius).collect();
    assert!(radii.iter().all(|r| (0.97..1.000_001).contains(r)));
    let hollow = radii.iter().filter(|&&r| r < 0.999).count() as f64 / radii.len() as f64;
    assert!((0.3..0.9).contains(&hollow), "{hollow}");
}

#[test]
fn sphere_grid_has_spheres_in_the_air_and_on_the_ground() {
    let scene = generate(GeneratedKind::SphereGrid, 4);
    let foot = |i: &Instance| i.world_from_mesh[1][3] - i.world_from_mesh[1][1];
    let on_ground = scene.instances.iter().filter(|i| foot(i) == 0.0).count();
    let in_air = scene.instances.iter().filter(|i| foot(i) > 0.4).count();
    assert_eq!((on_ground, in_air), (13, 12));
}

#[test]
fn cornell_box_is_open_to_the_front_and_holds_its_blocks() {
    let scene = generate(GeneratedKind::Cornell, 3);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let wall = |direction: [f64; 3]| {
        let ray = Ray { origin: [0.0, 5.0, 0.0], direction, t_min: 0.0, t_max: f64::INFINITY };
        tracer.nearest_surface(&ray).map(|hit| (hit.t, hit.material, hit.front))
    };
    // Half is the value as rounded to `f32`.
    let (half, height) = (f64::from(2.8_f32), 5.5);
    let near = |found: Option<(f64, u32, bool)>, t: f64, name: &str| {
        let (at, material, front) = found.unwrap();
        assert!((at - t).abs() < 1e-9 && front, "{name}: {at}");
        assert_eq!(scene.materials[material as usize].name, name);
    };
    near(wall([-1.0, 0.0, 0.0]), half, "left");
    near(wall([1.0, 0.0, 0.0]), half, "right");
    near(wall([0.0, 0.0, -1.0]), half, "white");
    near(wall([0.0, 1.0, 0.0]), height - 5.0, "white");
    assert_eq!(wall([0.0, 0.0, 1.0]), None);
    for (block, height) in [("tall block", f64::from(3.3_f32)), ("short block", f64::from(1.65_f32))] {
        let mut alone = scene.clone();
        alone.instances.retain(|i| i.name == block);
        let bounds = alone.bounds();
        assert!((bounds.max[1] - height).abs() < 1e-6 && bounds.min[1] < 0.0, "{block}: {bounds:?}");
        for a in [0, 2] {
            assert!(bounds.min[a] > -2.6 && bounds.max[a] < 2.6, "{block} stands free: {bounds:?}");
            assert!(bounds.max[a] - bounds.min[a] > 1.9, "{block} is turned: {bounds:?}");
        }
    }
}

#[test]
fn ground_is_a_slab_below_the_middle_of_the_model() {
    for kind in WITHOUT_GROUND {
        let mut scene = generate(kind, 2);
        for row in 0..3 {
            scene.instances[0].world_from_mesh[row][3] += [40.0, -7.0, 3.0][row];
        }
        let (model, triangles) = (scene.bounds(), scene.instanced_triangles());
        scene.stand_on_ground(4.0).unwrap();
        assert_eq!(scene.instanced_triangles(), triangles + 12);
        let mut ground = scene.clone();
        ground.instances.retain(|i| i.name == "ground");
        let slab = ground.bounds();
        let extent = (0..3).map(|a| model.max[a] - model.min[a]).fold(0.0, f64::max);
        let near = |x: f64, y: f64| (x - y).abs() < 1e-5 * extent.max(40.0);
        for a in [0, 2] {
            assert!(near(slab.max[a] - slab.min[a], 4.0 * extent), "{kind:?} {slab:?}");
            assert!(near(slab.max[a] + slab.min[a], model.max[a] + model.min[a]), "{kind:?} {slab:?}");
        }
        let depth = slab.max[1] - model.min[1];
        assert!(depth > 0.0 && depth < 0.005 * extent && slab.min[1] < model.min[1], "{kind:?} {slab:?}");
        assert!(ground.instances[0].world_from_mesh.iter().flatten().all(|&m| f64::from(m as f32) == m));
        let mesh = &scene.meshes[ground.instances[0].mesh as usize];
        assert_eq!(analyse(mesh, &scene.materials).solid_share(), 1.0);
    }
}

#[test]
fn ground_rejects_bad_factors_and_skips_empty_scenes() {
    let mut scene = generate(GeneratedKind::SphereGrid, 1);
    for factor in [0.0, -4.0, 0.99, 1001.0, f64::NAN, f64::INFINITY] {
        let refused = scene.stand_on_ground(factor);
        assert!(matches!(refused, Err(Error::GroundSize { .. })), "{factor}");
        let message = refused.unwrap_err().to_string();
        assert!(message.ends_with("from 1 to 1000 times the scene's extent"), "{message}");
    }
    assert_eq!(scene.instances.len(), 25);
    let mut empty = Scene::default();
    empty.stand_on_ground(4.0).unwrap();
    assert!(empty.instances.is_empty() && empty.meshes.is_empty());
}

#[test]
fn landscape_instances_reach_into_the_terrain() {
    let scene = generate(GeneratedKind::Landscape, 5);
    let terrain = &scene.meshes[0];
    for instance in scene.instances.iter().filter(|i| i.name != "terrain") {
        let mesh = &scene.meshes[instance.mesh as usize];
        let points = mesh.positions.iter().map(|&p| instance.to_world(p));
        let foot = points.min_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
        let ground = height_below(terrain, foot);
        assert!(ground.is_some_and(|g| foot[1] < g), "{} at {foot:?} over {ground:?}", instance.name);
    }
}

/// Height of the terrain at the point's (x, z).
fn height_below(terrain: &Mesh, point: [f64; 3]) -> Option<f64> {
    terrain.triangles.iter().find_map(|t| {
        let [a, b, c] = t.map(|v| terrain.positions[v as usize].map(f64::from));
        let side = |p: [f64; 3], q: [f64; 3]| {
            (p[0] - point[0]) * (q[2] - point[2]) - (p[2] - point[2]) * (q[0] - point[0])
        };
        let w = [side(b, c), side(c, a), side(a, b)];
        let whole = w[0] + w[1] + w[2];
        let holds = w.iter().all(|&s| s * whole >= 0.0);
        holds.then(|| (w[0] * a[1] + w[1] * b[1] + w[2] * c[1]) / whole)
    })
}
