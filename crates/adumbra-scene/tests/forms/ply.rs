//! Models as PLY.

use std::fmt::Write;

use crate::Form;
use crate::model::Mesh;

pub(crate) const FORMS: &[Form] = &[
    ("PLY, text", "scene.ply", |m| one(text(&m.flattened(), "\n"))),
    ("PLY, text, a record over several lines", "scene.ply", |m| {
        let bytes = text(&m.flattened(), "\n");
        let text = String::from_utf8(bytes).expect("is text");
        let (head, body) = text.split_once("end_header\n").expect("has a header");
        one(format!("{head}end_header\n{}", body.replace(' ', "\n")).into_bytes())
    }),
    ("PLY, little-endian", "scene.ply", |m| one(binary(&m.flattened(), true, false))),
    ("PLY, big-endian", "scene.ply", |m| one(binary(&m.flattened(), false, false))),
    ("PLY, faces before vertices", "scene.ply", |m| one(binary(&m.flattened(), true, true))),
    ("PLY, strips", "scene.ply", |m| one(strips(&m.flattened()))),
];

fn one(bytes: Vec<u8>) -> Vec<(String, Vec<u8>)> {
    vec![("scene.ply".to_owned(), bytes)]
}

fn text(mesh: &Mesh, end: &str) -> Vec<u8> {
    let (vertices, faces) = (mesh.positions.len(), mesh.faces.len());
    let mut out = [
        "ply",
        "format ascii 1.0",
        "comment \u{e9}",
        &format!("element vertex {vertices}"),
        "property double x",
        "property uchar red",
        "property double y",
        "property double z",
        &format!("element face {faces}"),
        "property list uchar int vertex_indices",
        "end_header",
        "",
    ]
    .join(end);
    for [x, y, z] in &mesh.positions {
        let _ = write!(out, "{x} 0.5 {y} {z}{end}");
    }
    for face in &mesh.faces {
        let _ = write!(out, "{}", face.len());
        for corner in face {
            let _ = write!(out, " {corner}");
        }
        out.push_str(end);
    }
    out.into_bytes()
}

fn binary(mesh: &Mesh, little: bool, faces_first: bool) -> Vec<u8> {
    let order = if little { "little" } else { "big" };
    let vertex = format!(
        "element vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty double nx\n",
        mesh.positions.len()
    );
    let face = format!(
        "element face {}\nproperty uchar flags\nproperty list ushort uint vertex_index\n",
        mesh.faces.len()
    );
    let (first, second) = if faces_first { (face, vertex) } else { (vertex, face) };
    let mut out = format!("ply\nformat binary_{order}_endian 1.0\n{first}{second}end_header\n").into_bytes();
    let turn = |bytes: &mut [u8]| {
        if !little {
            bytes.reverse();
        }
    };
    let put = |out: &mut Vec<u8>, bytes: &[u8]| {
        let from = out.len();
        out.extend_from_slice(bytes);
        turn(&mut out[from..]);
    };
    let mut vertices = Vec::new();
    for p in &mesh.positions {
        p.iter().for_each(|&c| put(&mut vertices, &(c as f32).to_le_bytes()));
        put(&mut vertices, &f64::NAN.to_le_bytes());
    }
    let mut faces = Vec::new();
    for face in &mesh.faces {
        faces.push(7);
        put(&mut faces, &(face.len() as u16).to_le_bytes());
        face.iter().for_each(|&c| put(&mut faces, &(c as u32).to_le_bytes()));
    }
    let (first, second) = if faces_first { (faces, vertices) } else { (vertices, faces) };
    out.extend(first);
    out.extend(second);
    out
}

/// Triangles as strips of one triangle, rectangles as strips of two, all in one record, separated by -1.
fn strips(mesh: &Mesh) -> Vec<u8> {
    let mut strip: Vec<i32> = Vec::new();
    for face in &mesh.faces {
        let corners: Vec<usize> = match face[..] {
            // The second triangle of a strip is reversed: b c a, then c d a.
            [a, b, c, d] => vec![b, c, a, d],
            _ => face.clone(),
        };
        strip.extend(corners.iter().map(|&c| c as i32));
        strip.push(-1);
    }
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element tristrips 1\nproperty list int int vertex_indices\nend_header\n",
        mesh.positions.len()
    )
    .into_bytes();
    out.extend(mesh.positions.iter().flatten().flat_map(|&c| (c as f32).to_le_bytes()));
    out.extend((strip.len() as i32).to_le_bytes());
    out.extend(strip.iter().flat_map(|c| c.to_le_bytes()));
    out
}
