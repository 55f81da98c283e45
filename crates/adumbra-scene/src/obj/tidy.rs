//! Rewrites OBJ and MTL text to a plain subset: one statement per line, absolute indices that exist, positions of three
//! numbers, and no normals, colours, lines or points.
//!
//! Vertices come first in the result, so that faces may precede them in the file.

use std::borrow::Cow;
use std::io::Write;
use std::str::FromStr;

use hashbrown::HashMap;

use crate::error::{Error, Result};
use crate::far_origin::FarOrigin;
use crate::polygon::Cutter;
use crate::sources::Sources;

/// A tidied OBJ file.
#[derive(Default)]
pub(super) struct Object {
    /// The OBJ text.
    pub(super) text: Vec<u8>,
    /// Names of objects and groups, each once. The text holds their indices instead, because the parser copies an
    /// object's name for each change of material.
    pub(super) names: Vec<String>,
    /// Number of objects, groups and changes of material; each becomes a model in the parser.
    pub(super) models: u64,
    /// Material libraries, each once.
    pub(super) libraries: Vec<String>,
    /// Names of the materials used, each once.
    pub(super) materials: Vec<String>,
    /// Skipped statements: lines, points, and faces with fewer than three corners.
    pub(super) skipped: u64,
    /// Polygons that could not be triangulated.
    pub(super) untriangulated: u64,
    /// Number of positions in the file.
    pub(super) vertices: u64,
    /// Number of triangles in its faces.
    pub(super) triangles: u64,
    /// The offset subtracted from the positions if they are far from zero; otherwise 0.
    pub(super) offset: [f64; 3],
}

/// The object of faces that precede any name.
const UNNAMED: &str = "unnamed_object";

/// The keyword that references a material library, used in errors.
pub(super) const LIBRARY: &str = "mtllib";

/// Statements of an MTL file that reference a texture, in addition to those that begin with `map_`.
const OTHER_MAPS: [&str; 5] = ["bump", "disp", "decal", "refl", "norm"];

/// Distinct names in the order of their first use.
#[derive(Default)]
struct Names {
    list: Vec<String>,
    known: HashMap<String, u32>,
}

impl Names {
    /// The index of a name, which is added if it is new.
    fn remember(&mut self, name: &str) -> u32 {
        let next = self.list.len() as u32;
        let number = *self.known.entry_ref(name).or_insert(next);
        if number == next {
            self.list.push(name.to_owned());
        }
        number
    }
}

/// Tidies an OBJ file. Texture coordinates are dropped unless `with_uvs`, because they split vertices. Polygons that a
/// fan would not cover are triangulated.
pub(super) fn object(sources: &Sources<'_>, bytes: &[u8], with_uvs: bool) -> Result<Object> {
    let text = String::from_utf8_lossy(bytes);
    let bad = |line: usize, what: &str, rest: &str| {
        sources.bad(format!("line {line}: {what}: {:?}", shorten(rest)))
    };
    let stated = statements(&text).filter(|(_, keyword, _)| keyword == "v");
    let offset = FarOrigin::of(stated.filter_map(|(_, _, rest)| numbers(&rest))).offset();
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let mut head = b"mtllib all\n".to_vec();
    // Faces without texture coordinates use the first entry, which is a dummy.
    let (mut uv_lines, mut uvs) = (b"vt 0 0\n".to_vec(), 0);
    for (line, keyword, rest) in statements(&text) {
        match keyword.as_ref() {
            "v" => {
                let p: [f64; 3] =
                    numbers(&rest).ok_or_else(|| bad(line, "a vertex needs three numbers", &rest))?;
                let [x, y, z] = std::array::from_fn(|a| (p[a] - offset[a]) as f32);
                positions.push([x, y, z]);
                if offset != [0.0; 3] {
                    line_of(&mut head, format_args!("v {x:e} {y:e} {z:e}"));
                    continue;
                }
                head.push(b'v');
                // Copied as written, since some numbers would otherwise be far longer.
                for word in rest.split_whitespace().take(3) {
                    head.push(b' ');
                    head.extend_from_slice(word.as_bytes());
                }
                head.push(b'\n');
            }
            "vt" => {
                uvs += 1;
                if with_uvs {
                    let [u, v] = numbers::<f32, 2>(&rest)
                        .or_else(|| numbers::<f32, 1>(&rest).map(|[u]| [u, 0.0]))
                        .unwrap_or_default();
                    line_of(&mut uv_lines, format_args!("vt {u:e} {v:e}"));
                }
            }
            _ => {}
        }
    }
    if with_uvs {
        head.append(&mut uv_lines);
    }
    let mut out = Object { text: head, vertices: positions.len() as u64, offset, ..Object::default() };
    let (mut libraries, mut materials) = (Names::default(), Names::default());
    let mut faces = Faces {
        positions: &positions,
        with_uvs,
        corners: Vec::new(),
        points: Vec::new(),
        room: 0,
        cutter: Cutter::default(),
    };
    let mut names = Names::default();
    let mut name = names.remember(UNNAMED);
    let (mut vertices_so_far, mut uvs_so_far) = (0, 0);
    for (line, keyword, rest) in statements(&text) {
        match keyword.as_ref() {
            "v" => vertices_so_far += 1,
            "vt" => uvs_so_far += 1,
            "o" | "g" => {
                name = names.remember(if rest.is_empty() { UNNAMED } else { &rest });
                out.models += 1;
                line_of(&mut out.text, format_args!("o {name}"));
            }
            "usemtl" if !rest.is_empty() => {
                materials.remember(&rest);
                out.models += 1;
                line_of(&mut out.text, format_args!("usemtl {rest}"));
            }
            "mtllib" if !rest.is_empty() => {
                note_named(&rest, |name| crate::obj::note_named(sources, name))?;
                // A library's name may contain spaces, or there may be several names.
                let several = rest.contains(char::is_whitespace)
                    && crate::obj::locate(sources, LIBRARY, &rest).is_err();
                if several {
                    for name in rest.split_whitespace() {
                        libraries.remember(name);
                    }
                } else {
                    libraries.remember(&rest);
                }
            }
            "l" | "p" => out.skipped += 1,
            "f" => {
                let count = rest.split_whitespace().count();
                if count < 3 {
                    out.skipped += 1;
                    continue;
                }
                faces.make_room(sources, count)?;
                for corner in rest.split_whitespace() {
                    let mut parts = corner.split('/');
                    let v = parts.next().and_then(|p| absolute(p, vertices_so_far));
                    let v = v.ok_or_else(|| bad(line, "a face's corner is not a vertex index", &rest))?;
                    if v > positions.len() {
                        let (index, vertices) = (v as u64, positions.len() as u64);
                        let path = sources.scene.to_owned();
                        let mesh = names.list.swap_remove(name as usize);
                        return Err(Error::IndexOutOfRange { path, mesh, index, vertices });
                    }
                    let uv = parts.next().and_then(|p| absolute(p, uvs_so_far)).filter(|&i| i <= uvs);
                    faces.corners.push((v, uv.map_or(1, |i| i + 1)));
                }
                out.triangles += faces.corners.len() as u64 - 2;
                faces.write(&mut out.text);
            }
            _ => {}
        }
    }
    sources.budget.release(faces.room as u64 * CORNER_BYTES);
    out.untriangulated = faces.cutter.failed;
    (out.libraries, out.materials, out.names) = (libraries.list, materials.list, names.list);
    Ok(out)
}

/// Writes faces.
struct Faces<'a> {
    positions: &'a [[f32; 3]],
    with_uvs: bool,
    /// Position and texture-coordinate indices of each corner, starting at 1.
    corners: Vec<(usize, usize)>,
    points: Vec<[f32; 3]>,
    /// Number of corners that memory is charged for.
    room: usize,
    cutter: Cutter,
}

/// Memory per corner while its face is written, bytes.
const CORNER_BYTES: u64 = size_of::<((usize, usize), [f32; 3])>() as u64;

impl Faces<'_> {
    /// Starts a face with this many corners.
    fn make_room(&mut self, sources: &Sources<'_>, corners: usize) -> Result<()> {
        self.corners.clear();
        if let Some(more) = corners.checked_sub(self.room) {
            sources.budget.charge(more as u64 * CORNER_BYTES, || format!("a face of {corners} corners"))?;
            self.corners.reserve_exact(corners);
            self.room = corners;
        }
        Ok(())
    }

    /// Writes the current face: unchanged if a fan covers it, otherwise as triangles.
    fn write(&mut self, out: &mut Vec<u8>) {
        self.points.clear();
        if self.corners.len() > 3 {
            self.points.extend(self.corners.iter().map(|&(v, _)| self.positions[v - 1]));
        }
        let (corners, with_uvs) = (&self.corners, self.with_uvs);
        let mut face = |numbers: &mut dyn Iterator<Item = usize>| {
            out.push(b'f');
            for (v, uv) in numbers.map(|i| corners[i]) {
                // Writing to memory cannot fail.
                let _ = if with_uvs { write!(out, " {v}/{uv}") } else { write!(out, " {v}") };
            }
            out.push(b'\n');
        };
        match self.cutter.cut(&self.points) {
            Some(triangles) => {
                triangles.iter().for_each(|t| face(&mut t.iter().map(|&corner| corner as usize)));
            }
            None => face(&mut (0..corners.len())),
        }
    }
}

/// Tidies an MTL file: keeps names, diffuse colours, dissolve, and their texture maps.
pub(super) fn materials(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for (_, keyword, rest) in statements(&String::from_utf8_lossy(bytes)) {
        let last = rest.split_whitespace().last().unwrap_or_default();
        let map = if rest.starts_with('-') { last } else { rest.as_ref() };
        match keyword.as_ref() {
            "newmtl" if !rest.is_empty() => line_of(&mut out, format_args!("newmtl {rest}")),
            "Kd" => {
                if let Some([r, g, b]) = numbers::<f32, 3>(&rest) {
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

/// Calls `note` with every string that may name a texture of any kind in an MTL file.
pub(super) fn named(bytes: &[u8], mut note: impl FnMut(&str) -> Result<()>) -> Result<()> {
    for (_, keyword, rest) in statements(&String::from_utf8_lossy(bytes)) {
        let keyword = keyword.to_ascii_lowercase();
        if keyword.starts_with("map_") || OTHER_MAPS.contains(&keyword.as_str()) {
            note_named(&rest, &mut note)?;
        }
    }
    Ok(())
}

/// Calls `note` with the rest of a statement, because a name may contain spaces, and with each of its words, because
/// there may be several names or options before the name.
fn note_named(rest: &str, mut note: impl FnMut(&str) -> Result<()>) -> Result<()> {
    std::iter::once(rest).chain(rest.split_whitespace()).try_for_each(&mut note)
}

/// The statements as line number, keyword and rest; a line that ends in a backslash continues on the next.
fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let line = line.trim();
        let Some(start) = line.strip_suffix('\\') else { return Some((number + 1, Cow::Borrowed(line))) };
        let mut joined = start.to_owned();
        for (_, next) in lines.by_ref() {
            joined.push(' ');
            joined.push_str(next.trim());
            if !joined.ends_with('\\') {
                break;
            }
            joined.pop();
        }
        Some((number + 1, Cow::Owned(joined)))
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

fn numbers<T: Copy + Default + FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let mut words = text.split_whitespace();
    let mut out = [T::default(); N];
    for value in &mut out {
        *value = words.next()?.parse().ok()?;
    }
    Some(out)
}

/// Converts an index to an absolute one, counted from 1; negative indices count back from the last element so far.
fn absolute(text: &str, so_far: usize) -> Option<usize> {
    let index: i64 = text.parse().ok()?;
    if index > 0 {
        return usize::try_from(index).ok();
    }
    let back = usize::try_from(index.checked_neg()?).ok()?;
    if back == 0 { None } else { (so_far + 1).checked_sub(back).filter(|&i| i > 0) }
}

fn line_of(out: &mut Vec<u8>, line: std::fmt::Arguments<'_>) {
    // Writing to memory cannot fail.
    let _ = writeln!(out, "{line}");
}

fn shorten(text: &str) -> String {
    text.chars().take(60).collect()
}
