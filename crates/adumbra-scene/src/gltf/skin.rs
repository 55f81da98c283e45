//! Skinned vertices, posed once by the joints as stored in the file (no animation is played).

use std::path::Path;
use std::rc::Rc;

use ::gltf::json::Root;
use hashbrown::HashMap;

use crate::affine::{Affine, IDENTITY, from_columns, multiply};
use crate::error::Result;
use crate::gltf::accessor::Accessor;
use crate::gltf::container::Buffers;
use crate::gltf::faults::bad;
use crate::gltf::nodes::Nodes;

/// The joint matrices of a skin, from mesh to world.
pub(super) struct Skin {
    world_from_mesh: Rc<[Affine]>,
    /// Transform for vertices without any joint.
    node: Affine,
}

/// Loads skins, each only once however many nodes use it.
pub(super) struct Skins<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    nodes: &'a Nodes,
    known: HashMap<usize, Rc<[Affine]>>,
}

impl<'a> Skins<'a> {
    pub(super) fn new(path: &'a Path, root: &'a Root, buffers: &'a Buffers<'a>, nodes: &'a Nodes) -> Self {
        Self { path, root, buffers, nodes, known: HashMap::new() }
    }

    /// The skin with index `index`, as used by `node`.
    pub(super) fn load(&mut self, index: usize, node: usize) -> Result<Skin> {
        let world_from_mesh = match self.known.get(&index) {
            Some(known) => known.clone(),
            None => {
                let matrices: Rc<[Affine]> = self.matrices(index)?.into();
                self.known.insert(index, matrices.clone());
                matrices
            }
        };
        let node = self.nodes.world.get(node).copied().unwrap_or(IDENTITY);
        Ok(Skin { world_from_mesh, node })
    }

    /// Multiplies each joint's world transform by its inverse bind matrix.
    fn matrices(&self, index: usize) -> Result<Vec<Affine>> {
        let broken = |what: &str| bad(self.path, format!("skin {index} {what}"));
        let json = self.root.skins.get(index).ok_or_else(|| broken("does not exist"))?;
        self.buffers.faults.check(self.path, "skin", index)?;
        let binds = match json.inverse_bind_matrices {
            Some(accessor) => Some(Accessor::open(self.path, self.root, self.buffers, accessor.value())?),
            None => None,
        };
        if binds.as_ref().is_some_and(|b| b.components != 16 || b.count < json.joints.len()) {
            return Err(broken("has too few inverse bind matrices"));
        }
        let bytes = (json.joints.len() * size_of::<Affine>()) as u64;
        self.buffers.sources.budget.charge(bytes, || format!("the joints of skin {index}"))?;
        let mut world_from_mesh = Vec::with_capacity(json.joints.len());
        for (i, joint) in json.joints.iter().enumerate() {
            let world = self.nodes.world.get(joint.value());
            let world = world.ok_or_else(|| broken("references a joint that does not exist"))?;
            let bind = binds.as_ref().and_then(|b| b.floats::<16>(i));
            world_from_mesh.push(bind.map_or(*world, |m| multiply(world, &from_columns(&m.map(f64::from)))));
        }
        Ok(world_from_mesh)
    }
}

impl Skin {
    /// Returns the vertex in world space: the weighted mean of its positions under each joint. Weights that
    /// do not add up to one are normalised. A vertex whose weights sum to zero follows the first joint that
    /// it names, as in three.js and Blender; glTF 2.0, 3.7.3.3, does not define this case.
    pub(super) fn place(&self, p: [f32; 3], influences: impl Iterator<Item = (u32, f32)>) -> [f32; 3] {
        let p = p.map(f64::from);
        let apply = |m: &Affine| m.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]);
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        let mut first = None;
        for (joint, weight) in influences {
            first = first.or(Some(joint));
            if weight == 0.0 {
                continue;
            }
            let Some(matrix) = self.world_from_mesh.get(joint as usize) else { continue };
            let weight = f64::from(weight);
            let moved = apply(matrix);
            for a in 0..3 {
                sum[a] += weight * moved[a];
            }
            total += weight;
        }
        let followed =
            || first.and_then(|joint| self.world_from_mesh.get(joint as usize)).unwrap_or(&self.node);
        let placed = if total == 0.0 { apply(followed()) } else { sum.map(|s| s / total) };
        placed.map(|c| c as f32)
    }
}
