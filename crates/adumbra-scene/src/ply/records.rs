//! The records of a PLY file: vertices, faces and triangle strips are kept, all others are skipped and
//! counted.
//!
//! Turk's definition names the elements `vertex` and `face` and the list `vertex_indices`. His tools and
//! those of Stanford's scanning repository also write `tristrips`, whose list holds strips that -1 separates.

use std::path::Path;

use super::header::{Element, Format, Header, Kind, Property, shown};
use super::polygons::Polygons;
use super::values::{Binary, Fault, Text, Values};
use crate::sources::Sources;
use crate::{Error, LoadNotes, Result};

/// Bytes per vertex as stated in the file.
pub(super) const STATED_BYTES: u64 = 24;
/// Bytes per vertex of the mesh: twice its position and once its new index.
pub(super) const VERTEX_BYTES: u64 = 28;

/// The records that are kept from a file.
#[derive(Debug, Default)]
pub(super) struct Records {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) faces: Polygons,
    pub(super) strips: Polygons,
}

/// Reads all records, and notes the omissions. Every corner that is kept is the index of a vertex.
pub(super) fn read(
    sources: &Sources<'_>,
    bytes: &[u8],
    mesh: &str,
    notes: &mut LoadNotes,
) -> Result<Records> {
    let header = Header::parse(sources, bytes)?;
    let body = bytes.get(header.body..).unwrap_or_default();
    let counts = header.elements.iter().filter(|e| e.name == b"vertex").map(|e| e.count);
    let vertices = counts.fold(0, u64::saturating_add);
    let job = Job { sources, mesh, vertices };
    match header.format {
        Format::Ascii => job.read(&header, Text::new(bytes, header.body), notes),
        Format::LittleEndian => job.read(&header, Binary::<false>::new(body), notes),
        Format::BigEndian => job.read(&header, Binary::<true>::new(body), notes),
    }
}

/// How a property is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    Skip,
    /// This coordinate of a vertex.
    Axis(usize),
    /// The corners of a face.
    Face,
    /// The corners of strips.
    Strips,
}

/// Why a record cannot be read.
enum Stop {
    Value(Fault),
    /// A list has this many items, a negative number.
    Length(i64),
    /// A list has this many items, more than the file can hold.
    LongList(i64),
    /// A face uses a vertex that does not exist.
    NoVertex(i64),
    Other(Error),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Self {
        Self::Value(fault)
    }
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Other(error)
    }
}

/// The records read so far.
#[derive(Default)]
struct Progress {
    records: Records,
    small_faces: u64,
    small_strips: u64,
}

struct Job<'a> {
    sources: &'a Sources<'a>,
    mesh: &'a str,
    /// Number of vertices as the header states it.
    vertices: u64,
}

impl Job<'_> {
    fn read<V: Values>(&self, header: &Header<'_>, mut values: V, notes: &mut LoadNotes) -> Result<Records> {
        let mut progress = Progress::default();
        for element in header.elements.iter().filter(|e| e.count > 0) {
            let plan = self.plan(element)?;
            if let Some(what) = omission(element, &plan) {
                notes.omit(what, element.count);
            }
            self.read_element(element, &plan, &mut values, &mut progress)?;
        }
        notes.omit("faces with fewer than three corners", progress.small_faces);
        notes.omit("triangle strips with fewer than three corners", progress.small_strips);
        notes.omit("values after the last record", values.count_rest());
        Ok(progress.records)
    }

    /// The use of each property.
    fn plan(&self, element: &Element<'_>) -> Result<Vec<Use>> {
        if element.properties.is_empty() {
            let name = shown(element.name);
            return Err(self.sources.bad(format!("element \"{name}\" has records but no properties")));
        }
        let mut plan = vec![Use::Skip; element.properties.len()];
        let mut set = |at: Option<usize>, to: Use| at.and_then(|at| plan.get_mut(at)).map(|slot| *slot = to);
        match element.name {
            b"vertex" => {
                for (axis, name) in [b"x", b"y", b"z"].into_iter().enumerate() {
                    let at = element.properties.iter().position(|p| p.name == name && p.list.is_none());
                    if set(at, Use::Axis(axis)).is_none() {
                        return Err(self.sources.bad("its vertices have no x, y and z"));
                    }
                }
            }
            b"face" => drop(set(corner_list(&element.properties), Use::Face)),
            b"tristrips" => drop(set(corner_list(&element.properties), Use::Strips)),
            _ => {}
        }
        Ok(plan)
    }

    fn read_element<V: Values>(
        &self,
        element: &Element<'_>,
        plan: &[Use],
        values: &mut V,
        progress: &mut Progress,
    ) -> Result<()> {
        let least: usize = element.properties.iter().map(|p| V::least(p.list.unwrap_or(p.kind))).sum();
        // The last value of a text needs no separator.
        let fits = element.count.checked_mul(least as u64).is_some_and(|n| n <= values.left() as u64 + 1);
        if !fits {
            return Err(self.cut_off(element, values));
        }
        let is_vertex = element.name == b"vertex";
        if is_vertex {
            let all = progress.records.positions.len() as u64 + element.count;
            let bytes = (VERTEX_BYTES + STATED_BYTES).saturating_mul(element.count);
            self.sources.budget.charge(bytes, || format!("{all} vertices"))?;
            progress.records.positions.reserve_exact(element.count as usize);
        }
        for index in 0..element.count {
            let mut position = [0.0; 3];
            for (property, &task) in element.properties.iter().zip(plan) {
                self.read_property(property, task, values, &mut position, progress)
                    .map_err(|stop| self.error(stop, element, index, property, values.line()))?;
            }
            if is_vertex {
                progress.records.positions.push(position);
            }
        }
        Ok(())
    }

    /// The error for an element that has more records than the file can hold. Nothing is kept, because this
    /// only finds the record that is cut off.
    fn cut_off<V: Values>(&self, element: &Element<'_>, values: &mut V) -> Error {
        let (mut nowhere, mut nothing) = ([0.0; 3], Progress::default());
        for index in 0..element.count {
            for property in &element.properties {
                let skipped = self.read_property(property, Use::Skip, values, &mut nowhere, &mut nothing);
                if let Err(stop) = skipped {
                    return self.error(stop, element, index, property, values.line());
                }
            }
        }
        let (name, count) = (shown(element.name), element.count);
        self.sources.bad(format!("it has {count} records of element \"{name}\", more than the file can hold"))
    }

    fn read_property<V: Values>(
        &self,
        property: &Property<'_>,
        task: Use,
        values: &mut V,
        position: &mut [f64; 3],
        progress: &mut Progress,
    ) -> Result<(), Stop> {
        let kind = property.kind;
        let Some(count_kind) = property.list else {
            match task {
                Use::Axis(axis) => position[axis] = values.number(kind)?,
                _ => values.skip(1, kind)?,
            }
            return Ok(());
        };
        let stated = values.whole(count_kind)?;
        let count = usize::try_from(stated).map_err(|_| Stop::Length(stated))?;
        if count.checked_mul(V::least(kind)).is_none_or(|n| n > values.left() + 1) {
            return Err(Stop::LongList(stated));
        }
        match task {
            Use::Face if count < 3 => {
                progress.small_faces += 1;
                values.skip(count, kind)?;
            }
            Use::Face => {
                let faces = &mut progress.records.faces;
                faces.make_room(count, &self.sources.budget)?;
                for _ in 0..count {
                    faces.corners.push(self.vertex(values.whole(kind)?)?);
                }
                faces.end(&self.sources.budget)?;
            }
            Use::Strips => {
                progress.records.strips.make_room(count, &self.sources.budget)?;
                for _ in 0..count {
                    let corner = values.whole(kind)?;
                    if is_separator(corner, kind) {
                        self.end_strip(progress)?;
                    } else {
                        progress.records.strips.corners.push(self.vertex(corner)?);
                    }
                }
                self.end_strip(progress)?;
            }
            Use::Skip | Use::Axis(_) => values.skip(count, kind)?,
        }
        Ok(())
    }

    fn end_strip(&self, progress: &mut Progress) -> Result<()> {
        let corners = progress.records.strips.end(&self.sources.budget)?;
        progress.small_strips += u64::from(matches!(corners, 1 | 2));
        Ok(())
    }

    fn vertex(&self, corner: i64) -> Result<u32, Stop> {
        match u32::try_from(corner) {
            Ok(vertex) if u64::from(vertex) < self.vertices => Ok(vertex),
            _ => Err(Stop::NoVertex(corner)),
        }
    }

    fn error(
        &self,
        stop: Stop,
        element: &Element<'_>,
        index: u64,
        property: &Property<'_>,
        line: Option<usize>,
    ) -> Error {
        let record = format!("{} {index} of {}", shown(element.name), element.count);
        let name = shown(property.name);
        let bad = |what: String| {
            let line = line.map_or_else(String::new, |line| format!(" (line {line})"));
            self.sources.bad(format!("{record}{what}{line}"))
        };
        match stop {
            Stop::Value(Fault::End) => self
                .sources
                .bad(format!("{record} is cut off: the file ends before its property \"{name}\" does")),
            Stop::LongList(items) => bad(format!(
                " is cut off: its list \"{name}\" has {items} items, more than the file can hold"
            )),
            Stop::Length(items) => bad(format!(": its list \"{name}\" has {items} items")),
            Stop::Value(Fault::Unfit { found, wanted }) => {
                bad(format!(": its property \"{name}\" needs {wanted}, but has \"{found}\""))
            }
            Stop::NoVertex(corner) => match u64::try_from(corner) {
                Ok(index) => Error::IndexOutOfRange {
                    path: Path::to_owned(self.sources.scene),
                    mesh: self.mesh.to_owned(),
                    index,
                    vertices: self.vertices,
                },
                Err(_) => bad(format!(" uses vertex {corner}, which does not exist")),
            },
            Stop::Other(error) => error,
        }
    }
}

/// Whether a corner ends a strip: -1, also where the type of the items is unsigned.
fn is_separator(corner: i64, kind: Kind) -> bool {
    corner == -1 || kind == Kind::U32 && corner == i64::from(u32::MAX)
}

/// The omission that an unused element causes, as a plural.
fn omission(element: &Element<'_>, plan: &[Use]) -> Option<String> {
    if plan.iter().any(|&task| task != Use::Skip) {
        return None;
    }
    Some(match element.name {
        b"face" => "faces without a list of vertices".to_owned(),
        b"tristrips" => "triangle strips without a list of vertices".to_owned(),
        name => format!("elements \"{}\"", shown(name)),
    })
}

/// The list that holds the corners: `vertex_indices` as Turk's tools call it, `vertex_index` as his text
/// calls it, or the only list of integers without another known purpose.
fn corner_list(properties: &[Property<'_>]) -> Option<usize> {
    let list = |p: &Property<'_>| p.list.is_some();
    for name in [&b"vertex_indices"[..], b"vertex_index"] {
        let at = properties.iter().position(|p| list(p) && p.name == name);
        if at.is_some() {
            return at;
        }
    }
    let for_else = |p: &Property<'_>| {
        [&b"tex"[..], b"uv", b"color", b"normal", b"material"].iter().any(|start| p.name.starts_with(start))
    };
    let fits = |p: &Property<'_>| list(p) && p.kind.is_integer() && !for_else(p);
    let at = properties.iter().position(fits)?;
    let only = properties.iter().filter(|p| fits(p)).count() == 1;
    only.then_some(at)
}
