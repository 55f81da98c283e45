//! Writes scenes as binary glTF 2.0 (Khronos, *glTF 2.0 Specification*, 2021, chapter 4).
//!
//! Meshes, instances, base colours, their textures and alpha modes are written, which is all that generated
//! scenes hold; vertex colours are not. Instancing is preserved: nodes share meshes. Each material used in a
//! mesh becomes one primitive with only the vertices it uses. The output is deterministic: equal scenes give
//! equal bytes.

mod images;

use adumbra::IoError;
use std::io::Write;
use std::path::Path;

use serde::Serialize;

use crate::{AlphaMode, Instance, Material, Mesh, Result, Scene};
use adumbra_files::replace_file;

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const CHUNK_JSON: &[u8; 4] = b"JSON";
const CHUNK_BIN: &[u8; 4] = b"BIN\0";
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Writes `scene` to `path` as encoded by [`to_glb`], through a temporary file in the same folder.
///
/// # Errors
/// Returns [`crate::Error::Io`] naming `path`; an existing file there is left untouched.
pub fn write_glb(scene: &Scene, path: &Path) -> Result<()> {
    let bytes = to_glb(scene);
    if u32::try_from(bytes.len()).is_err() {
        let source = std::io::Error::other("a GLB file holds at most 4 GiB; split the scene");
        return Err(IoError::at("write", path)(source).into());
    }
    replace_file(path, |file| file.write_all(&bytes).map(|()| bytes.len() as u64))?;
    Ok(())
}

/// Encodes `scene` as a GLB file. Meshes without triangles are skipped, with their instances. The format's
/// lengths are 32-bit, so more than 4 GiB do not fit; [`write_glb`] refuses such scenes.
pub fn to_glb(scene: &Scene) -> Vec<u8> {
    let mut document = GltfJson {
        asset: Asset { version: "2.0", generator: "adumbra" },
        materials: scene.materials.iter().map(material_json).collect(),
        ..GltfJson::default()
    };
    let mut bin = Vec::new();
    images::push_textures(scene, &mut document, &mut bin);
    // The glTF index of each mesh that has triangles.
    let mut mesh_index = Vec::with_capacity(scene.meshes.len());
    for mesh in &scene.meshes {
        mesh_index.push((!mesh.triangles.is_empty()).then_some(document.meshes.len()));
        if !mesh.triangles.is_empty() {
            let json = mesh_json(mesh, scene.materials.len(), &mut document, &mut bin);
            document.meshes.push(json);
        }
    }
    for instance in &scene.instances {
        if let Some(mesh) = mesh_index[instance.mesh as usize] {
            document.nodes.push(node_json(instance, mesh));
        }
    }
    if !document.nodes.is_empty() {
        document.scenes.push(SceneJson { nodes: (0..document.nodes.len()).collect() });
        document.scene = Some(0);
    }
    if !bin.is_empty() {
        document.buffers.push(Buffer { byte_length: bin.len() });
    }
    // Serializing structs of strings and numbers cannot fail.
    let json = serde_json::to_vec(&document).unwrap_or_default();
    container(json, bin, &[])
}

/// Assembles the header and the chunks, each padded to a multiple of 4 bytes. `others` are complete chunks,
/// which are appended unchanged.
pub(crate) fn container(mut json: Vec<u8>, mut bin: Vec<u8>, others: &[&[u8]]) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let bin_chunk = if bin.is_empty() { 0 } else { 8 + bin.len() };
    let total = 12 + 8 + json.len() + bin_chunk + others.iter().map(|chunk| chunk.len()).sum::<usize>();
    let mut out = Vec::with_capacity(total);
    out.extend_from_slice(MAGIC);
    out.extend_from_slice(&VERSION.to_le_bytes());
    out.extend_from_slice(&(total as u32).to_le_bytes());
    out.extend_from_slice(&(json.len() as u32).to_le_bytes());
    out.extend_from_slice(CHUNK_JSON);
    out.extend_from_slice(&json);
    if !bin.is_empty() {
        out.extend_from_slice(&(bin.len() as u32).to_le_bytes());
        out.extend_from_slice(CHUNK_BIN);
        out.extend_from_slice(&bin);
    }
    others.iter().for_each(|chunk| out.extend_from_slice(chunk));
    out
}

fn material_json(material: &Material) -> MaterialJson<'_> {
    // BLEND has no cut-off, and OPAQUE does not use one.
    let (alpha_mode, alpha_cutoff) = match material.alpha {
        AlphaMode::Opaque => (None, None),
        AlphaMode::Mask { .. } if material.blended => (Some("BLEND"), None),
        AlphaMode::Mask { cutoff } => (Some("MASK"), Some(cutoff)),
    };
    MaterialJson {
        name: &material.name,
        pbr: Pbr {
            base_color_factor: material.base_color,
            base_color_texture: material.texture.map(|index| TextureInfo { index }),
            metallic_factor: 0.0,
            roughness_factor: 1.0,
        },
        alpha_mode,
        alpha_cutoff,
        extras: Extras::where_false(material.casts),
    }
}

fn node_json(instance: &Instance, mesh: usize) -> Node<'_> {
    let m = &instance.world_from_mesh;
    let identity = (0..3).all(|r| (0..4).all(|c| m[r][c] == f64::from(u8::from(r == c))));
    // Column major; the last row is constant.
    let columns = std::array::from_fn(|i| match (i % 4, i / 4) {
        (3, c) => f32::from(u8::from(c == 3)),
        (r, c) => m[r][c] as f32,
    });
    Node {
        name: &instance.name,
        mesh,
        matrix: (!identity).then_some(columns),
        extras: Extras::where_false(instance.casts),
    }
}

fn mesh_json<'a>(
    mesh: &'a Mesh,
    materials: usize,
    document: &mut GltfJson<'_>,
    bin: &mut Vec<u8>,
) -> MeshJson<'a> {
    let mut used = vec![false; materials];
    for &m in &mesh.triangle_materials {
        used[m as usize] = true;
    }
    let mut primitives = Vec::new();
    // Index of each vertex within the current primitive.
    let mut number = vec![u32::MAX; mesh.positions.len()];
    for material in (0..materials as u32).filter(|&m| used[m as usize]) {
        let (mut vertices, mut indices) = (Vec::new(), Vec::new());
        let triangles = mesh.triangles.iter().zip(&mesh.triangle_materials).filter(|(_, m)| **m == material);
        for &v in triangles.flat_map(|(triangle, _)| triangle) {
            let slot = &mut number[v as usize];
            if *slot == u32::MAX {
                *slot = vertices.len() as u32;
                vertices.push(v);
            }
            indices.push(*slot);
        }
        primitives.push(Primitive {
            attributes: Attributes {
                position: push_positions(mesh, &vertices, document, bin),
                uv: (!mesh.uvs.is_empty()).then(|| push_uvs(mesh, &vertices, document, bin)),
            },
            indices: push_indices(&indices, vertices.len(), document, bin),
            material,
        });
        for v in vertices {
            number[v as usize] = u32::MAX;
        }
    }
    MeshJson { name: &mesh.name, primitives }
}

fn push_positions(mesh: &Mesh, vertices: &[u32], document: &mut GltfJson<'_>, bin: &mut Vec<u8>) -> usize {
    let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    let start = bin.len();
    for &v in vertices {
        for (a, c) in mesh.positions[v as usize].into_iter().enumerate() {
            min[a] = min[a].min(c);
            max[a] = max[a].max(c);
            bin.extend_from_slice(&c.to_le_bytes());
        }
    }
    let view = document.view(start, bin, Some(ARRAY_BUFFER));
    document.accessor(Accessor {
        buffer_view: view,
        component_type: FLOAT,
        count: vertices.len(),
        kind: "VEC3",
        min: Some(min),
        max: Some(max),
    })
}

fn push_uvs(mesh: &Mesh, vertices: &[u32], document: &mut GltfJson<'_>, bin: &mut Vec<u8>) -> usize {
    let start = bin.len();
    for &v in vertices {
        bin.extend(mesh.uvs[v as usize].into_iter().flat_map(f32::to_le_bytes));
    }
    let view = document.view(start, bin, Some(ARRAY_BUFFER));
    document.accessor(Accessor {
        buffer_view: view,
        component_type: FLOAT,
        count: vertices.len(),
        kind: "VEC2",
        min: None,
        max: None,
    })
}

fn push_indices(indices: &[u32], vertices: usize, document: &mut GltfJson<'_>, bin: &mut Vec<u8>) -> usize {
    let start = bin.len();
    // Index 65535 is not used: it is the primitive restart value.
    let short = vertices <= usize::from(u16::MAX);
    for &i in indices {
        if short {
            bin.extend_from_slice(&(i as u16).to_le_bytes());
        } else {
            bin.extend_from_slice(&i.to_le_bytes());
        }
    }
    let view = document.view(start, bin, Some(ELEMENT_ARRAY_BUFFER));
    document.accessor(Accessor {
        buffer_view: view,
        component_type: if short { UNSIGNED_SHORT } else { UNSIGNED_INT },
        count: indices.len(),
        kind: "SCALAR",
        min: None,
        max: None,
    })
}

#[derive(Default, Serialize)]
#[serde(rename_all = "camelCase")]
struct GltfJson<'a> {
    asset: Asset,
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<u32>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    scenes: Vec<SceneJson>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    nodes: Vec<Node<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    meshes: Vec<MeshJson<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    materials: Vec<MaterialJson<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    textures: Vec<images::TextureJson>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    images: Vec<images::ImageJson<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    samplers: Vec<images::SamplerJson>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    accessors: Vec<Accessor>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    buffer_views: Vec<BufferView>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    buffers: Vec<Buffer>,
}

impl GltfJson<'_> {
    /// Ends the buffer view that began at `start`, and pads the buffer to a multiple of 4 bytes.
    fn view(&mut self, start: usize, bin: &mut Vec<u8>, target: Option<u32>) -> usize {
        let byte_length = bin.len() - start;
        bin.resize(bin.len().next_multiple_of(4), 0);
        self.buffer_views.push(BufferView { buffer: 0, byte_offset: start, byte_length, target });
        self.buffer_views.len() - 1
    }

    fn accessor(&mut self, accessor: Accessor) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

#[derive(Default, Serialize)]
struct Asset {
    version: &'static str,
    generator: &'static str,
}

#[derive(Serialize)]
struct SceneJson {
    nodes: Vec<usize>,
}

#[derive(Serialize)]
struct Node<'a> {
    name: &'a str,
    mesh: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix: Option<[f32; 16]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    extras: Option<Extras>,
}

#[derive(Serialize)]
struct MeshJson<'a> {
    name: &'a str,
    primitives: Vec<Primitive>,
}

#[derive(Serialize)]
struct Primitive {
    attributes: Attributes,
    indices: usize,
    material: u32,
}

#[derive(Serialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: usize,
    #[serde(rename = "TEXCOORD_0", skip_serializing_if = "Option::is_none")]
    uv: Option<usize>,
}

#[derive(Serialize)]
struct MaterialJson<'a> {
    name: &'a str,
    #[serde(rename = "pbrMetallicRoughness")]
    pbr: Pbr,
    #[serde(rename = "alphaMode", skip_serializing_if = "Option::is_none")]
    alpha_mode: Option<&'static str>,
    #[serde(rename = "alphaCutoff", skip_serializing_if = "Option::is_none")]
    alpha_cutoff: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    extras: Option<Extras>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Pbr {
    base_color_factor: [f32; 4],
    #[serde(skip_serializing_if = "Option::is_none")]
    base_color_texture: Option<TextureInfo>,
    metallic_factor: f32,
    roughness_factor: f32,
}

#[derive(Serialize)]
struct TextureInfo {
    index: u32,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: usize,
    component_type: u32,
    count: usize,
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    min: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max: Option<[f32; 3]>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: u32,
    byte_offset: usize,
    byte_length: usize,
    /// How a graphics card uses the bytes; absent for images.
    #[serde(skip_serializing_if = "Option::is_none")]
    target: Option<u32>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Buffer {
    byte_length: usize,
}

/// `{"adumbra": {"cast": false}}`.
#[derive(Serialize)]
struct Extras {
    adumbra: Cast,
}

#[derive(Serialize)]
struct Cast {
    cast: bool,
}

impl Extras {
    fn where_false(casts: bool) -> Option<Self> {
        (!casts).then_some(Self { adumbra: Cast { cast: false } })
    }
}
