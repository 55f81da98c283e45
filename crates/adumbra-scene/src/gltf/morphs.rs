//! Morph targets at their default weights: those of the node, or else those of its mesh (glTF 2.0, 3.7.2.2).
//! No animation of weights is played.

use ::gltf::json::mesh::Mesh;

/// The weights of a mesh's targets, without the zeros at their end; empty if nothing is morphed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Weights {
    bits: Vec<u32>,
}

impl Weights {
    /// The weights that apply to a mesh. Weights beyond its number of targets, and weights that are not
    /// finite, have no effect.
    pub(super) fn of(weights: Option<&[f32]>, mesh: &Mesh) -> Self {
        let targets =
            mesh.primitives.iter().filter_map(|p| p.targets.as_ref().map(Vec::len)).max().unwrap_or(0);
        let used = weights.unwrap_or_default().iter().take(targets);
        let mut bits: Vec<u32> =
            used.map(|&w| if w.is_finite() && w != 0.0 { w.to_bits() } else { 0 }).collect();
        while bits.last() == Some(&0) {
            bits.pop();
        }
        Self { bits }
    }

    /// The targets that have an effect, and their weights.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        self.bits.iter().map(|&bits| f32::from_bits(bits)).enumerate().filter(|&(_, weight)| weight != 0.0)
    }
}
