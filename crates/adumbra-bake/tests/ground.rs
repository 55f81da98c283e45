//! Tests which scenes have their own ground.

use adumbra_bake::Ground;

use adumbra_scene::{GeneratedKind, Instance, LoadOptions, Material, Mesh, Scene, generate, load};
use adumbra_testing::shared;

/// A scene of boxes, given by their lowest and highest corners.
fn boxes(all: &[[[f32; 3]; 2]]) -> Scene {
    let mut mesh = Mesh::default();
    for [low, high] in all {
        let first = mesh.positions.len() as u32;
        let corner = |c: usize| [0, 1, 2].map(|a| if c >> a & 1 == 0 { low[a] } else { high[a] });
        mesh.positions.extend((0..8).map(corner));
        for [a, b, c, d] in
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
        {
            mesh.triangles.extend([[a, b, c], [a, c, d]].map(|t| t.map(|v| first + v)));
        }
    }
    scene_of(mesh)
}

fn scene_of(mesh: Mesh) -> Scene {
    let triangle_materials = vec![0; mesh.triangles.len()];
    Scene {
        meshes: vec![Mesh { triangle_materials, ..mesh }],
        instances: vec![Instance {
            name: String::new(),
            mesh: 0,
            world_from_mesh: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
            casts: true,
        }],
        materials: vec![Material::opaque("grey", [0.5, 0.5, 0.5, 1.0])],
        ..Scene::default()
    }
}

/// A field of heights, 64 × 64 squares of one metre.
fn field(height: impl Fn(f32, f32) -> f32) -> Scene {
    let mut mesh = Mesh::default();
    let (side, row) = (64_u32, 65);
    for z in 0..row {
        mesh.positions.extend((0..row).map(|x| [x as f32, height(x as f32, z as f32), z as f32]));
    }
    for (x, z) in (0..side * side).map(|i| (i % side, i / side)) {
        let first = z * row + x;
        mesh.triangles.extend([[first, first + row, first + 1], [first + 1, first + row, first + row + 1]]);
    }
    scene_of(mesh)
}

/// Blocks of houses, each with its own floor, 8 m wide and high and 8 m apart.
fn houses() -> Vec<[[f32; 3]; 2]> {
    let house = |i: u32| {
        let [x, z] = [i % 6, i / 6].map(|c| 16.0 * c as f32 + 8.0);
        [[x, 0.0, z], [x + 8.0, 8.0, z + 8.0]]
    };
    (0..36).map(house).collect()
}

fn assert_ground(name: &str, scene: &Scene, is_there: bool) {
    let ground = Ground::of(scene);
    assert_eq!(ground.is_there(), is_there, "{name}: {ground:?}");
}

#[test]
fn floor_that_receives_the_shadows_is_a_ground() {
    let slab = [[0.0, -0.5, 0.0], [104.0, 0.0, 104.0]];
    assert_ground("houses on a slab", &boxes(&[houses(), vec![slab]].concat()), true);
    assert_ground("slab", &boxes(&[slab]), true);
    assert_ground("plain", &field(|_, _| 0.0), true);
    assert_ground("hills", &field(|x, z| 6.0 * (x / 8.0).sin() * (z / 11.0).cos()), true);
    // Foundations reach below the ground.
    let mut deep = field(|x, _| 0.1 * x);
    let founded = boxes(&[[[20.0, -1.0, 20.0], [30.0, 9.0, 30.0]], [[40.0, 0.5, 8.0], [44.0, 12.0, 12.0]]]);
    deep.meshes.extend(founded.meshes);
    deep.instances.push(Instance { mesh: 1, ..deep.instances[0].clone() });
    assert_ground("houses with foundations", &deep, true);
    // A plain that casts no shadow still receives shadows.
    let mut plain = field(|_, _| 0.0);
    plain.instances[0].casts = false;
    assert_ground("plain that does not cast", &plain, true);
}

#[test]
fn scenes_without_a_floor_for_their_shadows_have_no_ground() {
    assert_ground("houses", &boxes(&houses()), false);
    assert_ground("house", &boxes(&[[[0.0; 3], [8.0, 6.0, 8.0]]]), false);
    assert_ground("nothing", &Scene::default(), false);
    let hall = [
        [[0.0, 7.0, 0.0], [40.0, 8.0, 30.0]],
        [[0.0, 0.0, 0.0], [0.4, 7.0, 30.0]],
        [[39.6, 0.0, 0.0], [40.0, 7.0, 30.0]],
    ];
    assert_ground("hall without a floor", &boxes(&hall), false);
    let tower = [[[0.0, 0.0, 0.0], [20.0, 0.5, 20.0]], [[5.0, 0.5, 5.0], [15.0, 100.0, 15.0]]];
    assert_ground("tower on a plate", &boxes(&tower), false);
    // The lowest leaves of a wood are at all heights.
    let leaf = |i: u32| {
        let [x, z] = [i % 90, i / 90].map(|c| c as f32);
        let y = 4.0 + (i.wrapping_mul(2_654_435_761) >> 16) as f32 % 997.0 / 100.0;
        [[x, y, z], [x + 1.0, y + 0.1, z + 1.0]]
    };
    let trunk = |i: u32| {
        let [x, z] = [i % 9, i / 9].map(|c| 10.0 * c as f32 + 5.0);
        [[x, 0.0, z], [x + 0.5, 10.0, z + 0.5]]
    };
    let wood: Vec<_> = (0..90 * 90).map(leaf).chain((0..81).map(trunk)).collect();
    assert_ground("wood", &boxes(&wood), false);
}

#[test]
fn generated_scenes_have_a_ground_until_it_is_taken_away() {
    for kind in [GeneratedKind::City, GeneratedKind::Spheres, GeneratedKind::Primitives] {
        let mut scene = generate(kind, 1);
        assert_ground(&format!("{kind:?}"), &scene, true);
        let is_ground = |i: &Instance| scene.meshes[i.mesh as usize].name == "ground";
        let count = scene.instances.len();
        scene.instances = scene.instances.iter().filter(|i| !is_ground(i)).cloned().collect();
        assert!(scene.instances.len() < count, "{kind:?} has a mesh called ground");
        assert_ground(&format!("{kind:?} without its ground"), &scene, false);
    }
    assert_ground("forest", &generate(GeneratedKind::Forest, 1), true);
    assert_ground("ball", &generate(GeneratedKind::Ball, 1), false);
}

#[test]
#[ignore = "slow: loads every shared scene"]
fn shared_scenes_are_classified_by_their_ground() {
    let Some(folder) = shared("scenes") else { return };
    let with = [
        "alpine-2.glb",
        "box-city-5k.glb",
        "box-city-51k.glb",
        "bridge_garden.glb",
        "dream_apartment.glb",
        "jacksboro.glb",
        "kaykit_city_21.glb",
        "kaykit_city_121.glb",
        "street-1.glb",
    ];
    let mut seen = 0;
    for entry in folder.read_dir().expect("a folder") {
        let path = entry.expect("a file").path();
        let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
        if ["glb", "obj", "ply"].iter().any(|kind| path.extension().is_some_and(|e| e == *kind)) {
            let scene = load(&path, &LoadOptions::default()).expect("a good scene");
            assert_ground(name, &scene, with.contains(&name));
            seen += 1;
        }
    }
    assert_eq!(seen, 18);
}
