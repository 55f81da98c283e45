//! Buffer views compressed with meshoptimizer. That project's encoders made the fixtures
//! (`tests/fixtures/encode.mjs`), and its decoder made the expected values.

use std::path::PathBuf;

use adumbra_scene::{Error, LoadOptions, Scene, load};
use serde_json::{Value, json};

#[cfg(feature = "meshopt")]
use crate::kit::world_triangles;
use crate::kit::{FLOAT, Glb, load_bytes, refused};

fn fixture(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/meshopt").join(name)
}

/// The streams of `streams.json`: one for each mode, filter, width and version.
fn streams() -> Vec<Value> {
    let text = std::fs::read(fixture("streams.json")).expect("the fixture");
    serde_json::from_slice(&text).expect("JSON")
}

fn text<'a>(stream: &'a Value, key: &str) -> &'a str {
    stream[key].as_str().expect("a text")
}

fn number(stream: &Value, key: &str) -> u64 {
    stream[key].as_u64().expect("a number")
}

/// Positions, and corners if the stream holds corners. The decoded values are in buffer 0 if `plain`, else in
/// a stream.
fn scene_of(stream: &Value, plain: bool) -> Value {
    let attributes = text(stream, "mode") == "ATTRIBUTES";
    let (count, stride) = (number(stream, "count"), number(stream, "stride"));
    let size = count * stride;
    let bytes = text(stream, if plain { "decoded" } else { "stream" });
    let uri = format!("data:application/octet-stream;base64,{bytes}");
    let length = bytes.len() / 4 * 3 - bytes.bytes().filter(|&b| b == b'=').count();
    let mut view = json!({"buffer": 0, "byteLength": size});
    let mut buffers = vec![json!({"byteLength": length, "uri": uri})];
    if attributes {
        view["byteStride"] = json!(stride);
    }
    if !plain {
        let extension = text(stream, "extension");
        view["buffer"] = json!(1);
        view["extensions"][extension] = json!({
            "buffer": 0, "byteLength": length, "byteStride": stride, "count": count, "mode": stream["mode"],
            "filter": stream["filter"],
        });
        buffers.push(json!({"byteLength": size, "extensions": {extension: {"fallback": true}}}));
    }
    let kind = stream["componentType"].clone();
    let shape = if attributes { "VEC3" } else { "SCALAR" };
    let of_stream = json!({"bufferView": 0, "componentType": kind, "type": shape, "count": count,
        "normalized": stream["normalized"] == true});
    // Corners refer to a separate list of positions.
    let grid: Vec<u8> =
        (0..18_u8).flat_map(|i| [i, i % 5, i % 7].map(f32::from)).flat_map(f32::to_le_bytes).collect();
    let positions = buffers.len();
    buffers.push(json!({"byteLength": grid.len(), "uri": data_uri(&grid)}));
    let others = json!({"bufferView": 1, "componentType": FLOAT, "type": "VEC3", "count": 18});
    let primitive = match attributes {
        true => json!({"attributes": {"POSITION": 0}}),
        false => json!({"attributes": {"POSITION": 1}, "indices": 0}),
    };
    json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}], "accessors": [of_stream, others],
        "bufferViews": [view, {"buffer": positions, "byteLength": grid.len()}], "buffers": buffers,
    })
}

fn data_uri(bytes: &[u8]) -> String {
    let percent: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
    format!("data:application/octet-stream,{percent}")
}

fn loads(json: &Value) -> adumbra_scene::Result<Scene> {
    load_bytes("scene.gltf", json.to_string().as_bytes(), &LoadOptions::default())
}

fn meshes(scene: &Scene) -> String {
    format!("{:?} {:?}", scene.meshes, scene.notes.degenerate_triangles)
}

#[cfg(feature = "meshopt")]
#[test]
fn meshopt_streams_match_the_reference_decoder() {
    let streams = streams();
    for filter in ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"] {
        assert!(streams.iter().any(|s| s["filter"] == filter), "{filter}");
    }
    for stream in &streams {
        let name = text(stream, "name");
        let expected = loads(&scene_of(stream, true)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let decoded = loads(&scene_of(stream, false)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(expected.stored_triangles() > 4, "{name}");
        assert_eq!(meshes(&decoded), meshes(&expected), "{name}");
    }
}

#[cfg(feature = "meshopt")]
#[test]
fn meshopt_takes_both_extension_names_and_prefers_the_newer() {
    let stream = streams().remove(0);
    let json = scene_of(&stream, false);
    let [older, newer] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
    let expected = meshes(&loads(&scene_of(&stream, true)).expect("loads"));
    let renamed = json.to_string().replace(older, newer);
    let renamed: Value = serde_json::from_str(&renamed).expect("JSON");
    for mut json in [json, renamed.clone()] {
        for required in [json!([]), json!([older]), json!([newer])] {
            json["extensionsRequired"] = required;
            assert_eq!(meshes(&loads(&json).expect("loads")), expected);
        }
    }
    let mut both = renamed;
    both["bufferViews"][0]["extensions"][older] = json!({"mode": "broken"});
    assert_eq!(meshes(&loads(&both).expect("loads")), expected);
}

#[cfg(feature = "meshopt")]
#[test]
fn meshopt_ignores_the_fallback_buffer() {
    let stream = streams().remove(0);
    let expected = meshes(&loads(&scene_of(&stream, true)).expect("loads"));
    let json = scene_of(&stream, false);
    let size = json["buffers"][1]["byteLength"].clone();
    let zeros = "0".repeat(size.as_u64().expect("a size") as usize);
    for fallback in [
        json!({"byteLength": size}),
        json!({"byteLength": size, "uri": "absent.bin"}),
        json!({"byteLength": size, "uri": format!("data:,{zeros}")}),
    ] {
        let mut json = json.clone();
        json["buffers"][1] = fallback;
        assert_eq!(meshes(&loads(&json).expect("loads")), expected, "{}", json["buffers"][1]);
    }
    // A view whose range is outside its own buffer, and buffers in reverse order.
    let mut json = json;
    json["bufferViews"][0]["byteOffset"] = json!(1 << 20);
    assert_eq!(meshes(&loads(&json).expect("loads")), expected);
    let buffers = json["buffers"].as_array_mut().expect("a list");
    buffers.swap(0, 1);
    json["bufferViews"][0]["buffer"] = json!(0);
    json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["buffer"] = json!(1);
    assert_eq!(meshes(&loads(&json).expect("loads")), expected);
}

#[cfg(feature = "meshopt")]
#[test]
fn meshopt_files_of_gltfpack_and_gltf_transform_load() {
    let options = LoadOptions { color_textures: true, ..LoadOptions::default() };
    let original = load(&fixture("wave.gltf"), &options).expect("loads");
    let sorted = |scene: &Scene| {
        let mut triangles = world_triangles(scene);
        for triangle in &mut triangles {
            let least = (0..3).min_by(|&a, &b| triangle[a].partial_cmp(&triangle[b]).expect("finite"));
            triangle.rotate_left(least.expect("a corner"));
        }
        triangles.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
        triangles
    };
    let expected = sorted(&original);
    assert_eq!(expected.len(), 98);
    for (name, error) in [
        ("gltf-transform", 0.0),
        ("gltfpack-noq", 0.0),
        ("gltfpack-c", 1e-3),
        ("gltfpack-cf", 1e-3),
        ("gltfpack-khr", 1e-3),
    ] {
        let scene =
            load(&fixture(&format!("{name}.glb")), &options).unwrap_or_else(|e| panic!("{name}: {e}"));
        let triangles = world_triangles(&scene);
        assert_eq!(triangles.len(), expected.len(), "{name}");
        if error == 0.0 {
            assert_eq!(sorted(&scene), expected, "{name}");
        }
        // Every triangle is near one of the original.
        for triangle in sorted(&scene) {
            let distance = |other: &[[f64; 3]; 3]| {
                let differences =
                    triangle.iter().flatten().zip(other.iter().flatten()).map(|(a, b)| (a - b).abs());
                differences.fold(0.0, f64::max)
            };
            let nearest = expected.iter().map(distance).fold(f64::INFINITY, f64::min);
            assert!(nearest <= error, "{name}: {nearest}");
        }
        assert_eq!(scene.textures.len(), 1, "{name}");
        assert!(scene.meshes[0].uvs.iter().flatten().any(|&u| u > 0.9), "{name}");
    }
}

#[cfg(feature = "meshopt")]
#[test]
fn meshopt_faults_are_errors_that_say_why() {
    let stream = streams().remove(0);
    let extension = text(&stream, "extension").to_owned();
    let json = scene_of(&stream, false);
    let faulty = |change: &dyn Fn(&mut Value)| {
        let mut json = json.clone();
        change(&mut json);
        refused(loads(&json)).to_string()
    };
    let field = |key: &'static str, value: Value| {
        let (key, extension) = (key, extension.as_str());
        faulty(&move |json| json["bufferViews"][0]["extensions"][extension][key] = value.clone())
    };
    for (key, value, part) in [
        ("mode", json!("LINES"), "unknown mode"),
        ("mode", json!(3), "unknown mode"),
        ("filter", json!("BLUR"), "unknown filter"),
        ("filter", json!("OCTAHEDRAL"), "byteStride of 12"),
        ("byteStride", json!(8), "byteStride of 8"),
        ("byteStride", json!(260), "byteStride of 260"),
        ("count", Value::Null, "no count"),
        ("count", json!(100), "broken data"),
        ("byteLength", json!(40), "broken data"),
        ("byteLength", json!(1 << 20), "past its buffer"),
        ("byteOffset", json!(u64::MAX), "past its buffer"),
        ("buffer", json!(7), "past its buffer"),
    ] {
        let message = field(key, value.clone());
        assert!(message.contains(part) && message.contains("buffer view 0"), "{key} {value}: {message}");
        assert!(message.contains(&extension), "{key} {value}: {message}");
    }
    // A count that a short stream cannot hold, and one beyond the memory limit.
    let message = field("count", json!(1_000_000));
    assert!(message.contains("broken data"), "{message}");
    let message = field("count", json!(1_u64 << 60));
    assert!(message.contains("MiB are allowed") && message.contains("buffer view 0"), "{message}");
    // The stream has an unknown version.
    let message = faulty(&|json| {
        let uri = json["buffers"][0]["uri"].as_str().expect("a URI").replace(";base64,oA", ";base64,rw");
        json["buffers"][0]["uri"] = json!(uri);
    });
    assert!(message.contains("unknown version"), "{message}");
}

#[cfg(feature = "meshopt")]
#[test]
fn meshopt_views_are_decoded_once_and_counted() {
    let stream =
        streams().into_iter().find(|s| text(s, "name").starts_with("more than one block")).expect("it");
    let mut json = scene_of(&stream, false);
    // Twenty meshes that share the view need no more than one.
    let accessor = json["accessors"][0].clone();
    let mut primitives = Vec::new();
    for _ in 0..20 {
        let accessors = json["accessors"].as_array_mut().expect("a list");
        accessors.push(accessor.clone());
        primitives.push(json!({"attributes": {"POSITION": accessors.len() - 1}}));
    }
    let needed = |json: &Value| {
        let within = |bytes: u64| {
            let options = LoadOptions { max_memory_bytes: Some(bytes), ..LoadOptions::default() };
            load_bytes("scene.gltf", json.to_string().as_bytes(), &options)
        };
        let (mut least, mut most) = (0, 1 << 24);
        while most - least > 16 {
            let middle = (least + most) / 2;
            match within(middle) {
                Ok(_) => most = middle,
                Err(Error::SceneMemory { .. }) => least = middle,
                Err(other) => panic!("{other}"),
            }
        }
        most
    };
    json["meshes"][0]["primitives"] = json!(primitives);
    let shared = needed(&json);
    let view = json["bufferViews"][0].clone();
    for i in 0..20 {
        let views = json["bufferViews"].as_array_mut().expect("a list");
        views.push(view.clone());
        let last = views.len() - 1;
        json["accessors"][2 + i]["bufferView"] = json!(last);
    }
    let size = number(&stream, "count") * number(&stream, "stride");
    let apart = needed(&json);
    assert!(apart > shared + 19 * size, "{apart} {shared}");
}

#[test]
fn meshopt_fallback_may_be_the_binary_chunk() {
    // Buffer 0 is the fallback in a GLB's binary chunk; the stream is in buffer 1.
    let stream = streams().remove(0);
    let mut glb = Glb::triangle();
    let json = scene_of(&stream, false);
    let (extension, view) = (text(&stream, "extension"), &json["bufferViews"][0]);
    let mut compressed = view["extensions"].clone();
    compressed[extension]["buffer"] = json!(1);
    glb.push("buffers", json["buffers"][0].clone());
    glb.json["buffers"][0]["extensions"][extension] = json!({"fallback": true});
    glb.json["bufferViews"][0]["extensions"] = compressed;
    let scene = glb.load().expect("loads");
    let expected = match cfg!(feature = "meshopt") {
        true => loads(&scene_of(&stream, true)).expect("loads"),
        false => Glb::triangle().load().expect("loads"),
    };
    assert_eq!(scene.meshes[0].positions[..3], expected.meshes[0].positions[..3]);
}

#[cfg(not(feature = "meshopt"))]
#[test]
fn meshopt_without_its_feature_needs_a_fallback() {
    let stream = streams().remove(0);
    let mut json = scene_of(&stream, false);
    let error = refused(loads(&json));
    assert!(matches!(error, Error::MissingFeature { feature: "meshopt", .. }), "{error}");
    assert!(error.to_string().contains("EXT_meshopt_compression"), "{error}");
    // If the fallback has data, it gives the same result.
    let plain = scene_of(&stream, true);
    json["buffers"][1]["uri"] = plain["buffers"][0]["uri"].clone();
    assert_eq!(meshes(&loads(&json).expect("loads")), meshes(&loads(&plain).expect("loads")));
    let result = load(&fixture("gltfpack-c.glb"), &LoadOptions::default());
    assert!(matches!(result, Err(Error::MissingFeature { .. })));
    load(&fixture("gltfpack-cf.glb"), &LoadOptions::default()).expect("loads");
}
