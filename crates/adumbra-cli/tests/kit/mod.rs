//! What the program's tests share: a folder that goes away, runs of the program, small scenes.

#![allow(dead_code, reason = "each test program uses a part")]

use std::fs;
use std::process::{Command, Output};

use serde_json::Value;

/// The program under test.
pub(crate) fn program() -> &'static str {
    env!("CARGO_BIN_EXE_adumbra")
}

/// Exit code and stderr of a run.
pub(crate) fn adumbra(arguments: &[&str]) -> (i32, String) {
    let output = Command::new(program()).args(arguments).output().unwrap();
    (output.status.code().unwrap(), stderr(&output))
}

/// The JSON that a run prints; the run must succeed.
pub(crate) fn json(arguments: &[&str]) -> Value {
    let output = Command::new(program()).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub(crate) fn read_f32(path: &str) -> Vec<f32> {
    fs::read(path).unwrap().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

/// A folder of the test's own.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    pub(crate) fn exists(&self, name: &str) -> bool {
        self.0.path().join(name).exists()
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> String {
        fs::write(self.0.path().join(name), bytes).unwrap();
        self.path(name)
    }

    pub(crate) fn write_f32(&self, name: &str, values: &[f32]) -> String {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.write(name, &bytes)
    }

    /// Writes a generated scene.
    pub(crate) fn generate(&self, kind: &str) -> String {
        let file = self.path(&format!("{kind}.glb"));
        let (code, error) = adumbra(&["generate", kind, "-o", &file]);
        assert_eq!(code, 0, "{error}");
        file
    }

    pub(crate) fn no_temporary_files(&self) -> bool {
        fs::read_dir(self.0.path())
            .unwrap()
            .all(|e| !e.unwrap().file_name().to_string_lossy().contains("tmp"))
    }
}

/// One masked triangle whose texture is not there.
pub(crate) const MASKED_GLTF: &str = r#"{
  "asset": {"version": "2.0"},
  "scenes": [{"nodes": [0]}],
  "nodes": [{"mesh": 0}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
  "materials": [{"name": "leaves", "alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
  "textures": [{"source": 0}],
  "images": [{"uri": "leaves.png"}],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
    {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2"}
  ],
  "bufferViews": [{"buffer": 0, "byteLength": 36}],
  "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAIA/AAAAAAAAgD8AAAAA"}]
}"#;

/// A file that cannot be read without an extension that is not supported.
pub(crate) const REQUIRING_GLTF: &str = r#"{
  "asset": {"version": "2.0"},
  "extensionsUsed": ["KHR_draco_mesh_compression"],
  "extensionsRequired": ["KHR_draco_mesh_compression"]
}"#;
