//! Skinned vertices, placed once by the joints as the file leaves them (no animation is played).

use std::path::Path;

use ::gltf::json::Root;

use super::accessor::Accessor;
use super::container::{Buffers, bad};
use super::nodes::Nodes;
use crate::error::Result;
use crate::scene::affine::{Affine, IDENTITY, from_columns, multiply};

/// Joint matrices of a skin, from mesh to world.
pub(super) struct Skin {
    world_from_mesh: Vec<Affine>,
    /// For vertices that no joint moves.
    node: Affine,
}

impl Skin {
    /// Multiplies each joint's world transform with its inverse bind matrix.
    pub(super) fn load(
        path: &Path,
        root: &Root,
        buffers: &Buffers<'_>,
        nodes: &Nodes,
        index: usize,
        node: usize,
    ) -> Result<Self> {
        let broken = |what: &str| bad(path, format!("skin {index} {what}"));
        let json = root.skins.get(index).ok_or_else(|| broken("does not exist"))?;
        let binds = match json.inverse_bind_matrices {
            Some(accessor) => Some(Accessor::open(path, root, buffers, accessor.value())?),
            None => None,
        };
        if binds.as_ref().is_some_and(|b| b.components != 16 || b.count < json.joints.len()) {
            return Err(broken("has too few inverse bind matrices"));
        }
        let mut world_from_mesh = Vec::with_capacity(json.joints.len());
        for (i, joint) in json.joints.iter().enumerate() {
            let world =
                nodes.world.get(joint.value()).ok_or_else(|| broken("names a joint that does not exist"))?;
            let bind = binds.as_ref().and_then(|b| b.floats::<16>(i));
            world_from_mesh.push(bind.map_or(*world, |m| multiply(world, &from_columns(&m))));
        }
        let node = nodes.world.get(node).copied().unwrap_or(IDENTITY);
        Ok(Self { world_from_mesh, node })
    }

    /// The vertex in world space: the joints' positions of it, weighted. Weights that do not add up to one are
    /// scaled; without any, the node's own transform counts.
    pub(super) fn place(&self, p: [f32; 3], influences: impl Iterator<Item = (u32, f32)>) -> [f32; 3] {
        let p = p.map(f64::from);
        let apply = |m: &Affine| m.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]);
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for (joint, weight) in influences {
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
        let placed = if total == 0.0 { apply(&self.node) } else { sum.map(|s| s / total) };
        placed.map(|c| c as f32)
    }
}
