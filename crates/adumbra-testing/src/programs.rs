//! Code shared by the tests of both programs: runs of the programs, a temporary folder, small scenes.
//!
//! A test of one program may run the other, which is in the same folder once the workspace is built.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::described::assert_described;

/// Returns the path of the program `adumbra`.
pub fn program() -> PathBuf {
    built("adumbra")
}

/// Returns the path of the program `adumbra-lab`.
pub fn lab_program() -> PathBuf {
    built("adumbra-lab")
}

/// Returns the path of a program in the build profile of the running test. The test's executable is in a
/// subfolder.
fn built(name: &str) -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let path = test.ancestors().nth(2).unwrap().join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(
        path.is_file(),
        "{}: not built; build the workspace first: cargo build --workspace, with --release if the tests run with it",
        path.display()
    );
    path
}

/// Runs `adumbra` and returns its exit code and stderr.
pub fn adumbra(arguments: &[&str]) -> (i32, String) {
    ended(&Command::new(program()).args(arguments).output().unwrap())
}

/// Runs `adumbra-lab` and returns its exit code and stderr.
pub fn lab(arguments: &[&str]) -> (i32, String) {
    ended(&Command::new(lab_program()).args(arguments).output().unwrap())
}

fn ended(output: &Output) -> (i32, String) {
    (output.status.code().unwrap(), stderr(output))
}

/// Runs `adumbra` and returns the JSON that it prints. The run must succeed, and the verb's schema must
/// describe the JSON.
pub fn json(arguments: &[&str]) -> Value {
    printed(&program(), arguments)
}

/// Runs `adumbra-lab` and returns the JSON that it prints. The run must succeed, and the verb's schema must
/// describe the JSON.
pub fn lab_json(arguments: &[&str]) -> Value {
    printed(&lab_program(), arguments)
}

fn printed(program: &Path, arguments: &[&str]) -> Value {
    let output = Command::new(program).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
    let value = serde_json::from_slice(&output.stdout).unwrap();
    assert_described(&schema(program, arguments), &value);
    value
}

/// Returns the schema that a program prints for a verb, which is the first word or the first two words.
fn schema(program: &Path, words: &[&str]) -> Value {
    let printed = (1..=2).find_map(|n| {
        let output = Command::new(program).arg("schema").args(&words[..n]).output().unwrap();
        output.status.success().then_some(output.stdout)
    });
    serde_json::from_slice(&printed.unwrap_or_else(|| panic!("{words:?}: no schema"))).unwrap()
}

/// Returns what a run printed on stderr.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Reads a file of little-endian floats.
pub fn read_f32(path: &str) -> Vec<f32> {
    fs::read(path).unwrap().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

/// A temporary folder of a test, deleted when it is dropped.
pub struct Folder(tempfile::TempDir);

impl Default for Folder {
    fn default() -> Self {
        Self::new()
    }
}

impl Folder {
    /// Creates an empty folder.
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// Returns the path of `name` in the folder.
    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    /// Whether a file of that name exists in the folder.
    pub fn exists(&self, name: &str) -> bool {
        self.0.path().join(name).exists()
    }

    /// Writes a file and returns its path.
    pub fn write(&self, name: &str, bytes: &[u8]) -> String {
        fs::write(self.0.path().join(name), bytes).unwrap();
        self.path(name)
    }

    /// Writes little-endian floats and returns the file's path.
    pub fn write_f32(&self, name: &str, values: &[f32]) -> String {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.write(name, &bytes)
    }

    /// Writes a generated scene and returns its path.
    pub fn generate(&self, kind: &str) -> String {
        let file = self.path(&format!("{kind}.glb"));
        let (code, error) = adumbra(&["generate", kind, "-o", &file]);
        assert_eq!(code, 0, "{error}");
        file
    }

    /// Whether no temporary file was left behind.
    pub fn no_temporary_files(&self) -> bool {
        fs::read_dir(self.0.path())
            .unwrap()
            .all(|e| !e.unwrap().file_name().to_string_lossy().contains("tmp"))
    }
}

/// A glTF file with one masked triangle whose texture does not exist.
pub const MASKED_GLTF: &str = r#"{
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

/// A glTF file that requires an extension that is not supported.
pub const REQUIRING_GLTF: &str = r#"{
  "asset": {"version": "2.0"},
  "extensionsUsed": ["EXT_not_supported"],
  "extensionsRequired": ["EXT_not_supported"]
}"#;
