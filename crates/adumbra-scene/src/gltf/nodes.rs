//! The node tree: world transforms, which nodes are drawn, which cast, and EXT_mesh_gpu_instancing.

use std::path::Path;

use ::gltf::json::{Root, extras::Extras, scene::Node};
use serde::Deserialize;

use crate::affine::{Affine, IDENTITY, compose, from_columns, is_finite, multiply};
use crate::error::{Error, Result};
use crate::gltf::accessor::Accessor;
use crate::gltf::container::{Buffers, bad};
use crate::movers::Rest;

/// A node's local transform in double precision, as JSON numbers are. The glTF crate stores `f32`, whose steps are half
/// a metre at map coordinates.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(from = "Written")]
pub(super) enum Place {
    Matrix(Affine),
    Parts(Rest),
}

/// A node's transform as written in the file.
#[derive(Deserialize)]
struct Written {
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

/// The transforms of all nodes, parsed separately from the rest of the file.
#[derive(Deserialize)]
pub(super) struct Places {
    #[serde(default)]
    nodes: Vec<Place>,
}

impl From<Written> for Place {
    fn from(written: Written) -> Self {
        match written.matrix {
            Some(matrix) => Self::Matrix(from_columns(&matrix)),
            None => Self::Parts(Rest {
                translation: written.translation.unwrap_or_default(),
                rotation: written.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
                scale: written.scale.unwrap_or([1.0; 3]),
            }),
        }
    }
}

impl Place {
    /// The node's local transform, to its parent's frame.
    pub(super) fn map(&self) -> Affine {
        match self {
            Self::Matrix(map) => *map,
            Self::Parts(rest) => rest.map(),
        }
    }

    /// The node's transform without animation. An animated node has no matrix.
    pub(super) fn rest(&self) -> Rest {
        match self {
            Self::Matrix(_) => Rest::default(),
            Self::Parts(rest) => *rest,
        }
    }
}

/// The node tree with its world transforms.
pub(super) struct Nodes {
    /// The local transform of every node.
    pub(super) place: Vec<Place>,
    /// World transform of every node.
    pub(super) world: Vec<Affine>,
    /// The parent of every node.
    pub(super) parent: Vec<Option<usize>>,
    /// All nodes, each after its parent.
    pub(super) order: Vec<usize>,
    /// The nodes of the scene that have a mesh, depth first, and whether they cast.
    pub(super) drawn: Vec<(usize, bool)>,
}

impl Nodes {
    /// Computes the world transforms and collects the drawn nodes of the default scene. Without one it uses the first
    /// scene, and without any scene all root nodes.
    pub(super) fn load(path: &Path, root: &Root, places: Places) -> Result<Self> {
        let (count, place) = (root.nodes.len(), places.nodes);
        if place.len() != count {
            return Err(bad(path, "it has two lists of nodes"));
        }
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
            world[index] = multiply(&above, &place[index].map());
            if !is_finite(&world[index]) {
                let what = format!("the transform of node {:?}", name(node, index));
                return Err(Error::NotFinite { path: path.to_owned(), what });
            }
            stack.extend(children(node));
        }
        if order.len() != count {
            return Err(bad(path, "its nodes form a cycle"));
        }
        let starts = match root.scene.map(|s| s.value()).or((!root.scenes.is_empty()).then_some(0)) {
            Some(scene) => match root.scenes.get(scene) {
                Some(scene) => scene.nodes.iter().map(|n| n.value()).collect(),
                None => return Err(bad(path, format!("its default scene {scene} does not exist"))),
            },
            None => roots,
        };
        let drawn = walk(path, root, starts)?;
        Ok(Self { place, world, parent, order, drawn })
    }
}

fn walk(path: &Path, root: &Root, starts: Vec<usize>) -> Result<Vec<(usize, bool)>> {
    let mut seen = vec![false; root.nodes.len()];
    let mut drawn = Vec::new();
    let mut stack: Vec<(usize, bool)> = starts.into_iter().rev().map(|i| (i, true)).collect();
    while let Some((index, inherited)) = stack.pop() {
        let (Some(node), Some(seen)) = (root.nodes.get(index), seen.get_mut(index)) else {
            return Err(bad(path, format!("its scene references node {index}, which does not exist")));
        };
        if std::mem::replace(seen, true) || is_hidden(node) {
            continue;
        }
        let casts = inherited && casts(&node.extras);
        if node.mesh.is_some() {
            drawn.push((index, casts));
        }
        let from = stack.len();
        stack.extend(children(node).map(|child| (child, casts)));
        stack[from..].reverse();
    }
    Ok(drawn)
}

/// The transforms within the node at which EXT_mesh_gpu_instancing places its mesh, or `None` if the node does not use
/// it.
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
        let accessor = accessor.as_u64().and_then(|a| usize::try_from(a).ok());
        let accessor = accessor.ok_or_else(|| broken("have an accessor index that is not a number"))?;
        Accessor::open(path, root, buffers, accessor).map(Some)
    };
    let (move_by, turn_by, scale_by) = (open("TRANSLATION")?, open("ROTATION")?, open("SCALE")?);
    let counts = || [&move_by, &turn_by, &scale_by].into_iter().flatten().map(|a| a.count);
    let count = counts().next().unwrap_or(0);
    if counts().any(|c| c != count) {
        return Err(broken("have attributes of different lengths"));
    }
    // Charged only while they are read; instances are charged when they are created.
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

/// False if the extras contain `{"adumbra": {"cast": false}}`.
pub(super) fn casts(extras: &Extras) -> bool {
    let Some(raw) = extras else { return true };
    let value: serde_json::Value = serde_json::from_str(raw.get()).unwrap_or_default();
    value.get("adumbra").and_then(|a| a.get("cast")).and_then(serde_json::Value::as_bool).unwrap_or(true)
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
