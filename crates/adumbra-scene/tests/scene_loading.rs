//! Loading scenes: the expected content of valid files, and the error for each kind of invalid file.

#[path = "scene_loading/gltf_container.rs"]
mod gltf_container;
#[path = "scene_loading/gltf_morphs.rs"]
mod gltf_morphs;
#[path = "scene_loading/gltf_opacity.rs"]
mod gltf_opacity;
#[path = "scene_loading/gltf_scenes.rs"]
mod gltf_scenes;
#[path = "scene_loading/gltf_tolerance.rs"]
mod gltf_tolerance;
#[path = "scene_loading/kit.rs"]
mod kit;
#[path = "scene_loading/ktx2.rs"]
mod ktx2;
#[path = "scene_loading/memory.rs"]
mod memory;
#[path = "scene_loading/meshopt.rs"]
mod meshopt;
#[path = "scene_loading/names.rs"]
mod names;
#[path = "scene_loading/obj.rs"]
mod obj;
#[path = "scene_loading/obj_fuzz.rs"]
mod obj_fuzz;
#[path = "scene_loading/obj_masks.rs"]
mod obj_masks;
#[path = "scene_loading/others.rs"]
mod others;
#[path = "scene_loading/ply.rs"]
mod ply;
#[path = "scene_loading/ply_kit.rs"]
mod ply_kit;
#[path = "scene_loading/ply_refused.rs"]
mod ply_refused;
#[path = "scene_loading/polygons.rs"]
mod polygons;
#[path = "scene_loading/untrusted.rs"]
mod untrusted;
#[path = "scene_loading/up.rs"]
mod up;

use adumbra::IoError;
use adumbra_scene::{EmptyReason, Error, LoadOptions, load};
use kit::{Glb, TRIANGLE, USHORT, load_bytes, only, refused, refused_any, textured, world_triangles};
use serde_json::json;

#[test]
fn gltf_reads_a_triangle_without_indices() {
    let scene = Glb::triangle().load().expect("loads");
    assert_eq!(scene.stored_triangles(), 1);
    assert_eq!(world_triangles(&scene), [[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]]);
    assert_eq!(scene.instances[0].name, "node 0");
    assert_eq!(scene.materials[scene.meshes[0].triangle_materials[0] as usize].name, "default");
}

#[test]
fn gltf_transforms_nest_and_mirror() {
    let mut glb = Glb::triangle();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    glb.json["nodes"] = json!([
        {"translation": [10, 0, 0], "rotation": [0, half, 0, half], "children": [1, 2]},
        {"scale": [2, 2, 2], "mesh": 0, "name": "turned"},
        {"matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,5,0,1], "mesh": 0, "name": "mirrored"},
    ]);
    let scene = glb.load().expect("loads");
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    let triangles = world_triangles(&scene);
    // A quarter turn about y maps x to -z and z to x.
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-6);
    assert!(near(triangles[0][1], [10.0, 0.0, -2.0]) && near(triangles[0][2], [12.0, 0.0, 0.0]));
    assert!(near(triangles[1][1], [10.0, 5.0, 1.0]) && near(triangles[1][2], [11.0, 5.0, 0.0]));
    assert!(scene.instances[0].determinant() > 0.0 && scene.instances[1].determinant() < 0.0);
}

#[test]
fn gltf_rotation_does_not_mirror_an_instance() {
    // A rotation by 120 degrees about each axis.
    let (sin, cos) = (0.75_f64.sqrt(), 0.5);
    for turn in [[sin, 0.0, 0.0, cos], [0.0, sin, 0.0, cos], [0.0, 0.0, sin, cos]] {
        for side in [1.0, -1.0] {
            let mut glb = Glb::triangle();
            glb.json["nodes"][0] = json!({"mesh": 0, "rotation": turn, "scale": [side, 1, 1]});
            let determinant = glb.load().expect("loads").instances[0].determinant();
            assert!((determinant - side).abs() < 1e-6, "{turn:?} {side}: {determinant}");
        }
    }
}

#[test]
fn gltf_nodes_at_map_coordinates_keep_double_precision() {
    let mut glb = Glb::triangle();
    glb.json["nodes"] = json!([
        {"translation": [500_000.37, 0, 5_000_000.37], "children": [1, 2]},
        {"translation": [0.125, 0, 1_000_000.1], "mesh": 0},
        {"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0.1,0,10_000_000.3,1], "mesh": 0},
    ]);
    let scene = glb.load().expect("loads");
    let places = [[500_000.495, 0.0, 6_000_000.47], [500_000.47, 0.0, 15_000_000.67]];
    for (instance, place) in scene.instances.iter().zip(places) {
        let stands = instance.world_from_mesh.map(|row| row[3]);
        assert!((0..3).all(|a| (stands[a] - place[a]).abs() < 1e-8), "{stands:?} {place:?}");
    }
}

#[test]
fn gltf_strips_and_fans_keep_their_winding() {
    let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0];
    for (mode, order) in [(5, [0, 1, 2, 3]), (6, [0, 1, 3, 2])] {
        let mut glb = Glb::new();
        let positions = glb.floats(&square, "VEC3");
        let indices = glb.indices(&order);
        glb.push(
            "meshes",
            json!({"primitives": [{"attributes": {"POSITION": positions}, "indices": indices, "mode": mode}]}),
        );
        let scene = glb.load().expect("loads");
        assert_eq!(scene.meshes[0].positions.len(), 4);
        let triangles = world_triangles(&scene);
        assert_eq!(triangles.len(), 2);
        for t in triangles {
            let normal_y =
                (t[1][2] - t[0][2]) * (t[2][0] - t[0][0]) - (t[1][0] - t[0][0]) * (t[2][2] - t[0][2]);
            assert_eq!(normal_y, -1.0, "mode {mode}");
        }
    }
}

#[test]
fn gltf_reads_sparse_accessors_with_and_without_a_base() {
    for with_base in [true, false] {
        let mut glb = Glb::triangle();
        let at = glb.view(&[1_u16, 2].map(u16::to_le_bytes).concat());
        let to = glb.view(&[5.0_f32, 0.0, 0.0, 0.0, 0.0, 7.0].map(f32::to_le_bytes).concat());
        glb.json["accessors"][0]["sparse"] = json!({
            "count": 2, "indices": {"bufferView": at, "componentType": USHORT}, "values": {"bufferView": to}
        });
        if !with_base {
            glb.json["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
        }
        let triangles = world_triangles(&glb.load().expect("loads"));
        assert_eq!(triangles, [[[0.0; 3], [5.0, 0.0, 0.0], [0.0, 0.0, 7.0]]]);
    }
}

#[test]
fn gltf_reads_quantised_positions() {
    let mut glb = Glb::new();
    let bytes = [0_i16, 0, 0, 0, 32767, 0, 0, 0, 0, 0, -32767, 0].map(i16::to_le_bytes).concat();
    let positions = glb.accessor(&bytes, 5122, "VEC3", 3);
    glb.json["accessors"][positions]["normalized"] = json!(true);
    glb.json["bufferViews"][0]["byteStride"] = json!(8);
    glb.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    glb.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}}]}));
    let triangles = world_triangles(&glb.load().expect("loads"));
    assert_eq!(triangles, [[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]]);
}

#[test]
fn gltf_gpu_instancing_places_every_instance() {
    let mut glb = Glb::triangle();
    let moves = glb.floats(&[1.0, 0.0, 0.0, 2.0, 0.0, 0.0], "VEC3");
    glb.json["nodes"][0] = json!({"mesh": 0, "translation": [0, 3, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moves}}}});
    glb.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = glb.load().expect("loads");
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    assert_eq!(world_triangles(&scene)[1][0], [2.0, 3.0, 0.0]);
}

#[test]
fn gltf_skin_keeps_the_pose_of_its_nodes_with_a_warning() {
    let mut glb = Glb::new();
    let positions = glb.floats(&TRIANGLE, "VEC3");
    let joints = glb.accessor(&[0; 12], 5121, "VEC4", 3);
    let weights = glb.floats(&[1.0, 0.0, 0.0, 0.0].repeat(3), "VEC4");
    let bind = glb.floats(&[1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., -1., 0., 1.], "MAT4");
    glb.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights}}]}),
    );
    glb.json["nodes"] =
        json!([{"mesh": 0, "skin": 0, "translation": [99, 99, 99]}, {"translation": [0, 4, 0]}]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1]);
    glb.push("skins", json!({"joints": [1], "inverseBindMatrices": bind}));
    let scene = glb.load().expect("loads");
    assert_eq!(world_triangles(&scene)[0], [[0.0, 3.0, 0.0], [1.0, 3.0, 0.0], [0.0, 3.0, 1.0]]);
    assert!(scene.notes.warnings[0].contains("skinned"));

    // Without weights, a vertex follows the first joint that it names.
    let none = glb.floats(&[0.0; 12], "VEC4");
    glb.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(none);
    assert_eq!(world_triangles(&glb.load().expect("loads")), world_triangles(&scene));
    glb.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);

    // Another joint, in a second set, has the same weight.
    let others = glb.accessor(&[1, 0, 0, 0].repeat(3), 5121, "VEC4", 3);
    let attributes = &mut glb.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = json!(others);
    attributes["WEIGHTS_1"] = json!(weights);
    let node = glb.push("nodes", json!({"translation": [0, 8, 6]}));
    glb.json["skins"][0] = json!({"joints": [1, node]});
    let scene = glb.load().expect("loads");
    let by_both = [[0.0, 6.0, 3.0], [1.0, 6.0, 3.0], [0.0, 6.0, 4.0]];
    assert_eq!(world_triangles(&scene)[0], by_both);

    // A primitive that shares everything except the second set has another position.
    let first_set = json!({"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights});
    add_primitive(&mut glb, json!({ "attributes": first_set }));
    let triangles = world_triangles(&glb.load().expect("loads"));
    assert_eq!(triangles, [by_both, [[0.0, 4.0, 0.0], [1.0, 4.0, 0.0], [0.0, 4.0, 1.0]]]);
}

fn add_primitive(glb: &mut Glb, primitive: serde_json::Value) {
    glb.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(primitive);
}

#[test]
fn gltf_extras_stop_casting() {
    let no = json!({"adumbra": {"cast": false}});
    let mut glb = Glb::triangle();
    glb.json["nodes"] = json!([{"mesh": 0}, {"children": [2], "extras": no}, {"mesh": 0}]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1]);
    let scene = glb.load().expect("loads");
    assert_eq!(scene.instances.iter().map(|i| i.casts).collect::<Vec<_>>(), [true, false]);

    glb.json["meshes"][0]["extras"] = no.clone();
    assert!(matches!(refused(glb.load()), Error::NoTriangles { reason: EmptyReason::NoneCasts, .. }));

    let mut glb = textured(json!({"extras": no}), &json!({}));
    let rest = glb.json["meshes"][0]["primitives"][0]["attributes"].clone();
    glb.push("materials", json!({}));
    add_primitive(&mut glb, json!({"attributes": rest, "material": 1}));
    let scene = glb.load().expect("loads");
    assert_eq!(scene.materials.iter().map(|m| m.casts).collect::<Vec<_>>(), [false, true, true]);
}

#[test]
fn gltf_cast_mark_may_be_a_number_and_others_are_warnings() {
    let casts = |mark: serde_json::Value| {
        let mut glb = Glb::triangle();
        let extras = json!({"adumbra": {"cast": mark}});
        glb.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "name": "lamp", "extras": extras}]);
        glb.json["scenes"][0]["nodes"] = json!([0, 1]);
        let scene = glb.load().expect("loads");
        (scene.instances[1].casts, scene.notes.warnings.concat())
    };
    for (mark, expected) in
        [(json!(false), false), (json!(0), false), (json!(0.0), false), (json!(1), true), (json!(true), true)]
    {
        assert_eq!(casts(mark.clone()), (expected, String::new()), "{mark}");
    }
    for mark in [json!("false"), json!(2), json!(null), json!([0]), json!("x".repeat(500))] {
        let (casts, said) = casts(mark.clone());
        let text: String = mark.to_string().chars().take(40).collect();
        assert!(
            casts && said.contains(&format!("cast of node \"lamp\" is {text}, which is neither")),
            "{said}"
        );
    }
    let mut glb = textured(json!({"name": "leaf", "extras": {"adumbra": {"cast": "no"}}}), &json!({}));
    glb.json["meshes"][0]["extras"] = json!({"adumbra": {"cast": "no"}});
    let said = glb.load().expect("loads").notes.warnings.concat();
    assert!(said.contains("cast of mesh") && said.contains("so it casts, and 1 more are neither"), "{said}");
}

#[test]
fn gltf_filter_makes_variants_and_keeps_instances() {
    let mut glb = textured(json!({"name": "bark"}), &json!({}));
    let rest = glb.json["meshes"][0]["primitives"][0]["attributes"].clone();
    glb.push("materials", json!({"name": "leaf"}));
    glb.json["meshes"][0]["name"] = json!("tree");
    add_primitive(&mut glb, json!({"attributes": rest, "material": 1}));
    glb.json["nodes"] = json!([{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b"}, {"mesh": 0, "name": "c"}]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let count = |only_these: &[&str], exclude: &[&str]| {
        let scene = glb.load_with(&only(only_these, exclude)).expect("loads");
        (scene.meshes.len(), scene.instances.len(), scene.instanced_triangles())
    };
    assert_eq!(count(&[], &[]), (1, 3, 6));
    assert_eq!(count(&["a"], &[]), (1, 1, 2));
    assert_eq!(count(&["a", "leaf"], &[]), (2, 3, 4));
    assert_eq!(count(&[], &["lea?"]), (1, 3, 3));
    assert_eq!(count(&["tree"], &["{a,b}"]), (1, 1, 2));
    let error = refused(glb.load_with(&only(&["house*"], &[])));
    assert!(matches!(error, Error::NoTriangles { reason: EmptyReason::Filtered { .. }, .. }));
}

#[test]
fn gltf_reads_buffers_from_a_file_or_a_data_uri() {
    let mut glb = Glb::triangle();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.gltf");
    std::fs::write(folder.path().join("a b.bin"), &glb.bin).expect("writes");
    glb.json["buffers"][0]["uri"] = json!("a%20b.bin");
    std::fs::write(&path, glb.json.to_string()).expect("writes");
    assert_eq!(load(&path, &LoadOptions::default()).expect("loads").stored_triangles(), 1);
    std::fs::remove_file(folder.path().join("a b.bin")).expect("removes");
    let error = refused_any(load(&path, &LoadOptions::default()));
    assert!(matches!(error, Error::Io(IoError { path, .. }) if path.ends_with("a b.bin")));

    // 36 bytes: nine floats, all 0 except for two of 1.0 (00 00 80 3f).
    glb.json["buffers"][0]["uri"] = json!(
        "data:application/octet-stream;base64,\
        AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/"
    );
    std::fs::write(&path, glb.json.to_string()).expect("writes");
    assert_eq!(load(&path, &LoadOptions::default()).expect("loads").stored_triangles(), 1);
}

#[test]
fn gltf_required_extension_is_named() {
    let mut glb = Glb::triangle();
    glb.json["extensionsRequired"] = json!(["KHR_texture_transform", "EXT_not_supported"]);
    let error = refused(glb.load());
    assert!(matches!(error, Error::RequiredExtension { extension, .. } if extension == "EXT_not_supported"));
}

#[test]
fn gltf_rejects_bad_vertices_transforms_and_indices() {
    let mut glb = Glb::triangle();
    glb.bin[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(matches!(refused(glb.load()), Error::NotFinite { what, .. } if what.contains("vertex 0")));

    let mut glb = Glb::triangle();
    glb.json["nodes"][0] = json!({"mesh": 0, "name": "far", "translation": [1e39, 0, 0]});
    assert!(matches!(refused(glb.load()), Error::NotFinite { what, .. } if what.contains("far")));

    let mut glb = Glb::triangle();
    let indices = glb.indices(&[0, 1, 3]);
    glb.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert!(matches!(refused(glb.load()), Error::IndexOutOfRange { index: 3, vertices: 3, .. }));
}

#[test]
fn gltf_skips_degenerate_triangles_and_rejects_empty_scenes() {
    let mut glb = Glb::new();
    let positions = glb.floats(&[TRIANGLE.as_slice(), &[0.5, 0.0, 0.0], &[0.0; 3]].concat(), "VEC3");
    let indices = glb.indices(&[0, 1, 2, 0, 0, 1, 0, 1, 3, 0, 4, 1]);
    let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices});
    glb.push(
        "meshes",
        json!({"primitives": [primitive, {"attributes": {"POSITION": positions}, "mode": 1}]}),
    );
    let scene = glb.load().expect("loads");
    assert_eq!((scene.stored_triangles(), scene.notes.degenerate_triangles), (1, 3));
    assert_eq!(scene.notes.omissions.iter().map(|o| o.count).sum::<u64>(), 1);
    assert_eq!(scene.meshes[0].positions.len(), 3);

    glb.json["meshes"][0]["primitives"].as_array_mut().expect("a list").remove(0);
    assert!(matches!(refused(glb.load()), Error::NoTriangles { .. }));
    let mut glb = Glb::triangle();
    glb.json["nodes"] = json!([{}]);
    assert!(matches!(refused(glb.load()), Error::NoTriangles { .. }));
    glb.json["nodes"] = json!([{"mesh": 0, "scale": [0, 0, 0]}]);
    assert!(matches!(refused(glb.load()), Error::ZeroExtent { .. }));
    let mut glb = Glb::triangle();
    glb.bin.fill(0);
    assert!(matches!(refused(glb.load()), Error::ZeroExtent { .. }));
}

#[test]
fn gltf_broken_references_are_errors() {
    let pointers = [
        ("/scene", json!(7)),
        ("/scenes/0/nodes/0", json!(7)),
        ("/nodes/0/mesh", json!(7)),
        ("/nodes/0/children", json!([0])),
        ("/nodes/0/children", json!([9])),
        ("/nodes/0/skin", json!(4)),
        ("/meshes/0/primitives/0/material", json!(3)),
        ("/meshes/0/primitives/0/indices", json!(99)),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(5)),
        ("/accessors/0/bufferView", json!(5)),
        ("/accessors/0/byteOffset", json!(u64::MAX)),
        ("/accessors/0/count", json!(4)),
        ("/accessors/0/count", json!(1_u64 << 60)),
        ("/accessors/0/componentType", json!(1)),
        ("/accessors/0/type", json!("VEC2")),
        ("/bufferViews/0/buffer", json!(2)),
        ("/bufferViews/0/byteOffset", json!(u64::MAX)),
        ("/bufferViews/0/byteLength", json!(u64::MAX)),
        ("/bufferViews/0/byteStride", json!(1)),
    ];
    for (pointer, value) in pointers {
        let mut glb = Glb::triangle();
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = glb.json.pointer_mut(parent).expect("there");
        match key.parse::<usize>() {
            Ok(index) => parent[index] = value.clone(),
            Err(_) => parent[key] = value.clone(),
        }
        let error = refused(glb.load());
        assert!(matches!(error, Error::SceneParse { .. }), "{pointer} {value}: {error}");
    }
}

#[test]
fn glb_cut_at_every_length_is_an_error() {
    let mut glb = textured(
        json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}),
        &json!({}),
    );
    let view = glb.view(&kit::png(&[0, 255, 90]));
    glb.json["images"][0] = json!({"bufferView": view});
    let bytes = glb.bytes();
    let (_folder, path) = kit::file("scene.glb", &bytes);
    for length in 0..bytes.len() {
        std::fs::write(&path, &bytes[..length]).expect("writes");
        let error = refused(load(&path, &LoadOptions::default()));
        assert!(matches!(error, Error::SceneParse { .. }), "{length}: {error}");
    }
    std::fs::write(&path, [&bytes[..], b"more"].concat()).expect("writes");
    load(&path, &LoadOptions::default()).expect("loads");
}

#[test]
fn glb_with_any_byte_changed_does_not_panic() {
    let bytes = Glb::triangle().bytes();
    for at in 0..bytes.len() {
        for flip in [1, 0x80, 0xff] {
            let mut changed = bytes.clone();
            changed[at] ^= flip;
            let _ = load_bytes("scene.glb", &changed, &LoadOptions::default());
        }
    }
}
