//! Models as Wavefront OBJ.

use std::fmt::Write;

use crate::Form;
use crate::model::Mesh;

pub(crate) const FORMS: &[Form] = &[
    ("OBJ", "scene.obj", |m| one(text(&m.flattened(), "\n", false).into_bytes())),
    ("OBJ, CR LF, relative indices", "scene.obj", |m| one(text(&m.flattened(), "\r\n", true).into_bytes())),
    ("OBJ, CR, byte-order mark", "scene.obj", |m| {
        one(["\u{feff}".to_owned(), text(&m.flattened(), "\r", true)].concat().into_bytes())
    }),
    ("OBJ, UTF-16", "scene.obj", |m| {
        let text = ["\u{feff}".to_owned(), text(&m.flattened(), "\n", false)].concat();
        one(text.encode_utf16().flat_map(u16::to_le_bytes).collect())
    }),
    ("OBJ, a statement over several lines", "scene.obj", |m| {
        one(text(&m.flattened(), "\n", false).replace("f ", "f \\\n").into_bytes())
    }),
];

fn one(bytes: Vec<u8>) -> Vec<(String, Vec<u8>)> {
    vec![("scene.obj".to_owned(), bytes)]
}

fn text(mesh: &Mesh, end: &str, relative: bool) -> String {
    let mut out = format!("# C:\\models\\{end}o all{end}");
    for [x, y, z] in &mesh.positions {
        let _ = write!(out, "v {x} {y} {z}{end}");
    }
    for (i, face) in mesh.faces.iter().enumerate() {
        if i % 5 == 3 {
            let _ = write!(out, "g part{i}{end}");
        }
        out.push_str("f ");
        for &corner in face {
            let number =
                if relative { corner as i64 - mesh.positions.len() as i64 } else { corner as i64 + 1 };
            let _ = write!(out, "{number} ");
        }
        let _ = write!(out, "# {i}{end}");
    }
    out
}
