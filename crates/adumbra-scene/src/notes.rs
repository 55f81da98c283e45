//! The counts, the omissions and the warnings of a load.

use std::fmt;
use std::path::PathBuf;

use crate::one_line::one_line;
use crate::unmatched::UnmatchedPattern;

/// Counts and warnings gathered while loading.
#[derive(Clone, Debug, Default)]
pub struct LoadNotes {
    /// What the loader has read from the file, before anything was dropped.
    pub read: Counts,
    /// The kinds of things that the loader left out, each once with its count, in the order in which they
    /// were found. Triangles without area are not included, because they cast no shadow.
    pub omissions: Vec<Omission>,
    /// Degenerate triangles (a repeated vertex or zero area) that were skipped.
    pub degenerate_triangles: u64,
    /// Materials with glTF alpha mode BLEND, which cast where alpha >= 0.5.
    pub blended_materials: u64,
    /// Triangles of blended materials (not multiplied by instances).
    pub blended_triangles: u64,
    /// Polygons of OBJ and PLY files that could not be triangulated because they self-intersect, are far from
    /// flat, or are concave with more than 16,384 corners. Each was cut into a fan from its first corner,
    /// which may cover more or less than the polygon.
    pub untriangulated_polygons: u64,
    /// Animated instances that were dropped by [`MoverPolicy::Skip`](crate::MoverPolicy::Skip).
    pub skipped_movers: u64,
    /// Whether the extents of an OBJ or PLY file whose up axis was not given suggest that Z points up: the
    /// scene is flat along Z, or much taller than wide.
    pub looks_z_up: bool,
    /// Patterns of the name filter that match no name in the scene.
    pub unmatched_patterns: Vec<UnmatchedPattern>,
    /// Files that the scene references, each once and sorted, with paths relative to the scene's folder:
    /// buffers, images, material libraries and their textures, whether they were read or not. A program that
    /// writes a file next to a scene can check here what it must not overwrite.
    pub named_files: Vec<PathBuf>,
    /// Colour textures that were not read because they are outside the scene's folder; each has a warning
    /// that names it.
    pub outside_textures: u64,
    /// Messages for the user about how the file was read: skins in bind pose, missing colour textures, and so
    /// on.
    pub warnings: Vec<String>,
}

/// Counts of the things that the loader has read from a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Meshes of a glTF file, objects and groups with faces of an OBJ file, 1 for a PLY file.
    pub meshes: u64,
    /// Nodes of a glTF file; 0 for other formats.
    pub nodes: u64,
    /// Faces with three or more corners: triangles of a glTF file, polygons of OBJ and PLY files. Each
    /// triangle of a strip or a fan counts.
    pub faces: u64,
}

/// A kind of thing that the loader left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Omission {
    /// What was left out, as a plural: "lines and points".
    pub what: String,
    /// How many there are.
    pub count: u64,
}

impl fmt::Display for Omission {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.count, one_line(&self.what))
    }
}

impl LoadNotes {
    /// Records that `count` things of a kind were left out; 0 records nothing. `what` is a plural.
    pub(crate) fn omit(&mut self, what: impl Into<String>, count: u64) {
        let what = what.into();
        if count == 0 {
            return;
        }
        match self.omissions.iter_mut().find(|known| known.what == what) {
            Some(known) => known.count += count,
            None => self.omissions.push(Omission { what, count }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_omissions_of_the_same_kind() {
        let mut notes = LoadNotes::default();
        notes.omit("lines", 2);
        notes.omit("curves", 0);
        notes.omit("points", 1);
        notes.omit("lines", 3);
        let texts: Vec<String> = notes.omissions.iter().map(ToString::to_string).collect();
        assert_eq!(texts, ["5 lines", "1 points"]);
    }
}
