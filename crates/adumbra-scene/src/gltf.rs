//! Loads glTF 2.0 (Khronos): `.glb`, and `.gltf` with its buffers in separate files or in data URIs.
//!
//! [`document`] reads the JSON, element by element, into the types of the `gltf` crate. Accessors are read
//! here with bounds checks, so that no file can cause a panic and quantised positions work. A mesh is stored
//! once, however many nodes use it. Node animations become movers, and directional lights become suns. Morph
//! targets have their default weights. Cameras are not read.

mod accessor;
mod animations;
mod casting;
mod container;
mod document;
mod draco;
mod extents;
mod faults;
mod files;
mod images;
mod materials;
mod meshes;
mod meshopt;
mod morphs;
mod nodes;
mod numbers;
mod shadow_name;
mod skin;
mod transforms;
mod uris;

pub use files::files_of_gltf;
pub use shadow_name::write_shadow_name;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use ::gltf::json::{Root, mesh::Primitive};
use hashbrown::HashMap;

use crate::affine::IDENTITY;
use crate::filter::{Marks, NameFilter};
use crate::movers::{Mover, MoverPolicy, Movers};
use crate::sources::Sources;
use crate::validate::{Sieve, finish};
use crate::{Error, Instance, LoadNotes, LoadOptions, Mesh, Result, Scene, affine};
use animations::Animations;
use casting::Casting;
use container::Buffers;
use document::GltfDocument;
use draco::Streams;
use extents::{Extents, MeshBox};
use faults::{Faults, bad};
use materials::Materials;
use meshes::{MeshBuilder, Pose, has_triangles, material_of};
use morphs::Weights;
use nodes::Nodes;
use skin::Skins;

/// Required extensions that are supported, or that do not affect opacity.
const KNOWN_EXTENSIONS: [&str; 29] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    draco::EXTENSION,
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
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
    "MSFT_screencoverage",
];

/// A mesh and those of its primitives that the filter keeps.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Selection {
    mesh: usize,
    kept: Vec<u32>,
}

/// A mesh to build for the scene.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Variant {
    /// Index into [`Plan::selections`].
    selection: u32,
    /// The node, if it has a skin: skinned vertices are not shared between nodes.
    skinned: Option<usize>,
    /// The weights of its morph targets.
    weights: Weights,
}

/// Loads a `.glb` or `.gltf` file.
pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let sources = Sources::new(path, "glTF", options);
    let bytes = sources.read_scene()?;
    let container::Container { json, bin, .. } = container::split(path, &bytes)?;
    let GltfDocument { root, transforms, lights, other_targets, other_channels, faults, warnings } =
        GltfDocument::parse(path, json, &sources.budget)?;
    let mut scene = Scene::default();
    scene.notes.warnings = warnings;
    if let Some(extension) = root.extensions_required.iter().find(|e| !is_known(e)) {
        return Err(Error::RequiredExtension { path: path.to_owned(), extension: extension.clone() });
    }
    note_unknown(&root, json, &mut scene.notes);
    scene.notes.omit("morph targets of texture coordinates or colours", other_targets);
    scene.notes.omit(animations::OTHER_CHANNELS, other_channels);
    note_named(&sources, &root)?;
    let mut casting = Casting::default();
    let nodes = Nodes::load(path, &root, transforms, &lights, &faults, &mut casting)?;
    scene.suns = nodes.suns(&root);
    scene.notes.omit("nodes with meshes outside the default scene", nodes.unreached);
    let mut sieve = Sieve::default();
    sieve.empty_scene = nodes.is_empty_scene;
    let buffers = Buffers::load(&sources, &root, &faults, bin, &mut scene.notes)?;
    let plan = choose(&buffers, &root, &nodes, options, &mut sieve, &mut casting, &mut scene.notes)?;

    let used = used_materials(&plan, &root, &faults, path)?;
    let materials = materials::load(&root, &buffers, options, &used, &mut casting, &mut scene.notes)?;
    scene.notes.warnings.extend(casting.warning());

    scene.notes.read.meshes = root.meshes.len() as u64;
    scene.notes.read.nodes = root.nodes.len() as u64;
    let sources_of_meshes =
        MeshSources { root: &root, buffers: &buffers, nodes: &nodes, materials: &materials };
    scene.meshes = sources_of_meshes.build(&plan, options, &mut sieve, &mut scene.notes)?;
    place_instances(&plan, &root, &buffers, &nodes, &mut scene)?;
    scene.notes.warnings.extend(faults.warnings().chain(buffers.warning()));
    scene.notes.named_files = sources.named_files();
    (scene.materials, scene.textures) = (materials.list, materials.textures);
    scene.pose(0.0);
    match options.movers {
        MoverPolicy::Keep => {}
        MoverPolicy::Skip => scene.notes.skipped_movers = scene.remove_movers() as u64,
        MoverPolicy::Freeze => scene.movers = Movers::default(),
    }
    finish(path, scene, &sieve, options)
}

/// Returns, for each material and then for the default material, whether a primitive to build uses it.
fn used_materials(plan: &Plan, root: &Root, faults: &Faults, path: &Path) -> Result<Vec<bool>> {
    let mut used = vec![false; root.materials.len() + 1];
    for primitive in plan.selections.iter().flat_map(|selection| selection.primitives(root)) {
        let material = material_of(root, primitive);
        faults.check(path, "material", material)?;
        match used.get_mut(material) {
            Some(used) => *used = true,
            None => {
                return Err(bad(path, format!("a primitive has material {material}, which does not exist")));
            }
        }
    }
    Ok(used)
}

/// The sources of the meshes to build.
struct MeshSources<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    nodes: &'a Nodes,
    materials: &'a Materials,
}

impl MeshSources<'_> {
    /// Builds a mesh for each variant of the plan.
    fn build(
        &self,
        plan: &Plan,
        options: &LoadOptions,
        sieve: &mut Sieve,
        notes: &mut LoadNotes,
    ) -> Result<Vec<Mesh>> {
        let &Self { root, buffers, nodes, materials } = self;
        let path = buffers.sources.scene;
        let mut streams = Streams::default();
        for selection in &plan.selections {
            let primitives = selection.kept.iter().copied().zip(selection.primitives(root));
            streams.decode(path, root, buffers, &mesh_name(root, selection.mesh), primitives)?;
        }
        let builder = MeshBuilder::new(path, root, buffers, materials, &streams, options.color_textures);
        // Count the memory for everything before building anything: each skinned node takes a few bytes in
        // the file, but becomes a separate mesh.
        for ((selection, is_skinned), copies) in plan.copies() {
            let selection = &plan.selections[selection as usize];
            let primitives: Vec<&Primitive> = selection.primitives(root).collect();
            builder.charge(&mesh_name(root, selection.mesh), &primitives, is_skinned, copies)?;
        }
        for selection in &plan.selections {
            let primitives: Vec<&Primitive> = selection.primitives(root).collect();
            notes.read.faces += builder.faces(&primitives)?;
        }
        let mut meshes = Vec::new();
        let mut skins = Skins::new(path, root, buffers, nodes);
        for variant in &plan.variants {
            let skin = match variant.skinned.and_then(|node| Some((node, root.nodes.get(node)?.skin?))) {
                Some((node, skin)) => Some(skins.load(skin.value(), node)?),
                None => None,
            };
            let selection = &plan.selections[variant.selection as usize];
            let primitives: Vec<&Primitive> = selection.primitives(root).collect();
            let name = mesh_name(root, selection.mesh);
            let pose = Pose { skin: skin.as_ref(), weights: &variant.weights };
            meshes.push(builder.build(&name, &primitives, pose, sieve)?);
        }
        Ok(meshes)
    }
}

/// Places the instances of the plan, and reads the animations that move them.
fn place_instances(
    plan: &Plan,
    root: &Root,
    buffers: &Buffers<'_>,
    nodes: &Nodes,
    scene: &mut Scene,
) -> Result<()> {
    let path = buffers.sources.scene;
    let extents = extents_of(plan, &scene.meshes, nodes, root, buffers)?;
    let animations = Animations::load(path, root, buffers, &extents, &mut scene.notes)?;
    let placer = Placer { path, root, buffers, nodes, animations: &animations };
    let mut movers = Vec::new();
    for instance in &plan.instances {
        placer.place(instance, scene, &mut movers)?;
    }
    placer.note_moving_skins(plan, &mut scene.notes);
    scene.movers = Movers::new(movers, animations.moving);
    Ok(())
}

/// Records the files of all buffers and images, whether they are needed or not.
fn note_named(sources: &Sources<'_>, root: &Root) -> Result<()> {
    files::named(root).try_for_each(|file| sources.note_named(&file))
}

fn is_known(extension: &str) -> bool {
    KNOWN_EXTENSIONS.contains(&extension) || IMMATERIAL.iter().any(|prefix| extension.starts_with(prefix))
}

/// Prefixes of unknown extensions that a file may require, because they affect only how lit surfaces look.
const IMMATERIAL: [&str; 1] = ["KHR_materials_"];

/// Maximum number of unknown extensions to look for in the file's text.
const MAX_UNKNOWN: usize = 64;

/// Notes the uses of extensions that are not understood. A file may also list an extension that it does not
/// use.
fn note_unknown(root: &Root, json: &[u8], notes: &mut LoadNotes) {
    let text = String::from_utf8_lossy(json);
    let mut unknown: Vec<&str> =
        root.extensions_used.iter().map(String::as_str).filter(|e| !is_known(e)).collect();
    unknown.sort_unstable();
    unknown.dedup();
    for extension in unknown.into_iter().take(MAX_UNKNOWN) {
        let named = text.matches(&format!("\"{extension}\"")).count() as u64;
        let listed = root.extensions_used.iter().filter(|e| *e == extension).count() as u64;
        let what = format!("uses of the extension {extension}, which is not understood");
        notes.omit(what, named.saturating_sub(listed));
    }
}

/// The meshes to build and their instances.
#[derive(Default)]
struct Plan {
    /// The distinct selections.
    selections: Vec<Selection>,
    variants: Vec<Variant>,
    instances: Vec<PlannedInstance>,
}

/// A variant, the node that places it, and whether it casts.
struct PlannedInstance {
    variant: u32,
    node: usize,
    casts: bool,
}

impl Selection {
    /// The primitives of a mesh that the filter keeps, on nodes with these marks.
    fn new(root: &Root, mesh: usize, filter: &NameFilter, node: Marks, sieve: &mut Sieve) -> Self {
        let mesh_marks = filter.marks(&mesh_name(root, mesh), &mut sieve.met);
        let mut kept = Vec::new();
        let primitives = root.meshes.get(mesh).map_or(&[][..], |m| &m.primitives);
        for (i, primitive) in primitives.iter().enumerate().filter(|(_, p)| has_triangles(p)) {
            let material = materials::name(root, material_of(root, primitive));
            let material_marks = filter.marks(&material, &mut sieve.met);
            if filter.keeps_marked([node, mesh_marks, material_marks]) {
                kept.push(i as u32);
            } else {
                sieve.filtered = true;
            }
        }
        Self { mesh, kept }
    }

    fn primitives<'a>(&'a self, root: &'a Root) -> impl Iterator<Item = &'a Primitive> {
        let primitives = root.meshes.get(self.mesh).map_or(&[][..], |m| &m.primitives);
        self.kept.iter().filter_map(|&i| primitives.get(i as usize))
    }
}

impl Plan {
    /// The number of variants of each selection, separately without and with a skin.
    fn copies(&self) -> impl Iterator<Item = ((u32, bool), u64)> {
        let mut copies: BTreeMap<(u32, bool), u64> = BTreeMap::new();
        for variant in &self.variants {
            *copies.entry((variant.selection, variant.skinned.is_some())).or_default() += 1;
        }
        copies.into_iter()
    }
}

/// Applies the filter and groups nodes that place the same mesh. A mesh is not scanned once per node, but
/// only once per distinct value of the nodes' filter marks, of which there are few.
fn choose(
    buffers: &Buffers<'_>,
    root: &Root,
    nodes: &Nodes,
    options: &LoadOptions,
    sieve: &mut Sieve,
    casting: &mut Casting,
    notes: &mut LoadNotes,
) -> Result<Plan> {
    let path = buffers.sources.scene;
    let mut plan = Plan::default();
    let mut variants: HashMap<Variant, u32> = HashMap::new();
    let mut selections: HashMap<Selection, u32> = HashMap::new();
    // The selection of a mesh on nodes with these marks; `None` if nothing is left.
    let mut selected: HashMap<(usize, Marks), Option<u32>> = HashMap::new();
    // For each mesh visited so far, whether it casts.
    let mut seen: Vec<Option<bool>> = vec![None; root.meshes.len()];
    let mut skinned = 0;
    if !options.filter.is_empty() {
        let mut is_drawn = vec![false; root.nodes.len()];
        nodes.drawn.iter().for_each(|&(node, _)| is_drawn[node] = true);
        for (node, json) in root.nodes.iter().enumerate().filter(|(node, _)| !is_drawn[*node]) {
            sieve.met.meet_hidden(&options.filter, &nodes::name(json, node));
        }
    }
    for &(node, casts) in &nodes.drawn {
        let json = &root.nodes[node];
        let Some(index) = json.mesh.map(|m| m.value()) else { continue };
        let (Some(mesh), Some(seen)) = (root.meshes.get(index), seen.get_mut(index)) else {
            return Err(bad(path, format!("node {node} has mesh {index}, which does not exist")));
        };
        buffers.faults.check(path, "mesh", index)?;
        let mesh_casts = *seen.get_or_insert_with(|| {
            let others = mesh.primitives.iter().filter(|p| !has_triangles(p)).count() as u64;
            notes.omit("primitives of lines, of points or without positions", others);
            casting.of(&mesh.extras, || format!("mesh {:?}", mesh_name(root, index)))
        });
        let marks = options.filter.marks(&nodes::name(json, node), &mut sieve.met);
        let selection = *selected.entry((index, marks)).or_insert_with(|| {
            let selection = Selection::new(root, index, &options.filter, marks, sieve);
            let next = plan.selections.len() as u32;
            (!selection.kept.is_empty()).then(|| {
                let number = *selections.entry_ref(&selection).or_insert(next);
                if number == next {
                    plan.selections.push(selection);
                }
                number
            })
        });
        let Some(selection) = selection else { continue };
        skinned += u32::from(json.skin.is_some());
        let weights =
            Weights::of(json.weights.as_deref().filter(|w| !w.is_empty()).or(mesh.weights.as_deref()), mesh);
        let variant = Variant { selection, skinned: json.skin.map(|_| node), weights };
        let next = plan.variants.len() as u32;
        let number = *variants.entry_ref(&variant).or_insert(next);
        if number == next {
            plan.variants.push(variant);
        }
        plan.instances.push(PlannedInstance { variant: number, node, casts: casts && mesh_casts });
    }
    if skinned > 0 {
        notes.warnings.push(format!("{skinned} skinned meshes keep the pose of the file's nodes"));
    }
    Ok(plan)
}

/// How far the meshes on and below each node reach. Skinned meshes belong to no node. Needed only for
/// animated files.
fn extents_of<'a>(
    plan: &Plan,
    meshes: &[Mesh],
    nodes: &'a Nodes,
    root: &Root,
    buffers: &Buffers<'_>,
) -> Result<Extents<'a>> {
    let mut extents = Extents::new(nodes);
    if root.animations.is_empty() {
        return Ok(extents);
    }
    let boxes: Vec<MeshBox> = meshes.iter().map(|mesh| MeshBox::of(&mesh.positions)).collect();
    for &PlannedInstance { variant, node, .. } in &plan.instances {
        if root.nodes[node].skin.is_none() {
            let maps = nodes::gpu_instances(buffers.sources.scene, root, buffers, node)?;
            for map in maps.as_deref().unwrap_or(&[IDENTITY]) {
                extents.add(node, map, boxes[variant as usize]);
            }
        }
    }
    extents.gather();
    Ok(extents)
}

/// The mesh's name, or `mesh 7`.
fn mesh_name(root: &Root, index: usize) -> Cow<'_, str> {
    match root.meshes.get(index).and_then(|m| m.name.as_deref()) {
        Some(name) => Cow::Borrowed(name),
        None => Cow::Owned(format!("mesh {index}")),
    }
}

/// The data from which instances are built.
struct Placer<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    nodes: &'a Nodes,
    animations: &'a Animations,
}

impl Placer<'_> {
    /// Adds the scene instances of a planned instance, and adds those that move to `movers` as well.
    fn place(&self, instance: &PlannedInstance, scene: &mut Scene, movers: &mut Vec<Mover>) -> Result<()> {
        let &PlannedInstance { variant, node, casts } = instance;
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

    /// Warns about skins with animated joints: skins keep the pose of the file's nodes, whatever their joints
    /// do.
    fn note_moving_skins(&self, plan: &Plan, notes: &mut LoadNotes) {
        let skins = plan.instances.iter().filter_map(|p| self.root.nodes[p.node].skin);
        let mut moves: HashMap<usize, bool> = HashMap::new();
        let mut moves =
            |skin| *moves.entry(skin).or_insert_with(|| self.animations.moves_skin(self.root, skin));
        let count = skins.filter(|s| moves(s.value())).count();
        if count > 0 {
            notes
                .warnings
                .push(format!("{count} skinned meshes have animated joints, but do not move with them"));
        }
    }
}
