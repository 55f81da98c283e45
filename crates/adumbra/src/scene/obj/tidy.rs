//! Rewrites OBJ and MTL text to a plain subset: one statement a line, absolute indices that exist, positions of
//! three numbers, no normals, colours, lines or points.
//!
//! Vertices come first in the result, so that faces may come before them in the file.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};

/// A tidied OBJ file.
#[derive(Default)]
pub(super) struct Object {
    /// The OBJ text.
    pub(super) text: Vec<u8>,
    /// Material libraries, each once.
    pub(super) libraries: Vec<String>,
    /// Names of the materials used, each once.
    pub(super) materials: Vec<String>,
    /// Lines, points, and faces with fewer than three corners.
    pub(super) skipped: u64,
}

/// Tidies an OBJ file; texture coordinates are dropped unless `with_uvs`, because they split vertices.
pub(super) fn object(path: &Path, bytes: &[u8], with_uvs: bool) -> Result<Object> {
    let text = String::from_utf8_lossy(bytes);
    let total = |keyword: &str| statements(&text).filter(|(_, k, _)| k == keyword).count();
    let (vertices, uvs) = (total("v"), total("vt"));
    let mut out = Object { text: b"mtllib all\n".to_vec(), ..Object::default() };
    let mut head = std::mem::take(&mut out.text);
    // Faces without texture coordinates take the first, which is made up.
    let (mut uv_lines, mut body) = (b"vt 0 0\n".to_vec(), Vec::new());
    let mut name = "unnamed_object".to_owned();
    let (mut vertices_so_far, mut uvs_so_far) = (0, 0);
    for (line, keyword, rest) in statements(&text) {
        let bad = |what: &str| Error::SceneParse {
            path: path.to_owned(),
            format: "OBJ",
            what: format!("line {line}: {what}: {:?}", shorten(&rest)),
        };
        match keyword.as_ref() {
            "v" => {
                vertices_so_far += 1;
                let p = numbers::<3>(&rest).ok_or_else(|| bad("a vertex needs three numbers"))?;
                line_of(&mut head, format_args!("v {} {} {}", p[0], p[1], p[2]));
            }
            "vt" => {
                uvs_so_far += 1;
                let [u, v] = numbers::<2>(&rest)
                    .or_else(|| numbers::<1>(&rest).map(|[u]| [u, 0.0]))
                    .unwrap_or_default();
                line_of(&mut uv_lines, format_args!("vt {u} {v}"));
            }
            "o" | "g" => {
                name = if rest.is_empty() { "unnamed_object".to_owned() } else { rest.to_string() };
                line_of(&mut body, format_args!("o {name}"));
            }
            "usemtl" if !rest.is_empty() => {
                remember(&mut out.materials, &rest);
                line_of(&mut body, format_args!("usemtl {rest}"));
            }
            "mtllib" if !rest.is_empty() => libraries(path, &rest, &mut out.libraries),
            "l" | "p" => out.skipped += 1,
            "f" if rest.split_whitespace().count() < 3 => out.skipped += 1,
            "f" => {
                body.push(b'f');
                for corner in rest.split_whitespace() {
                    let mut parts = corner.split('/');
                    let v = parts.next().and_then(|p| absolute(p, vertices_so_far));
                    let v = v.ok_or_else(|| bad("a face's corner is not a vertex index"))?;
                    if v > vertices {
                        let (index, vertices) = (v as u64, vertices as u64);
                        return Err(Error::IndexOutOfRange {
                            path: path.to_owned(),
                            mesh: name,
                            index,
                            vertices,
                        });
                    }
                    let uv = parts.next().and_then(|p| absolute(p, uvs_so_far)).filter(|&i| i <= uvs);
                    // Writing to memory does not fail.
                    let _ = if with_uvs {
                        write!(body, " {v}/{}", uv.map_or(1, |i| i + 1))
                    } else {
                        write!(body, " {v}")
                    };
                }
                body.push(b'\n');
            }
            _ => {}
        }
    }
    if with_uvs {
        head.append(&mut uv_lines);
    }
    head.append(&mut body);
    out.text = head;
    Ok(out)
}

/// Tidies an MTL file: names, diffuse colours, dissolve, and the maps of those.
pub(super) fn materials(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for (_, keyword, rest) in statements(&String::from_utf8_lossy(bytes)) {
        let last = rest.split_whitespace().last().unwrap_or_default();
        let map = if rest.starts_with('-') { last } else { rest.as_ref() };
        match keyword.as_ref() {
            "newmtl" if !rest.is_empty() => line_of(&mut out, format_args!("newmtl {rest}")),
            "Kd" => {
                if let Some([r, g, b]) = numbers(&rest) {
                    line_of(&mut out, format_args!("Kd {r} {g} {b}"));
                }
            }
            "d" | "Tr" => {
                if let Ok(value) = last.parse::<f32>() {
                    let dissolve = if keyword == "d" { value } else { 1.0 - value };
                    line_of(&mut out, format_args!("d {dissolve}"));
                }
            }
            "map_Kd" | "map_d" if !map.is_empty() => line_of(&mut out, format_args!("{keyword} {map}")),
            _ => {}
        }
    }
    out
}

/// Statements as line number, keyword and the rest; lines that end in a backslash go on.
fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let mut whole = Cow::Borrowed(line.trim());
        while let Some(start) = whole.strip_suffix('\\') {
            let mut joined = start.to_owned();
            if let Some((_, next)) = lines.next() {
                joined.push(' ');
                joined.push_str(next.trim());
            }
            whole = Cow::Owned(joined);
        }
        Some((number + 1, whole))
    })
    .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
    .map(|(number, line)| match line {
        Cow::Borrowed(line) => {
            let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            (number, Cow::Borrowed(keyword), Cow::Borrowed(rest.trim()))
        }
        Cow::Owned(line) => {
            let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((&line, ""));
            (number, Cow::Owned(keyword.to_owned()), Cow::Owned(rest.trim().to_owned()))
        }
    })
}

fn numbers<const N: usize>(text: &str) -> Option<[f32; N]> {
    let mut words = text.split_whitespace();
    let mut out = [0.0; N];
    for value in &mut out {
        *value = words.next()?.parse().ok()?;
    }
    Some(out)
}

/// An index counted from 1; negative ones count back from the last so far.
fn absolute(text: &str, so_far: usize) -> Option<usize> {
    let index: i64 = text.parse().ok()?;
    if index > 0 {
        return usize::try_from(index).ok();
    }
    let back = usize::try_from(index.checked_neg()?).ok()?;
    if back == 0 { None } else { (so_far + 1).checked_sub(back).filter(|&i| i > 0) }
}

/// A library's name may hold spaces, or there may be several names.
fn libraries(path: &Path, rest: &str, known: &mut Vec<String>) {
    if super::beside(path, rest).is_file() || !rest.contains(char::is_whitespace) {
        remember(known, rest);
    } else {
        rest.split_whitespace().for_each(|name| remember(known, name));
    }
}

fn remember(names: &mut Vec<String>, name: &str) {
    if !names.iter().any(|n| n == name) {
        names.push(name.to_owned());
    }
}

fn line_of(out: &mut Vec<u8>, line: std::fmt::Arguments<'_>) {
    // Writing to memory does not fail.
    let _ = writeln!(out, "{line}");
}

fn shorten(text: &str) -> String {
    text.chars().take(60).collect()
}
