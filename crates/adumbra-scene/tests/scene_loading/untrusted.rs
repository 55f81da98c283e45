//! Untrusted scenes: which files they may read.

use std::path::{Path, PathBuf};

use adumbra_scene::{Error, Result};
use adumbra_scene::{LoadOptions, Scene, load};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::kit::{TRIANGLE, png};

const ANYWHERE: fn() -> LoadOptions = || LoadOptions { allow_outside: true, ..LoadOptions::default() };

/// A folder that holds `secret.bin`, which contains a triangle, and the subfolder `scenes`.
struct SceneFolder {
    folder: TempDir,
    scenes: PathBuf,
}

impl SceneFolder {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scenes = folder.path().join("scenes");
        std::fs::create_dir_all(scenes.join("sub")).expect("creates");
        let place = Self { folder, scenes };
        let positions: Vec<u8> = TRIANGLE.iter().flat_map(|c| c.to_le_bytes()).collect();
        std::fs::write(place.secret(), &positions).expect("writes");
        std::fs::write(place.scenes.join("inside.bin"), &positions).expect("writes");
        place
    }

    fn secret(&self) -> PathBuf {
        self.folder.path().join("secret.bin")
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.scenes.join(name);
        std::fs::write(&path, bytes).expect("writes");
        path
    }

    /// A triangle whose buffer is in another file.
    fn gltf(&self, uri: &str) -> PathBuf {
        self.write("scene.gltf", gltf(uri).to_string())
    }
}

fn gltf(uri: &str) -> Value {
    json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"uri": uri, "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    })
}

/// The triangle of `gltf`, with a texture.
fn gltf_with_image(uri: &str, alpha_mode: &str) -> Value {
    let mut json = gltf("inside.bin");
    json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let texture = json!({"baseColorTexture": {"index": 0}});
    json["materials"] = json!([{"name": "leaf", "alphaMode": alpha_mode, "pbrMetallicRoughness": texture}]);
    json["textures"] = json!([{"source": 0}]);
    json["images"] = json!([{"uri": uri}]);
    json
}

fn plain(path: &Path) -> Result<Scene> {
    load(path, &LoadOptions::default())
}

/// Asserts that the load fails because of a file outside the folder, with a message that states the remedy.
fn assert_outside(result: Result<Scene>, place: &str, named: &str) {
    let error = result.expect_err("a file outside the folder");
    let message = error.to_string();
    assert!(message.contains("allow files outside it") && message.contains("scene."), "{message}");
    match error {
        Error::OutsideScene { place: p, named: n, .. } => {
            assert_eq!((p.as_str(), n.as_str()), (place, named));
        }
        other => panic!("{other}"),
    }
}

#[test]
fn buffers_stay_in_the_scenes_folder() {
    let place = SceneFolder::new();
    for inside in ["inside.bin", "./inside.bin", "sub/../inside.bin", "%69nside.bin"] {
        assert_eq!(plain(&place.gltf(inside)).expect(inside).stored_triangles(), 1);
    }
    let secret = place.secret().display().to_string();
    for outside in ["../secret.bin", "sub/../../secret.bin", &secret, "%2e%2e/secret.bin"] {
        let path = place.gltf(outside);
        let named = outside.replace("%2e", ".");
        assert_outside(plain(&path), "buffer 0", &named);
        assert_eq!(load(&path, &ANYWHERE()).expect(outside).stored_triangles(), 1);
    }
    // A missing file gives the same message, so that a scene cannot probe which files exist.
    assert_outside(plain(&place.gltf("../nothing.bin")), "buffer 0", "../nothing.bin");
    let error = plain(&place.gltf("http://example.com/x.bin")).expect_err("no network");
    assert!(matches!(error, Error::Io(_)), "{error}");
}

#[test]
fn scene_with_a_relative_path_reads_files_beside_it() {
    let place = SceneFolder::new();
    let path = place.gltf("inside.bin");
    let relative = pathdiff(&path);
    assert_eq!(plain(&relative).expect("loads").stored_triangles(), 1);
}

/// The path relative to the working folder.
fn pathdiff(path: &Path) -> PathBuf {
    let up = std::env::current_dir().expect("a folder").components().count() - 1;
    let mut out: PathBuf = std::iter::repeat_n("..", up).collect();
    out.extend(path.components().skip(1));
    out
}

#[test]
fn images_stay_in_the_scenes_folder() {
    let place = SceneFolder::new();
    std::fs::write(place.folder.path().join("leaf.png"), png(&[0, 255])).expect("writes");
    let masked = place.write("scene.gltf", gltf_with_image("../leaf.png", "MASK").to_string());
    assert_outside(plain(&masked), "image 0", "../leaf.png");
    assert_eq!(load(&masked, &ANYWHERE()).expect("loads").textures.len(), 1);
    // A colour-only texture outside the folder is not an error.
    let colored = place.write("scene.gltf", gltf_with_image("../leaf.png", "OPAQUE").to_string());
    let colors = LoadOptions { color_textures: true, ..LoadOptions::default() };
    let scene = load(&colored, &colors).expect("loads");
    assert!(scene.textures.is_empty());
    assert_eq!(scene.notes.outside_textures, 1);
    assert!(scene.notes.warnings.iter().any(|w| w.contains("outside")), "{:?}", scene.notes.warnings);
}

const FACE: &str = "v 0 0 0\nv 0 0 1\nv 1 0 0\nusemtl m\nf 1 2 3\n";

#[test]
fn material_libraries_and_their_textures_stay_in_the_scenes_folder() {
    let place = SceneFolder::new();
    std::fs::write(place.folder.path().join("lib.mtl"), "newmtl m\nd 0.25\n").expect("writes");
    let path = place.write("scene.obj", format!("mtllib ../lib.mtl\n{FACE}"));
    assert_outside(plain(&path), "mtllib", "../lib.mtl");
    assert_eq!(load(&path, &ANYWHERE()).expect("loads").notes.blended_materials, 1);
    let path = place.write("scene.obj", format!("mtllib ..\\lib.mtl\n{FACE}"));
    assert_outside(plain(&path), "mtllib", "../lib.mtl");

    std::fs::write(place.folder.path().join("color.png"), png(&[255])).expect("writes");
    place.write("lib.mtl", "newmtl m\nmap_Kd ../color.png\n");
    let path = place.write("scene.obj", format!("mtllib lib.mtl\n{FACE}"));
    let scene = load(&path, &LoadOptions { color_textures: true, ..LoadOptions::default() }).expect("loads");
    assert!(scene.textures.is_empty());
    assert_eq!(scene.notes.outside_textures, 1);
    assert!(scene.notes.warnings.iter().any(|w| w.contains("outside")), "{:?}", scene.notes.warnings);
    let scene = load(&path, &LoadOptions { color_textures: true, ..ANYWHERE() }).expect("loads");
    assert_eq!(scene.textures.len(), 1);
}

#[test]
fn named_files_lists_each_file_once() {
    let place = SceneFolder::new();
    let names = |path: &Path| {
        let named = plain(path).expect("loads").notes.named_files;
        named.into_iter().map(|n| n.display().to_string()).collect::<Vec<_>>()
    };
    let path = place.write("scene.gltf", gltf_with_image("tex/a%20b.png", "OPAQUE").to_string());
    assert_eq!(names(&path), ["inside.bin", "tex/a b.png"]);

    let libraries = format!("mtllib{}", " lib.mtl".repeat(1000));
    let maps = format!("map_Kd{}", " ../a.png".repeat(1000));
    place.write("lib.mtl", format!("newmtl m\n{maps}\nnorm -bm 2 tex\\\\b.png\n"));
    let path = place.write("scene.obj", format!("{libraries}\n{FACE}"));
    let named = names(&path);
    for name in ["lib.mtl", "../a.png", "tex//b.png", "-bm 2 tex//b.png"] {
        assert!(named.iter().any(|n| n == name), "{name}");
    }
    // The other four names: the two long lines, and the words of the option.
    assert_eq!(named.len(), 8);
    let path = place.write("scene.obj", format!("mtllib lib.mtl\n{FACE}"));
    let many: String = (0..100_000).map(|i| format!("map_Kd {i}\n")).collect();
    place.write("lib.mtl", many);
    let options = LoadOptions { max_memory_bytes: Some(4 << 20), ..LoadOptions::default() };
    let error = load(&path, &options).expect_err("more names than fit");
    assert!(matches!(error, Error::SceneMemory { .. }), "{error}");
    assert!(error.to_string().contains("the names of its files"), "{error}");
}

#[test]
fn buffers_are_read_up_to_their_stated_length() {
    let place = SceneFolder::new();
    let long = std::fs::File::options().write(true).open(place.scenes.join("inside.bin")).expect("opens");
    // A sparse file: it uses no disk space, but is far larger than the memory of most machines.
    long.set_len(1 << 36).expect("grows");
    let options = LoadOptions { max_memory_bytes: Some(1 << 20), ..LoadOptions::default() };
    assert_eq!(load(&place.gltf("inside.bin"), &options).expect("loads").stored_triangles(), 1);
}

#[cfg(unix)]
#[test]
fn links_that_leave_the_folder_are_rejected() {
    let place = SceneFolder::new();
    std::os::unix::fs::symlink(place.secret(), place.scenes.join("link.bin")).expect("links");
    std::os::unix::fs::symlink("inside.bin", place.scenes.join("near.bin")).expect("links");
    std::os::unix::fs::symlink(place.folder.path(), place.scenes.join("up")).expect("links");
    assert_eq!(plain(&place.gltf("near.bin")).expect("loads").stored_triangles(), 1);
    for link in ["link.bin", "up/secret.bin"] {
        let path = place.gltf(link);
        assert_outside(plain(&path), "buffer 0", link);
        assert_eq!(load(&path, &ANYWHERE()).expect(link).stored_triangles(), 1);
    }
    // The scene itself may be a link; the files it references are next to the link.
    let path = place.gltf("inside.bin");
    let link = place.scenes.join("scene.link.gltf");
    std::os::unix::fs::symlink(path, &link).expect("links");
    assert_eq!(plain(&link).expect("loads").stored_triangles(), 1);
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_not_read() {
    let place = SceneFolder::new();
    let pipe = place.scenes.join("pipe.bin");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("runs");
    assert!(made.success());
    let refused = |result: Result<Scene>, part: &str| {
        let error = result.expect_err("not a regular file");
        assert!(matches!(error, Error::NotRegularFile { .. }), "{error}");
        assert!(error.to_string().contains(part), "{error}");
    };
    refused(plain(&place.gltf("pipe.bin")), "buffer 0");
    for device in ["/dev/zero", "/dev/stdin"] {
        assert_outside(plain(&place.gltf(device)), "buffer 0", device);
    }
    refused(load(&place.gltf("/dev/zero"), &ANYWHERE()), "/dev/zero");
    let path = place.write("scene.obj", format!("mtllib /dev/zero\n{FACE}"));
    assert_outside(plain(&path), "mtllib", "/dev/zero");
    refused(load(&path, &ANYWHERE()), "/dev/zero");
    // The same applies to the scene file itself.
    for ending in ["glb", "gltf", "obj", "ply"] {
        let scene = place.scenes.join("scene.pipe").with_extension(ending);
        std::fs::rename(&pipe, &scene).expect("renames");
        refused(plain(&scene), "the scene");
        std::fs::rename(&scene, &pipe).expect("renames");
    }
}
