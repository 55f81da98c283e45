//! Loads PLY (Greg Turk, 1994): ASCII and both binary byte orders, with polygons triangulated. PLY has no names or
//! materials. The node and the mesh get the file's name, and the material is called `default`.

use std::io::BufRead;
use std::path::Path;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use crate::far_origin::{FarOrigin, placed_at};
use crate::polygon::Cutter;
use crate::sources::Sources;
use crate::validate::{Sieve, check_vertex, finish};
use crate::{EmptyReason, Error, Instance, LoadOptions, Material, Mesh, Result, Scene};

/// One element of the file: a vertex's position or a face's corners.
struct Record {
    position: [f64; 3],
    /// The corner list as stored in the file.
    corners: Property,
}

impl PropertyAccess for Record {
    fn new() -> Self {
        Self { position: [0.0; 3], corners: Property::ListUInt(Vec::new()) }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            "vertex_indices" | "vertex_index" => {
                self.corners = property;
                return PropertyAccessResult::Set;
            }
            _ => return PropertyAccessResult::Ignored,
        };
        self.position[axis] = match property {
            Property::Char(v) => f64::from(v),
            Property::UChar(v) => f64::from(v),
            Property::Short(v) => f64::from(v),
            Property::UShort(v) => f64::from(v),
            Property::Int(v) => f64::from(v),
            Property::UInt(v) => f64::from(v),
            Property::Float(v) => f64::from(v),
            Property::Double(v) => v,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// Number of corners in a list.
fn corner_count(list: &Property) -> usize {
    match list {
        Property::ListChar(v) => v.len(),
        Property::ListUChar(v) => v.len(),
        Property::ListShort(v) => v.len(),
        Property::ListUShort(v) => v.len(),
        Property::ListInt(v) => v.len(),
        Property::ListUInt(v) => v.len(),
        _ => 0,
    }
}

/// Loads a `.ply` file.
pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let sources = Sources::new(path, "PLY", options);
    let bytes = sources.read_scene()?;
    let name = path.file_stem().map_or_else(|| "mesh".to_owned(), |s| s.to_string_lossy().into_owned());
    let mut scene = Scene { materials: vec![Material::opaque("default", [1.0; 4])], ..Scene::default() };
    let mut sieve = Sieve::default();
    let mut mesh = Mesh { name: name.clone(), ..Mesh::default() };
    let mut stated = Vec::new();
    let mut skipped = 0;
    let faces = parse(&sources, &bytes, &mut stated, &mut skipped)?;
    scene.notes.omit("faces with fewer than three corners", skipped);
    sources.budget.release(bytes.len() as u64);
    drop(bytes);
    let offset = FarOrigin::of(stated.iter().copied()).offset();
    mesh.positions = stated.iter().map(|p| std::array::from_fn(|a| (p[a] - offset[a]) as f32)).collect();
    sources.budget.release(STATED_BYTES * stated.len() as u64);
    drop(stated);
    if !options.filter.keeps(&name, &name, "default") {
        sieve.filtered = true;
        return finish(path, scene, &sieve, options);
    }
    if faces.ends.is_empty() {
        return Err(Error::NoTriangles { path: path.to_owned(), reason: EmptyReason::PointCloud });
    }
    let mut cutter = Cutter::default();
    let (mut from, mut points) = (0, Vec::new());
    for &end in &faces.ends {
        let corners = &faces.corners[from..end];
        from = end;
        points.clear();
        for &corner in corners {
            let Some(&p) = mesh.positions.get(corner as usize) else {
                return Err(Error::IndexOutOfRange {
                    path: path.to_owned(),
                    mesh: name,
                    index: u64::from(corner),
                    vertices: mesh.positions.len() as u64,
                });
            };
            check_vertex(path, &name, u64::from(corner), p)?;
            points.push(p);
        }
        let mut add = |triangle: [usize; 3]| {
            if sieve.keeps(triangle.map(|i| points[i])) {
                mesh.triangles.push(triangle.map(|i| corners[i]));
            }
        };
        match cutter.cut(&points) {
            Some(triangles) => triangles.iter().for_each(|t| add(t.map(|i| i as usize))),
            None => (2..corners.len()).for_each(|i| add([0, i - 1, i])),
        }
    }
    scene.notes.untriangulated_polygons = cutter.failed;
    drop(faces);
    drop_unused(&mut mesh);
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    scene.meshes.push(mesh);
    scene.instances.push(Instance { name, mesh: 0, world_from_mesh: placed_at(offset), casts: true });
    finish(path, scene, &sieve, options)
}

/// Faces with three or more corners.
#[derive(Default)]
struct Faces {
    /// The corners of all faces, one face after another.
    corners: Vec<u32>,
    /// The end index of each face's corners.
    ends: Vec<usize>,
}

impl Faces {
    /// Adds a face with the corners in a list. The error is a corner that is not a vertex index.
    fn push(&mut self, list: Property) -> Result<(), i64> {
        match list {
            Property::ListChar(v) => self.extend(v),
            Property::ListUChar(v) => self.extend(v),
            Property::ListShort(v) => self.extend(v),
            Property::ListUShort(v) => self.extend(v),
            Property::ListInt(v) => self.extend(v),
            Property::ListUInt(v) => self.extend(v),
            _ => Ok(()),
        }?;
        self.ends.push(self.corners.len());
        Ok(())
    }

    fn extend<T: Into<i64>>(&mut self, corners: Vec<T>) -> Result<(), i64> {
        for corner in corners.into_iter().map(T::into) {
            self.corners.push(u32::try_from(corner).map_err(|_| corner)?);
        }
        Ok(())
    }
}

/// Bytes per vertex: as read, and as kept with its new index.
const VERTEX_BYTES: u64 = 28;
/// Bytes per vertex as stated in the file, held until its mesh is built.
const STATED_BYTES: u64 = 24;
/// Bytes per corner: as read, and its part of a triangle.
const CORNER_BYTES: u64 = 20;

/// Reads the positions and the faces.
fn parse(
    sources: &Sources<'_>,
    bytes: &[u8],
    positions: &mut Vec<[f64; 3]>,
    skipped: &mut u64,
) -> Result<Faces> {
    let bad = |what: String| sources.bad(what);
    let unreadable = |e: ParseError| bad(e.to_string().split_whitespace().collect::<Vec<_>>().join(" "));
    let parser = Parser::<Record>::new();
    let mut reader = Reader::new(bytes);
    let header = parser.read_header(&mut reader).map_err(unreadable)?;
    let mut faces = Faces::default();
    for (_, element) in &header.elements {
        let (count, stated) = (element.count, &element.name);
        let least = least_size(element, header.encoding);
        if least == 0 && count > 0 {
            return Err(bad(format!("element {stated} has no properties")));
        }
        if count.checked_mul(least).is_none_or(|n| n > reader.get_ref().len() + 1) {
            return Err(bad(format!(
                "it states {count} records of element {stated}, more than the file can hold"
            )));
        }
        let is_vertex = stated == "vertex";
        if is_vertex && !["x", "y", "z"].iter().all(|&axis| element.properties.contains_key(axis)) {
            return Err(bad("its vertices have no x, y and z".to_owned()));
        }
        if is_vertex {
            let bytes = (VERTEX_BYTES + STATED_BYTES) * count as u64;
            sources.budget.charge(bytes, || format!("{count} vertices"))?;
            positions.reserve_exact(count);
        }
        for i in 0..count {
            let record = read_record(&parser, &mut reader, element, header.encoding)
                .map_err(|e| bad(format!("{stated} {i} of {count}: {}", one_line(&e))))?;
            let corners = corner_count(&record.corners);
            if is_vertex {
                positions.push(record.position);
            } else if stated == "face" && corners < 3 {
                *skipped += 1;
            } else if stated == "face" {
                let all = faces.corners.len() + corners;
                sources.budget.charge(CORNER_BYTES * corners as u64, || format!("{all} corners of faces"))?;
                faces
                    .push(record.corners)
                    .map_err(|corner| bad(format!("face {i} uses vertex {corner}, which does not exist")))?;
            }
        }
    }
    Ok(faces)
}

fn read_record(
    parser: &Parser<Record>,
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    encoding: Encoding,
) -> Result<Record, ParseError> {
    match encoding {
        Encoding::BinaryLittleEndian => parser.read_little_endian_element(reader.get_mut(), element),
        Encoding::BinaryBigEndian => parser.read_big_endian_element(reader.get_mut(), element),
        Encoding::Ascii => {
            let mut line = String::new();
            // Empty lines contain no element.
            while reader.get_mut().read_line(&mut line)? > 0 && line.trim().is_empty() {
                line.clear();
            }
            parser.read_ascii_element(line.trim(), element)
        }
    }
}

fn one_line(e: &ParseError) -> String {
    e.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The minimum size of one element, bytes.
fn least_size(element: &ElementDef, encoding: Encoding) -> usize {
    let size = |s: &ScalarType| match (encoding, s) {
        (Encoding::Ascii, _) => 2,
        (_, ScalarType::Char | ScalarType::UChar) => 1,
        (_, ScalarType::Short | ScalarType::UShort) => 2,
        (_, ScalarType::Int | ScalarType::UInt | ScalarType::Float) => 4,
        (_, ScalarType::Double) => 8,
    };
    let of = |t: &PropertyType| match t {
        PropertyType::Scalar(s) | PropertyType::List(s, _) => size(s),
    };
    element.properties.iter().map(|(_, p)| of(&p.data_type)).sum()
}

/// Removes vertices that no triangle uses, which have not been validated.
fn drop_unused(mesh: &mut Mesh) {
    let mut new_index = vec![u32::MAX; mesh.positions.len()];
    for &corner in mesh.triangles.iter().flatten() {
        if let Some(slot) = new_index.get_mut(corner as usize) {
            *slot = 0;
        }
    }
    let mut next = 0;
    let mut kept = Vec::with_capacity(new_index.iter().filter(|&&i| i == 0).count());
    for (slot, &p) in new_index.iter_mut().zip(&mesh.positions) {
        if *slot == 0 {
            *slot = next;
            next += 1;
            kept.push(p);
        }
    }
    mesh.positions = kept;
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = new_index.get(*corner as usize).copied().unwrap_or_default();
    }
}
