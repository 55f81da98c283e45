//! The first pass over an OBJ file: its vertices, the names in it, and how many statements of each kind it
//! has.

use hashbrown::HashSet;

use crate::far_origin::FarOrigin;
use crate::obj::room::{free, make_room};
use crate::obj::text::{Name, Statement, Statements, lower, numbers, shown};
use crate::sources::Sources;
use crate::{LoadNotes, Result};

/// Memory per name, in addition to its text; bytes.
const NAME_BYTES: u64 = 256;

/// The kinds of statements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Vertex,
    Uv,
    Face,
    /// `o` or `g`.
    Object,
    UseMaterial,
    Library,
    Line,
    Point,
    /// `curv`, `surf`, and the patches and curves that came before them: `bsp`, `bzp`, `cdc`, `cdp`.
    Curve,
    /// `call`.
    Call,
    /// `csh`.
    Command,
    /// `shadow_obj`.
    ShadowObject,
    /// Does not affect shadows.
    Other,
    Unknown,
}

impl Kind {
    /// The kind of a statement (Wavefront's OBJ text, appendix B1, with the superseded statements).
    pub(super) fn of(statement: &Statement<'_>) -> Self {
        match lower(statement.keyword, &mut [0; 16]) {
            b"v" => Self::Vertex,
            b"vt" => Self::Uv,
            b"f" | b"fo" => Self::Face,
            b"o" | b"g" => Self::Object,
            b"usemtl" => Self::UseMaterial,
            b"mtllib" => Self::Library,
            b"l" => Self::Line,
            b"p" => Self::Point,
            b"curv" | b"surf" | b"bsp" | b"bzp" | b"cdc" | b"cdp" => Self::Curve,
            b"call" => Self::Call,
            b"csh" => Self::Command,
            b"shadow_obj" => Self::ShadowObject,
            // Normals, smoothing, display and textures in general; also the parts of curves and surfaces,
            // which are counted with their curve or surface.
            b"vn" | b"vp" | b"s" | b"mg" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"maplib"
            | b"usemap" | b"trace_obj" | b"ctech" | b"stech" | b"cstype" | b"deg" | b"bmat" | b"step"
            | b"curv2" | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"res" => {
                Self::Other
            }
            _ if statement.keyword.is_empty() => Self::Other,
            _ => Self::Unknown,
        }
    }
}

/// The result of the first pass.
#[derive(Default)]
pub(super) struct Survey {
    /// Positions, with `offset` subtracted.
    pub(super) positions: Vec<[f32; 3]>,
    /// The offset subtracted from the positions if they are far from zero; otherwise 0.
    pub(super) offset: [f64; 3],
    /// Number of texture coordinates.
    pub(super) uvs: u32,
    /// The statements that name material libraries, each once.
    pub(super) libraries: Vec<Name>,
    /// The names of the materials used, each once.
    pub(super) materials: Vec<Name>,
    pub(super) lines: u64,
    pub(super) points: u64,
    pub(super) curves: u64,
    calls: u64,
    commands: u64,
    shadow_objects: u64,
    unknown: u64,
}

impl Survey {
    /// Reads everything but the faces.
    ///
    /// # Errors
    /// Returns [`crate::Error::SceneParse`] for a vertex without three numbers, or
    /// [`crate::Error::SceneMemory`].
    pub(super) fn of(sources: &Sources<'_>, text: &[u8]) -> Result<Self> {
        let budget = &sources.budget;
        let mut out = Self::default();
        let mut stated: Vec<[f64; 3]> = Vec::new();
        let (mut libraries, mut materials) = (HashSet::new(), HashSet::new());
        let remember =
            |statement: &Statement<'_>, known: &mut HashSet<Name>, list: &mut Vec<Name>| -> Result<()> {
                let name = statement.name();
                if !name.long.is_empty() && !known.contains(&name) {
                    let bytes = NAME_BYTES + 4 * statement.whole.len() as u64;
                    budget.charge(bytes, || "the names of its materials".to_owned())?;
                    known.insert(name.clone());
                    list.push(name);
                }
                Ok(())
            };
        let mut statements = Statements::of(text);
        while let Some(statement) = statements.next() {
            match Kind::of(&statement) {
                Kind::Vertex => {
                    let p = numbers(statement.rest)
                        .ok_or_else(|| bad(sources, &statement, "a vertex needs three numbers"))?;
                    make_room(budget, &mut stated, 1, || "its vertices".to_owned())?;
                    stated.push(p);
                }
                Kind::Uv => out.uvs = out.uvs.saturating_add(1),
                Kind::UseMaterial => remember(&statement, &mut materials, &mut out.materials)?,
                Kind::Library => remember(&statement, &mut libraries, &mut out.libraries)?,
                Kind::Line => out.lines += 1,
                Kind::Point => out.points += 1,
                Kind::Curve => out.curves += 1,
                Kind::Call => out.calls += 1,
                Kind::Command => out.commands += 1,
                Kind::ShadowObject => out.shadow_objects += 1,
                Kind::Unknown => out.unknown += 1,
                Kind::Face | Kind::Object | Kind::Other => {}
            }
        }
        if u32::try_from(stated.len()).is_err() || out.uvs == u32::MAX {
            return Err(sources.bad(format!("it has more than {} vertices", u32::MAX)));
        }
        out.offset = FarOrigin::of(stated.iter().copied()).offset();
        make_room(budget, &mut out.positions, stated.len(), || format!("{} vertices", stated.len()))?;
        out.positions.extend(
            stated.iter().map(|p| -> [f32; 3] { std::array::from_fn(|a| (p[a] - out.offset[a]) as f32) }),
        );
        free(budget, stated);
        Ok(out)
    }

    /// Records the statements that are left out of the scene.
    pub(super) fn report(&self, notes: &mut LoadNotes) {
        notes.omit("lines", self.lines);
        notes.omit("points", self.points);
        notes.omit("curves and surfaces", self.curves);
        notes.omit("files to be inserted (call)", self.calls);
        notes.omit("commands to be run (csh)", self.commands);
        notes.omit("objects that cast in place of others (shadow_obj)", self.shadow_objects);
        notes.omit("statements that OBJ does not have", self.unknown);
    }
}

/// The texture coordinates of a file, of which there are `count`; values that are missing or not finite
/// become 0.
///
/// # Errors
/// Returns [`crate::Error::SceneMemory`] if they exceed the budget.
pub(super) fn texture_coordinates(sources: &Sources<'_>, text: &[u8], count: u32) -> Result<Vec<[f32; 2]>> {
    let mut out = Vec::new();
    make_room(&sources.budget, &mut out, count as usize, || format!("{count} texture coordinates"))?;
    let mut statements = Statements::of(text);
    while let Some(statement) = statements.next() {
        if Kind::of(&statement) == Kind::Uv {
            let uv =
                numbers::<2>(statement.rest).or_else(|| numbers::<1>(statement.rest).map(|[u]| [u, 0.0]));
            out.push(uv.unwrap_or_default().map(|c| c as f32));
        }
    }
    Ok(out)
}

/// An error about a statement.
pub(super) fn bad(sources: &Sources<'_>, statement: &Statement<'_>, what: &str) -> crate::Error {
    let text: String = shown(statement.rest).chars().take(60).collect();
    sources.bad(format!("line {}: {what}: {text:?}", statement.line))
}
