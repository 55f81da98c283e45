//! Builds meshes: all kept primitives of a mesh in one triangle list, with only the vertices that they use.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

use ::gltf::json::Root;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use hashbrown::HashMap;

use crate::gltf::accessor::Accessor;
use crate::gltf::container::Buffers;
use crate::gltf::draco::Streams;
use crate::gltf::faults::bad;
use crate::gltf::materials::{Coordinates, Materials};
use crate::gltf::morphs::Weights;
use crate::gltf::skin::Skin;
use crate::validate::{Sieve, check_vertex};
use crate::{AlphaMode, Error, Mesh, Result, linear_to_srgb};

/// Builds meshes from primitives.
pub(super) struct MeshBuilder<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    materials: &'a Materials,
    streams: &'a Streams,
    /// Load all vertex colours. If false, only those whose alpha affects opacity are read.
    colors: bool,
    /// Accessors opened so far, by index; many primitives may use the same one.
    opened: RefCell<HashMap<usize, Rc<Accessor<'a>>>>,
    /// The distinct lists of morph targets, each with its number.
    targets: RefCell<HashMap<Vec<Option<usize>>, usize>>,
}

/// The pose in which a mesh is built.
#[derive(Clone, Copy)]
pub(super) struct Pose<'a> {
    /// Moves the vertices to the pose of its joints.
    pub(super) skin: Option<&'a Skin>,
    /// The weights of the morph targets.
    pub(super) weights: &'a Weights,
}

/// Vertex data of one primitive.
struct Source<'a> {
    positions: Morphed<'a>,
    uvs: Option<(Rc<Accessor<'a>>, Coordinates)>,
    colors: Option<Rc<Accessor<'a>>>,
    /// Joints and weights, one pair per set of four.
    joints: Vec<[Rc<Accessor<'a>>; 2]>,
}

/// Positions and the displacements of morph targets.
struct Morphed<'a> {
    base: Rc<Accessor<'a>>,
    /// Weights and displacements.
    targets: Vec<(f32, Rc<Accessor<'a>>)>,
}

impl Morphed<'_> {
    /// The position of a vertex, or `None` if it does not exist.
    fn at(&self, index: usize) -> Option<[f32; 3]> {
        let mut sum = self.base.floats::<3>(index)?;
        for (weight, target) in &self.targets {
            let moved = target.floats::<3>(index).unwrap_or_default();
            sum = std::array::from_fn(|a| sum[a] + weight * moved[a]);
        }
        Some(sum)
    }
}

/// Identifies vertex data: primitives with equal keys share vertices.
#[derive(Clone, PartialEq, Eq, Hash)]
struct SourceKey {
    /// The index of an accessor. The joints, weights and colours below are accessor indices too.
    positions: usize,
    /// The buffer view of the Draco stream, if there is one.
    stream: Option<usize>,
    /// One pair per set of four joints. Empty without a skin.
    joints_and_weights: Vec<[usize; 2]>,
    colors: Option<usize>,
    /// The material, if it has a texture, since it determines the transform of the texture coordinates.
    textured_material: Option<usize>,
    /// The number of the list of morph targets, if there is one.
    targets: Option<usize>,
}

/// Whether a primitive consists of triangles. False for lines and points, and for a primitive without
/// positions.
pub(super) fn has_triangles(primitive: &Primitive) -> bool {
    let mode =
        matches!(primitive.mode, Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan));
    mode && attribute(primitive, Semantic::Positions).is_some()
}

/// The index of a primitive's material. The default material comes after those of the file.
pub(super) fn material_of(root: &Root, primitive: &Primitive) -> usize {
    primitive.material.map_or(root.materials.len(), |m| m.value())
}

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<usize> {
    primitive.attributes.get(&Checked::Valid(semantic)).map(|a| a.value())
}

/// The accessors of a primitive's sets of joints and weights, up to the first set that lacks one of them.
fn joints_and_weights(primitive: &Primitive) -> Vec<[usize; 2]> {
    let pair = |set| {
        Some([attribute(primitive, Semantic::Joints(set))?, attribute(primitive, Semantic::Weights(set))?])
    };
    (0..).map_while(pair).collect()
}

/// Bytes per mesh, without its triangles and vertices.
const MESH_BYTES: u64 = size_of::<Mesh>() as u64;
/// Bytes per triangle: its corners and its material.
const TRIANGLE_BYTES: u64 = 16;
/// Bytes per vertex: its position, texture coordinates and colour.
const VERTEX_BYTES: u64 = 24;
/// Bytes per vertex in the look-up table used while its mesh is built.
const TABLE_BYTES: u64 = 28;

impl<'a> MeshBuilder<'a> {
    pub(super) fn new(
        path: &'a Path,
        root: &'a Root,
        buffers: &'a Buffers<'a>,
        materials: &'a Materials,
        streams: &'a Streams,
        colors: bool,
    ) -> Self {
        let (opened, targets) = Default::default();
        Self { path, root, buffers, materials, streams, colors, opened, targets }
    }

    /// Builds one mesh from the given primitives.
    pub(super) fn build(
        &self,
        name: &str,
        primitives: &[&Primitive],
        pose: Pose<'_>,
        sieve: &mut Sieve,
    ) -> Result<Mesh> {
        let skin = pose.skin;
        let (_, vertices) = self.most(primitives, skin.is_some())?;
        let passing = vertices.saturating_mul(TABLE_BYTES);
        self.buffers.sources.budget.charge(passing, || format!("mesh {name:?} of {vertices} vertices"))?;
        let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
        let any_textured = primitives.iter().any(|p| self.texture(p).is_some());
        let any_colored = primitives.iter().any(|p| self.vertex_colors(p).is_some());
        let mut keys: HashMap<SourceKey, u32> = HashMap::new();
        let mut vertices: HashMap<(u32, u32), u32> = HashMap::new();
        for primitive in primitives {
            let Some(key) = self.source_key(primitive, skin.is_some()) else { continue };
            let coordinates = self.texture(primitive).map(|t| t.1);
            let source = self.open(name, primitive, &key, coordinates, pose)?;
            let next = keys.len() as u32;
            let key = *keys.entry(key).or_insert(next);
            let material = material_of(self.root, primitive) as u32;
            self.each_triangle(name, primitive, source.positions.base.count, |corners| {
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
                        if any_colored {
                            mesh.colors.push(source.color(corners[i]));
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
        mesh.colors.shrink_to_fit();
        mesh.triangles.shrink_to_fit();
        mesh.triangle_materials.shrink_to_fit();
        self.buffers.sources.budget.release(passing);
        Ok(mesh)
    }

    /// Charges the memory of `copies` copies of a mesh before any of it is allocated. The size is the largest
    /// that its accessors allow.
    pub(super) fn charge(
        &self,
        name: &str,
        primitives: &[&Primitive],
        skinned: bool,
        copies: u64,
    ) -> Result<()> {
        let (triangles, vertices) = self.most(primitives, skinned)?;
        let [triangles, vertices, names] =
            [triangles, vertices, name.len() as u64 + MESH_BYTES].map(|n| n.saturating_mul(copies));
        let bytes =
            triangles.saturating_mul(TRIANGLE_BYTES).saturating_add(vertices.saturating_mul(VERTEX_BYTES));
        self.buffers.sources.budget.charge(bytes.saturating_add(names), || {
            let what = match (copies, skinned) {
                (1, _) => "mesh".to_owned(),
                (_, true) => format!("{copies} skinned copies of mesh"),
                (_, false) => format!("{copies} morphed copies of mesh"),
            };
            format!("{what} {name:?} of up to {triangles} triangles and {vertices} vertices")
        })
    }

    /// Number of triangles that the given primitives state.
    pub(super) fn faces(&self, primitives: &[&Primitive]) -> Result<u64> {
        Ok(self.most(primitives, false)?.0)
    }

    /// Upper bounds on a mesh's triangle and vertex counts.
    fn most(&self, primitives: &[&Primitive], skinned: bool) -> Result<(u64, u64)> {
        let mut triangles = 0_u64;
        let mut corners_of: HashMap<SourceKey, (u64, u64)> = HashMap::new();
        for primitive in primitives {
            let Some(key) = self.source_key(primitive, skinned) else { continue };
            let positions = self.values(primitive, &Semantic::Positions, key.positions)?.count as u64;
            let corners = self.indices(primitive)?.map_or(positions, |i| i.count as u64);
            let made = match self.mode(primitive) {
                Checked::Valid(Mode::Triangles) => corners / 3,
                _ => corners.saturating_sub(2),
            };
            triangles = triangles.saturating_add(made);
            let named = corners_of.entry(key).or_insert((0, positions));
            named.0 = named.0.saturating_add(made.saturating_mul(3));
        }
        let vertices = corners_of.values().map(|&(corners, positions)| corners.min(positions));
        Ok((triangles, vertices.fold(0, u64::saturating_add)))
    }

    /// The key that decides whether a primitive shares its vertices with another one, or `None` without
    /// positions.
    fn source_key(&self, primitive: &Primitive, skinned: bool) -> Option<SourceKey> {
        let positions = attribute(primitive, Semantic::Positions)?;
        let joints_and_weights = if skinned { joints_and_weights(primitive) } else { Vec::new() };
        let colors = self.vertex_colors(primitive);
        let textured_material = self.texture(primitive).map(|t| t.0);
        let targets = primitive.targets.as_ref().map(|targets| {
            let list = targets.iter().map(|t| t.positions.map(|p| p.value())).collect();
            let mut known = self.targets.borrow_mut();
            let next = known.len();
            *known.entry(list).or_insert(next)
        });
        let stream = self.streams.of(primitive).map(|s| s.view);
        Some(SourceKey { positions, stream, joints_and_weights, colors, textured_material, targets })
    }

    /// The accessor of a primitive's vertex colours, if they are needed.
    fn vertex_colors(&self, primitive: &Primitive) -> Option<usize> {
        let material = self.materials.list.get(material_of(self.root, primitive));
        let cuts = material.is_some_and(|m| m.alpha != AlphaMode::Opaque);
        (self.colors || cuts).then(|| attribute(primitive, Semantic::Colors(0))).flatten()
    }

    /// The primitive's material and the texture coordinates it uses, or `None` if it has no texture.
    fn texture(&self, primitive: &Primitive) -> Option<(usize, Coordinates)> {
        let material = material_of(self.root, primitive);
        self.materials.coordinates.get(material).copied().flatten().map(|c| (material, c))
    }

    /// The values of an attribute: those of a Draco stream, or those of the accessor.
    fn values(&self, primitive: &Primitive, semantic: &Semantic, index: usize) -> Result<Rc<Accessor<'a>>> {
        if let Some(stream) = self.streams.of(primitive)
            && let Some(attribute) = stream.attribute(&semantic.to_string())
        {
            return Accessor::decoded(self.path, self.root, stream.decoded, attribute, index).map(Rc::new);
        }
        self.accessor(index)
    }

    /// The indices of a primitive: the corners of a Draco stream's triangles, or those of the accessor.
    fn indices(&self, primitive: &Primitive) -> Result<Option<Rc<Accessor<'a>>>> {
        if let Some(stream) = self.streams.of(primitive) {
            return Ok(Some(Rc::new(Accessor::corners(stream.decoded))));
        }
        primitive.indices.map(|index| self.accessor(index.value())).transpose()
    }

    /// The primitive mode of the indices. A Draco stream holds triangles, whatever mode the primitive states.
    fn mode(&self, primitive: &Primitive) -> Checked<Mode> {
        if self.streams.of(primitive).is_some() { Checked::Valid(Mode::Triangles) } else { primitive.mode }
    }

    fn accessor(&self, index: usize) -> Result<Rc<Accessor<'a>>> {
        if let Some(known) = self.opened.borrow().get(&index) {
            return Ok(known.clone());
        }
        let accessor = Rc::new(Accessor::open(self.path, self.root, self.buffers, index)?);
        self.opened.borrow_mut().insert(index, accessor.clone());
        Ok(accessor)
    }

    fn open(
        &self,
        mesh: &str,
        primitive: &Primitive,
        key: &SourceKey,
        coordinates: Option<Coordinates>,
        pose: Pose<'_>,
    ) -> Result<Source<'a>> {
        let broken = |what: &str| bad(self.path, format!("in mesh {mesh:?} {what}"));
        let open = |semantic: Semantic, index| self.values(primitive, &semantic, index);
        let positions = open(Semantic::Positions, key.positions)?;
        if positions.components != 3 {
            return Err(broken("a POSITION attribute is not made of three components"));
        }
        let mut targets = Vec::new();
        for (index, weight) in pose.weights.iter() {
            let target = primitive.targets.as_ref().and_then(|targets| targets.get(index));
            let Some(target) = target.and_then(|t| t.positions) else { continue };
            let target = self.accessor(target.value())?;
            if target.components != 3 || target.count < positions.count {
                return Err(broken("a morph target does not have a displacement for each vertex"));
            }
            targets.push((weight, target));
        }
        let positions = Morphed { base: positions, targets };
        let uvs = match coordinates {
            None => None,
            Some(c) => match attribute(primitive, Semantic::TexCoords(c.set)) {
                Some(index) => Some((open(Semantic::TexCoords(c.set), index)?, c)),
                None => None,
            },
        };
        let colors = key.colors.map(|index| open(Semantic::Colors(0), index)).transpose()?;
        if colors.as_ref().is_some_and(|c| !(3..=4).contains(&c.components)) {
            return Err(broken("a COLOR_0 attribute is not made of three or four components"));
        }
        let mut joints = Vec::with_capacity(key.joints_and_weights.len());
        for (set, &[j, w]) in (0..).zip(&key.joints_and_weights) {
            joints.push([open(Semantic::Joints(set), j)?, open(Semantic::Weights(set), w)?]);
        }
        Ok(Source { positions, uvs, colors, joints })
    }

    /// Calls `each` with the corners of every triangle, all less than `vertices`, wound as in glTF 2.0
    /// section 3.7.2.1.
    fn each_triangle(
        &self,
        mesh: &str,
        primitive: &Primitive,
        vertices: usize,
        mut each: impl FnMut([u32; 3]) -> Result<()>,
    ) -> Result<()> {
        let indices = self.indices(primitive)?;
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
        match self.mode(primitive) {
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
        let p = self.positions.at(at).unwrap_or([f32::NAN; 3]);
        let Some(skin) = skin else { return p };
        let influences = self.joints.iter().flat_map(|[joints, weights]| {
            let joints = joints.integers::<4>(at).unwrap_or_default();
            let weights = weights.floats::<4>(at).unwrap_or_default();
            joints.into_iter().zip(weights)
        });
        skin.place(p, influences)
    }

    /// The colour of a vertex: white if the file has none. A NaN component becomes 1.
    fn color(&self, index: u32) -> [u8; 4] {
        let read = |accessor: &Rc<Accessor<'_>>| {
            let [r, g, b, a] = accessor.floats(index as usize)?;
            Some([r, g, b, if accessor.components == 4 { a } else { 1.0 }])
        };
        let linear = self.colors.as_ref().and_then(read).unwrap_or([1.0; 4]);
        let [r, g, b, a] = linear.map(|c| if c.is_nan() { 1.0 } else { c.clamp(0.0, 1.0) });
        let [r, g, b] = [r, g, b].map(linear_to_srgb);
        [r, g, b, (a * 255.0 + 0.5) as u8]
    }

    fn uv(&self, index: u32) -> [f32; 2] {
        let Some((accessor, coordinates)) = &self.uvs else { return [0.0; 2] };
        coordinates.apply(accessor.floats(index as usize).unwrap_or_default())
    }
}
