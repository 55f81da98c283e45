//! Triangles of a mesh: all its kept primitives in one list, with only the vertices that they use.

use std::path::Path;

use ::gltf::json::Root;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use hashbrown::HashMap;

use super::accessor::Accessor;
use super::container::{Buffers, bad};
use super::materials::{Coordinates, Materials};
use super::skin::Skin;
use crate::error::{Error, Result};
use crate::scene::Mesh;
use crate::scene::validate::{Sieve, check_vertex};

/// What it takes to build a mesh.
pub(super) struct Builder<'a> {
    pub(super) path: &'a Path,
    pub(super) root: &'a Root,
    pub(super) buffers: &'a Buffers<'a>,
    pub(super) materials: &'a Materials,
}

/// Vertices of one primitive.
struct Source<'a> {
    positions: Accessor<'a>,
    uvs: Option<(Accessor<'a>, Coordinates)>,
    /// Joints and weights, a pair a set of four.
    joints: Vec<[Accessor<'a>; 2]>,
}

/// Primitives with the same key share vertices: accessors of positions, joints and weights, material with a texture.
type SourceKey = (usize, [Option<usize>; 2], Option<usize>);

/// Whether a primitive is triangles; lines and points are not, nor is one without positions.
pub(super) fn has_triangles(primitive: &Primitive) -> bool {
    let mode =
        matches!(primitive.mode, Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan));
    mode && attribute(primitive, Semantic::Positions).is_some()
}

/// The index of a primitive's material; the default one is after the file's own.
pub(super) fn material_of(root: &Root, primitive: &Primitive) -> usize {
    primitive.material.map_or(root.materials.len(), |m| m.value())
}

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<usize> {
    primitive.attributes.get(&Checked::Valid(semantic)).map(|a| a.value())
}

impl<'a> Builder<'a> {
    /// The mesh's chosen primitives as one mesh; a skin puts the vertices where its joints say.
    pub(super) fn build(
        &self,
        name: &str,
        primitives: &[&Primitive],
        skin: Option<&Skin>,
        sieve: &mut Sieve,
    ) -> Result<Mesh> {
        let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
        let textured = |p: &Primitive| {
            let material = material_of(self.root, p);
            self.materials.coordinates.get(material).copied().flatten().map(|c| (material, c))
        };
        let any_textured = primitives.iter().any(|p| textured(p).is_some());
        let mut keys: Vec<SourceKey> = Vec::new();
        let mut vertices: HashMap<(u32, u32), u32> = HashMap::new();
        for primitive in primitives {
            let Some(positions) = attribute(primitive, Semantic::Positions) else { continue };
            let texture = textured(primitive);
            let joints = match skin {
                Some(_) => [Semantic::Joints(0), Semantic::Weights(0)].map(|s| attribute(primitive, s)),
                None => [None; 2],
            };
            let key = (positions, joints, texture.map(|t| t.0));
            let key = keys.iter().position(|k| *k == key).unwrap_or_else(|| {
                keys.push(key);
                keys.len() - 1
            }) as u32;
            let source = self.open(primitive, positions, texture.map(|t| t.1), skin.is_some())?;
            let material = material_of(self.root, primitive) as u32;
            self.each_triangle(name, primitive, source.positions.count, |corners| {
                let mut points = [[0.0; 3]; 3];
                for (point, &corner) in points.iter_mut().zip(&corners) {
                    *point = source.position(corner, skin);
                    check_vertex(self.path, name, u64::from(corner), *point)?;
                }
                if !sieve.keeps(points) {
                    return Ok(());
                }
                let mut triangle = [0; 3];
                for i in 0..3 {
                    let next = mesh.positions.len() as u32;
                    triangle[i] = *vertices.entry((key, corners[i])).or_insert(next);
                    if triangle[i] == next {
                        mesh.positions.push(points[i]);
                        if any_textured {
                            mesh.uvs.push(source.uv(corners[i]));
                        }
                    }
                }
                mesh.triangles.push(triangle);
                mesh.triangle_materials.push(material);
                Ok(())
            })?;
        }
        mesh.positions.shrink_to_fit();
        mesh.uvs.shrink_to_fit();
        mesh.triangles.shrink_to_fit();
        mesh.triangle_materials.shrink_to_fit();
        Ok(mesh)
    }

    fn open(
        &self,
        primitive: &Primitive,
        positions: usize,
        coordinates: Option<Coordinates>,
        skinned: bool,
    ) -> Result<Source<'a>> {
        let open = |index| Accessor::open(self.path, self.root, self.buffers, index);
        let positions = open(positions)?;
        if positions.components != 3 {
            return Err(bad(self.path, "a POSITION attribute is not made of three components"));
        }
        let uvs = match coordinates {
            None => None,
            Some(c) => match attribute(primitive, Semantic::TexCoords(c.set)) {
                Some(index) => Some((open(index)?, c)),
                None => None,
            },
        };
        let mut joints = Vec::new();
        while skinned && let Ok(set) = u32::try_from(joints.len()) {
            let pair =
                (attribute(primitive, Semantic::Joints(set)), attribute(primitive, Semantic::Weights(set)));
            let (Some(j), Some(w)) = pair else { break };
            joints.push([open(j)?, open(w)?]);
        }
        Ok(Source { positions, uvs, joints })
    }

    /// Calls `each` with the corners of every triangle, all below `vertices`, wound as glTF 2.0 section 3.7.2.1.
    fn each_triangle(
        &self,
        mesh: &str,
        primitive: &Primitive,
        vertices: usize,
        mut each: impl FnMut([u32; 3]) -> Result<()>,
    ) -> Result<()> {
        let indices = match primitive.indices {
            Some(index) => Some(Accessor::open(self.path, self.root, self.buffers, index.value())?),
            None => None,
        };
        if indices.as_ref().is_some_and(|i| i.components != 1 || !i.is_unsigned()) {
            return Err(bad(self.path, format!("the indices of mesh {mesh:?} are not unsigned integers")));
        }
        let corner = |at: usize| -> Result<u32> {
            let index = match &indices {
                Some(indices) => indices.integers::<1>(at).map_or(u32::MAX, |[i]| i),
                None => at as u32,
            };
            if (index as usize) < vertices {
                return Ok(index);
            }
            Err(Error::IndexOutOfRange {
                path: self.path.to_owned(),
                mesh: mesh.to_owned(),
                index: u64::from(index),
                vertices: vertices as u64,
            })
        };
        let count = indices.as_ref().map_or(vertices, |i| i.count);
        match primitive.mode {
            Checked::Valid(Mode::Triangles) => {
                for t in 0..count / 3 {
                    each([corner(t * 3)?, corner(t * 3 + 1)?, corner(t * 3 + 2)?])?;
                }
            }
            Checked::Valid(Mode::TriangleStrip) => {
                for t in 0..count.saturating_sub(2) {
                    each([corner(t)?, corner(t + 1 + t % 2)?, corner(t + 2 - t % 2)?])?;
                }
            }
            Checked::Valid(Mode::TriangleFan) => {
                for t in 0..count.saturating_sub(2) {
                    each([corner(t + 1)?, corner(t + 2)?, corner(0)?])?;
                }
            }
            _ => {}
        }
        Ok(())
    }
}

impl Source<'_> {
    fn position(&self, index: u32, skin: Option<&Skin>) -> [f32; 3] {
        let at = index as usize;
        let p = self.positions.floats::<3>(at).unwrap_or([f32::NAN; 3]);
        let Some(skin) = skin else { return p };
        let influences = self.joints.iter().flat_map(|[joints, weights]| {
            let joints = joints.integers::<4>(at).unwrap_or_default();
            let weights = weights.floats::<4>(at).unwrap_or_default();
            joints.into_iter().zip(weights)
        });
        skin.place(p, influences)
    }

    fn uv(&self, index: u32) -> [f32; 2] {
        let Some((accessor, coordinates)) = &self.uvs else { return [0.0; 2] };
        coordinates.apply(accessor.floats(index as usize).unwrap_or_default())
    }
}
