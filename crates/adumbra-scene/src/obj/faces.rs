//! The second pass over an OBJ file: its faces become the triangles of one mesh for each name of an object or
//! group.
//!
//! Vertices are shared within a run of faces of one object and one material, and are in the order of their
//! first use. Polygons are cut into fans, or triangulated where a fan would not cover them.

use hashbrown::HashMap;

use crate::filter::Marks;
use crate::obj::maps::Placing;
use crate::obj::materials::Library;
use crate::obj::room::{free, make_room, shrink};
use crate::obj::survey::{Kind, Survey, bad};
use crate::obj::text::{Statement, Statements, shown, words};
use crate::polygon::Cutter;
use crate::sources::Sources;
use crate::validate::{Sieve, check_vertex};
use crate::{Counts, Error, Instance, LoadOptions, Mesh, Result};

/// The object of faces that precede any name.
const UNNAMED: &str = "unnamed_object";
/// Memory per object and its entry in the map of names, without the name, bytes.
const OBJECT_BYTES: u64 = size_of::<Object>() as u64 + 64;
/// Memory per mesh and its instance, without the name; bytes.
const MESH_BYTES: u64 = (size_of::<Mesh>() + size_of::<Instance>()) as u64;
/// Memory per entry of a map from corners to vertices, bytes.
const ENTRY_BYTES: u64 = 40;
/// The index that means no texture coordinate.
const NONE: u32 = u32::MAX;

/// The meshes of a file.
#[derive(Default)]
pub(super) struct ObjMeshes {
    pub(super) meshes: Vec<Mesh>,
    /// For each material of the scene, whether a face has it.
    pub(super) used: Vec<bool>,
    pub(super) read: Counts,
    /// Faces with fewer than three corners.
    pub(super) small: u64,
    /// Polygons that could not be triangulated.
    pub(super) untriangulated: u64,
    /// Faces of masked materials without texture coordinates.
    pub(super) unplaced: u64,
    pub(super) sieve: Sieve,
}

/// An object or group.
struct Object {
    name: String,
    marks: Marks,
    has_faces: bool,
    mesh: Option<usize>,
}

/// A position and a texture coordinate, as indices from 0.
type Corner = (u32, u32);

/// A run of consecutive faces with the same object and material. Its first face creates it.
struct Run {
    number: u32,
    /// `None` if the filter drops the run.
    mesh: Option<usize>,
    material: u32,
    placing: Option<Placing>,
    is_masked: bool,
}

struct Reader<'a> {
    sources: &'a Sources<'a>,
    survey: &'a Survey,
    uvs: &'a [[f32; 2]],
    library: &'a Library,
    options: &'a LoadOptions,
    objects: Vec<Object>,
    runs: u32,
    welder: Welder,
    corners: Vec<Corner>,
    points: Vec<[f32; 3]>,
    cutter: Cutter,
    out: ObjMeshes,
}

/// Reads the faces. `uvs` holds the file's texture coordinates, and is empty if no material needs them.
///
/// # Errors
/// Returns [`Error::SceneParse`], [`Error::IndexOutOfRange`], [`Error::NotFinite`] or [`Error::SceneMemory`].
pub(super) fn read(
    sources: &Sources<'_>,
    text: &[u8],
    survey: &Survey,
    uvs: &[[f32; 2]],
    library: &Library,
    options: &LoadOptions,
) -> Result<ObjMeshes> {
    let mut reader = Reader {
        sources,
        survey,
        uvs,
        library,
        options,
        objects: Vec::new(),
        runs: 0,
        welder: Welder::default(),
        corners: Vec::new(),
        points: Vec::new(),
        cutter: Cutter::default(),
        out: ObjMeshes { used: vec![false; library.list.len() + 1], ..ObjMeshes::default() },
    };
    let vertices = survey.positions.len();
    make_room(&sources.budget, &mut reader.welder.plain, vertices, || format!("{vertices} vertices"))?;
    reader.welder.plain.resize(vertices, (0, 0));
    reader.read(text)
}

/// Finds the vertices that a run already has.
#[derive(Default)]
struct Welder {
    /// For each position, the last run that used it without a texture coordinate, and its vertex there.
    plain: Vec<(u32, u32)>,
    /// For each corner with a texture coordinate, the same.
    placed: HashMap<Corner, (u32, u32)>,
    /// Bytes charged for `placed`.
    placed_bytes: u64,
}

impl Welder {
    /// Makes room for more corners with texture coordinates.
    fn make_room(&mut self, sources: &Sources<'_>, corners: usize) -> Result<()> {
        let capacity = self.placed.capacity();
        if capacity - self.placed.len() < corners {
            let more = corners.max(capacity);
            let bytes = more as u64 * ENTRY_BYTES;
            sources.budget.charge(bytes, || "corners with texture coordinates".to_owned())?;
            self.placed_bytes += bytes;
            self.placed.reserve(more);
        }
        Ok(())
    }

    /// The vertex of a corner in a run. `add` creates the vertex if it is new.
    fn vertex(&mut self, run: &Run, corner: Corner, add: impl FnOnce() -> u32) -> u32 {
        let known = match run.placing {
            Some(_) => Some(self.placed.entry(corner).or_default()),
            None => self.plain.get_mut(corner.0 as usize),
        };
        let Some(known) = known else { return add() };
        if known.0 != run.number {
            *known = (run.number, add());
        }
        known.1
    }
}

impl Reader<'_> {
    fn read(mut self, text: &[u8]) -> Result<ObjMeshes> {
        let mut numbers: HashMap<Vec<u8>, usize> = HashMap::new();
        let mut object = self.object(&mut numbers, &[])?;
        let mut material = self.library.default_index();
        let (mut vertices_so_far, mut uvs_so_far) = (0, 0);
        let mut run: Option<Run> = None;
        let mut statements = Statements::of(text);
        while let Some(statement) = statements.next() {
            match Kind::of(&statement) {
                Kind::Vertex => vertices_so_far += 1,
                Kind::Uv => uvs_so_far += 1,
                Kind::Object => {
                    object = self.object(&mut numbers, statement.rest)?;
                    run = None;
                }
                Kind::UseMaterial if !statement.whole.is_empty() => {
                    let next = self.library.index(&statement.name());
                    if next != material {
                        run = None;
                    }
                    material = next;
                }
                Kind::Face if words(statement.rest).nth(2).is_none() => self.out.small += 1,
                Kind::Face => {
                    self.read_corners(&statement, object, vertices_so_far, uvs_so_far)?;
                    self.out.read.faces += 1;
                    let run = match &mut run {
                        Some(run) => run,
                        none => none.insert(self.begin(object, material)?),
                    };
                    self.add_face(run)?;
                }
                _ => {}
            }
        }
        self.finish()
    }

    /// The index of an object, which is added if its name is new.
    fn object(&mut self, numbers: &mut HashMap<Vec<u8>, usize>, name: &[u8]) -> Result<usize> {
        if let Some(&number) = numbers.get(name) {
            return Ok(number);
        }
        let bytes = OBJECT_BYTES + 2 * name.len() as u64;
        self.sources.budget.charge(bytes, || "the names of its objects".to_owned())?;
        let shown = if name.is_empty() { UNNAMED.to_owned() } else { shown(name).into_owned() };
        // A face is in each of the groups that a statement names.
        let (filter, met) = (&self.options.filter, &mut self.out.sieve.met);
        let whole = filter.marks(&shown, met);
        let marks = shown.split_ascii_whitespace().fold(whole, |all, name| all.or(filter.marks(name, met)));
        let number = self.objects.len();
        numbers.insert(name.to_owned(), number);
        self.objects.push(Object { name: shown, marks, has_faces: false, mesh: None });
        Ok(number)
    }

    /// Reads the corners of a face, which has at least three.
    fn read_corners(
        &mut self,
        statement: &Statement<'_>,
        object: usize,
        vertices: u32,
        uvs: u32,
    ) -> Result<()> {
        let count = words(statement.rest).count();
        let what = || format!("a face of {count} corners");
        self.corners.clear();
        make_room(&self.sources.budget, &mut self.corners, count, what)?;
        let stated = self.survey.positions.len() as u64;
        for word in words(statement.rest) {
            // A comment may follow without white space.
            let (word, ends) = match word.iter().position(|&b| b == b'#') {
                Some(at) => (word.get(..at).unwrap_or_default(), true),
                None => (word, false),
            };
            let mut parts = word.split(|&b| b == b'/');
            let v = parts.next().and_then(|part| absolute(part, vertices));
            let v = v.ok_or_else(|| bad(self.sources, statement, "a face's corner is not a vertex index"))?;
            if v > stated {
                let path = self.sources.scene.to_owned();
                let mesh = self.objects.get(object).map(|o| o.name.clone()).unwrap_or_default();
                return Err(Error::IndexOutOfRange { path, mesh, index: v, vertices: stated });
            }
            let uv = parts.next().and_then(|part| absolute(part, uvs));
            let uv = uv.filter(|&uv| uv <= u64::from(self.survey.uvs)).map_or(NONE, |uv| uv as u32 - 1);
            self.corners.push((v as u32 - 1, uv));
            if ends {
                break;
            }
        }
        if self.corners.len() < 3 {
            return Err(bad(self.sources, statement, "a face needs three corners before its comment"));
        }
        Ok(())
    }

    /// Begins a run of faces.
    fn begin(&mut self, object: usize, material: u32) -> Result<Run> {
        let mtl = self.library.list.get(material as usize);
        let placing = mtl.and_then(|mtl| mtl.placing(self.options));
        let mut run = Run {
            number: self.runs + 1,
            mesh: None,
            material,
            placing: placing.or_else(|| self.options.color_textures.then(Placing::default)),
            is_masked: mtl.is_some_and(|mtl| mtl.wanted_mask(self.options).is_some()),
        };
        self.runs = run.number;
        if self.runs == u32::MAX {
            return Err(self.sources.bad("it changes its objects and materials too often"));
        }
        let Some(object) = self.objects.get_mut(object) else { return Ok(run) };
        if !object.has_faces {
            object.has_faces = true;
            self.out.read.meshes += 1;
        }
        let name = mtl.map_or("default", |mtl| &mtl.name);
        let material_marks = self.options.filter.marks(name, &mut self.out.sieve.met);
        if !self.options.filter.keeps_marked([object.marks, object.marks, material_marks]) {
            self.out.sieve.filtered = true;
            return Ok(run);
        }
        if let Some(used) = self.out.used.get_mut(material as usize) {
            *used = true;
        }
        let next = self.out.meshes.len();
        run.mesh = Some(*object.mesh.get_or_insert(next));
        if run.mesh == Some(next) {
            let bytes = MESH_BYTES + 2 * object.name.len() as u64;
            self.sources.budget.charge(bytes, || "its meshes".to_owned())?;
            self.out.meshes.push(Mesh { name: object.name.clone(), ..Mesh::default() });
        }
        Ok(run)
    }

    /// Adds the triangles of the face whose corners have been read.
    fn add_face(&mut self, run: &Run) -> Result<()> {
        let Some(mesh) = run.mesh.and_then(|mesh| self.out.meshes.get_mut(mesh)) else { return Ok(()) };
        let budget = &self.sources.budget;
        let corners = self.corners.len();
        self.points.clear();
        make_room(budget, &mut self.points, corners, || format!("a face of {corners} corners"))?;
        self.points.extend(self.corners.iter().filter_map(|&(v, _)| self.survey.positions.get(v as usize)));
        if run.is_masked && self.corners.iter().any(|&(_, uv)| uv == NONE) {
            self.out.unplaced += 1;
        }
        let cut = if corners > 3 { self.cutter.cut(&self.points) } else { None };
        let count = cut.map_or(corners - 2, <[_]>::len);
        let what = || format!("the triangles and vertices of {:?}", mesh.name);
        make_room(budget, &mut mesh.positions, corners, what)?;
        make_room(budget, &mut mesh.triangles, count, what)?;
        make_room(budget, &mut mesh.triangle_materials, count, what)?;
        if run.placing.is_some() || !mesh.uvs.is_empty() {
            let behind = mesh.positions.len() - mesh.uvs.len();
            make_room(budget, &mut mesh.uvs, behind + corners, what)?;
            // The earlier vertices belong to materials without texture coordinates.
            mesh.uvs.resize(mesh.positions.len(), [0.0; 2]);
        }
        if run.placing.is_some() {
            self.welder.make_room(self.sources, corners)?;
        }
        if mesh.positions.len().saturating_add(corners) > u32::MAX as usize {
            return Err(self.sources.bad(format!("object {:?} has too many vertices", mesh.name)));
        }
        for triangle in 0..count {
            let fan = [0, triangle as u32 + 1, triangle as u32 + 2];
            let numbers = cut.and_then(|cut| cut.get(triangle).copied()).unwrap_or(fan);
            let mut points = [[0.0; 3]; 3];
            let mut vertices = [0; 3];
            for ((point, vertex), number) in points.iter_mut().zip(&mut vertices).zip(numbers) {
                let number = number as usize;
                let (Some(&corner), Some(&p)) = (self.corners.get(number), self.points.get(number)) else {
                    continue;
                };
                check_vertex(self.sources.scene, &mesh.name, u64::from(corner.0) + 1, p)?;
                *point = p;
                *vertex = self.welder.vertex(run, corner, || {
                    if let Some(placing) = run.placing {
                        let uv = self.uvs.get(corner.1 as usize).copied().unwrap_or_default();
                        mesh.uvs.push(placing.apply(uv));
                    } else if !mesh.uvs.is_empty() {
                        mesh.uvs.push([0.0; 2]);
                    }
                    mesh.positions.push(p);
                    mesh.positions.len() as u32 - 1
                });
            }
            if self.out.sieve.keeps(points) {
                mesh.triangles.push(vertices);
                mesh.triangle_materials.push(run.material);
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<ObjMeshes> {
        let budget = &self.sources.budget;
        self.out.untriangulated = self.cutter.failed;
        for mesh in &mut self.out.meshes {
            shrink(budget, &mut mesh.positions);
            shrink(budget, &mut mesh.uvs);
            shrink(budget, &mut mesh.triangles);
            shrink(budget, &mut mesh.triangle_materials);
        }
        free(budget, self.welder.plain);
        free(budget, self.corners);
        free(budget, self.points);
        budget.release(self.welder.placed_bytes);
        Ok(self.out)
    }
}

/// Converts an index to an absolute one, counted from 1; negative indices count back from the last element so
/// far.
fn absolute(text: &[u8], so_far: u32) -> Option<u64> {
    let index: i64 = std::str::from_utf8(text).ok()?.parse().ok()?;
    match u64::try_from(index) {
        Ok(0) => None,
        Ok(index) => Some(index),
        Err(_) => (u64::from(so_far) + 1).checked_sub(index.unsigned_abs()).filter(|&index| index > 0),
    }
}
