//! Builds tiny scene files for the loading tests.

use std::path::PathBuf;

use adumbra_scene::{Error, Result};
use adumbra_scene::{LoadOptions, NameFilter, Scene, load};
use adumbra_testing::glb;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A glTF file being built: editable JSON, and the binary chunk.
#[derive(Clone)]
pub(crate) struct Glb {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

/// The corners of a right triangle in the xz plane.
pub(crate) const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

pub(crate) const FLOAT: u32 = 5126;
pub(crate) const UINT: u32 = 5125;
pub(crate) const USHORT: u32 = 5123;

impl Glb {
    pub(crate) fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [], "materials": [], "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}],
        });
        Self { json, bin: Vec::new() }
    }

    /// A file with one node and one mesh of a single triangle without indices.
    pub(crate) fn triangle() -> Self {
        let mut glb = Self::new();
        let positions = glb.floats(&TRIANGLE, "VEC3");
        glb.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}}]}));
        glb
    }

    pub(crate) fn push(&mut self, list: &str, value: Value) -> usize {
        if !self.json[list].is_array() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let from = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.bin.len());
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": from, "byteLength": bytes.len()}))
    }

    pub(crate) fn accessor(&mut self, bytes: &[u8], kind: u32, shape: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": kind, "type": shape, "count": count}),
        )
    }

    pub(crate) fn floats(&mut self, values: &[f32], shape: &str) -> usize {
        let each = match shape {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 1,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, FLOAT, shape, values.len() / each)
    }

    pub(crate) fn indices(&mut self, values: &[u32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, UINT, "SCALAR", values.len())
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        glb(&self.json, &self.bin)
    }

    /// Loads the file from a temporary `.glb`.
    pub(crate) fn load(&self) -> Result<Scene> {
        self.load_with(&LoadOptions::default())
    }

    pub(crate) fn load_with(&self, options: &LoadOptions) -> Result<Scene> {
        load_bytes("scene.glb", &self.bytes(), options)
    }
}

/// A triangle with one textured material; `image` is the image's JSON.
pub(crate) fn textured(material: Value, image: &Value) -> Glb {
    let mut glb = Glb::triangle();
    let uvs = glb.floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0], "VEC2");
    glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(uvs);
    glb.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    glb.json["images"] = json!([image]);
    glb.json["textures"] = json!([{"source": 0}]);
    glb.push("materials", material);
    glb
}

/// A temporary folder, and a file in it.
pub(crate) fn file(name: &str, bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("writes");
    (folder, path)
}

pub(crate) fn load_bytes(name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Scene> {
    let (_folder, path) = file(name, bytes);
    load(&path, options)
}

pub(crate) fn only(only: &[&str], exclude: &[&str]) -> LoadOptions {
    let owned = |list: &[&str]| list.iter().map(|&s| s.to_owned()).collect::<Vec<_>>();
    let filter = NameFilter::new(&owned(only), &owned(exclude)).expect("valid globs");
    LoadOptions { filter, ..LoadOptions::default() }
}

/// Every placed triangle, in world space.
pub(crate) fn world_triangles(scene: &Scene) -> Vec<[[f64; 3]; 3]> {
    let mut out = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        out.extend(mesh.triangles.iter().map(|t| t.map(|i| instance.to_world(mesh.positions[i as usize]))));
    }
    out
}

/// The error of a load that must fail; checks that its message names the file.
pub(crate) fn refused(result: Result<Scene>) -> Error {
    let error = result.expect_err("the load fails");
    let message = error.to_string();
    assert!(message.contains("scene."), "names no file: {message}");
    assert!(!message.contains('\n'), "more than one line: {message}");
    error
}

/// The error of a load that must fail; its message may name another file.
pub(crate) fn refused_any(result: Result<Scene>) -> Error {
    result.expect_err("the load fails")
}

/// A PNG with a single row of one colour and the given alpha values.
pub(crate) fn png(alpha: &[u8]) -> Vec<u8> {
    let pixels: Vec<u8> = alpha.iter().flat_map(|&a| [255, 128, 0, a]).collect();
    let image = image::RgbaImage::from_raw(alpha.len() as u32, 1, pixels).expect("fits");
    let mut out = std::io::Cursor::new(Vec::new());
    image.write_to(&mut out, image::ImageFormat::Png).expect("encodes");
    out.into_inner()
}
