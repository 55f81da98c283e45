//! The compressed files, opened for editing, and the comparison of scenes.

use std::path::PathBuf;

use adumbra_scene::{LoadOptions, Result, Scene, load};
use serde_json::{Value, json};

/// A `.glb` being edited: editable JSON, and the binary chunk.
#[derive(Clone)]
pub(crate) struct Fixture {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

/// A corner of a triangle: position, texture coordinates and colour.
pub(crate) type Corner = ([f32; 3], [f32; 2], [u8; 4]);

pub(crate) fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/draco").join(format!("{name}.glb"))
}

impl Fixture {
    pub(crate) fn read(name: &str) -> Self {
        Self::parse(&std::fs::read(path(name)).expect("the fixture is there"))
    }

    pub(crate) fn parse(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
        let end = 20 + word(12);
        let json = serde_json::from_slice(&bytes[20..end]).expect("JSON");
        Self { json, bin: bytes[end + 8..][..word(end)].to_vec() }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        adumbra_testing::glb(&self.json, &self.bin)
    }

    pub(crate) fn load(&self) -> Result<Scene> {
        self.load_with(&LoadOptions { color_textures: true, ..LoadOptions::default() })
    }

    pub(crate) fn load_with(&self, options: &LoadOptions) -> Result<Scene> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scene.glb");
        std::fs::write(&path, self.bytes()).expect("writes");
        load(&path, options)
    }

    pub(crate) fn add_view(&mut self, bytes: &[u8]) -> usize {
        let from = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.bin.len());
        let views = self.json["bufferViews"].as_array_mut().expect("views");
        views.push(json!({"buffer": 0, "byteOffset": from, "byteLength": bytes.len()}));
        views.len() - 1
    }
}

/// Every triangle of every mesh, each rotated to begin with its smallest corner, all sorted.
pub(crate) fn triangles(scene: &Scene) -> Vec<(String, u32, [Corner; 3])> {
    let mut out = Vec::new();
    for mesh in &scene.meshes {
        for (triangle, &material) in mesh.triangles.iter().zip(&mesh.triangle_materials) {
            let mut corners = triangle.map(|i| {
                let i = i as usize;
                let uv = mesh.uvs.get(i).copied().unwrap_or_default();
                (mesh.positions[i], uv, mesh.colors.get(i).copied().unwrap_or_default())
            });
            let first = (0..3).min_by(|&a, &b| corners[a].partial_cmp(&corners[b]).expect("finite"));
            corners.rotate_left(first.expect("three corners"));
            out.push((mesh.name.clone(), material, corners));
        }
    }
    out.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    out
}

/// Asserts that each triangle of `plain` matches one in `other` whose corners are within `step` of its own,
/// and that no triangle of `other` remains unmatched.
#[cfg(feature = "draco")]
pub(crate) fn assert_close(plain: &Scene, other: &Scene, step: f32, uv_step: f32) {
    let (plain, mut others) = (triangles(plain), triangles(other));
    assert_eq!(plain.len(), others.len());
    for (mesh, material, corners) in plain {
        let is_close = |(a, b): (&Corner, &Corner)| {
            a.0.iter().zip(b.0).all(|(x, y)| (x - y).abs() <= step)
                && a.1.iter().zip(b.1).all(|(x, y)| (x - y).abs() <= uv_step)
                && a.2 == b.2
        };
        let found = others.iter().position(|(name, other_material, there)| {
            let turned = |by: usize| [there[by], there[(by + 1) % 3], there[(by + 2) % 3]];
            *name == mesh
                && *other_material == material
                && (0..3).any(|by| corners.iter().zip(&turned(by)).all(is_close))
        });
        others.swap_remove(found.unwrap_or_else(|| panic!("no triangle near {corners:?} of {mesh}")));
    }
}
