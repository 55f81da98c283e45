//! The scene model shared by the bake, the ray tracer and the renderer: triangle meshes, their instances, and
//! materials that define where a surface is opaque. Right-handed, Y up, metres, as in glTF 2.0.
//!
//! Loaders ([`load`]) validate: after loading, every vertex and transform is finite, every index is in range,
//! and at least one triangle casts a shadow.

#![forbid(unsafe_code)]

mod affine;
mod budget;
mod camera;
pub mod daylight;
mod edit;
mod error;
mod far_origin;
mod filter;
mod generate;
mod glb;
mod gltf;
mod heights;
mod ktx2;
mod loaded_as;
mod mips;
mod movers;
mod notes;
mod obj;
mod one_line;
mod ply;
mod polygon;
pub mod random;
mod sources;
mod srgb;
mod subdivide;
mod texture;
pub mod topology;
mod triangles;
mod unmatched;
mod up;
mod usual_size;
mod validate;

use std::path::Path;

use adumbra::Bounds;

use one_line::one_line;

pub use camera::{Camera, Projection, View};
pub use edit::{Added, Edits, Moved, Which};
pub use error::{EmptyReason, Error, Result};
pub use filter::NameFilter;
pub use generate::{GeneratedKind, generate, icosphere};
pub use glb::{to_glb, write_glb};
pub use gltf::{files_of_gltf, write_shadow_name};
pub use heights::{HeightSurface, Heights, from_heights};
pub use loaded_as::LoadedAs;
pub use mips::{MipLevel, MippedTexture};
pub use movers::{MoverPolicy, Movers};
pub use notes::{Counts, LoadNotes, Omission};
pub use srgb::{linear_to_srgb, srgb_to_linear};
pub use texture::{Pixels, Texture, Wrap};
pub use triangles::from_triangles;
pub use unmatched::{UnmatchedPattern, pattern_of};
pub use up::UpAxis;

/// A scene: meshes stored once, placed by instances.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Meshes, each stored once however often it is placed.
    pub meshes: Vec<Mesh>,
    /// Placements of the meshes.
    pub instances: Vec<Instance>,
    /// Materials, referenced by index from triangles; never empty if there are meshes.
    pub materials: Vec<Material>,
    /// Textures, referenced by index from materials.
    pub textures: Vec<Texture>,
    /// The instances that move, and how. Their `world_from_mesh` is their position at the time last passed to
    /// [`Scene::pose`], initially 0. A bake treats every instance as static: call [`Scene::remove_movers`]
    /// first.
    pub movers: Movers,
    /// The axis that points up in the file that the scene was loaded from. The scene itself is Y up.
    pub up: UpAxis,
    /// The directional lights of the file that shine, in the order of its nodes. The first is the default sun
    /// of every verb.
    pub suns: Vec<FileSun>,
    /// Counts and warnings from loading.
    pub notes: LoadNotes,
}

/// A directional light of the scene's file (`KHR_lights_punctual`).
#[derive(Clone, Debug, PartialEq)]
pub struct FileSun {
    /// The node's name, or `node 7` if it is unnamed.
    pub name: String,
    /// Vector in world space from the scene towards the light, opposite to the direction in which it shines.
    /// It has the length of the node's Z axis, because normalizing it would change the last bits of the sun.
    /// It is never zero.
    pub towards: [f64; 3],
}

impl FileSun {
    /// Returns the vector towards the light with a length of 1.
    pub fn unit_towards(&self) -> [f64; 3] {
        // The squares of very small components would be 0.
        let largest = self.towards.iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
        let scaled = self.towards.map(|c| c / largest);
        let length = scaled.iter().map(|c| c * c).sum::<f64>().sqrt();
        scaled.map(|c| c / length)
    }
}

/// Triangles in a mesh's own space.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// The mesh's name, or a generated one.
    pub name: String,
    /// Vertex positions in the mesh's own space, all finite.
    pub positions: Vec<[f32; 3]>,
    /// Texture coordinates used by the material's base-colour texture, already transformed
    /// (KHR_texture_transform); empty, or one per vertex.
    pub uvs: Vec<[f32; 2]>,
    /// Vertex colours (glTF's COLOR_0), which multiply the material's base colour and alpha: red, green and
    /// blue as sRGB bytes, to be interpolated in linear light, and linear alpha. Empty for white, or one per
    /// vertex.
    pub colors: Vec<[u8; 4]>,
    /// Three vertex indices per triangle, all in range; degenerate triangles are already removed.
    pub triangles: Vec<[u32; 3]>,
    /// The material of each triangle, an index into [`Scene::materials`].
    pub triangle_materials: Vec<u32>,
}

/// One placement of a mesh in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The node's name.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Affine map, row major: `world[r] = m[r][0..3] · mesh + m[r][3]`.
    pub world_from_mesh: [[f64; 4]; 3],
    /// False if `extras: {"adumbra": {"cast": false}}` marks the instance as casting no shadow (it still
    /// receives shadows).
    pub casts: bool,
}

/// Counts of the shadow casters in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Casters {
    /// Triangles, counting every instance.
    pub triangles: u64,
    /// Instances.
    pub instances: u64,
}

/// How a material treats alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Opaque everywhere.
    Opaque,
    /// Opaque where alpha >= the cut-off. BLEND materials are loaded as `Mask` with cut-off 0.5 and `blended`
    /// set.
    Mask {
        /// Alpha at or above this is opaque.
        cutoff: f32,
    },
}

/// A surface material, reduced to what shadows and the CPU renderer need.
#[derive(Clone, Debug)]
pub struct Material {
    /// The material's name.
    pub name: String,
    /// Linear base colour factor and alpha factor, 0 to 1.
    pub base_color: [f32; 4],
    /// Base-colour texture (alpha in its fourth channel), an index into [`Scene::textures`].
    pub texture: Option<u32>,
    /// Where the surface is opaque.
    pub alpha: AlphaMode,
    /// True if the material was glTF BLEND.
    pub blended: bool,
    /// Share of the sun's light that passes through the surface, 0 to 1: the factor of
    /// KHR_materials_transmission, or what [`from_triangles`] was given. A bake counts the surface as opaque
    /// all the same. Above 0, it is never part of a solid.
    pub transmissivity: f32,
    /// False if the extras mark the material as casting no shadow.
    pub casts: bool,
}

/// Options for loading a scene.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Which nodes, meshes and materials to keep.
    pub filter: NameFilter,
    /// Load colour textures too. If false, only textures that decide opacity are read.
    pub color_textures: bool,
    /// Treat every material as opaque; no texture is needed then.
    pub ignore_alpha: bool,
    /// How to treat animated instances.
    pub movers: MoverPolicy,
    /// The axis that points up in an OBJ or PLY file. If it is [`UpAxis::Z`], the scene is turned, so that
    /// (x, y, z) of the file is (x, z, −y) of the scene. `None` takes Y, and [`LoadNotes::looks_z_up`] says
    /// whether that may be wrong. glTF defines Y as up: another axis is [`Error::GltfIsYUp`].
    pub up: Option<UpAxis>,
    /// Also read files outside the scene's folder. If false, an absolute path, a path that leaves the folder
    /// through `..`, and a link that leads out of it are [`Error::OutsideScene`].
    pub allow_outside: bool,
    /// Limit on the memory that the load may hold: files, decoded textures, triangles, vertices and
    /// instances, counted before they are allocated. Exceeding it is [`Error::SceneMemory`]. The default is 2
    /// GiB plus 64 bytes for each byte of the scene's files, so that a small file cannot exhaust memory while
    /// a large file still loads.
    pub max_memory_bytes: Option<u64>,
    /// Edits of the instances, applied after everything else.
    pub edits: Edits,
    /// Treat everything that the loader leaves out as an error: [`Error::Omitted`] instead of
    /// [`LoadNotes::omissions`].
    pub strict: bool,
}

impl Material {
    /// An opaque material of one linear colour, 0 to 1.
    pub fn opaque(name: &str, base_color: [f32; 4]) -> Self {
        Self {
            name: name.to_owned(),
            base_color,
            texture: None,
            alpha: AlphaMode::Opaque,
            blended: false,
            transmissivity: 0.0,
            casts: true,
        }
    }

    /// Whether a surface of this material can bound a solid.
    pub(crate) fn can_be_solid(&self) -> bool {
        self.alpha == AlphaMode::Opaque && self.transmissivity == 0.0
    }
}

impl Mesh {
    /// Texture coordinates of a triangle's corners; zero if the mesh has none.
    pub fn corner_uvs(&self, triangle: u32) -> [[f32; 2]; 3] {
        self.corners_of(triangle, &self.uvs).map(Option::unwrap_or_default)
    }

    /// Alpha of a triangle's corners, 0 to 1; 1 for a mesh without vertex colours.
    pub fn corner_alphas(&self, triangle: u32) -> [f32; 3] {
        self.corners_of(triangle, &self.colors).map(|c| c.map_or(1.0, |c| f32::from(c[3]) / 255.0))
    }

    /// Alpha of the vertex colours at a point in a triangle, given by barycentric `weights`; exactly 1 for a
    /// mesh without vertex colours.
    pub fn alpha_at(&self, triangle: u32, weights: [f64; 3]) -> f32 {
        if self.colors.is_empty() {
            return 1.0;
        }
        let alphas = self.corner_alphas(triangle).map(f64::from);
        (0..3).map(|c| weights[c] * alphas[c]).sum::<f64>() as f32
    }

    /// Linear red, green and blue of a triangle's corners; white for a mesh without vertex colours.
    pub fn corner_colors(&self, triangle: u32) -> [[f32; 3]; 3] {
        let linear = |[r, g, b, _]: [u8; 4]| [r, g, b].map(srgb_to_linear);
        self.corners_of(triangle, &self.colors).map(|c| c.map_or([1.0; 3], linear))
    }

    /// Adds the midpoint of two vertices and returns its index. The result does not depend on their order.
    /// Colours are averaged in linear light.
    pub fn add_middle(&mut self, [a, b]: [u32; 2]) -> u32 {
        let [a, b] = [a as usize, b as usize];
        // Exact in f64, so rounded only once.
        let between = |x: f32, y: f32| ((f64::from(x) + f64::from(y)) / 2.0) as f32;
        let (p, q) = (self.positions[a], self.positions[b]);
        self.positions.push([0, 1, 2].map(|i| between(p[i], q[i])));
        if !self.uvs.is_empty() {
            let (s, t) = (self.uvs[a], self.uvs[b]);
            self.uvs.push([0, 1].map(|i| between(s[i], t[i])));
        }
        if !self.colors.is_empty() {
            let (c, d) = (self.colors[a], self.colors[b]);
            let color = |i: usize| linear_to_srgb(between(srgb_to_linear(c[i]), srgb_to_linear(d[i])));
            self.colors.push([color(0), color(1), color(2), c[3].midpoint(d[3])]);
        }
        self.positions.len() as u32 - 1
    }

    fn corners_of<T: Copy>(&self, triangle: u32, of: &[T]) -> [Option<T>; 3] {
        self.triangles[triangle as usize].map(|vertex| of.get(vertex as usize).copied())
    }
}

impl Instance {
    /// The point `p_mesh` in world space.
    pub fn to_world(&self, p_mesh: [f32; 3]) -> [f64; 3] {
        let p = p_mesh.map(f64::from);
        self.world_from_mesh.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
    }

    /// Determinant of the linear part; negative if the instance is mirrored.
    pub fn determinant(&self) -> f64 {
        let m = &self.world_from_mesh;
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    }
}

impl Scene {
    /// Number of triangles, counting every instance.
    pub fn instanced_triangles(&self) -> u64 {
        self.instances.iter().map(|i| self.meshes[i.mesh as usize].triangles.len() as u64).sum()
    }

    /// Counts the shadow casters: their triangles, counting every instance, and their instances. The header
    /// of a shadow file has these two numbers of the scene that it was baked from.
    pub fn casters(&self) -> Casters {
        let casts =
            |m: &Mesh| m.triangle_materials.iter().filter(|&&m| self.materials[m as usize].casts).count();
        let of_mesh: Vec<u64> = self.meshes.iter().map(|mesh| casts(mesh) as u64).collect();
        let casting = self.instances.iter().filter(|instance| instance.casts);
        let triangles = casting.clone().map(|instance| of_mesh[instance.mesh as usize]).sum();
        Casters { triangles, instances: casting.count() as u64 }
    }

    /// Number of stored triangles, counting each mesh once.
    pub fn stored_triangles(&self) -> u64 {
        self.meshes.iter().map(|m| m.triangles.len() as u64).sum()
    }

    /// Bytes held by meshes, instances and textures.
    pub fn memory_bytes(&self) -> u64 {
        let meshes = self.meshes.iter().map(|m| {
            m.positions.capacity() * 12
                + m.uvs.capacity() * 8
                + m.colors.capacity() * 4
                + m.triangles.capacity() * 12
                + m.triangle_materials.capacity() * 4
        });
        let textures = self.textures.iter().map(Texture::memory_bytes);
        let instances = self.instances.iter().map(|i| size_of::<Instance>() + i.name.capacity());
        meshes.chain(textures).chain(instances).sum::<usize>() as u64
    }

    /// Bounding box of the vertices of all placed triangles. Cost: one pass over the instanced vertices.
    pub fn bounds(&self) -> Bounds {
        let mut b = Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
        for instance in &self.instances {
            let mesh = &self.meshes[instance.mesh as usize];
            for &p in mesh.triangles.iter().flatten().map(|&i| &mesh.positions[i as usize]) {
                let p_world = instance.to_world(p);
                for (a, c) in p_world.into_iter().enumerate() {
                    b.min[a] = b.min[a].min(c);
                    b.max[a] = b.max[a].max(c);
                }
            }
        }
        b
    }

    /// Alpha of `material` at `uv`: factor × texture × `vertex_alpha`. Rays and the bake share this function.
    #[inline]
    pub fn alpha(&self, material: u32, uv: [f32; 2], vertex_alpha: f32) -> f32 {
        let m = &self.materials[material as usize];
        let texel = m.texture.map_or(1.0, |t| self.textures[t as usize].alpha(uv));
        m.base_color[3] * texel * vertex_alpha
    }

    /// Whether `material` is opaque at `uv`, given the interpolated vertex alpha there. Cost: one bilinear
    /// texture sample for masked materials.
    #[inline]
    pub fn is_opaque(&self, material: u32, uv: [f32; 2], vertex_alpha: f32) -> bool {
        match self.materials[material as usize].alpha {
            AlphaMode::Opaque => true,
            AlphaMode::Mask { cutoff } => self.alpha(material, uv, vertex_alpha) >= cutoff,
        }
    }
}

/// Loads a scene. The file extension selects the format: `.glb`, `.gltf`, `.obj`, `.ply`.
///
/// # Errors
/// Returns an [`Error`] if something is missing, unreadable, outside the scene's folder, too large or
/// invalid. It names the file, the part of it and the remedy.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let mut scene = match ending(path).as_str() {
        "glb" | "gltf" if options.up == Some(UpAxis::Z) => {
            return Err(Error::GltfIsYUp { path: path.to_owned() });
        }
        "glb" | "gltf" => gltf::load(path, options)?,
        "obj" => obj::load(path, options)?,
        "ply" => ply::load(path, options)?,
        _ => return Err(Error::UnknownSceneFormat { path: path.to_owned() }),
    };
    match options.up {
        Some(up) => scene.turn_up(up),
        None if !is_gltf(path) => scene.notes.looks_z_up = up::looks_z_up(&scene.bounds()),
        None => {}
    }
    let notes = &mut scene.notes;
    for text in notes.omissions.iter_mut().map(|omission| &mut omission.what).chain(&mut notes.warnings) {
        let line = one_line(text).to_string();
        *text = line;
    }
    if options.strict && !scene.notes.omissions.is_empty() {
        return Err(Error::Omitted { path: path.to_owned(), omissions: scene.notes.omissions });
    }
    let mut patterns = scene.notes.unmatched_patterns.clone();
    patterns.retain(|pattern| !pattern.is_of_hidden);
    if options.strict && !patterns.is_empty() {
        return Err(Error::Unmatched { path: path.to_owned(), patterns });
    }
    if options.edits != Edits::default() {
        scene.edit(&options.edits)?;
    }
    Ok(scene)
}

fn ending(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// Whether a path's extension is that of a glTF file, the format in which Y is up by definition.
pub fn is_gltf(path: &Path) -> bool {
    matches!(ending(path).as_str(), "glb" | "gltf")
}
