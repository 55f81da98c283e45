//! Movers: how the animations of a glTF file move instances, how a load treats movers, and balls on paths.

#[path = "scene_loading/kit.rs"]
#[allow(dead_code, reason = "shared with the other loading tests")]
mod kit;

use adumbra_scene::Error;
use adumbra_scene::{GeneratedKind, LoadOptions, MoverPolicy, Scene, generate};
use kit::{Glb, refused};
use serde_json::json;

fn policy(movers: MoverPolicy) -> LoadOptions {
    LoadOptions { movers, ..LoadOptions::default() }
}

fn keep(glb: &Glb) -> Scene {
    glb.load_with(&policy(MoverPolicy::Keep)).expect("loads")
}

/// Adds an animation with a single channel.
fn animate(glb: &mut Glb, node: usize, property: &str, kind: &str, times: &[f32], values: &[f32]) {
    let shape = if property == "rotation" { "VEC4" } else { "VEC3" };
    let (input, output) = (glb.floats(times, "SCALAR"), glb.floats(values, shape));
    glb.push(
        "animations",
        json!({
            "samplers": [{"input": input, "output": output, "interpolation": kind}],
            "channels": [{"sampler": 0, "target": {"node": node, "path": property}}],
        }),
    );
}

/// A static triangle, and another one on a grandchild of an animated node.
fn tower() -> Glb {
    let mut glb = Glb::triangle();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    glb.json["nodes"] = json!([
        {"mesh": 0, "name": "still"},
        {"translation": [100, 0, 0], "children": [2]},
        {"name": "turning", "children": [3]},
        {"translation": [0, 5, 0], "scale": [2, 2, 2], "children": [4]},
        {"name": "rising", "mesh": 0, "translation": [7, 7, 7]},
    ]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1]);
    animate(&mut glb, 2, "rotation", "LINEAR", &[0.0, 2.0], &[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]);
    animate(&mut glb, 4, "translation", "LINEAR", &[1.0, 3.0], &[0.0, 0.0, 0.0, 0.0, 10.0, 0.0]);
    glb
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn movers_follow_their_parents() {
    let mut scene = keep(&tower());
    assert_eq!(scene.movers.instances().collect::<Vec<_>>(), [1]);
    assert!(scene.movers.contains(1) && !scene.movers.contains(0));
    assert_eq!(scene.movers.end_seconds(), 3.0);
    let mut at = |seconds: f64, p: [f32; 3]| {
        scene.pose(seconds);
        scene.instances[1].to_world(p)
    };
    // Before the first key, too, the animation's value replaces that of the node.
    assert!(near(at(0.0, [0.0; 3]), [100.0, 5.0, 0.0]));
    assert!(near(at(0.0, [1.0, 0.0, 0.0]), [102.0, 5.0, 0.0]));
    // Half way up, scaled by the intermediate node, and rotated by a quarter turn.
    assert!(near(at(2.0, [1.0, 0.0, 0.0]), [100.0, 15.0, -2.0]));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert!(near(at(1.0, [1.0, 0.0, 0.0]), [100.0 + 2.0 * half, 5.0, -2.0 * half]));
    assert!(near(at(99.0, [0.0; 3]), [100.0, 25.0, 0.0]));
    assert_eq!(scene.instances[0].to_world([0.0; 3]), [0.0; 3]);
}

#[test]
fn movers_follow_step_and_spline_interpolation() {
    let mut glb = Glb::triangle();
    animate(&mut glb, 0, "scale", "STEP", &[0.0, 1.0], &[1.0, 1.0, 1.0, 3.0, 3.0, 3.0]);
    // Tangents along z: the spline bends although both keys have z = 0.
    let values = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, -4.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    animate(&mut glb, 0, "translation", "CUBICSPLINE", &[0.0, 1.0], &values);
    let scene = keep(&glb);
    let scale = |seconds: f64| scene.movers.pose(seconds)[0][0][0];
    assert_eq!((scale(0.99), scale(1.0)), (1.0, 3.0));
    let place = |seconds: f64| scene.movers.pose(seconds)[0].map(|row| row[3]);
    assert_eq!((place(0.0), place(1.0)), ([0.0; 3], [2.0, 0.0, 0.0]));
    assert!(near(place(0.5), [1.0, 0.0, 1.0]), "{:?}", place(0.5));
}

#[test]
fn movers_are_skipped_by_default() {
    let glb = tower();
    let scene = glb.load().expect("loads");
    assert_eq!((scene.instances.len(), scene.notes.skipped_movers), (1, 1));
    assert!(scene.movers.is_empty());
    let frozen = glb.load_with(&policy(MoverPolicy::Freeze)).expect("loads");
    assert_eq!((frozen.instances.len(), frozen.movers.len()), (2, 0));
    assert!(near(frozen.instances[1].to_world([0.0; 3]), [100.0, 5.0, 0.0]));
    // A scene that contains only movers has nothing to bake.
    let mut alone = Glb::triangle();
    animate(&mut alone, 0, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let error = refused(alone.load());
    assert!(error.to_string().contains("all 1 instances are animated; load them frozen"), "{error}");
}

#[test]
fn movers_need_a_key_that_moves_them() {
    let mut glb = Glb::triangle();
    glb.json["nodes"][0]["translation"] = json!([1, 2, 3]);
    animate(&mut glb, 0, "translation", "LINEAR", &[0.0, 1.0], &[1.0, 2.0, 3.0, 1.0, 2.0, 3.0]);
    let scene = glb.load().expect("loads");
    assert_eq!((scene.instances.len(), scene.notes.skipped_movers), (1, 0));
}

#[test]
fn movers_include_every_gpu_instance_of_a_node() {
    let mut glb = Glb::triangle();
    let moves = glb.floats(&[1.0, 0.0, 0.0, 2.0, 0.0, 0.0], "VEC3");
    glb.json["nodes"][0] = json!({"mesh": 0,
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moves}}}});
    animate(&mut glb, 0, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 0.0, 8.0, 0.0]);
    let scene = keep(&glb);
    assert_eq!(scene.movers.len(), 2);
    let poses = scene.movers.pose(0.5);
    assert_eq!([0, 1].map(|i| poses[i].map(|row| row[3])), [[1.0, 4.0, 0.0], [2.0, 4.0, 0.0]]);
}

#[test]
fn second_channel_of_a_property_is_ignored_with_a_warning() {
    let mut glb = Glb::triangle();
    for x in [1.0, 2.0] {
        animate(&mut glb, 0, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, x, 0.0, 0.0]);
    }
    let scene = keep(&glb);
    assert_eq!(scene.movers.pose(1.0)[0][0][3], 1.0);
    assert!(scene.notes.warnings[0].contains("the first is used"), "{:?}", scene.notes.warnings);
}

#[test]
fn rejects_movers_with_broken_keys() {
    let cases: [(&str, &[f32], &[f32]); 3] = [
        ("LINEAR", &[1.0, 0.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
        ("LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0]),
        ("CUBICSPLINE", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
    ];
    for (kind, times, values) in cases {
        let mut glb = Glb::triangle();
        animate(&mut glb, 0, "translation", kind, times, values);
        let error = refused(glb.load());
        assert!(matches!(error, Error::SceneParse { .. }), "{error}");
    }
    let mut glb = Glb::triangle();
    animate(&mut glb, 9, "translation", "LINEAR", &[0.0], &[0.0; 3]);
    assert!(refused(glb.load()).to_string().contains("does not exist"));
}

#[test]
fn motion_below_rounding_does_not_make_a_mover() {
    // A triangle of side 1 at a distance of 1000, on a node that scales it to the size of a house: 20.
    let house = |glb: &mut Glb| {
        glb.json["nodes"][0] = json!({"mesh": 0, "translation": [1000, 2, 3], "scale": [20, 20, 20],
            "rotation": [0, 0.6, 0, 0.8]});
    };
    let place = [1000.0, 2.0, 3.0];
    let turned = |angle: f32| {
        let (sine, cosine) = (0.5 * angle).sin_cos();
        [0.0, 0.6 * cosine + 0.8 * sine, 0.0, 0.8 * cosine - 0.6 * sine]
    };
    let moved_by = |d: f32| [place, [1000.0, 2.0 + d, 3.0]].concat();
    let turned_by = |angle: f32| [turned(0.0), turned(angle)].concat();
    let negated = [turned(0.0), turned(0.0).map(|c| -c)].concat();
    let spline = |tangent: f32| [[0.0; 3], place, [0.0, tangent, 0.0], [0.0; 3], place, [0.0; 3]].concat();
    let scaled_by = |s: f32| [[20.0; 3], [20.0 * s, 20.0, 20.0]].concat();
    for (property, kind, values, moves) in [
        ("translation", "LINEAR", moved_by(0.0), false),
        ("translation", "LINEAR", moved_by(0.0018), false),
        ("translation", "LINEAR", moved_by(0.0025), true),
        ("translation", "STEP", moved_by(0.0025), true),
        ("rotation", "LINEAR", turned_by(5e-5), false),
        ("rotation", "LINEAR", turned_by(3e-4), true),
        ("rotation", "LINEAR", negated.clone(), false),
        ("rotation", "STEP", negated, false),
        ("scale", "LINEAR", scaled_by(1.00005), false),
        ("scale", "LINEAR", scaled_by(1.0003), true),
        // Tangents move the node between two equal keys: by 4/27 of the tangent.
        ("translation", "CUBICSPLINE", spline(0.01), false),
        ("translation", "CUBICSPLINE", spline(0.02), true),
    ] {
        let mut glb = Glb::triangle();
        house(&mut glb);
        animate(&mut glb, 0, property, kind, &[0.0, 1.0], &values);
        let scene = keep(&glb);
        assert_eq!(scene.movers.len(), usize::from(moves), "{property} {kind} {values:?}");
        if !moves {
            assert!(near(scene.instances[0].to_world([0.0; 3]), [1000.0, 2.0, 3.0]));
        }
    }
}

#[test]
fn small_rotation_makes_a_mover_of_a_distant_mesh() {
    // 1e-5 radians move a triangle of side 1 by 2e-3 at a distance of 200, and by 1e-5 at the origin.
    for (distance, moves) in [(0.0, false), (200.0, true)] {
        let mut glb = Glb::triangle();
        glb.json["nodes"] =
            json!([{"children": [1]}, {"children": [2], "translation": [distance, 0, 0]}, {"mesh": 0}]);
        let turned = [0.0, 0.0, 0.0, 1.0, 0.0, 5e-6, 0.0, 1.0];
        animate(&mut glb, 0, "rotation", "LINEAR", &[0.0, 1.0], &turned);
        assert_eq!(keep(&glb).movers.len(), usize::from(moves), "{distance}");
    }
}

#[test]
fn an_animated_node_with_a_matrix_is_a_mover() {
    // A quarter turn about y, mirrored and doubled, at (5, 0, 0).
    let matrix = json!([0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 5, 0, 0, 1]);
    let mut glb = Glb::triangle();
    glb.json["nodes"] = json!([{"mesh": 0, "name": "town"}, {"mesh": 0, "matrix": matrix}]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1]);
    animate(&mut glb, 1, "translation", "LINEAR", &[0.0, 1.0], &[5.0, 0.0, 0.0, 5.0, 8.0, 0.0]);
    let town = glb.load().expect("loads");
    assert_eq!((town.instances.len(), town.notes.skipped_movers), (1, 1));
    let mut scene = keep(&glb);
    assert!(scene.notes.warnings[0].contains("1 animated nodes have a matrix"), "{:?}", scene.notes.warnings);
    for (seconds, height) in [(0.0, 0.0), (0.5, 4.0), (1.0, 8.0)] {
        scene.pose(seconds);
        let at = |p| scene.instances[1].to_world(p);
        assert!(near(at([0.0; 3]), [5.0, height, 0.0]));
        assert!(
            near(at([1.0, 0.0, 0.0]), [5.0, height, 2.0])
                && near(at([0.0, 1.0, 0.0]), [5.0, height + 2.0, 0.0])
        );
        assert!(near(at([0.0, 0.0, 1.0]), [7.0, height, 0.0]));
    }
    // Keys without motion do not replace the node's matrix.
    let mut still = Glb::triangle();
    still.json["nodes"][0] = json!({"mesh": 0, "matrix": [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]});
    animate(&mut still, 0, "translation", "LINEAR", &[0.0, 1.0], &[0.0; 6]);
    let scene = keep(&still);
    assert!(scene.movers.is_empty() && near(scene.instances[0].to_world([0.0, 1.0, 0.0]), [0.5, 1.0, 0.0]));
}

#[test]
fn removing_movers_removes_their_meshes() {
    let mut glb = tower();
    let positions = glb.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
    let mesh = glb.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}}]}));
    glb.json["nodes"][4]["mesh"] = json!(mesh);
    assert_eq!(keep(&glb).meshes.len(), 2);
    let mut scene = glb.load().expect("loads");
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 1));
    assert_eq!(scene.remove_movers(), 0);
}

#[test]
fn take_movers_keeps_their_poses() {
    let mut scene = keep(&tower());
    scene.add_ball(0.5, [1.0; 4], &[(0.0, [0.0; 3]), (4.0, [8.0, 0.0, 0.0])]);
    let mut whole = scene.clone();
    let mut moving = scene.take_movers();
    assert_eq!((scene.instances.len(), scene.meshes.len(), scene.movers.len()), (1, 1, 0));
    assert_eq!((moving.instances.len(), moving.meshes.len(), moving.movers.len()), (2, 2, 2));
    for seconds in [0.5, 2.5] {
        whole.pose(seconds);
        moving.pose(seconds);
        for (a, b) in whole.instances[1..].iter().zip(&moving.instances) {
            assert_eq!((&a.name, a.world_from_mesh), (&b.name, b.world_from_mesh));
            assert_eq!(whole.meshes[a.mesh as usize].name, moving.meshes[b.mesh as usize].name);
        }
    }
}

#[test]
fn ball_moves_along_its_path_and_can_be_removed() {
    let mut scene = generate(GeneratedKind::Primitives, 1);
    let (instances, meshes) = (scene.instances.len(), scene.meshes.len());
    let path = [(0.0, [0.0, 9.0, 0.0]), (2.0, [4.0, 9.0, 0.0]), (3.0, [4.0, 9.0, 8.0])];
    let ball = scene.add_ball(0.5, [1.0; 4], &path).expect("a path");
    assert!(scene.movers.contains(ball) && scene.movers.end_seconds() == 3.0);
    scene.pose(2.5);
    let placed = &scene.instances[ball as usize];
    assert_eq!(placed.to_world([0.0; 3]), [4.0, 9.0, 4.0]);
    let mesh = &scene.meshes[placed.mesh as usize];
    for p in &mesh.positions {
        let q = placed.to_world(*p);
        let radius = ((q[0] - 4.0).powi(2) + (q[1] - 9.0).powi(2) + (q[2] - 4.0).powi(2)).sqrt();
        assert!((radius - 0.5).abs() < 1e-6);
    }
    assert_eq!(scene.add_ball(0.5, [1.0; 4], &[]), None);
    assert_eq!(scene.add_ball(0.5, [1.0; 4], &[(1.0, [0.0; 3]), (0.0, [0.0; 3])]), None);
    assert_eq!(scene.remove_movers(), 1);
    assert_eq!((scene.instances.len(), scene.meshes.len()), (instances, meshes));
}
