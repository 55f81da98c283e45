//! Random valid glTF files with most features of the format, and the ways in which a file can be written.

use std::path::Path;

use serde_json::{Number, Value, json};

use crate::dice::Dice;
use crate::each_value;
use crate::kit::{Glb, TRIANGLE, USHORT, png};

/// A random file. Its first node is static, visible, and places a mesh whose first triangle has an area.
pub(crate) fn file(dice: &mut Dice) -> Glb {
    let mut glb = Glb::new();
    if dice.chance(0.6) {
        materials(dice, &mut glb);
    }
    let meshes = 1 + dice.below(3);
    for _ in 0..meshes {
        mesh(dice, &mut glb);
    }
    nodes(dice, &mut glb, meshes);
    if dice.chance(0.4) {
        animation(dice, &mut glb);
    }
    if dice.chance(0.2) {
        glb.json["cameras"] = json!([{"type": "orthographic"}]);
    }
    glb
}

/// Length of a list of the file; 0 if the file lacks the list.
fn count(glb: &Glb, list: &str) -> usize {
    glb.json[list].as_array().map_or(0, Vec::len)
}

fn materials(dice: &mut Dice, glb: &mut Glb) {
    let view = glb.view(&png(&[0, 255, 90]));
    glb.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    for _ in 0..dice.below(3) {
        glb.push(
            "samplers",
            json!({"wrapS": dice.pick(&[10_497, 33_071, 33_648]), "magFilter": 9728 + dice.below(2)}),
        );
    }
    for _ in 0..1 + dice.below(2) {
        let mut texture = json!({"source": 0});
        if count(glb, "samplers") > 0 {
            texture["sampler"] = json!(dice.below(count(glb, "samplers")));
        }
        glb.push("textures", texture);
    }
    for _ in 0..1 + dice.below(3) {
        let mut info = json!({"index": dice.below(count(glb, "textures"))});
        if dice.chance(0.3) {
            info["extensions"] =
                json!({"KHR_texture_transform": {"scale": [2, 3], "offset": [0.5, 0], "rotation": 1}});
        }
        let mode = dice.pick(&["OPAQUE", "MASK", "BLEND"]);
        let glossy = json!({"KHR_materials_pbrSpecularGlossiness": {"diffuseTexture": info}});
        let mut material = json!({"alphaMode": mode});
        match dice.below(3) {
            0 => material["extensions"] = glossy,
            1 => {
                material["pbrMetallicRoughness"] =
                    json!({"baseColorTexture": info, "baseColorFactor": [1, 0.5, 0, 1]});
            }
            _ => material["extras"] = json!({"adumbra": {"cast": true}, "a": [1, 2]}),
        }
        glb.push("materials", material);
    }
}

fn mesh(dice: &mut Dice, glb: &mut Glb) {
    let targets = if dice.chance(0.4) { 1 + dice.below(2) } else { 0 };
    let primitives: Vec<Value> = (0..1 + dice.below(2)).map(|_| primitive(dice, glb, targets)).collect();
    let mut mesh = json!({"primitives": primitives});
    if targets > 0 {
        mesh["weights"] = json!((0..targets).map(|_| dice.pick(&[0.0, 1.0, 0.5])).collect::<Vec<_>>());
    }
    if dice.chance(0.5) {
        mesh["name"] = json!("mesh");
    }
    glb.push("meshes", mesh);
}

fn primitive(dice: &mut Dice, glb: &mut Glb, targets: usize) -> Value {
    let vertices = 3 + dice.below(6);
    let mut corners = TRIANGLE.to_vec();
    corners.extend((9..3 * vertices).map(|_| dice.below(8) as f32));
    let positions = positions(dice, glb, &corners);
    let mut attributes = json!({"POSITION": positions});
    if dice.chance(0.5) {
        let uvs: Vec<f32> = (0..2 * vertices).map(|_| dice.below(5) as f32 / 4.0).collect();
        attributes["TEXCOORD_0"] = json!(glb.floats(&uvs, "VEC2"));
    }
    if dice.chance(0.2) {
        let colors: Vec<u8> = (0..4 * vertices).map(|_| dice.below(256) as u8).collect();
        let accessor = glb.accessor(&colors, 5121, "VEC4", vertices);
        glb.json["accessors"][accessor]["normalized"] = json!(true);
        attributes["COLOR_0"] = json!(accessor);
    }
    if dice.chance(0.3) {
        attributes["JOINTS_0"] = json!(glb.accessor(&vec![0; 4 * vertices], 5121, "VEC4", vertices));
        attributes["WEIGHTS_0"] = json!(glb.floats(&[1.0, 0.0, 0.0, 0.0].repeat(vertices), "VEC4"));
    }
    let mut primitive = json!({"attributes": attributes, "mode": 4 + dice.below(3)});
    if dice.chance(0.7) {
        let indices: Vec<usize> = (0..3).chain((0..dice.below(12)).map(|_| dice.below(vertices))).collect();
        primitive["indices"] = json!(match dice.below(3) {
            0 => glb.accessor(
                &indices.iter().map(|&i| i as u8).collect::<Vec<_>>(),
                5121,
                "SCALAR",
                indices.len()
            ),
            1 => {
                let bytes: Vec<u8> = indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect();
                glb.accessor(&bytes, USHORT, "SCALAR", indices.len())
            }
            _ => glb.indices(&indices.iter().map(|&i| i as u32).collect::<Vec<_>>()),
        });
    }
    if targets > 0 {
        let one = |dice: &mut Dice, glb: &mut Glb| {
            // The same displacement for all vertices, so that no triangle loses its area.
            let by = [dice.below(4) as f32, dice.below(4) as f32, 0.0];
            let mut target = json!({"POSITION": glb.floats(&by.repeat(vertices), "VEC3")});
            if dice.chance(0.2) {
                target["COLOR_0"] = target["POSITION"].clone();
            }
            target
        };
        primitive["targets"] = (0..targets).map(|_| one(dice, glb)).collect();
    }
    let materials = count(glb, "materials");
    if materials > 0 && dice.chance(0.8) {
        primitive["material"] = json!(dice.below(materials));
    }
    primitive
}

/// Positions as floats, as integers with a stride, or with sparse elements.
fn positions(dice: &mut Dice, glb: &mut Glb, corners: &[f32]) -> usize {
    let count = corners.len() / 3;
    match dice.below(3) {
        0 => glb.floats(corners, "VEC3"),
        1 => {
            let short = |p: &[f32]| [p[0] as i16, p[1] as i16, p[2] as i16, 0].map(i16::to_le_bytes).concat();
            let bytes: Vec<u8> = corners.chunks_exact(3).flat_map(short).collect();
            let accessor = glb.accessor(&bytes, 5122, "VEC3", count);
            let view = glb.json["accessors"][accessor]["bufferView"].as_u64().unwrap_or_default() as usize;
            glb.json["bufferViews"][view]["byteStride"] = json!(8);
            accessor
        }
        _ => {
            let values = glb.view(&corners.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<_>>());
            let indices = glb.view(&(0..count as u8).collect::<Vec<_>>());
            let sparse = json!({"count": count, "indices": {"bufferView": indices, "componentType": 5121},
                "values": {"bufferView": values}});
            glb.push(
                "accessors",
                json!({"componentType": 5126, "type": "VEC3", "count": count, "sparse": sparse}),
            )
        }
    }
}

fn nodes(dice: &mut Dice, glb: &mut Glb, meshes: usize) {
    glb.json["nodes"] = json!([{"mesh": 0}]);
    let (mut roots, others) = (vec![0], dice.below(7));
    for index in 1..=others {
        let mut node = json!({});
        if dice.chance(0.7) {
            node["mesh"] = json!(dice.below(meshes));
        }
        match dice.below(4) {
            0 => node["translation"] = json!([dice.below(9), 1, 2]),
            1 => node["matrix"] = json!([1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]),
            2 => node["scale"] = json!([1, 2, -1]),
            _ => node["rotation"] = json!([0, 0.6, 0, 0.8]),
        }
        if dice.chance(0.2) {
            node["name"] = json!(format!("n{index}"));
        }
        match dice.below(8) {
            0 => {
                let moves = glb.floats(&[1.0, 0.0, 0.0, 0.0, 2.0, 0.0], "VEC3");
                let custom = glb.floats(&[4.0, 5.0], "SCALAR");
                node["extensions"] =
                    json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moves, "_ID": custom}}});
            }
            1 => node["extensions"] = json!({"KHR_lights_punctual": {"light": 0}}),
            2 => node["extensions"] = json!({"MSFT_lod": {"ids": [1 + dice.below(others)]}}),
            3 => node["extensions"] = json!({"KHR_node_visibility": {"visible": false}}),
            4 if node["mesh"].is_number() => node["skin"] = json!(0),
            _ => {}
        }
        let parent = dice.below(index);
        glb.push("nodes", node);
        if parent > 0 {
            let parent = &mut glb.json["nodes"][parent];
            if !parent["children"].is_array() {
                parent["children"] = json!([]);
            }
            parent["children"].as_array_mut().into_iter().for_each(|list| list.push(json!(index)));
        } else if dice.chance(0.9) {
            roots.push(index);
        }
    }
    glb.json["skins"] = json!([{"joints": [dice.below(others + 1)]}]);
    glb.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "directional"}]}});
    match dice.below(3) {
        0 => glb.json["scenes"] = json!([{"nodes": roots}]),
        1 => {
            glb.json["scenes"] = json!([{}, {"nodes": roots}]);
            glb.json["scene"] = json!(1);
        }
        _ => {
            glb.json["scenes"] = json!([]);
            glb.json["scene"] = json!(null);
        }
    }
}

fn animation(dice: &mut Dice, glb: &mut Glb) {
    let free = |node: &usize| glb.json["nodes"][*node]["matrix"].is_null();
    let nodes: Vec<usize> = (1..count(glb, "nodes")).filter(free).collect();
    if nodes.is_empty() {
        return;
    }
    let (times, moves) =
        (glb.floats(&[0.0, 1.0], "SCALAR"), glb.floats(&[0.0, 0.0, 0.0, 5.0, 0.0, 0.0], "VEC3"));
    let node = dice.pick(&nodes);
    let path = dice.pick(&["translation", "scale", "weights"]);
    let mut channels = vec![json!({"sampler": 0, "target": {"node": node, "path": path}})];
    if dice.chance(0.3) {
        channels.push(json!({"sampler": 0, "target": {"path": "pointer"}}));
    }
    let interpolation = dice.pick(&["LINEAR", "STEP"]);
    let sampler = json!({"input": times, "output": moves, "interpolation": interpolation});
    glb.push("animations", json!({"samplers": [sampler], "channels": channels}));
}

/// A file in its different containers and encodings: a description, the file name and the bytes. Writes the
/// separate file of the buffer.
pub(crate) fn ways_to_write(glb: &Glb, folder: &Path) -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let plain = glb.bytes();
    let mut pointed = glb.clone();
    each_value(&mut pointed.json, &mut |value| {
        if let Value::Number(number) = value {
            *number = number.as_f64().and_then(Number::from_f64).unwrap_or_else(|| number.clone());
        }
    });
    std::fs::write(folder.join("50% of it.bin"), &glb.bin).expect("writes");
    let mut beside = glb.json.clone();
    beside["buffers"][0]["uri"] = json!("50% of%20it.bin");
    let beside = [b"\xef\xbb\xbf", beside.to_string().as_bytes(), b"\n\0"].concat();
    // An unknown chunk before the data.
    let mut chunks = plain.clone();
    let end = 20 + u32::from_le_bytes([plain[12], plain[13], plain[14], plain[15]]) as usize;
    chunks.splice(end..end, *b"\x04\0\0\0METAabcd").for_each(drop);
    let length = (chunks.len() as u32).to_le_bytes();
    chunks[8..12].copy_from_slice(&length);
    vec![
        ("a binary file", "scene.glb", plain),
        ("numbers with a point", "scene.glb", pointed.bytes()),
        ("an unknown chunk", "scene.glb", chunks),
        ("text beside its data", "scene.gltf", beside),
    ]
}
