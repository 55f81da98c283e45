//! Which parts of a glTF file are drawn: its default scene (glTF 2.0, 3.5.1), levels of detail (MSFT_lod),
//! instances (EXT_mesh_gpu_instancing), suns (KHR_lights_punctual), and which parts are counted as left out.

use adumbra_scene::{EmptyReason, Error, LoadOptions, Scene};
use serde_json::{Value, json};

use crate::kit::{Glb, refused, world_triangles};

/// A triangle with these nodes and scenes.
fn with_nodes(nodes: Value, scene: &Value, scenes: &Value) -> Glb {
    let mut glb = Glb::triangle();
    glb.json["nodes"] = nodes;
    glb.json["scene"] = scene.clone();
    glb.json["scenes"] = scenes.clone();
    glb
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.instances.iter().map(|i| i.name.as_str()).collect()
}

fn omissions(scene: &Scene) -> Vec<String> {
    scene.notes.omissions.iter().map(ToString::to_string).collect()
}

const OUTSIDE: &str = "nodes with meshes outside the default scene";

#[test]
fn gltf_default_scene_is_the_named_one_or_the_first_or_all_nodes() {
    let nodes = || json!([{"mesh": 0, "children": [1]}, {"mesh": 0}, {"mesh": 0}]);
    let two = json!([{"nodes": [2]}, {"nodes": [0]}]);
    for (scene, scenes, drawn, outside) in [
        (json!(0), &two, vec!["node 2"], 2),
        (json!(1), &two, vec!["node 0", "node 1"], 1),
        (json!(1.0), &two, vec!["node 0", "node 1"], 1),
        (json!(null), &two, vec!["node 2"], 2),
        (json!(null), &json!([]), vec!["node 0", "node 1", "node 2"], 0),
        (json!(null), &json!(null), vec!["node 0", "node 1", "node 2"], 0),
        (json!(0), &json!([{"nodes": [2, 1, 0]}]), vec!["node 2", "node 1", "node 0"], 0),
        (json!(0), &json!([{"nodes": [1, 1, 1]}]), vec!["node 1"], 2),
    ] {
        let read = with_nodes(nodes(), &scene, scenes).load();
        let read = read.unwrap_or_else(|error| panic!("{scene} {scenes}: {error}"));
        assert_eq!(names(&read), drawn, "{scene} {scenes}");
        let expected = if outside > 0 { vec![format!("{outside} {OUTSIDE}")] } else { Vec::new() };
        assert_eq!(omissions(&read), expected, "{scene} {scenes}");
        let read = read.notes.read;
        assert_eq!((read.meshes, read.nodes, read.faces), (1, 3, 1));
    }
}

#[test]
fn gltf_default_scene_without_nodes_is_an_empty_scene_error() {
    for scenes in [json!([{}]), json!([{"nodes": []}]), json!([{"name": "empty"}]), json!([{"nodes": null}])]
    {
        let error = refused(with_nodes(json!([{"mesh": 0}]), &json!(0), &scenes).load());
        assert!(
            matches!(error, Error::NoTriangles { reason: EmptyReason::EmptyScene, .. }),
            "{scenes}: {error}"
        );
        assert!(error.to_string().contains("its default scene has no nodes"), "{error}");
        // Another scene may be empty.
        let both = json!([{"nodes": [0]}, scenes[0]]);
        let scene = with_nodes(json!([{"mesh": 0}]), &json!(0), &both).load().expect("loads");
        assert_eq!(names(&scene), ["node 0"]);
    }
    let error = refused(with_nodes(json!([{"mesh": 0}]), &json!(1), &json!([{"nodes": [0]}])).load());
    assert!(error.to_string().contains("its default scene 1 does not exist"), "{error}");
    let error = refused(with_nodes(json!([{"mesh": 0}]), &json!(0), &json!([])).load());
    assert!(error.to_string().contains("its default scene 0 does not exist"), "{error}");
}

fn lod(ids: &[usize]) -> Value {
    json!({"MSFT_lod": {"ids": ids}})
}

#[test]
fn gltf_only_the_finest_level_of_detail_is_drawn() {
    let flat = || json!([{"mesh": 0, "extensions": lod(&[1, 2])}, {"mesh": 0}, {"mesh": 0}]);
    // The coarser levels are in no scene or in the scene as well, or the file has no scenes.
    for scenes in
        [json!([{"nodes": [0]}]), json!([{"nodes": [0, 1, 2]}]), json!([{"nodes": [2, 1, 0]}]), json!(null)]
    {
        let scene = with_nodes(flat(), &json!(null), &scenes).load().expect("loads");
        assert_eq!((names(&scene), omissions(&scene)), (vec!["node 0"], vec![]), "{scenes}");
    }
    // Levels that are nodes with children, in another order, and levels within levels.
    let nested = || {
        json!([
            {"children": [5], "extensions": lod(&[1])},
            {"children": [2]},
            {"mesh": 0, "extensions": lod(&[3])},
            {"mesh": 0},
            {"mesh": 0},
            {"mesh": 0, "extensions": lod(&[4])},
        ])
    };
    for scenes in [json!([{"nodes": [0]}]), json!([{"nodes": [0, 1, 3, 4]}]), json!(null)] {
        let scene = with_nodes(nested(), &json!(null), &scenes).load().expect("loads");
        assert_eq!((names(&scene), omissions(&scene)), (vec!["node 5"], vec![]), "{scenes}");
    }
    // Skip indices of nodes that do not exist, and values that are not lists.
    for ids in [json!([77]), json!([-1, "a"]), json!(7), json!(null)] {
        let nodes = json!([{"mesh": 0, "extensions": {"MSFT_lod": {"ids": ids}}}]);
        let scene = with_nodes(nodes, &json!(0), &json!([{"nodes": [0]}])).load().expect("loads");
        assert_eq!(names(&scene), ["node 0"], "{ids}");
    }
}

#[test]
fn gltf_hidden_nodes_are_not_omissions() {
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    let nodes = json!([{"mesh": 0}, {"mesh": 0, "extensions": hidden, "children": [2]}, {"mesh": 0}]);
    let scene = with_nodes(nodes, &json!(0), &json!([{"nodes": [0, 1]}])).load().expect("loads");
    assert_eq!((names(&scene), omissions(&scene)), (vec!["node 0"], vec![]));
}

#[test]
fn gltf_custom_attributes_determine_the_instance_count() {
    let instanced = |attributes: &dyn Fn(&mut Glb) -> Value| {
        let mut glb = Glb::triangle();
        let attributes = attributes(&mut glb);
        glb.json["nodes"][0] = json!({"mesh": 0, "translation": [0, 3, 0],
            "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}});
        glb
    };
    // Only custom attributes of the application.
    let custom = instanced(&|glb| json!({"_ID": glb.floats(&[7.0, 8.0, 9.0, 10.0], "SCALAR")}));
    let scene = custom.load().expect("loads");
    assert_eq!(scene.instances.len(), 4);
    assert!(world_triangles(&scene).iter().all(|t| t[0] == [0.0, 3.0, 0.0]));
    let both = instanced(&|glb| {
        json!({"_ID": glb.floats(&[7.0, 8.0], "SCALAR"), "TRANSLATION": glb.floats(&[0.0, 1.0, 0.0, 5.0, 0.0, 0.0], "VEC3"),
            "SCALE": glb.floats(&[2.0, 2.0, 2.0, 1.0, 1.0, 1.0], "VEC3")})
    });
    let triangles = world_triangles(&both.load().expect("loads"));
    assert_eq!(triangles[0], [[0.0, 4.0, 0.0], [2.0, 4.0, 0.0], [0.0, 4.0, 2.0]]);
    assert_eq!(triangles[1][0], [5.0, 3.0, 0.0]);
    let unequal = instanced(
        &|glb| json!({"_ID": glb.floats(&[7.0, 8.0, 9.0], "SCALAR"), "TRANSLATION": glb.floats(&[0.0; 6], "VEC3")}),
    );
    assert!(
        refused(unequal.load())
            .to_string()
            .contains("the instances of node 0 have attributes of different lengths")
    );
    let missing = instanced(&|_| json!({"_ID": 55}));
    assert!(refused(missing.load()).to_string().contains("accessor 55 does not exist"));
    let word = instanced(&|_| json!({"_ID": "first"}));
    assert!(refused(word.load()).to_string().contains("an accessor index that is not a number"));
}

const LIGHT: &str = "KHR_lights_punctual";

/// A file with these lights, and its triangle at the last node.
fn lit(lights: Value, mut nodes: Vec<Value>, roots: &Value) -> Glb {
    nodes.push(json!({"mesh": 0}));
    let mut glb = Glb::triangle();
    let mut starts = roots.as_array().expect("a list").clone();
    starts.push(json!(nodes.len() - 1));
    glb.json["nodes"] = json!(nodes);
    glb.json["scenes"] = json!([{"nodes": starts}]);
    glb.json["extensions"][LIGHT]["lights"] = lights;
    glb.json["extensionsUsed"] = json!([LIGHT]);
    glb
}

fn shining(light: usize, mut node: Value) -> Value {
    node["extensions"] = json!({LIGHT: {"light": light}});
    node
}

fn sun() -> Value {
    json!([{"type": "directional", "intensity": 1000}])
}

#[test]
fn gltf_sun_direction_follows_the_node_transform() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // A quarter turn about x rotates +z, opposite to the light's direction, to -y; the opposite turn rotates
    // it to +y.
    let down = json!({"rotation": [-half, 0, 0, half]});
    let matrix = json!({"matrix": [1,0,0,0, 0,0,-1,0, 0,1,0,0, 5,6,7,1]});
    for (node, towards) in [
        (json!({}), [0.0, 0.0, 1.0]),
        (json!({"translation": [5, 6, 7]}), [0.0, 0.0, 1.0]),
        (json!({"scale": [3, 4, 5]}), [0.0, 0.0, 1.0]),
        (json!({"scale": [-1, 1, 1]}), [0.0, 0.0, 1.0]),
        (json!({"scale": [1, 1, -2]}), [0.0, 0.0, -1.0]),
        (down, [0.0, 1.0, 0.0]),
        (matrix, [0.0, 1.0, 0.0]),
        (json!({"rotation": [0, half, 0, half]}), [1.0, 0.0, 0.0]),
    ] {
        let scene = lit(sun(), vec![shining(0, node.clone())], &json!([0])).load().expect("loads");
        let found = scene.suns[0].unit_towards();
        assert!((0..3).all(|a| (found[a] - towards[a]).abs() < 1e-9), "{node}: {found:?}");
        assert_eq!((scene.suns.len(), scene.suns[0].name.as_str()), (1, "node 0"));
        // A node below a parent that rotates, stretches and mirrors.
        let parent = json!({"children": [1], "rotation": [0, half, 0, half], "scale": [2, 3, -5]});
        let scene = lit(sun(), vec![parent, shining(0, node.clone())], &json!([0])).load().expect("loads");
        let [x, y, z] = [2.0 * towards[0], 3.0 * towards[1], -5.0 * towards[2]];
        let length = (x * x + y * y + z * z).sqrt();
        let (found, turned) = (scene.suns[0].unit_towards(), [z, y, -x].map(|c| c / length));
        assert!((0..3).all(|a| (found[a] - turned[a]).abs() < 1e-6), "{node}: {found:?} {turned:?}");
    }
    let scene = lit(sun(), vec![shining(0, json!({"scale": [0, 0, 0]}))], &json!([0])).load().expect("loads");
    assert!(scene.suns.is_empty());
}

#[test]
fn gltf_dark_or_point_lights_are_not_suns() {
    let lights = json!([
        {"type": "directional", "name": "moon", "intensity": 0},
        {"type": "directional", "intensity": 5, "color": [0, 0, 0]},
        {"type": "directional", "intensity": -1.5},
        {"type": "point", "intensity": 100},
        {"type": "directional", "intensity": 0.01, "color": [0, 0, 0.2]},
        {"type": "directional"},
        {"type": "directional", "intensity": "bright", "color": null},
    ]);
    let named = |light: usize| shining(light, json!({"name": light.to_string()}));
    let scene =
        lit(lights, (0..7).map(named).collect(), &json!([0, 1, 2, 3, 4, 5, 6])).load().expect("loads");
    let suns: Vec<&str> = scene.suns.iter().map(|sun| sun.name.as_str()).collect();
    assert_eq!(suns, ["4", "5", "6"]);
}

#[test]
fn gltf_suns_are_in_the_order_of_the_nodes_depth_first() {
    let named = |name: &str, children: &[usize]| shining(0, json!({"name": name, "children": children}));
    let nodes =
        vec![named("d", &[]), named("a", &[3, 2]), named("c", &[]), named("b", &[]), json!({"name": "e"})];
    let scene = lit(sun(), nodes, &json!([1, 4, 0])).load().expect("loads");
    let order: Vec<&str> = scene.suns.iter().map(|sun| sun.name.as_str()).collect();
    assert_eq!(order, ["a", "b", "c", "d"]);
}

#[test]
fn gltf_hidden_unreached_or_invalid_lights_are_not_suns() {
    let hidden = json!({"KHR_node_visibility": {"visible": false}, LIGHT: {"light": 0}});
    let point = json!([{"type": "point"}, {"type": "spot"}, {"type": "directional"}, {}, 5, {"type": 3}]);
    for (lights, nodes, suns) in [
        (sun(), vec![json!({"extensions": hidden})], 0),
        (
            sun(),
            vec![
                json!({"children": [1], "extensions": {"KHR_node_visibility": {"visible": false}}}),
                shining(0, json!({})),
            ],
            0,
        ),
        (point.clone(), (0..7).map(|i| shining(i, json!({}))).collect(), 1),
        (json!(null), vec![shining(0, json!({}))], 0),
        (json!(5), vec![shining(0, json!({}))], 0),
        (sun(), vec![json!({"extensions": {LIGHT: {"light": "sun"}}})], 0),
        (sun(), vec![json!({"extensions": {LIGHT: 0}})], 0),
        (sun(), vec![json!({"extensions": {LIGHT: {"light": 0.0}}})], 1),
    ] {
        let roots: Vec<usize> =
            (0..nodes.len().min(7)).filter(|&i| i == 0 || nodes[0].get("children").is_none()).collect();
        let scene = lit(lights.clone(), nodes.clone(), &json!(roots)).load();
        let scene = scene.unwrap_or_else(|error| panic!("{lights} {nodes:?}: {error}"));
        assert_eq!(scene.suns.len(), suns, "{lights} {nodes:?}");
    }
    // A light that the default scene does not reach, and one at a coarser level of detail.
    let scene = lit(sun(), vec![shining(0, json!({}))], &json!([])).load().expect("loads");
    assert!(scene.suns.is_empty());
    let nodes = vec![json!({"extensions": lod(&[1])}), shining(0, json!({}))];
    assert!(lit(sun(), nodes, &json!([0, 1])).load().expect("loads").suns.is_empty());
    // Lights do not count as left out.
    let scene = lit(point, vec![shining(0, json!({}))], &json!([0])).load().expect("loads");
    assert!(omissions(&scene).is_empty());
}

#[test]
fn gltf_unknown_extensions_are_counted_by_name() {
    let mut glb = Glb::triangle();
    glb.json["extensionsUsed"] =
        json!(["EXT_used", "EXT_listed_only", "KHR_materials_ior", "KHR_materials_new"]);
    glb.json["nodes"][0]["extensions"] = json!({"EXT_used": {}});
    glb.json["meshes"][0]["extensions"] = json!({"EXT_used": {"a": [1, 2]}});
    glb.json["materials"] =
        json!([{"extensions": {"KHR_materials_ior": {"ior": 1.3}, "KHR_materials_new": {}}}]);
    let scene = glb.load().expect("loads");
    let used = "2 uses of the extension EXT_used, which is not understood";
    assert_eq!(omissions(&scene), [used]);

    let error =
        glb.load_with(&LoadOptions { strict: true, ..LoadOptions::default() }).expect_err("is strict");
    assert!(matches!(&error, Error::Omitted { omissions, .. } if omissions.len() == 1));
    assert!(error.to_string().contains(used), "{error}");

    glb.json["extensionsRequired"] = json!(["KHR_materials_new", "EXT_used"]);
    let error = refused(glb.load());
    assert!(matches!(error, Error::RequiredExtension { extension, .. } if extension == "EXT_used"));
}

#[test]
fn gltf_strict_error_lists_all_omissions() {
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    Glb::triangle().load_with(&strict).expect("nothing is left out");
    let mut glb = with_nodes(json!([{"mesh": 0}, {"mesh": 0}]), &json!(0), &json!([{"nodes": [0]}]));
    glb.json["meshes"][0]["primitives"]
        .as_array_mut()
        .expect("a list")
        .extend([json!({"attributes": {"POSITION": 0}, "mode": 1}), json!({"attributes": {"NORMAL": 0}})]);
    glb.push("animations", json!({}));
    let message = glb.load_with(&strict).expect_err("is strict").to_string();
    for part in [
        "1 nodes with meshes outside the default scene",
        "2 primitives of lines, of points or without positions",
        "1 animations that cannot be read",
        "load it without strict",
    ] {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert_eq!(omissions(&glb.load().expect("loads")).len(), 3);
}

#[test]
fn gltf_counts_meshes_nodes_and_faces_of_the_file() {
    let mut glb = with_nodes(
        json!([{"mesh": 0}, {"mesh": 0}, {"mesh": 1}, {}]),
        &json!(0),
        &json!([{"nodes": [0, 1, 2, 3]}]),
    );
    let square =
        glb.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0], "VEC3");
    let indices = glb.indices(&[0, 1, 2, 0, 0, 0]);
    glb.push(
        "meshes",
        json!({"primitives": [
            {"attributes": {"POSITION": square}, "mode": 5}, {"attributes": {"POSITION": square}, "mode": 6},
            {"attributes": {"POSITION": square}, "indices": indices},
        ]}),
    );
    glb.push("meshes", json!({"primitives": []}));
    let scene = glb.load().expect("loads");
    let read = scene.notes.read;
    // Two nodes place the triangle. The other mesh has a strip and a fan of three triangles each, and two
    // triangles, one of them degenerate to a point.
    assert_eq!((read.meshes, read.nodes, read.faces), (3, 4, 1 + 3 + 3 + 2));
    assert_eq!(scene.stored_triangles() + scene.notes.degenerate_triangles, read.faces);
}
