//! Morph targets of glTF files at their default weights (glTF 2.0, 3.7.2.2).

use adumbra_scene::{Error, Scene};
use serde_json::{Value, json};

use crate::kit::{Glb, USHORT, refused, world_triangles};

/// Moves the first vertex up by 1.
const UP: [f32; 9] = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
/// Moves all vertices aside by 2.
const ASIDE: [f32; 9] = [2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0];

/// A triangle with the targets `UP` and `ASIDE`. `mesh` and `node` are their weights.
fn morphed(mesh: &Value, node: &Value) -> Glb {
    let mut glb = Glb::triangle();
    let targets = [UP, ASIDE].map(|target| glb.floats(&target, "VEC3"));
    glb.json["meshes"][0]["primitives"][0]["targets"] = json!(targets.map(|t| json!({"POSITION": t})));
    glb.json["meshes"][0]["weights"] = mesh.clone();
    glb.json["nodes"][0]["weights"] = node.clone();
    glb
}

/// The triangle, moved by these weights of the two targets.
fn moved(up: f64, aside: f64) -> [[f64; 3]; 3] {
    [[2.0 * aside, up, 0.0], [1.0 + 2.0 * aside, 0.0, 0.0], [2.0 * aside, 0.0, 1.0]]
}

fn omissions(scene: &Scene) -> Vec<String> {
    scene.notes.omissions.iter().map(ToString::to_string).collect()
}

#[test]
fn gltf_morph_weights_come_from_the_node_or_else_the_mesh() {
    for (mesh, node, up, aside) in [
        (json!(null), json!(null), 0.0, 0.0),
        (json!([1, 0]), json!(null), 1.0, 0.0),
        (json!([0, 1]), json!(null), 0.0, 1.0),
        (json!([0.5, 0.25]), json!(null), 0.5, 0.25),
        (json!([-1, 2]), json!(null), -1.0, 2.0),
        (json!([1, 1]), json!([0, 0]), 0.0, 0.0),
        (json!([1, 1]), json!([0, 3]), 0.0, 3.0),
        (json!(null), json!([2, 1]), 2.0, 1.0),
        // The list of weights is too short or too long.
        (json!([1]), json!(null), 1.0, 0.0),
        (json!([1, 1, 7, 7]), json!(null), 1.0, 1.0),
        (json!([]), json!(null), 0.0, 0.0),
    ] {
        let scene = morphed(&mesh, &node).load().unwrap_or_else(|error| panic!("{mesh} {node}: {error}"));
        assert_eq!(world_triangles(&scene), [moved(up, aside)], "{mesh} {node}");
        assert!(scene.notes.warnings.is_empty() && scene.notes.omissions.is_empty(), "{mesh} {node}");
    }
}

#[test]
fn gltf_morphed_bounds_are_those_of_the_moved_vertices() {
    let bounds = morphed(&json!([5, 10]), &json!(null)).load().expect("loads").bounds();
    assert_eq!((bounds.min, bounds.max), ([20.0, 0.0, 0.0], [21.0, 5.0, 1.0]));
}

#[test]
fn gltf_nodes_with_different_weights_get_separate_meshes() {
    let mut glb = morphed(&json!([1, 0]), &json!(null));
    glb.json["nodes"] = json!([
        {"mesh": 0}, {"mesh": 0, "weights": [0, 1]}, {"mesh": 0, "weights": [0, 1, 5]}, {"mesh": 0, "weights": [1]},
        {"mesh": 0, "weights": [0, 0]},
    ]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4]);
    let scene = glb.load().expect("loads");
    let expected = [moved(1.0, 0.0), moved(0.0, 1.0), moved(0.0, 1.0), moved(1.0, 0.0), moved(0.0, 0.0)];
    assert_eq!(world_triangles(&scene), expected);
    // Equal weights share a mesh.
    assert_eq!((scene.meshes.len(), scene.notes.read.faces), (3, 1));
}

#[test]
fn gltf_morph_targets_may_be_sparse_or_quantized() {
    // A sparse accessor without base data.
    let mut glb = morphed(&json!([1, 0]), &json!(null));
    let (at, to) =
        (glb.view(&2_u16.to_le_bytes()), glb.view(&[0.0_f32, 4.0, 0.0].map(f32::to_le_bytes).concat()));
    let target = glb.push(
        "accessors",
        json!({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": {"count": 1,
            "indices": {"bufferView": at, "componentType": USHORT}, "values": {"bufferView": to}}}),
    );
    glb.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(target);
    let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 4.0, 1.0]];
    assert_eq!(world_triangles(&glb.load().expect("loads")), [triangle]);

    // Bytes, normalized and not.
    for (normalized, up) in [(true, 1.0), (false, 127.0)] {
        let mut glb = morphed(&json!([1, 0]), &json!(null));
        let target = glb.accessor(&[0, 127, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], 5120, "VEC3", 3);
        glb.json["accessors"][target]["normalized"] = json!(normalized);
        let view = glb.json["accessors"][target]["bufferView"].as_u64().expect("a view") as usize;
        glb.json["bufferViews"][view]["byteStride"] = json!(4);
        glb.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        glb.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(target);
        assert_eq!(world_triangles(&glb.load().expect("loads")), [moved(up, 0.0)], "{normalized}");
    }
}

#[test]
fn gltf_morph_targets_act_before_the_skin() {
    let mut glb = morphed(&json!([1, 0]), &json!(null));
    let joints = glb.accessor(&[0; 12], 5121, "VEC4", 3);
    let weights = glb.floats(&[1.0, 0.0, 0.0, 0.0].repeat(3), "VEC4");
    let attributes = &mut glb.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    // The joint doubles and moves.
    glb.json["nodes"] = json!([
        {"mesh": 0, "skin": 0}, {"translation": [0, 0, 5], "scale": [2, 2, 2]}, {"mesh": 0, "skin": 0, "weights": [0, 1]},
    ]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    glb.push("skins", json!({"joints": [1]}));
    let triangles = world_triangles(&glb.load().expect("loads"));
    assert_eq!(triangles[0], [[0.0, 2.0, 5.0], [2.0, 0.0, 5.0], [0.0, 0.0, 7.0]]);
    assert_eq!(triangles[1], [[4.0, 0.0, 5.0], [6.0, 0.0, 5.0], [4.0, 0.0, 7.0]]);
}

#[test]
fn gltf_primitives_share_vertices_only_with_the_same_targets() {
    let mut glb = morphed(&json!([1, 0]), &json!(null));
    let mut second = glb.json["meshes"][0]["primitives"][0].clone();
    let first = second.clone();
    second["targets"].as_array_mut().expect("a list").swap(0, 1);
    let plain = json!({"attributes": {"POSITION": 0}});
    glb.json["meshes"][0]["primitives"] = json!([first, second, plain, first]);
    let scene = glb.load().expect("loads");
    assert_eq!(world_triangles(&scene), [moved(1.0, 0.0), moved(0.0, 1.0), moved(0.0, 0.0), moved(1.0, 0.0)]);
    assert_eq!(scene.meshes[0].positions.len(), 9);
}

#[test]
fn gltf_mismatched_morph_targets_are_errors_if_weighted() {
    let changes: [(&str, Value); 4] =
        [("count", json!(2)), ("type", json!("VEC2")), ("bufferView", json!(99)), ("count", json!("all"))];
    for (key, value) in changes {
        let mut glb = morphed(&json!([1, 0]), &json!(null));
        glb.json["accessors"][1][key] = value.clone();
        glb.json["meshes"][0]["name"] = json!("cloth");
        let error = refused(glb.load());
        let message = error.to_string();
        assert!(matches!(error, Error::SceneParse { .. }), "{message}");
        if key != "bufferView" && value != json!("all") {
            assert!(
                message.contains("in mesh \"cloth\" a morph target does not have a displacement"),
                "{message}"
            );
        }
        // With a weight of 0, the target has no effect.
        glb.json["meshes"][0]["weights"] = json!([0, 1]);
        assert_eq!(world_triangles(&glb.load().expect("loads")), [moved(0.0, 1.0)], "{key} {value}");
    }
    // A target without positions moves nothing.
    let mut glb = morphed(&json!([1, 1]), &json!(null));
    glb.json["meshes"][0]["primitives"][0]["targets"][0] = json!({"NORMAL": 77});
    assert_eq!(world_triangles(&glb.load().expect("loads")), [moved(0.0, 1.0)]);
    // Infinite displacements name the vertex.
    let mut glb = morphed(&json!([3e38, 0]), &json!(null));
    let far = glb.floats(&UP.map(|c| c * 1e30), "VEC3");
    glb.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(far);
    assert!(matches!(refused(glb.load()), Error::NotFinite { what, .. } if what.contains("vertex 0")));
}

#[test]
fn gltf_morph_targets_of_uvs_and_colours_are_omissions() {
    let what = "morph targets of texture coordinates or colours";
    for (targets, count) in [
        (json!([{"POSITION": 1, "NORMAL": 1, "TANGENT": 1}]), 0),
        (json!([{"POSITION": 1, "TEXCOORD_0": 1}]), 1),
        (json!([{"COLOR_0": 1}, {"TEXCOORD_1": 1}, {"POSITION": 1}]), 2),
        (json!([{"COLOR_1": 1, "TEXCOORD_2": 1}]), 1),
        (json!([{"_CUSTOM": 1}]), 0),
        (json!([]), 0),
        (json!(null), 0),
    ] {
        let mut glb = morphed(&json!([1]), &json!(null));
        glb.json["meshes"][0]["primitives"][0]["targets"] = targets.clone();
        let scene = glb.load().unwrap_or_else(|error| panic!("{targets}: {error}"));
        let expected = if count > 0 { vec![format!("{count} {what}")] } else { Vec::new() };
        assert_eq!(omissions(&scene), expected, "{targets}");
    }
}
