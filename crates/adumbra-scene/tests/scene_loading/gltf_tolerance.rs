//! glTF files that violate the specification where a bake does not look, or in ways that are common in
//! practice: whole numbers written `4.0`, names that are not strings, and elements that cannot be read. An
//! element that is used must be valid.

use adumbra_scene::{AlphaMode, Error, LoadOptions, MoverPolicy, Scene, Wrap};
use serde_json::{Value, json};

use crate::kit::{Glb, USHORT, png, refused, world_triangles};

/// Writes every whole number as `4.0`.
fn with_points(value: &mut Value) {
    match value {
        Value::Number(number) => {
            *number = serde_json::Number::from_f64(number.as_f64().expect("fits")).expect("finite");
        }
        Value::Array(list) => list.iter_mut().for_each(with_points),
        Value::Object(members) => members.values_mut().for_each(with_points),
        _ => {}
    }
}

/// A file with every kind of number that a bake reads.
fn numbers() -> Glb {
    let mut glb = Glb::triangle();
    let uvs = glb.floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0], "VEC2");
    let indices = glb.indices(&[0, 1, 2]);
    let delta = glb.floats(&[0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], "VEC3");
    let (at, to) =
        (glb.view(&1_u16.to_le_bytes()), glb.view(&[3.0_f32, 0.0, 0.0].map(f32::to_le_bytes).concat()));
    glb.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": at, "byteOffset": 0, "componentType": USHORT},
        "values": {"bufferView": to, "byteOffset": 0}});
    glb.json["accessors"][0]["byteOffset"] = json!(0);
    let view = glb.view(&png(&[0, 255]));
    glb.json["images"] = json!([{"bufferView": view}]);
    glb.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9987}]);
    glb.json["textures"] = json!([{"source": 0, "sampler": 0}, {"sampler": 0, "extensions": {"EXT_texture_webp": {"source": 0}}}]);
    let glossy = json!({"diffuseFactor": [1, 1, 1, 1], "diffuseTexture": {"index": 1, "texCoord": 1}});
    glb.json["materials"] = json!([
        {"alphaMode": "MASK", "alphaCutoff": 1, "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1],
            "baseColorTexture": {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": {"texCoord": 1}}}}},
        {"alphaMode": "MASK", "extensions": {"KHR_materials_pbrSpecularGlossiness": glossy}},
    ]);
    let primitive = |material: usize| {
        json!({"attributes": {"POSITION": 0, "TEXCOORD_1": uvs}, "indices": indices, "mode": 5,
            "material": material, "targets": [{"POSITION": delta}]})
    };
    glb.json["meshes"] = json!([{"primitives": [primitive(0), primitive(1)], "weights": [1]}]);
    let moves = glb.floats(&[0.0, 9.0, 0.0, 0.0, 8.0, 0.0], "VEC3");
    let times = glb.floats(&[0.0, 1.0], "SCALAR");
    glb.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2], "weights": [2], "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]},
        {"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 7,0,0,1],
            "extensions": {"MSFT_lod": {"ids": [3]}, "KHR_lights_punctual": {"light": 0}}},
        {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moves}}}},
        {"mesh": 0},
        {"mesh": 0, "skin": 0},
        {"mesh": 0},
    ]);
    glb.json["skins"] = json!([{"joints": [0]}]);
    glb.json["scenes"] = json!([{"nodes": []}, {"nodes": [0, 3, 4, 5]}]);
    glb.json["scene"] = json!(1);
    glb.json["extensions"]["KHR_lights_punctual"]["lights"] =
        json!([{"type": "directional", "intensity": 3}]);
    glb.json["animations"] = json!([{"samplers": [{"input": times, "output": moves}],
        "channels": [{"sampler": 0, "target": {"node": 5, "path": "translation"}}]}]);
    glb
}

fn summary(scene: &Scene) -> String {
    format!(
        "{:?} {:?} {:?} {:?} {:?}",
        scene.meshes, scene.instances, scene.materials, scene.suns, scene.notes
    )
}

#[test]
fn gltf_accepts_whole_numbers_written_as_floats() {
    let plain = numbers();
    let scene = plain.load().expect("loads");
    assert_eq!((scene.instances.len(), scene.suns.len(), scene.notes.skipped_movers), (5, 1, 1));
    assert_eq!(scene.textures.len(), 1);
    assert_eq!(scene.textures[0].wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert!(scene.materials[..2].iter().all(|m| m.texture == Some(0) && m.alpha != AlphaMode::Opaque));
    // Moved by the node's own weights, or by those of the mesh.
    let first: Vec<f64> = world_triangles(&scene).iter().map(|t| t[0][1]).collect();
    assert!(first.contains(&6.0) && first.contains(&4.0), "{first:?}");
    let mut pointed = plain;
    with_points(&mut pointed.json);
    assert!(pointed.json.to_string().contains("\"componentType\":5126.0"));
    assert_eq!(summary(&pointed.load().expect("loads")), summary(&scene));
}

#[test]
fn gltf_rejects_fractions_where_an_integer_is_needed() {
    for pointer in [
        "/accessors/0/count",
        "/accessors/0/componentType",
        "/meshes/0/primitives/0/mode",
        "/meshes/0/primitives/0/indices",
        "/bufferViews/0/byteLength",
        "/nodes/0/mesh",
        "/scenes/0/nodes/0",
        "/scene",
    ] {
        for value in [json!(0.5), json!(-1), json!("0"), json!(1e300)] {
            let mut glb = Glb::triangle();
            let indices = glb.indices(&[0, 1, 2]);
            glb.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
            glb.json["meshes"][0]["primitives"][0]["mode"] = json!(4);
            *glb.json.pointer_mut(pointer).expect("is there") = value.clone();
            let error = refused(glb.load());
            assert!(matches!(error, Error::SceneParse { .. }), "{pointer} {value}: {error}");
        }
    }
}

#[test]
fn gltf_ignores_names_that_are_not_strings() {
    for name in [json!(7), json!(null), json!(["a"]), json!({"a": 1}), json!(true)] {
        let mut glb = numbers();
        for list in glb.json.as_object_mut().expect("an object").values_mut() {
            for element in list.as_array_mut().into_iter().flatten() {
                if let Value::Object(members) = element {
                    members.insert("name".to_owned(), name.clone());
                }
            }
        }
        let scene = glb.load().unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(summary(&scene), summary(&numbers().load().expect("loads")), "{name}");
        assert_eq!((scene.instances[0].name.as_str(), scene.meshes[0].name.as_str()), ("node 0", "mesh 0"));
    }
}

#[test]
fn gltf_text_that_is_not_gltf_json_is_a_parse_error() {
    for text in ["", " ", "{", "[]", "5", "{\"asset\": }", "null", "{\"nodes\": {}}x", "\u{feff}\u{feff}{}"] {
        let error =
            crate::kit::load_bytes("scene.gltf", text.as_bytes(), &LoadOptions::default()).expect_err(text);
        assert!(matches!(error, Error::SceneParse { .. }), "{text:?}: {error}");
    }
    for list in ["nodes", "meshes", "accessors", "bufferViews", "buffers", "materials", "scenes", "images"] {
        let mut glb = Glb::triangle();
        glb.json[list] = json!(5);
        let message = refused(glb.load()).to_string();
        assert!(message.contains(&format!("its {list} are not a list")), "{message}");
    }
}

/// A list of the file, the kind that messages name, a faulty element, and a use of it: a pointer and its new
/// value.
type Fault = (&'static str, &'static str, Value, Option<(&'static str, Value)>);

/// Elements that cannot be read, each with its list, its kind, and a change that uses it.
fn faults() -> Vec<Fault> {
    let texture = |index: usize| json!({"index": index});
    vec![
        (
            "accessors",
            "accessor",
            json!({"count": 3}),
            Some(("/meshes/0/primitives/0/attributes/POSITION", json!(1))),
        ),
        ("accessors", "accessor", json!(7), Some(("/meshes/0/primitives/0/indices", json!(1)))),
        ("bufferViews", "buffer view", json!({"byteLength": 4}), Some(("/accessors/0/bufferView", json!(1)))),
        ("buffers", "buffer", json!("a.bin"), Some(("/bufferViews/0/buffer", json!(1)))),
        (
            "materials",
            "material",
            json!({"alphaMode": 5}),
            Some(("/meshes/0/primitives/0/material", json!(1))),
        ),
        ("materials", "material", json!("leaf"), Some(("/meshes/0/primitives/0/material", json!(1)))),
        ("meshes", "mesh", json!({"name": "no primitives"}), Some(("/nodes/0/mesh", json!(1)))),
        ("meshes", "mesh", json!({"primitives": [{}]}), Some(("/nodes/0/mesh", json!(1)))),
        ("nodes", "node", json!({"mesh": "all"}), Some(("/scenes/0/nodes", json!([0, 1])))),
        ("nodes", "node", json!({"matrix": [1, 2]}), Some(("/nodes/0/children", json!([1])))),
        ("scenes", "scene", json!({"nodes": 5}), Some(("/scene", json!(1)))),
        ("skins", "skin", json!({}), Some(("/nodes/0/skin", json!(0)))),
        (
            "textures",
            "texture",
            json!({"source": "a"}),
            Some(("/materials/0/pbrMetallicRoughness/baseColorTexture", texture(1))),
        ),
        ("images", "image", json!({"uri": 7}), Some(("/textures/0/source", json!(1)))),
        ("samplers", "sampler", json!({"wrapS": "repeat"}), Some(("/textures/0/sampler", json!(0)))),
        ("cameras", "camera", json!({"type": "perspective", "perspective": {"yfov": 1}}), None),
        ("cameras", "camera", json!(null), None),
    ]
}

/// A masked triangle.
fn masked() -> Glb {
    let mut glb = Glb::triangle();
    let uvs = glb.floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0], "VEC2");
    let view = glb.view(&png(&[0, 255]));
    glb.json["images"] = json!([{"bufferView": view}]);
    glb.json["textures"] = json!([{"source": 0}]);
    let pbr = json!({"baseColorTexture": {"index": 0}});
    glb.json["materials"] = json!([{"name": "leaf", "alphaMode": "MASK", "pbrMetallicRoughness": pbr}]);
    glb.json["meshes"][0]["primitives"][0] =
        json!({"attributes": {"POSITION": 0, "TEXCOORD_0": uvs}, "material": 0});
    glb
}

/// Appends an element to a list, and returns its index.
fn with_fault(list: &str, element: &Value) -> (Glb, usize) {
    let mut glb = masked();
    let index = glb.push(list, element.clone());
    (glb, index)
}

#[test]
fn gltf_faulty_unused_elements_are_warnings() {
    for (list, kind, element, _) in faults() {
        let (glb, _) = with_fault(list, &element);
        let scene = glb.load().unwrap_or_else(|error| panic!("{list} {element}: {error}"));
        assert_eq!(scene.stored_triangles(), 1, "{list} {element}");
        let warnings = &scene.notes.warnings;
        if kind.is_empty() {
            assert!(warnings.is_empty(), "{warnings:?}");
        } else {
            let expected = format!("elements that cannot be read, and that nothing needs: 1 of kind {kind}");
            assert_eq!(*warnings, [expected], "{list} {element}");
        }
        assert!(scene.notes.omissions.is_empty(), "{:?}", scene.notes.omissions);
    }
}

#[test]
fn gltf_faulty_used_elements_are_errors_that_name_them() {
    for (list, kind, element, change) in faults() {
        let Some((pointer, mut value)) = change else { continue };
        let (mut glb, index) = with_fault(list, &element);
        // Use the index of the added element if the change needs an index.
        if value.is_number() {
            value = json!(index);
        }
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        glb.json.pointer_mut(parent).expect("is there")[key] = value;
        let error = refused(glb.load());
        let message = error.to_string();
        assert!(message.contains(&format!("{kind} {index} cannot be read: ")), "{list} {element}: {message}");
        assert!(!message.contains(" at line "), "{message}");
        let is_texture = ["texture", "image", "sampler"].contains(&kind);
        assert_eq!(matches!(error, Error::Texture { .. }), is_texture, "{message}");
        assert!(message.contains("leaf") || !is_texture, "{message}");
    }
}

#[test]
fn gltf_message_about_a_long_faulty_element_is_short() {
    for text in ["a".repeat(1 << 20), "ä\n".repeat(1 << 18)] {
        let mut glb = Glb::triangle();
        glb.json["nodes"][0]["mesh"] = json!(text);
        let message = refused(glb.load()).to_string();
        assert!(message.contains("node 0 cannot be read") && message.len() < 1000, "{}", message.len());
    }
}

#[test]
fn gltf_broken_json_error_has_line_and_plain_words() {
    for (text, says) in [
        ("{\"asset\":", "line 1, column 9: it ends too early"),
        ("{\n  nodes: []}", "line 2, column 3: what stands there is not JSON"),
    ] {
        let (_folder, path) = crate::kit::file("scene.gltf", text.as_bytes());
        let error = adumbra_scene::load(&path, &LoadOptions::default()).expect_err("no JSON").to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn gltf_line_breaks_in_names_are_escaped_in_messages() {
    let mut glb = masked();
    glb.json["images"][0] = json!({"name": "a\nb\u{1b}[2J"});
    let message = refused(glb.load()).to_string();
    assert!(message.contains(r"a\nb\u{1b}[2J") && !message.contains(char::is_control), "{message}");
    let mut glb = Glb::triangle();
    glb.json["extensionsRequired"] = json!(["a\nb"]);
    let message = refused(glb.load()).to_string();
    assert!(message.contains(r"a\nb") && !message.contains('\n'), "{message}");
}

#[test]
fn gltf_animations_that_cannot_be_read_are_omissions() {
    let sampler = json!({"input": 0, "output": 0});
    let channel = |node: Value, path: &str| json!({"sampler": 0, "target": {"node": node, "path": path}});
    let moves = channel(json!(0), "translation");
    let cases = [
        (json!({}), "1 animations that cannot be read"),
        (json!({"channels": [moves]}), "1 animations that cannot be read"),
        (json!({"channels": 5, "samplers": []}), "1 animations that cannot be read"),
        (json!({"channels": [moves], "samplers": []}), "1 animation channels without a sampler"),
        (
            json!({"channels": [channel(json!(null), "pointer"), channel(json!(0), "x")], "samplers": [sampler]}),
            "2 animations of other things than nodes",
        ),
        (
            json!({"channels": [channel(json!(0), "weights")], "samplers": [sampler]}),
            "1 animations of morph weights",
        ),
    ];
    for (animation, omission) in cases {
        let mut glb = Glb::triangle();
        glb.push("animations", animation.clone());
        let scene = glb.load().unwrap_or_else(|error| panic!("{animation}: {error}"));
        let omissions: Vec<String> = scene.notes.omissions.iter().map(ToString::to_string).collect();
        assert_eq!(omissions, [omission], "{animation}");
        assert!(scene.notes.warnings.is_empty(), "{animation}: {:?}", scene.notes.warnings);
    }
}

#[test]
fn gltf_channel_without_a_node_does_not_affect_others() {
    let mut glb = Glb::triangle();
    let (times, moves) =
        (glb.floats(&[0.0, 1.0], "SCALAR"), glb.floats(&[0.0, 0.0, 0.0, 5.0, 0.0, 0.0], "VEC3"));
    let pointer = json!({"sampler": 0, "target": {"path": "pointer",
        "extensions": {"KHR_animation_pointer": {"pointer": "/materials/0/alphaCutoff"}}}});
    let moving = json!({"sampler": 0, "target": {"node": 0, "path": "translation"}});
    glb.push(
        "animations",
        json!({"samplers": [{"input": times, "output": moves}], "channels": [pointer, moving]}),
    );
    let scene =
        glb.load_with(&LoadOptions { movers: MoverPolicy::Keep, ..LoadOptions::default() }).expect("loads");
    assert_eq!(scene.movers.len(), 1);
    assert_eq!(scene.notes.omissions[0].to_string(), "1 animations of other things than nodes");
}

#[test]
fn gltf_faulty_colour_textures_are_warnings() {
    for (list, kind, element, change) in faults() {
        let (Some((pointer, _)), true) = (change, ["images", "samplers", "textures"].contains(&list)) else {
            continue;
        };
        let (mut glb, index) = with_fault(list, &element);
        glb.json["materials"][0]["alphaMode"] = json!("OPAQUE");
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        glb.json.pointer_mut(parent).expect("is there")[key] =
            if list == "textures" { json!({"index": index}) } else { json!(index) };
        let options = LoadOptions { color_textures: true, ..LoadOptions::default() };
        let scene = glb.load_with(&options).unwrap_or_else(|error| panic!("{list}: {error}"));
        let warning = &scene.notes.warnings[0];
        assert!(
            warning.contains("\"leaf\"") && warning.contains(&format!("{kind} {index} cannot be read")),
            "{warning}"
        );
    }
}
