//! Loads glTF 2.0 (Khronos): `.glb`, and `.gltf` with its buffers beside it or in data URIs.
//!
//! The `gltf` crate parses the container and the JSON; accessors are read here with their bounds checked, so that
//! no file can make it panic, and quantised positions work. A mesh is stored once however many nodes place it.
//! Animations of nodes make movers; morph targets, vertex colours, cameras and lights are not read.

mod accessor;
mod animations;
mod container;
mod images;
mod materials;
mod meshes;
mod nodes;
mod skin;

use std::path::Path;

use ::gltf::json::{Root, mesh::Primitive};
use hashbrown::HashMap;

use super::affine::{self, IDENTITY};
use super::movers::{Mover, MoverPolicy, Movers};
use super::sources::Sources;
use super::validate::{Sieve, finish};
use super::{Instance, LoadNotes, LoadOptions, Scene};
use crate::error::{Error, Result};
use animations::Animations;
use container::{Buffers, bad};
use meshes::{Builder, has_triangles, material_of};
use nodes::Nodes;

/// Required extensions that are understood, or that change nothing about what is opaque where.
const KNOWN_EXTENSIONS: [&str; 22] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Bytes of an object of the file's JSON once it is read: of an empty node, which takes three bytes there.
const OBJECT_BYTES: u64 = 512;

/// A node's mesh with the primitives of it that the filter keeps.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Variant {
    mesh: usize,
    kept: Vec<u32>,
    /// The node, where it has a skin: its vertices are its own.
    skinned: Option<usize>,
}

/// Loads a `.glb` or `.gltf` file.
pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let sources = Sources::new(path, "glTF", options);
    let bytes = sources.read_scene()?;
    let (json, bin) = container::split(path, &bytes)?;
    let objects = json.iter().filter(|&&byte| byte == b'{').count() as u64;
    sources.budget.charge(objects * OBJECT_BYTES + json.len() as u64, || {
        format!("the {objects} objects of its JSON")
    })?;
    let root = parse(path, &json)?;
    note_named(&sources, &root)?;
    let nodes = Nodes::load(path, &root)?;
    let mut scene = Scene::default();
    let mut sieve = Sieve::default();
    let plan = choose(path, &root, &nodes, options, &mut sieve, &mut scene.notes)?;
    let buffers = Buffers::load(&sources, &root, bin)?;

    let mut used = vec![false; root.materials.len() + 1];
    for (variant, _) in &plan.variants {
        for primitive in kept(&root, variant) {
            let material = material_of(&root, primitive);
            match used.get_mut(material) {
                Some(used) => *used = true,
                None => {
                    return Err(bad(
                        path,
                        format!("a primitive has material {material}, which does not exist"),
                    ));
                }
            }
        }
    }
    let materials = materials::load(&root, &buffers, options, &used, &mut scene.notes)?;

    let builder = Builder::new(path, &root, &buffers, &materials);
    for (variant, name) in &plan.variants {
        let skin = variant.skinned.zip(variant.skinned.and_then(|n| root.nodes.get(n)?.skin));
        let skin = match skin {
            Some((node, s)) => Some(skin::Skin::load(path, &root, &buffers, &nodes, s.value(), node)?),
            None => None,
        };
        let primitives: Vec<&Primitive> = kept(&root, variant).collect();
        scene.meshes.push(builder.build(name, &primitives, skin.as_ref(), &mut sieve)?);
    }
    drop(builder);
    let animations = Animations::load(path, &root, &buffers, &nodes, &mut scene.notes)?;
    let placer = Placer { path, root: &root, buffers: &buffers, nodes: &nodes, animations: &animations };
    let mut movers = Vec::new();
    for placing in &plan.placings {
        placer.place(placing, &mut scene, &mut movers)?;
    }
    placer.note_moving_skins(&plan, &mut scene.notes);
    scene.movers = Movers::new(movers, animations.moving);
    scene.notes.named_files = sources.named_files();
    (scene.materials, scene.textures) = (materials.list, materials.textures);
    scene.pose(0.0);
    match options.movers {
        MoverPolicy::Keep => {}
        MoverPolicy::LeaveOut => scene.notes.movers_left_out = scene.remove_movers() as u64,
        MoverPolicy::Freeze => scene.movers = Movers::default(),
    }
    finish(path, scene, &sieve, options)
}

/// Remembers the files of all buffers and images, whether they are needed or not.
fn note_named(sources: &Sources<'_>, root: &Root) -> Result<()> {
    let buffers = root.buffers.iter().filter_map(|b| b.uri.as_deref());
    let images = root.images.iter().filter_map(|i| i.uri.as_deref());
    let mut files = buffers.chain(images).filter(|uri| !uri.starts_with("data:"));
    files.try_for_each(|uri| sources.note_named(&container::file_name(uri)))
}

fn parse(path: &Path, json: &[u8]) -> Result<Root> {
    /// What is read first, because the rest may make no sense without the extension.
    #[derive(serde::Deserialize)]
    struct Required {
        #[serde(default, rename = "extensionsRequired")]
        extensions: Vec<String>,
    }
    let invalid = |e: serde_json::Error| bad(path, format!("its JSON is broken: {e}"));
    let required: Required = serde_json::from_slice(json).map_err(invalid)?;
    for extension in required.extensions {
        if !KNOWN_EXTENSIONS.contains(&extension.as_str()) {
            return Err(Error::RequiredExtension { path: path.to_owned(), extension });
        }
    }
    serde_json::from_slice(json).map_err(invalid)
}

/// What is to be built and where it goes.
#[derive(Default)]
struct Plan {
    /// Each with the mesh's name.
    variants: Vec<(Variant, String)>,
    placings: Vec<Placing>,
}

/// A variant, the node that places it, and whether it casts.
struct Placing {
    variant: u32,
    node: usize,
    casts: bool,
}

/// Applies the filter and groups nodes that place the same thing.
fn choose(
    path: &Path,
    root: &Root,
    nodes: &Nodes,
    options: &LoadOptions,
    sieve: &mut Sieve,
    notes: &mut LoadNotes,
) -> Result<Plan> {
    let mut plan = Plan::default();
    let mut known: HashMap<Variant, u32> = HashMap::new();
    let mut seen = vec![false; root.meshes.len()];
    // Variants of meshes of which every primitive is kept, so that each mesh is looked through once.
    let mut whole: Vec<Option<u32>> = vec![None; root.meshes.len()];
    let (mut skinned, mut morphed) = (0, 0);
    for &(node, casts) in &nodes.drawn {
        let json = &root.nodes[node];
        let Some(index) = json.mesh.map(|m| m.value()) else { continue };
        let (Some(mesh), Some(seen)) = (root.meshes.get(index), seen.get_mut(index)) else {
            return Err(bad(path, format!("node {node} has mesh {index}, which does not exist")));
        };
        let node_name = nodes::name(json, node);
        let mesh_name = mesh.name.clone().unwrap_or_else(|| format!("mesh {index}"));
        let unfiltered = options.filter.is_empty() && json.skin.is_none();
        if let Some(&Some(variant)) = whole.get(index)
            && unfiltered
        {
            plan.placings.push(Placing { variant, node, casts: casts && nodes::casts(&mesh.extras) });
            continue;
        }
        if !std::mem::replace(seen, true) {
            notes.skipped_primitives += mesh.primitives.iter().filter(|p| !has_triangles(p)).count() as u64;
            morphed += u32::from(mesh.primitives.iter().any(|p| p.targets.is_some()));
        }
        let keeps = |p: &Primitive| {
            options.filter.is_empty()
                || options.filter.keeps(&node_name, &mesh_name, &materials::name(root, material_of(root, p)))
        };
        let mut kept = Vec::new();
        for (i, primitive) in mesh.primitives.iter().enumerate().filter(|(_, p)| has_triangles(p)) {
            if keeps(primitive) {
                kept.push(i as u32);
            } else {
                sieve.filtered = true;
            }
        }
        if kept.is_empty() {
            continue;
        }
        skinned += u32::from(json.skin.is_some());
        let variant = Variant { mesh: index, kept, skinned: json.skin.map(|_| node) };
        let next = plan.variants.len() as u32;
        let number = *known.entry_ref(&variant).or_insert(next);
        if number == next {
            plan.variants.push((variant, mesh_name));
        }
        if unfiltered {
            whole[index] = Some(number);
        }
        plan.placings.push(Placing { variant: number, node, casts: casts && nodes::casts(&mesh.extras) });
    }
    if skinned > 0 {
        notes
            .warnings
            .push(format!("{skinned} skinned meshes stand in the pose that the file's nodes give them"));
    }
    if morphed > 0 {
        notes.warnings.push(format!("{morphed} meshes have morph targets, which are ignored"));
    }
    Ok(plan)
}

fn kept<'a>(root: &'a Root, variant: &'a Variant) -> impl Iterator<Item = &'a Primitive> {
    let primitives = root.meshes.get(variant.mesh).map_or(&[][..], |m| &m.primitives);
    variant.kept.iter().filter_map(|&i| primitives.get(i as usize))
}

/// What instances are made from.
struct Placer<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    nodes: &'a Nodes,
    animations: &'a Animations,
}

impl Placer<'_> {
    /// Adds the instances of a placing, and those of them that move to `movers`.
    fn place(&self, placing: &Placing, scene: &mut Scene, movers: &mut Vec<Mover>) -> Result<()> {
        let &Placing { variant, node, casts } = placing;
        let json = &self.root.nodes[node];
        let name = nodes::name(json, node);
        let budget = &self.buffers.sources.budget;
        let each = (size_of::<Instance>() + size_of::<Mover>() + name.len()) as u64;
        let mut add = |world_from_mesh| {
            let name = name.clone();
            scene.instances.push(Instance { name, mesh: variant, world_from_mesh, casts });
            scene.instances.len() as u32 - 1
        };
        if json.skin.is_some() {
            budget.charge(each, || format!("the instances of node {node}"))?;
            add(IDENTITY);
            return Ok(());
        }
        let maps = nodes::gpu_instances(self.path, self.root, self.buffers, node)?;
        let maps = maps.as_deref().unwrap_or(&[IDENTITY]);
        budget.charge(each.saturating_mul(maps.len() as u64), || format!("the instances of node {node}"))?;
        for map in maps {
            let world_from_mesh = affine::multiply(&self.nodes.world[node], map);
            if !affine::is_finite(&world_from_mesh) {
                let what = format!("the transform of node {:?}", nodes::name(json, node));
                return Err(Error::NotFinite { path: self.path.to_owned(), what });
            }
            let instance = add(world_from_mesh);
            if let Some((on, moving_from_node)) = self.animations.of_node(node) {
                let node_from_mesh = affine::multiply(&moving_from_node, map);
                movers.push(Mover { instance, node: on, node_from_mesh });
            }
        }
        Ok(())
    }

    /// Skins stand in the pose of the file's nodes, whatever their joints do.
    fn note_moving_skins(&self, plan: &Plan, notes: &mut LoadNotes) {
        let skins = plan.placings.iter().filter_map(|p| self.root.nodes[p.node].skin);
        let count = skins.filter(|s| self.animations.moves_skin(self.root, s.value())).count();
        if count > 0 {
            notes
                .warnings
                .push(format!("{count} skinned meshes have animated joints, which do not move them"));
        }
    }
}
