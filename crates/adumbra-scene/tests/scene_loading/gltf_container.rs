//! Containers of glTF files: chunks and padding of `.glb` (glTF 2.0, 4.4), versions (3.2), buffers (3.6.1)
//! and their URIs (2.8). Files that violate the specification in ways that are common in practice are read.

use std::path::{Path, PathBuf};

use adumbra::Sun;
use adumbra_scene::{Error, LoadOptions, Scene, files_of_gltf, load, write_shadow_name};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::kit::{Glb, load_bytes, refused};

const MARK: &[u8] = b"\xef\xbb\xbf";

/// A chunk of a `.glb`, not padded.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    [&(data.len() as u32).to_le_bytes()[..], kind, data].concat()
}

fn container(version: u32, chunks: &[Vec<u8>]) -> Vec<u8> {
    let chunks = chunks.concat();
    let length = 12 + chunks.len() as u32;
    [&b"glTF"[..], &version.to_le_bytes(), &length.to_le_bytes(), &chunks].concat()
}

fn plain(name: &str, bytes: &[u8]) -> adumbra_scene::Result<Scene> {
    load_bytes(name, bytes, &LoadOptions::default())
}

/// Valid or tolerated files of one triangle that are written in unusual ways.
fn odd_files() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let glb = Glb::triangle();
    let mut text = glb.json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let json = || chunk(b"JSON", &text);
    let bin = || chunk(b"BIN\0", &glb.bin);
    let other = || chunk(b"META", b"12345678");
    let glb_of = |chunks: &[Vec<u8>]| container(2, chunks);
    let mut alone = glb.json.clone();
    alone["buffers"][0]["uri"] = data_uri();
    let alone = alone.to_string().into_bytes();
    vec![
        ("as usual", "scene.glb", glb_of(&[json(), bin()])),
        ("an unknown chunk before BIN", "scene.glb", glb_of(&[json(), other(), bin()])),
        ("two unknown chunks before BIN", "scene.glb", glb_of(&[json(), other(), other(), bin()])),
        ("an unknown chunk after BIN", "scene.glb", glb_of(&[json(), bin(), other()])),
        ("an empty unknown chunk", "scene.glb", glb_of(&[json(), chunk(b"META", b""), bin()])),
        ("an unknown chunk before JSON", "scene.glb", glb_of(&[other(), json(), bin()])),
        ("an unknown chunk instead of BIN", "scene.glb", glb_of(&[chunk(b"JSON", &alone), other()])),
        ("no BIN", "scene.glb", glb_of(&[chunk(b"JSON", &alone)])),
        ("a second BIN", "scene.glb", glb_of(&[json(), bin(), chunk(b"BIN\0", &[0; 36])])),
        (
            "zeros after the JSON",
            "scene.glb",
            glb_of(&[chunk(b"JSON", &[&text[..], &[0; 4]].concat()), bin()]),
        ),
        (
            "spaces and zeros",
            "scene.glb",
            glb_of(&[chunk(b"JSON", &[&text[..], b" \0\0\n"].concat()), bin()]),
        ),
        ("a byte-order mark", "scene.glb", glb_of(&[chunk(b"JSON", &[MARK, &text, b" "].concat()), bin()])),
        ("bytes after the end", "scene.glb", [glb_of(&[json(), bin()]), vec![7; 3]].concat()),
        ("padding in the container", "scene.glb", glb_of(&[json(), bin(), vec![0; 4]])),
        ("binary under the other name", "scene.gltf", glb_of(&[json(), bin()])),
        ("text with a byte-order mark", "scene.gltf", [MARK, &alone].concat()),
        ("text that ends in a zero", "scene.gltf", [&alone[..], b"\0"].concat()),
        ("text that ends in a line", "scene.gltf", [&alone[..], b"\r\n"].concat()),
    ]
}

/// The nine floats of the triangle.
fn data_uri() -> Value {
    json!("data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/")
}

#[test]
fn gltf_reads_unusual_containers() {
    for (what, name, bytes) in odd_files() {
        let scene = plain(name, &bytes).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(scene.stored_triangles(), 1, "{what}");
        assert!(scene.notes.warnings.is_empty(), "{what}: {:?}", scene.notes.warnings);
    }
}

#[test]
fn gltf_shadow_name_keeps_triangles_and_other_chunks() {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).expect("above the horizon");
    for (what, name, bytes) in odd_files() {
        let (_folder, path) = crate::kit::file(name, &bytes);
        write_shadow_name(&path, "city.adumbra", sun).unwrap_or_else(|error| panic!("{what}: {error}"));
        let scene = load(&path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!((scene.stored_triangles(), scene.suns.len()), (1, 1), "{what}");
        let found = Sun::from_direction(scene.suns[0].towards).expect("above the horizon");
        assert_eq!(found, sun, "{what}");
        let written = std::fs::read(&path).expect("reads");
        let count = |bytes: &[u8], part: &[u8]| bytes.windows(part.len()).filter(|w| *w == part).count();
        for kept in [&b"META12345678"[..], b"BIN\0"] {
            assert_eq!(count(&written, kept), count(&bytes, kept), "{what}");
        }
        assert_eq!(count(&written, b"city.adumbra"), 1, "{what}");
    }
}

#[test]
fn gltf_shadow_name_fits_files_with_unusual_numbers() {
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).expect("above the horizon");
    let cases = [
        ("/scene", json!(0.0)),
        ("/scene", json!(null)),
        ("/scenes/0/nodes", json!([0.0])),
        ("/extensionsUsed", json!([5, "EXT_x"])),
        ("/extensionsUsed", json!(null)),
    ];
    for (pointer, value) in cases {
        let mut glb = Glb::triangle();
        glb.json["extensionsUsed"] = json!([]);
        *glb.json.pointer_mut(pointer).expect("is there") = value;
        let (_folder, path) = crate::kit::file("scene.glb", &glb.bytes());
        load(&path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{pointer}: {error}"));
        write_shadow_name(&path, "a.adumbra", sun).unwrap_or_else(|error| panic!("{pointer}: {error}"));
        let scene = load(&path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{pointer}: {error}"));
        assert_eq!((scene.stored_triangles(), scene.suns.len()), (1, 1), "{pointer}");
    }
}

#[test]
fn gltf_broken_containers_are_errors_that_say_why() {
    let glb = Glb::triangle();
    let text = glb.json.to_string().into_bytes();
    let (json, bin) = (chunk(b"JSON", &text), chunk(b"BIN\0", &glb.bin));
    let many: Vec<Vec<u8>> =
        std::iter::once(json.clone()).chain((0..1030).map(|_| chunk(b"META", b""))).collect();
    let mut long = container(2, &[json.clone(), bin.clone()]);
    let length = long.len() as u32 + 1;
    long[8..12].copy_from_slice(&length.to_le_bytes());
    let mut inner = container(2, &[json.clone(), bin.clone()]);
    let at = 12 + json.len();
    inner[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    let cases = [
        ("no JSON chunk", container(2, std::slice::from_ref(&bin))),
        ("no JSON chunk", container(2, &[])),
        ("too many chunks", container(2, &many)),
        ("container version 3", container(3, &[json.clone(), bin.clone()])),
        ("container version 0", container(0, &[json, bin])),
        ("is cut off", long),
        ("is cut off", inner),
        ("within its header", b"glTF\x02\0\0\0".to_vec()),
        ("does not begin with the letters glTF", text),
    ];
    for (part, bytes) in cases {
        let message = refused(plain("scene.glb", &bytes)).to_string();
        assert!(message.contains(part), "{part}: {message}");
    }
}

#[test]
fn gltf_rejects_other_versions_and_names_them() {
    let refused_as = |name: &str, bytes: &[u8], version: &str| {
        let error = refused(plain(name, bytes));
        let message = error.to_string();
        assert!(
            matches!(&error, Error::GltfVersion { version: v, .. } if v == version),
            "{version}: {message}"
        );
        assert!(message.contains(&format!("glTF {version}; convert it to 2.0")), "{message}");
    };
    let assets = [
        (json!({"version": "2.1", "minVersion": "2.1"}), "2.1"),
        (json!({"version": "2.0", "minVersion": "2.1"}), "2.1"),
        (json!({"minVersion": "3.0"}), "3.0"),
        (json!({"version": "3.0"}), "3.0"),
        (json!({"version": 3}), "3.0"),
        (json!({"version": "1.0"}), "1.0"),
        (json!({"version": "1.1"}), "1.1"),
        (json!({"version": "1.0.1"}), "1.0"),
        (json!({"version": 1.0}), "1.0"),
    ];
    for (asset, version) in assets {
        let mut glb = Glb::triangle();
        glb.json["asset"] = asset;
        refused_as("scene.glb", &glb.bytes(), version);
        refused_as("scene.gltf", glb.json.to_string().as_bytes(), version);
    }
    // The lists of glTF 1.0 are dictionaries, whatever version the file states.
    for asset in [json!({}), json!({"version": "1.0"}), json!({"version": "2.0"})] {
        let dictionaries = json!({"asset": asset, "scene": "main", "scenes": {"main": {"nodes": ["a"]}},
            "nodes": {"a": {"meshes": ["b"]}}, "meshes": {"b": {}}});
        refused_as("scene.gltf", dictionaries.to_string().as_bytes(), "1.0");
    }
    // The binary container of version 1 has another header.
    let old =
        [&b"glTF"[..], &1_u32.to_le_bytes(), &24_u32.to_le_bytes(), &4_u32.to_le_bytes(), &[0; 8]].concat();
    refused_as("scene.glb", &old, "1.0");
}

#[test]
fn gltf_reads_versions_that_require_at_most_2_0() {
    for (asset, warnings) in [
        (json!({"version": "2.0"}), 0),
        (json!({"version": "2.0", "minVersion": "2.0"}), 0),
        (json!({"version": "2.1", "minVersion": "2.0"}), 0),
        (json!({"version": "2.1"}), 0),
        (json!({"version": "2"}), 0),
        (json!({"version": 2.0, "generator": 7}), 0),
        (json!({"generator": "by hand"}), 1),
        (json!(null), 1),
    ] {
        let mut glb = Glb::triangle();
        glb.json["asset"] = asset.clone();
        let scene = glb.load().unwrap_or_else(|error| panic!("{asset}: {error}"));
        assert_eq!(scene.notes.warnings.len(), warnings, "{asset}: {:?}", scene.notes.warnings);
    }
}

#[test]
fn gltf_shadow_name_in_a_file_without_scenes_keeps_all_nodes_drawn() {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).expect("above the horizon");
    for scenes in [json!([]), json!(null)] {
        let mut glb = Glb::triangle();
        glb.json["nodes"] = json!([{"mesh": 0}, {"children": [2.0]}, {"mesh": 0}]);
        glb.json["scenes"] = scenes;
        glb.json["scene"] = json!(null);
        let (_folder, path) = crate::kit::file("scene.glb", &glb.bytes());
        let drawn = |scene: Scene| scene.instances.into_iter().map(|i| i.name).collect::<Vec<_>>();
        let before = drawn(load(&path, &LoadOptions::default()).expect("loads"));
        write_shadow_name(&path, "a.adumbra", sun).expect("writes");
        assert_eq!(drawn(load(&path, &LoadOptions::default()).expect("loads")), before);
    }
}

/// A triangle in `a.bin`, and a second buffer with a view that nothing uses.
fn with_second_buffer(second: &Value) -> Value {
    let mut json = Glb::triangle().json;
    json["buffers"] = json!([{"byteLength": 36, "uri": data_uri()}, second]);
    json["bufferViews"].as_array_mut().expect("a list").push(json!({"buffer": 1, "byteLength": 4}));
    json
}

fn faulty_buffers() -> [(Value, &'static str); 6] {
    [
        (json!({"byteLength": 4, "uri": "missing.bin"}), "missing.bin"),
        (json!({"byteLength": 4}), "has 0 bytes, not 4"),
        (json!({"byteLength": 4, "uri": "data:;base64,!!!!"}), "not valid base64"),
        (json!({"byteLength": 4, "uri": "data:nothing"}), "not valid base64"),
        (json!({"byteLength": 4, "uri": "../outside.bin"}), "outside"),
        (json!({"byteLength": "four"}), "1 of kind buffer"),
    ]
}

#[test]
fn gltf_unused_faulty_buffers_are_warnings() {
    for (second, part) in faulty_buffers() {
        let scene = plain("scene.gltf", with_second_buffer(&second).to_string().as_bytes());
        let scene = scene.unwrap_or_else(|error| panic!("{second}: {error}"));
        assert_eq!(scene.stored_triangles(), 1, "{second}");
        let warnings = &scene.notes.warnings;
        assert!(warnings.len() == 1 && warnings[0].contains(part), "{second}: {warnings:?}");
        // A buffer without a view is not read.
        let mut json = with_second_buffer(&second);
        json["bufferViews"].as_array_mut().expect("a list").pop();
        plain("scene.gltf", json.to_string().as_bytes()).unwrap_or_else(|error| panic!("{second}: {error}"));
    }
}

#[test]
fn gltf_used_faulty_buffers_are_errors() {
    for (second, part) in faulty_buffers() {
        let mut json = with_second_buffer(&second);
        json["bufferViews"][0]["buffer"] = json!(1);
        let error = plain("scene.gltf", json.to_string().as_bytes()).expect_err(part);
        let message = error.to_string();
        match part {
            "missing.bin" => assert!(matches!(error, Error::Io(_)) && message.contains(part), "{message}"),
            "outside" => assert!(matches!(error, Error::OutsideScene { .. }), "{message}"),
            "has 0 bytes, not 4" => assert!(message.contains("reaches past its buffer"), "{message}"),
            "1 of kind buffer" => assert!(message.contains("buffer 1 cannot be read: "), "{message}"),
            _ => assert!(message.contains(part) && message.contains("buffer 1"), "{message}"),
        }
    }
}

#[test]
fn gltf_short_buffer_is_read_if_its_views_fit() {
    // The missing byte is outside the view, or inside it.
    for (view, loads) in [(36, true), (37, false)] {
        let mut glb = Glb::triangle();
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.gltf");
        std::fs::write(folder.path().join("a.bin"), &glb.bin).expect("writes");
        glb.json["buffers"][0] = json!({"byteLength": 37, "uri": "a.bin"});
        glb.json["bufferViews"][0]["byteLength"] = json!(view);
        std::fs::write(&path, glb.json.to_string()).expect("writes");
        let result = load(&path, &LoadOptions::default());
        if loads {
            assert_eq!(result.expect("loads").notes.warnings, ["buffer 0 has 36 bytes, not 37"]);
        } else {
            assert!(refused(result).to_string().contains("buffer view 0 reaches past its buffer"));
        }
    }
    // The same applies to the binary chunk.
    let mut glb = Glb::triangle();
    glb.json["buffers"][0]["byteLength"] = json!(37);
    assert_eq!(glb.load().expect("loads").notes.warnings, ["buffer 0 has 36 bytes, not 37"]);
}

/// A folder with a triangle's buffer in the file `file`, and a scene whose buffer has the URI `uri`.
fn beside(file: &str, uri: &str) -> (TempDir, PathBuf) {
    let mut glb = Glb::triangle();
    let folder = tempfile::tempdir().expect("a folder");
    let (buffer, path) = (folder.path().join(file), folder.path().join("scene.gltf"));
    std::fs::create_dir_all(buffer.parent().expect("a folder")).expect("creates");
    std::fs::write(&buffer, &glb.bin).expect("writes");
    glb.json["buffers"][0]["uri"] = json!(uri);
    std::fs::write(&path, glb.json.to_string()).expect("writes");
    (folder, path)
}

#[test]
fn gltf_uris_find_files_by_decoded_or_literal_names() {
    for (file, uri) in [
        ("a b.bin", "a%20b.bin"),
        ("a b.bin", "a b.bin"),
        ("data/a.bin", "data/a.bin"),
        ("data/a.bin", "./data/../data/a.bin"),
        ("data/a.bin", "data\\a.bin"),
        ("data/a.bin", ".\\data\\a.bin"),
        ("data/a.bin", "data%5Ca.bin"),
        ("data/a b.bin", "data\\a%20b.bin"),
        ("100%.bin", "100%.bin"),
        ("100%.bin", "100%25.bin"),
        ("a%20b.bin", "a%20b.bin"),
        ("50%25/a%20b.bin", "50%25\\a%20b.bin"),
        ("ä.bin", "%C3%A4.bin"),
        ("ä.bin", "ä.bin"),
    ] {
        let (_folder, path) = beside(file, uri);
        let scene =
            load(&path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{file} {uri}: {error}"));
        assert_eq!(scene.stored_triangles(), 1, "{file} {uri}");
        let named = &scene.notes.named_files;
        assert!(named.iter().any(|name| path.with_file_name(name).is_file()), "{file} {uri}: {named:?}");
    }
}

#[test]
fn gltf_ambiguous_uris_mean_the_decoded_name() {
    let (folder, path) = beside("a b.bin", "a%20b.bin");
    std::fs::write(folder.path().join("a%20b.bin"), "x").expect("writes");
    assert!(load(&path, &LoadOptions::default()).expect("loads").notes.warnings.is_empty());
}

#[test]
fn gltf_uris_with_backslashes_stay_in_the_folder() {
    for uri in ["..\\secret.bin", "a\\..\\..\\secret.bin", "..%5Csecret.bin", "\\secret.bin"] {
        let (_folder, path) = beside("a.bin", uri);
        let error = refused(load(&path, &LoadOptions::default()));
        assert!(matches!(error, Error::OutsideScene { .. }), "{uri}: {error}");
    }
}

#[test]
fn files_of_gltf_accepts_unusual_and_faulty_files() {
    let listed = |name: &str, bytes: &[u8]| files_of_gltf(Path::new(name), bytes);
    for (what, name, bytes) in odd_files() {
        assert!(listed(name, &bytes).unwrap_or_else(|error| panic!("{what}: {error}")).is_empty(), "{what}");
    }
    let json = json!({"asset": {"version": "2.0"}, "cameras": 5, "nodes": [7],
        "buffers": [{"uri": "t\\a%20b.bin", "byteLength": 1.0}, {"uri": "x.bin"}, {"uri": 5, "byteLength": 1}],
        "images": [{"uri": "..\\a.png"}, {"uri": "100%.png", "name": 3}]});
    let bytes = [MARK, json.to_string().as_bytes()].concat();
    let files = listed("scene.gltf", &bytes).expect("is read");
    assert_eq!(files, ["100%.png", "t/a b.bin", "x.bin"].map(PathBuf::from));
    assert!(matches!(listed("a.gltf", br#"{"asset": {"version": "3.0"}}"#), Err(Error::GltfVersion { .. })));
}
