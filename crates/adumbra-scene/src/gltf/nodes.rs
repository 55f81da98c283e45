//! The node tree: world transforms, which nodes are drawn, which cast, and EXT_mesh_gpu_instancing.

use std::path::Path;

use ::gltf::json::{Root, scene::Node};

use crate::FileSun;
use crate::affine::{Affine, IDENTITY, compose, is_finite, multiply};
use crate::error::{Error, Result};
use crate::gltf::accessor::Accessor;
use crate::gltf::casting::Casting;
use crate::gltf::container::Buffers;
use crate::gltf::faults::{Faults, bad};
use crate::gltf::numbers::index_of;
use crate::gltf::transforms::NodeTransform;

/// The node tree with its world transforms.
pub(super) struct Nodes {
    /// The local transform of every node.
    pub(super) transforms: Vec<NodeTransform>,
    /// World transform of every node.
    pub(super) world: Vec<Affine>,
    /// The parent of every node.
    pub(super) parent: Vec<Option<usize>>,
    /// All nodes, each after its parent.
    pub(super) order: Vec<usize>,
    /// The nodes of the scene that have a mesh, depth first, and whether they cast.
    pub(super) drawn: Vec<(usize, bool)>,
    /// The nodes of the scene with a directional light that shines, depth first.
    suns: Vec<usize>,
    /// Whether the file has a default scene without nodes.
    pub(super) is_empty_scene: bool,
    /// Number of nodes with a mesh that the scene does not reach, excluding coarser levels of detail.
    pub(super) unreached: u64,
}

impl Nodes {
    /// Computes the world transforms and collects the drawn nodes of the default scene. Without one it uses
    /// the first scene, and without any scene all root nodes. Of the levels of detail of MSFT_lod only the
    /// finest is drawn.
    pub(super) fn load(
        path: &Path,
        root: &Root,
        transforms: Vec<NodeTransform>,
        lights: &[bool],
        faults: &Faults,
        casting: &mut Casting,
    ) -> Result<Self> {
        let count = root.nodes.len();
        let mut parent = vec![None; count];
        for (index, node) in root.nodes.iter().enumerate() {
            for child in children(node) {
                match parent.get_mut(child) {
                    None => {
                        return Err(bad(
                            path,
                            format!("node {index} has a child {child} that does not exist"),
                        ));
                    }
                    Some(Some(_)) => return Err(bad(path, format!("node {child} has more than one parent"))),
                    Some(slot) => *slot = Some(index),
                }
            }
        }
        let roots: Vec<usize> = (0..count).filter(|&i| parent[i].is_none()).collect();
        let mut world = vec![IDENTITY; count];
        let mut order = Vec::with_capacity(count);
        let mut stack: Vec<usize> = roots.clone();
        while let Some(index) = stack.pop() {
            order.push(index);
            let node = &root.nodes[index];
            let above = parent[index].map_or(IDENTITY, |p| world[p]);
            world[index] = multiply(&above, &transforms[index].map());
            if !is_finite(&world[index]) {
                let what = format!("the transform of node {:?}", name(node, index));
                return Err(Error::NotFinite { path: path.to_owned(), what });
            }
            stack.extend(children(node));
        }
        if order.len() != count {
            return Err(bad(path, "its nodes form a cycle"));
        }
        let scene = root.scene.map(|s| s.value()).or((!root.scenes.is_empty()).then_some(0));
        let starts = match scene {
            Some(index) => match root.scenes.get(index) {
                Some(scene) => {
                    faults.check(path, "scene", index)?;
                    scene.nodes.iter().map(|n| n.value()).collect::<Vec<_>>()
                }
                None => return Err(bad(path, format!("its default scene {index} does not exist"))),
            },
            None => roots,
        };
        let is_empty_scene = scene.is_some() && starts.is_empty();
        let all = walk(path, root, faults, &starts, &[], &mut Casting::default())?.seen;
        let mut is_coarse = vec![false; count];
        let in_scene = root.nodes.iter().zip(&all).filter(|&(_, &seen)| seen);
        for index in in_scene.flat_map(|(node, _)| coarser_levels(node)) {
            if let Some(coarse) = is_coarse.get_mut(index) {
                *coarse = true;
            }
        }
        let walk = walk(path, root, faults, &starts, &is_coarse, casting)?;
        let of_sun = |node: usize| light(&root.nodes[node]).and_then(|l| lights.get(l)) == Some(&true);
        let suns = walk.lit.into_iter().filter(|&node| of_sun(node)).collect();
        let coarse = with_all_below(root, is_coarse);
        let unreached = (0..count).filter(|&i| root.nodes[i].mesh.is_some() && !walk.seen[i] && !coarse[i]);
        let unreached = unreached.count() as u64;
        Ok(Self { transforms, world, parent, order, drawn: walk.drawn, suns, is_empty_scene, unreached })
    }

    /// The light of the first sun.
    pub(super) fn first_sun(&self, root: &Root) -> Option<usize> {
        light(root.nodes.get(*self.suns.first()?)?)
    }

    /// The directional lights of the scene. A light whose node's transform reduces its direction to zero is
    /// left out.
    pub(super) fn suns(&self, root: &Root) -> Vec<FileSun> {
        let sun = |&node: &usize| {
            // A light shines along its node's -Z (KHR_lights_punctual).
            let name = name(root.nodes.get(node)?, node);
            let towards = self.world[node].map(|row| row[2]);
            towards.iter().any(|&c| c != 0.0).then_some(FileSun { name, towards })
        };
        self.suns.iter().filter_map(sun).collect()
    }
}

/// The result of a walk over a scene.
struct Walk {
    /// For each node, whether it is part of the scene, drawn or hidden.
    seen: Vec<bool>,
    /// The nodes with a mesh, and whether they cast.
    drawn: Vec<(usize, bool)>,
    /// The nodes with a light.
    lit: Vec<usize>,
}

fn walk(
    path: &Path,
    root: &Root,
    faults: &Faults,
    starts: &[usize],
    is_coarse: &[bool],
    casting: &mut Casting,
) -> Result<Walk> {
    let mut walk = Walk { seen: vec![false; root.nodes.len()], drawn: Vec::new(), lit: Vec::new() };
    let mut stack: Vec<(usize, bool, bool)> = starts.iter().rev().map(|&i| (i, true, true)).collect();
    while let Some((index, visible, inherited)) = stack.pop() {
        let (Some(node), Some(seen)) = (root.nodes.get(index), walk.seen.get_mut(index)) else {
            return Err(bad(path, format!("its scene references node {index}, which does not exist")));
        };
        if is_coarse.get(index) == Some(&true) || std::mem::replace(seen, true) {
            continue;
        }
        faults.check(path, "node", index)?;
        let visible = visible && !is_hidden(node);
        let casts = casting.of(&node.extras, || format!("node {:?}", name(node, index))) && inherited;
        if visible && node.mesh.is_some() {
            walk.drawn.push((index, casts));
        }
        if visible && light(node).is_some() {
            walk.lit.push(index);
        }
        let from = stack.len();
        stack.extend(children(node).map(|child| (child, visible, casts)));
        stack[from..].reverse();
    }
    Ok(walk)
}

/// For each node, whether it is marked, is a descendant of a marked node, or is a coarser level of detail of
/// either.
fn with_all_below(root: &Root, mut marked: Vec<bool>) -> Vec<bool> {
    let mut stack: Vec<usize> = (0..marked.len()).filter(|&i| marked[i]).collect();
    while let Some(node) = stack.pop().and_then(|index| root.nodes.get(index)) {
        for next in children(node).chain(coarser_levels(node)) {
            if let Some(marked) = marked.get_mut(next)
                && !std::mem::replace(marked, true)
            {
                stack.push(next);
            }
        }
    }
    marked
}

/// The coarser levels of detail of a node (MSFT_lod).
fn coarser_levels(node: &Node) -> impl Iterator<Item = usize> {
    let lod = node.extensions.as_ref().and_then(|e| e.others.get("MSFT_lod")).and_then(|e| e.get("ids"));
    lod.and_then(|ids| ids.as_array()).into_iter().flatten().filter_map(index_of)
}

/// The index of a node's light (KHR_lights_punctual).
fn light(node: &Node) -> Option<usize> {
    index_of(node.extensions.as_ref()?.others.get("KHR_lights_punctual")?.get("light")?)
}

/// The transforms within the node at which EXT_mesh_gpu_instancing places its mesh, or `None` if the node
/// does not use it.
pub(super) fn gpu_instances(
    path: &Path,
    root: &Root,
    buffers: &Buffers<'_>,
    index: usize,
) -> Result<Option<Vec<Affine>>> {
    let node = root.nodes.get(index);
    let Some(value) = node
        .and_then(|n| n.extensions.as_ref())
        .and_then(|e| e.others.get("EXT_mesh_gpu_instancing"))
        .and_then(|e| e.get("attributes"))
    else {
        return Ok(None);
    };
    let broken = |what: &str| bad(path, format!("the instances of node {index} {what}"));
    let open = |semantic: &str| -> Result<Option<Accessor<'_>>> {
        let Some(accessor) = value.get(semantic) else { return Ok(None) };
        let accessor =
            index_of(accessor).ok_or_else(|| broken("have an accessor index that is not a number"))?;
        Accessor::open(path, root, buffers, accessor).map(Some)
    };
    let (move_by, turn_by, scale_by) = (open("TRANSLATION")?, open("ROTATION")?, open("SCALE")?);
    // Attributes with other names do not place anything, but they state the number of instances.
    let others = value.as_object().into_iter().flatten().map(|(semantic, _)| semantic.as_str());
    let mut counts = Vec::new();
    for semantic in others {
        counts.extend(open(semantic)?.map(|accessor| accessor.count));
    }
    let count = counts.first().copied().unwrap_or(0);
    if counts.iter().any(|&c| c != count) {
        return Err(broken("have attributes of different lengths"));
    }
    // Charge the transforms only while they are read. The instances are charged when they are created.
    let bytes = (count * size_of::<Affine>()) as u64;
    buffers.sources.budget.charge(bytes, || format!("the instances of node {index}"))?;
    buffers.sources.budget.release(bytes);
    let mut maps = Vec::with_capacity(count);
    for i in 0..count {
        let t = move_by.as_ref().and_then(|a| a.floats::<3>(i)).unwrap_or_default();
        let r = turn_by.as_ref().and_then(|a| a.floats::<4>(i)).unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let s = scale_by.as_ref().and_then(|a| a.floats::<3>(i)).unwrap_or([1.0; 3]);
        let map = compose(t.map(f64::from), r.map(f64::from), s.map(f64::from));
        if !is_finite(&map) {
            let what = format!("the transform of instance {i} of node {index}");
            return Err(Error::NotFinite { path: path.to_owned(), what });
        }
        maps.push(map);
    }
    Ok(Some(maps))
}

/// The node's name, or `node 7`.
pub(super) fn name(node: &Node, index: usize) -> String {
    node.name.clone().unwrap_or_else(|| format!("node {index}"))
}

/// Whether KHR_node_visibility hides the node and its descendants.
fn is_hidden(node: &Node) -> bool {
    let visible = node
        .extensions
        .as_ref()
        .and_then(|e| e.others.get("KHR_node_visibility"))
        .and_then(|e| e.get("visible"))
        .and_then(serde_json::Value::as_bool);
    visible == Some(false)
}

fn children(node: &Node) -> impl Iterator<Item = usize> + '_ {
    node.children.iter().flatten().map(|c| c.value())
}
