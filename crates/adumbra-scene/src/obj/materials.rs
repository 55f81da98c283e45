//! Material libraries: MTL files, and the material that each name in an OBJ file refers to (Wavefront's MTL
//! text).
//!
//! Keywords may be in any case. `d` is opacity and `Tr` is 1 - opacity; `d` wins if a material has both. A
//! name refers to the first library that defines it, as the format says, and within that library to the last
//! definition, as in most loaders.

use hashbrown::{HashMap, HashSet};

use crate::obj::files::{Files, both, several};
use crate::obj::maps::{Map, Placing};
use crate::obj::text::{Name, Statements, decoded, lower, number, numbers, shown, words};
use crate::sources::{Located, MAX_LIBRARY_BYTES};
use crate::{AlphaMode, Error, LoadNotes, LoadOptions, Material, Result};

/// The keyword that references a material library, used in errors.
const LIBRARY: &str = "mtllib";
/// The file ending that separates several library names in a statement.
const ENDING: &str = ".mtl";
/// Statements that reference a texture, in addition to those that begin with `map_`.
const OTHER_MAPS: [&[u8]; 5] = [b"bump", b"disp", b"decal", b"refl", b"norm"];
/// Memory per material, both parsed and in the scene, without its names; bytes.
const MATERIAL_BYTES: u64 = (size_of::<Mtl>() + size_of::<Material>()) as u64 + 128;
/// Memory per texture of a material, without its name, bytes.
const MAP_BYTES: u64 = size_of::<Map>() as u64;
/// At most this many names are listed in a message.
const LISTED: usize = 5;

/// A material as its library describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mtl {
    /// The name for messages and filters.
    pub(super) name: String,
    diffuse: Option<[f32; 3]>,
    /// `d`.
    dissolve: Option<f32>,
    /// `Tr`.
    transparency: Option<f32>,
    /// `map_Kd`.
    pub(super) color: Option<Box<Map>>,
    /// `map_d`.
    pub(super) mask: Option<Box<Map>>,
    /// Statements that other programs use for opacity maps.
    foreign_masks: u64,
}

/// The materials of a scene.
#[derive(Default)]
pub(super) struct Library {
    /// The materials of the libraries, in order, then one for each name that no library defines.
    pub(super) list: Vec<Mtl>,
    /// The index of each name that the OBJ file uses.
    index_of: HashMap<Name, u32>,
    /// The number of materials that a library defines.
    defined: usize,
    /// Whether all libraries were read.
    complete: bool,
}

impl Mtl {
    /// Opacity without textures, 0 to 1.
    fn opacity(&self) -> f32 {
        self.dissolve.or(self.transparency.map(|t| 1.0 - t)).unwrap_or(1.0)
    }

    /// The mask, unless the options ignore it.
    pub(super) fn wanted_mask(&self, options: &LoadOptions) -> Option<&Map> {
        self.mask.as_deref().filter(|_| !options.ignore_alpha)
    }

    /// How to map the material's texture coordinates; `None` if it needs none.
    pub(super) fn placing(&self, options: &LoadOptions) -> Option<Placing> {
        let color = || {
            options.color_textures.then(|| self.color.as_ref().map_or_else(Placing::default, |m| m.placing))
        };
        self.wanted_mask(options).map(|mask| mask.placing).or_else(color)
    }

    /// The material without textures. Opacity below 1 is treated like glTF's BLEND: it casts if it is at
    /// least 0.5.
    pub(super) fn material(&self, options: &LoadOptions) -> Material {
        let [r, g, b] = self.diffuse.unwrap_or([0.8; 3]);
        let opacity = self.opacity();
        let blended = opacity < 1.0;
        let cuts = (blended || self.mask.is_some()) && !options.ignore_alpha;
        let alpha = if cuts { AlphaMode::Mask { cutoff: 0.5 } } else { AlphaMode::Opaque };
        Material { alpha, blended, ..Material::opaque(&self.name, [r, g, b, opacity]) }
    }
}

impl Library {
    /// Reads the libraries that these statements name, and finds the materials of the names that are `used`.
    ///
    /// # Errors
    /// Returns [`Error::OutsideScene`], [`Error::NotRegularFile`] or [`Error::SceneMemory`]. Libraries that
    /// cannot be read are omissions.
    pub(super) fn read(
        files: &Files<'_>,
        statements: &[Name],
        used: &[Name],
        notes: &mut LoadNotes,
    ) -> Result<Self> {
        let mut reader = Reader {
            files,
            read: HashSet::new(),
            lost: Vec::new(),
            long: HashMap::new(),
            short: HashMap::new(),
            list: Vec::new(),
        };
        for statement in statements {
            reader.read_statement(statement, notes)?;
        }
        let lost: Vec<&[u8]> = reader.lost.iter().map(Vec::as_slice).collect();
        notes.omit(format!("material libraries ({})", listed(&lost)), lost.len() as u64);
        let mut out = Self { complete: lost.is_empty(), defined: reader.list.len(), ..Self::default() };
        out.list = reader.list;
        let mut undefined: HashMap<&[u8], u32> = HashMap::new();
        for name in used {
            let known = reader.long.get(&name.long).or_else(|| reader.short.get(&name.short));
            let index = match known.or_else(|| undefined.get(name.short.as_slice())) {
                Some(&index) => index,
                None => {
                    files
                        .sources
                        .budget
                        .charge(MATERIAL_BYTES, || "materials that no library defines".to_owned())?;
                    let index = out.list.len() as u32;
                    undefined.insert(&name.short, index);
                    out.list.push(Mtl { name: shown(&name.short).into_owned(), ..Mtl::default() });
                    index
                }
            };
            out.index_of.insert(name.clone(), index);
        }
        Ok(out)
    }

    /// The index of the material with a name that the file uses. For other names, it is that of the default
    /// material, which follows the list.
    pub(super) fn index(&self, name: &Name) -> u32 {
        self.index_of.get(name).copied().unwrap_or_else(|| self.default_index())
    }

    /// The index of the default material.
    pub(super) fn default_index(&self) -> u32 {
        self.list.len() as u32
    }

    /// The scene's materials, without textures.
    pub(super) fn materials(&self, options: &LoadOptions) -> Vec<Material> {
        let default = Material::opaque("default", [0.8, 0.8, 0.8, 1.0]);
        self.list.iter().map(|m| m.material(options)).chain([default]).collect()
    }

    /// Reports undefined materials and unsupported features among the materials that are used.
    pub(super) fn report(&self, used: &[bool], options: &LoadOptions, notes: &mut LoadNotes) {
        let used = || self.list.iter().zip(used).enumerate().filter(|(_, (_, used))| **used);
        // A missing library would explain undefined names, so report these only if all libraries were read.
        if self.complete {
            let undefined: Vec<&[u8]> =
                used().filter(|&(i, _)| i >= self.defined).map(|(_, (m, _))| m.name.as_bytes()).collect();
            notes.omit(
                format!("materials that no library defines ({})", listed(&undefined)),
                undefined.len() as u64,
            );
        }
        if options.ignore_alpha {
            return;
        }
        notes.omit(
            "opacity maps that are not stated by map_d (map_Tr, map_opacity)",
            used().map(|(_, (m, _))| m.foreign_masks).sum(),
        );
        let turbulent = used().filter(|(_, (m, _))| m.mask.as_ref().is_some_and(|mask| mask.turbulent));
        notes.omit("turbulences of opacity maps (-t)", turbulent.count() as u64);
    }
}

/// Reads libraries one after another.
struct Reader<'r, 'a> {
    files: &'r Files<'a>,
    read: HashSet<Located>,
    lost: Vec<Vec<u8>>,
    list: Vec<Mtl>,
    /// The material of each name with its comment.
    long: HashMap<Vec<u8>, u32>,
    /// The material of each name without its comment.
    short: HashMap<Vec<u8>, u32>,
}

impl Reader<'_, '_> {
    /// Reads the libraries of a statement. The statement may hold one name with spaces, or several names.
    fn read_statement(&mut self, statement: &Name, notes: &mut LoadNotes) -> Result<()> {
        self.files.note(statement)?;
        let names = several(&statement.short, ENDING);
        for name in &names {
            self.files.note_file(name)?;
        }
        let whole = both(statement);
        let one = names.len() < 2 && words(&statement.short).count() < 2;
        match self.files.locate(LIBRARY, &whole) {
            Ok(file) => return self.read_file(&file, &statement.short, notes),
            Err(e @ Error::SceneMemory { .. }) => return Err(e),
            Err(Error::Io(_)) if one => {
                self.lost.push(statement.short.clone());
                return Ok(());
            }
            Err(e) if one => return Err(e),
            Err(_) => {}
        }
        for name in names {
            let found = self.files.locate(LIBRARY, &[name]);
            if found.is_err() && words(name).count() > 1 {
                self.read_words(name, notes)?;
                continue;
            }
            self.read_found(found, name, notes)?;
        }
        Ok(())
    }

    /// Reads the libraries that the words of a text name. If no word names a library, the whole text counts
    /// as one name.
    fn read_words(&mut self, text: &[u8], notes: &mut LoadNotes) -> Result<()> {
        let found: Vec<_> = words(text).map(|word| (word, self.files.locate(LIBRARY, &[word]))).collect();
        if found.iter().all(|(_, found)| matches!(found, Err(Error::Io(_)))) {
            self.lost.push(text.to_owned());
            return Ok(());
        }
        found.into_iter().try_for_each(|(word, found)| self.read_found(found, word, notes))
    }

    fn read_found(&mut self, found: Result<Located>, name: &[u8], notes: &mut LoadNotes) -> Result<()> {
        match found {
            Ok(file) => self.read_file(&file, name, notes),
            Err(Error::Io(_)) => {
                self.lost.push(name.to_owned());
                Ok(())
            }
            Err(e) => Err(e),
        }
    }

    /// Reads a library, unless it has been read already.
    fn read_file(&mut self, file: &Located, name: &[u8], notes: &mut LoadNotes) -> Result<()> {
        let sources = self.files.sources;
        if !self.read.insert(file.clone()) {
            return Ok(());
        }
        let bytes = match sources.read_whole(file, LIBRARY, MAX_LIBRARY_BYTES) {
            Err(Error::Io(_)) => {
                self.lost.push(name.to_owned());
                return Ok(());
            }
            read => read?,
        };
        let text = match decoded(bytes, &sources.budget)? {
            Ok(text) => text,
            Err(what) => {
                notes.warnings.push(format!("material library {:?}: {what}", shown(name)));
                self.lost.push(name.to_owned());
                return Ok(());
            }
        };
        // Joining continued lines makes copies.
        let copied = text.len() as u64 * 2;
        sources.budget.charge(copied, || format!("the text of {:?}", shown(name)))?;
        self.parse(&text, notes)?;
        sources.budget.release(copied + text.len() as u64);
        Ok(())
    }

    /// Reads the materials of a library. Definitions in earlier libraries win; in this one, the last wins.
    fn parse(&mut self, text: &[u8], notes: &mut LoadNotes) -> Result<()> {
        let budget = &self.files.sources.budget;
        let first = self.list.len();
        let mut names: Vec<Name> = Vec::new();
        let mut statements = Statements::of(text);
        while let Some(statement) = statements.next() {
            let mut buffer = [0; 16];
            let keyword = lower(statement.keyword, &mut buffer);
            if keyword.starts_with(b"map_") || OTHER_MAPS.contains(&keyword) {
                self.files.note(&statement.name())?;
            }
            if keyword == b"newmtl" {
                let length = statement.whole.len() as u64;
                budget.charge(MATERIAL_BYTES + 4 * length, || format!("{} materials", self.list.len()))?;
                names.push(statement.name());
                self.list.push(Mtl::default());
                continue;
            }
            let Some(mtl) = self.list.last_mut().filter(|_| !names.is_empty()) else { continue };
            let last = || words(statement.rest).next_back().and_then(number).map(|v| v as f32);
            let fraction = || last().filter(|v| v.is_finite()).map(|v| v.clamp(0.0, 1.0));
            match keyword {
                b"kd" => {
                    let finite = |c: &[f64; 3]| c.iter().all(|c| c.is_finite());
                    let grey = || numbers::<1>(statement.rest).map(|[r]| [r; 3]);
                    let color = numbers::<3>(statement.rest).or_else(grey).filter(finite);
                    mtl.diffuse = color.map(|c| c.map(|c| c as f32)).or(mtl.diffuse);
                }
                b"d" => mtl.dissolve = fraction().or(mtl.dissolve),
                b"tr" => mtl.transparency = fraction().or(mtl.transparency),
                b"map_kd" | b"map_d" => {
                    budget.charge(MAP_BYTES + 3 * statement.whole.len() as u64, || {
                        "the names of its textures".to_owned()
                    })?;
                    let map = Map::of(&statement.name()).map(Box::new);
                    let kept = if keyword == b"map_d" { &mut mtl.mask } else { &mut mtl.color };
                    *kept = map.or(kept.take());
                }
                b"map_tr" | b"map_opacity" => mtl.foreign_masks += 1,
                _ => {}
            }
        }
        self.define(first, &names, notes);
        Ok(())
    }

    /// Names the materials of a library, which begin at index `first`.
    fn define(&mut self, first: usize, names: &[Name], notes: &mut LoadNotes) {
        let (mut long, mut short): (HashMap<Vec<u8>, u32>, HashMap<Vec<u8>, u32>) = Default::default();
        let mut twice: Vec<&[u8]> = Vec::new();
        for (index, name) in names.iter().enumerate() {
            let index = first + index;
            let earlier = long.insert(name.long.clone(), index as u32);
            let twins = earlier.map(|earlier| [self.list.get(earlier as usize), self.list.get(index)]);
            if twins.is_some_and(|[a, b]| a.zip(b).is_some_and(|(a, b)| !a.same_as(b))) {
                twice.push(&name.short);
            }
            let is_other = short.insert(name.short.clone(), index as u32).is_some() && earlier.is_none();
            if let Some(mtl) = self.list.get_mut(index) {
                // If names differ only after a `#`, show that part.
                mtl.name = shown(if is_other { &name.long } else { &name.short }).into_owned();
            }
        }
        if !twice.is_empty() {
            let listed = listed(&twice);
            notes
                .warnings
                .push(format!("materials defined more than once: {listed}; the last definition counts"));
        }
        for (name, index) in long {
            self.long.entry(name).or_insert(index);
        }
        for (name, index) in short {
            self.short.entry(name).or_insert(index);
        }
    }
}

impl Mtl {
    /// Whether two materials are equal except for their names.
    fn same_as(&self, other: &Self) -> bool {
        Self { name: String::new(), ..self.clone() } == Self { name: String::new(), ..other.clone() }
    }
}

/// The first names of a list for a message.
fn listed(names: &[&[u8]]) -> String {
    let mut text: Vec<String> = names.iter().take(LISTED).map(|name| format!("{:?}", shown(name))).collect();
    if names.len() > LISTED {
        text.push("\u{2026}".to_owned());
    }
    text.join(", ")
}
