//! Models as glTF 2.0, in the different ways in which the specification allows them to be stored.

use adumbra_testing::glb;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::Form;
use crate::model::{Mesh, Model, Placement};

pub(crate) const FORMS: &[Form] = &[
    ("GLB", "scene.glb", |m| write(m, &PLAIN)),
    ("glTF with its data in the text", "scene.gltf", |m| {
        write(m, &Style { container: Container::Data, ..PLAIN })
    }),
    ("glTF with a file of data", "scene.gltf", |m| write(m, &Style { container: Container::File, ..PLAIN })),
    ("indices of 8 bits", "scene.glb", |m| write(m, &Style { indices: Indices::Bytes, ..PLAIN })),
    ("indices of 16 bits", "scene.glb", |m| write(m, &Style { indices: Indices::Shorts, ..PLAIN })),
    ("no indices", "scene.glb", |m| write(m, &Style { indices: Indices::None, ..PLAIN })),
    ("strips", "scene.glb", |m| write(m, &Style { mode: Mode::Strips, ..PLAIN })),
    ("fans", "scene.glb", |m| write(m, &Style { mode: Mode::Fans, ..PLAIN })),
    ("interleaved", "scene.glb", |m| write(m, &Style { positions: Positions::Interleaved, ..PLAIN })),
    ("sparse", "scene.glb", |m| write(m, &Style { positions: Positions::Sparse, ..PLAIN })),
    ("quantized", "scene.glb", |m| write(m, &Style { positions: Positions::Shorts, ..PLAIN })),
    ("morphed", "scene.glb", |m| write(m, &Style { positions: Positions::Morphed, ..PLAIN })),
    ("matrices below a parent", "scene.glb", |m| write(m, &Style { nodes: Nodes::Matrices, ..PLAIN })),
    ("EXT_mesh_gpu_instancing", "scene.glb", |m| write(m, &Style { nodes: Nodes::Instanced, ..PLAIN })),
    ("skinned", "scene.glb", |m| write(m, &Style { nodes: Nodes::Skinned, ..PLAIN })),
    ("a mixture", "scene.glb", |m| write(m, &Style::mixed(m))),
];

const PLAIN: Style = Style {
    container: Container::Glb,
    indices: Indices::Words,
    mode: Mode::Triangles,
    positions: Positions::Floats,
    nodes: Nodes::Plain,
};

/// How a model is stored.
struct Style {
    container: Container,
    indices: Indices,
    mode: Mode,
    positions: Positions,
    nodes: Nodes,
}

#[derive(Clone, Copy)]
enum Container {
    Glb,
    Data,
    File,
}

#[derive(Clone, Copy)]
enum Indices {
    None,
    Bytes,
    Shorts,
    Words,
}

#[derive(Clone, Copy)]
enum Mode {
    Triangles,
    Strips,
    Fans,
}

#[derive(Clone, Copy, PartialEq)]
enum Positions {
    Floats,
    Interleaved,
    Sparse,
    Shorts,
    Morphed,
}

#[derive(Clone, Copy)]
enum Nodes {
    Plain,
    Matrices,
    Instanced,
    Skinned,
}

impl Style {
    /// A combination that depends on the model.
    fn mixed(model: &Model) -> Self {
        let mut dice =
            model.meshes[0].positions.len() * 31 + model.placements.len() * 7 + model.meshes[0].faces.len();
        let mut pick = |count: usize| {
            dice = dice.wrapping_mul(1_103_515_245).wrapping_add(12_345) % (1 << 31);
            (dice >> 8) % count
        };
        Self {
            container: Container::Glb,
            indices: [Indices::None, Indices::Bytes, Indices::Shorts, Indices::Words][pick(4)],
            mode: [Mode::Triangles, Mode::Strips, Mode::Fans][pick(3)],
            positions: [Positions::Floats, Positions::Interleaved, Positions::Sparse, Positions::Morphed]
                [pick(4)],
            nodes: [Nodes::Plain, Nodes::Matrices, Nodes::Instanced, Nodes::Skinned][pick(4)],
        }
    }
}

/// A file being built.
struct File {
    json: Value,
    bin: Vec<u8>,
}

fn write(model: &Model, style: &Style) -> Vec<(String, Vec<u8>)> {
    let mut file = File {
        json: json!({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}),
        bin: Vec::new(),
    };
    for mesh in &model.meshes {
        let mesh = file.mesh(mesh, style);
        file.push("meshes", mesh);
    }
    let mut roots = Vec::new();
    match style.nodes {
        Nodes::Instanced => {
            for mesh in 0..model.meshes.len() {
                let placed: Vec<&Placement> = model.placements.iter().filter(|p| p.mesh == mesh).collect();
                roots.push(file.instanced(mesh, &placed, style));
            }
        }
        _ => roots.extend(model.placements.iter().map(|placement| file.node(placement, style))),
    }
    file.json["scenes"][0]["nodes"] = json!(roots);
    file.finish(style.container)
}

impl File {
    fn push(&mut self, list: &str, value: Value) -> usize {
        if !self.json[list].is_array() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    fn need(&mut self, extension: &str) {
        for list in ["extensionsUsed", "extensionsRequired"] {
            if !self.json[list].as_array().is_some_and(|l| l.contains(&json!(extension))) {
                self.push(list, json!(extension));
            }
        }
    }

    fn view(&mut self, bytes: &[u8], stride: Option<usize>) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(8), 0xee);
        let mut view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()});
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    fn accessor(&mut self, view: usize, kind: u32, shape: &str, count: usize) -> usize {
        let accessor = json!({"bufferView": view, "componentType": kind, "type": shape, "count": count});
        self.push("accessors", accessor)
    }

    fn floats(&mut self, values: &[f64], shape: &str, each: usize) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|&v| (v as f32).to_le_bytes()).collect();
        let view = self.view(&bytes, None);
        self.accessor(view, 5126, shape, values.len() / each)
    }

    /// Adds positions, and a morph target if the style is morphed. Returns both accessors.
    fn positions(&mut self, points: &[[f64; 3]], style: &Style) -> (usize, Option<usize>) {
        let flat: Vec<f64> = points.iter().flatten().copied().collect();
        match style.positions {
            Positions::Floats => (self.floats(&flat, "VEC3", 3), None),
            Positions::Interleaved => {
                let bytes: Vec<u8> = points
                    .iter()
                    .flat_map(|p| [p[0], p[1], p[2], f64::NAN, f64::NAN].map(|c| (c as f32).to_le_bytes()))
                    .flatten()
                    .collect();
                let view = self.view(&bytes, Some(20));
                (self.accessor(view, 5126, "VEC3", points.len()), None)
            }
            Positions::Sparse => {
                let wrong: Vec<f64> =
                    flat.iter().enumerate().map(|(i, &c)| if i / 3 % 2 == 0 { 1e9 } else { c }).collect();
                let accessor = self.floats(&wrong, "VEC3", 3);
                let even: Vec<usize> = (0..points.len()).step_by(2).collect();
                let indices: Vec<u8> = even.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect();
                let values: Vec<u8> = even
                    .iter()
                    .flat_map(|&i| points[i].map(|c| (c as f32).to_le_bytes()))
                    .flatten()
                    .collect();
                let (indices, values) = (self.view(&indices, None), self.view(&values, None));
                self.json["accessors"][accessor]["sparse"] = json!({
                    "count": even.len(), "indices": {"bufferView": indices, "componentType": 5123},
                    "values": {"bufferView": values},
                });
                (accessor, None)
            }
            Positions::Shorts => {
                self.need("KHR_mesh_quantization");
                let shorts = points.iter().flat_map(|p| [p[0], p[1], p[2], 0.0].map(|c| (c * 4.0) as i16));
                let bytes: Vec<u8> = shorts.flat_map(i16::to_le_bytes).collect();
                let view = self.view(&bytes, Some(8));
                (self.accessor(view, 5122, "VEC3", points.len()), None)
            }
            Positions::Morphed => {
                let shift = |i: usize| (i % 7) as f64 - 3.0;
                let base: Vec<f64> = flat.iter().enumerate().map(|(i, c)| c - 0.5 * shift(i)).collect();
                let target: Vec<f64> = (0..flat.len()).map(shift).collect();
                (self.floats(&base, "VEC3", 3), Some(self.floats(&target, "VEC3", 3)))
            }
        }
    }

    fn indices(&mut self, corners: &[usize], style: &Style) -> usize {
        let most = corners.iter().copied().max().unwrap_or(0);
        let (kind, bytes): (u32, Vec<u8>) = match style.indices {
            Indices::Bytes if most < 255 => (5121, corners.iter().map(|&c| c as u8).collect()),
            Indices::Bytes | Indices::Shorts => {
                (5123, corners.iter().flat_map(|&c| (c as u16).to_le_bytes()).collect())
            }
            _ => (5125, corners.iter().flat_map(|&c| (c as u32).to_le_bytes()).collect()),
        };
        let view = self.view(&bytes, None);
        self.accessor(view, kind, "SCALAR", corners.len())
    }

    fn mesh(&mut self, mesh: &Mesh, style: &Style) -> Value {
        let runs: Vec<(u32, Vec<usize>)> = match style.mode {
            Mode::Triangles => vec![(4, mesh.triangles().concat())],
            // The second triangle of a strip is reversed: b c a, then c d a.
            Mode::Strips => mesh.faces.iter().map(|f| (5, strip(f))).collect(),
            Mode::Fans => mesh.faces.iter().map(|f| (6, f.clone())).collect(),
        };
        let shared = match style.indices {
            Indices::None => None,
            _ => Some(self.positions(&mesh.positions, style)),
        };
        let mut primitives = Vec::new();
        let mut morphed = false;
        for (mode, corners) in runs {
            let (positions, target) = shared.unwrap_or_else(|| {
                let points: Vec<[f64; 3]> = corners.iter().map(|&c| mesh.positions[c]).collect();
                self.positions(&points, style)
            });
            let joined = self.influences(positions, style);
            let mut primitive = json!({"mode": mode, "attributes": {"POSITION": positions}});
            if shared.is_some() {
                primitive["indices"] = json!(self.indices(&corners, style));
            }
            if let Some(target) = target {
                primitive["targets"] = json!([{"POSITION": target}]);
                morphed = true;
            }
            if let Some((joints, weights)) = joined {
                primitive["attributes"]["JOINTS_0"] = json!(joints);
                primitive["attributes"]["WEIGHTS_0"] = json!(weights);
            }
            primitives.push(primitive);
        }
        let mut json = json!({"primitives": primitives});
        if morphed {
            json["weights"] = json!([0.5]);
        }
        json
    }

    /// Lets all vertices follow the only joint of their skin.
    fn influences(&mut self, positions: usize, style: &Style) -> Option<(usize, usize)> {
        let Nodes::Skinned = style.nodes else { return None };
        let count = self.json["accessors"][positions]["count"].as_u64().expect("a count") as usize;
        let joints = self.view(&vec![0; 4 * count], None);
        let joints = self.accessor(joints, 5121, "VEC4", count);
        let weights = self.floats(&[1.0, 0.0, 0.0, 0.0].repeat(count), "VEC4", 4);
        Some((joints, weights))
    }

    fn node(&mut self, placement: &Placement, style: &Style) -> usize {
        let (mesh, [x, y, z]) = (placement.mesh, placement.offset);
        let scale =
            if style.positions == Positions::Shorts { placement.scale / 4.0 } else { placement.scale };
        let place = json!({"translation": [x, y, z], "scale": [scale, scale, scale]});
        match style.nodes {
            Nodes::Matrices => {
                let matrix = [
                    scale,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    scale,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    scale,
                    0.0,
                    x - 8.0,
                    y + 4.0,
                    z,
                    1.0,
                ];
                let child = self.push("nodes", json!({"mesh": mesh, "matrix": matrix}));
                self.push("nodes", json!({"children": [child], "translation": [8, -4.0, 0]}))
            }
            Nodes::Skinned => {
                let joint = self.push("nodes", place);
                let skin = self.push("skins", json!({"joints": [joint]}));
                // A skinned node's own transform is ignored.
                let skinned =
                    self.push("nodes", json!({"mesh": mesh, "skin": skin, "translation": [1000, 0, 0]}));
                self.push("nodes", json!({"children": [joint, skinned]}))
            }
            _ => {
                let node = self.push("nodes", place);
                self.json["nodes"][node]["mesh"] = json!(mesh);
                node
            }
        }
    }

    fn instanced(&mut self, mesh: usize, placed: &[&Placement], style: &Style) -> usize {
        self.need("EXT_mesh_gpu_instancing");
        let quarter = if style.positions == Positions::Shorts { 0.25 } else { 1.0 };
        let offsets: Vec<f64> = placed.iter().flat_map(|p| p.offset).collect();
        let scales: Vec<f64> = placed.iter().flat_map(|p| [p.scale * quarter; 3]).collect();
        let (offsets, scales) = (self.floats(&offsets, "VEC3", 3), self.floats(&scales, "VEC3", 3));
        let attributes = json!({"TRANSLATION": offsets, "SCALE": scales});
        self.push(
            "nodes",
            json!({"mesh": mesh, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}),
        )
    }

    fn finish(mut self, container: Container) -> Vec<(String, Vec<u8>)> {
        let buffer = json!({"byteLength": self.bin.len()});
        self.json["buffers"] = json!([buffer]);
        let mut files = Vec::new();
        match container {
            Container::Glb => return vec![("scene.glb".to_owned(), glb(&self.json, &self.bin))],
            Container::Data => {
                let data = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bin));
                self.json["buffers"][0]["uri"] = json!(data);
            }
            Container::File => {
                self.json["buffers"][0]["uri"] = json!("scene%20data.bin");
                files.push(("scene data.bin".to_owned(), self.bin));
            }
        }
        files.push(("scene.gltf".to_owned(), self.json.to_string().into_bytes()));
        files
    }
}

fn strip(face: &[usize]) -> Vec<usize> {
    match *face {
        [a, b, c, d] => vec![b, c, a, d],
        _ => face.to_vec(),
    }
}
