//! How far the meshes on and below each node reach. This distinguishes keys that move them from rounding.

use crate::affine::{Affine, IDENTITY, multiply, stretch};
use crate::gltf::nodes::Nodes;
use crate::movers::{Rest, Tracks};

/// Keys that move the meshes by no more than this share of their size are rounding, as left by exporters that
/// sample every node.
const STILL: f64 = 1e-4;

/// The extent of the meshes on and below each node.
pub(super) struct Extents<'a> {
    pub(super) nodes: &'a Nodes,
    of_node: Vec<Extent>,
}

/// The meshes on a node and on its descendants, each at rest.
#[derive(Clone, Copy)]
struct Extent {
    /// The largest distance from the node's origin, in its own frame.
    radius_node: f64,
    low_world: [f64; 3],
    high_world: [f64; 3],
}

const NOTHING: Extent =
    Extent { radius_node: 0.0, low_world: [f64::INFINITY; 3], high_world: [f64::NEG_INFINITY; 3] };

/// The box around a mesh's vertices.
#[derive(Clone, Copy)]
pub(super) struct MeshBox {
    pub(super) low: [f32; 3],
    pub(super) high: [f32; 3],
}

impl MeshBox {
    pub(super) fn of(positions: &[[f32; 3]]) -> Self {
        let mut b = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };
        for p in positions {
            b.low = std::array::from_fn(|a| b.low[a].min(p[a]));
            b.high = std::array::from_fn(|a| b.high[a].max(p[a]));
        }
        b
    }

    /// The box's corners; empty if the box contains no vertex.
    fn corners(&self) -> impl Iterator<Item = [f64; 3]> {
        let (low, high) = (self.low, self.high);
        let corner = move |i: usize| {
            std::array::from_fn(|a| f64::from(if i >> a & 1 == 0 { low[a] } else { high[a] }))
        };
        (0..8).filter(move |_| low[0] <= high[0]).map(corner)
    }
}

impl<'a> Extents<'a> {
    pub(super) fn new(nodes: &'a Nodes) -> Self {
        Self { nodes, of_node: vec![NOTHING; nodes.transforms.len()] }
    }

    /// Adds a mesh to its node.
    pub(super) fn add(&mut self, node: usize, node_from_mesh: &Affine, mesh: MeshBox) {
        let extent = &mut self.of_node[node];
        for p in mesh.corners() {
            let p_node = transformed(node_from_mesh, p);
            extent.radius_node = extent.radius_node.max(length(p_node));
            extent.include(transformed(&self.nodes.world[node], p_node));
        }
    }

    /// Adds to each node the extents of its descendants.
    pub(super) fn gather(&mut self) {
        for &node in self.nodes.order.iter().rev() {
            let Some(parent) = self.nodes.parent[node] else { continue };
            let (below, map) = (self.of_node[node], self.nodes.transforms[node].map());
            if below.is_nothing() {
                continue;
            }
            let radius = length(map.map(|row| row[3])) + stretch(&map) * below.radius_node;
            let above = &mut self.of_node[parent];
            above.radius_node = above.radius_node.max(radius);
            above.include(below.low_world);
            above.include(below.high_world);
        }
    }

    /// Whether tracks move the meshes on and below a node from their rest pose by more than a ten-thousandth
    /// of their size. If there are no meshes, the size is the length of the node's translation, or 1 if that
    /// is zero.
    pub(super) fn are_moved(&self, node: usize, rest: &Rest, tracks: &Tracks) -> bool {
        let nodes = self.nodes;
        let parent = nodes.parent[node].map_or(IDENTITY, |p| nodes.world[p]);
        let extent = &self.of_node[node];
        let (radius, size) = if extent.is_nothing() {
            let bone = length(rest.translation);
            let bone = if bone > 0.0 { bone } else { 1.0 };
            (bone, bone * stretch(&parent))
        } else {
            (extent.radius_node, extent.size_world())
        };
        let rest_map = rest.map();
        tracks.moments().any(|seconds| {
            let map = tracks.at(rest, seconds);
            let change = std::array::from_fn(|r| std::array::from_fn(|c| map[r][c] - rest_map[r][c]));
            // The parent's translation cancels out in a difference.
            let change = multiply(&linear(&parent), &change);
            let distance = length(change.map(|row| row[3])) + stretch(&change) * radius;
            // Written so that an overflow or NaN counts as motion.
            !(distance <= STILL * size)
        })
    }
}

impl Extent {
    fn is_nothing(&self) -> bool {
        self.low_world[0] > self.high_world[0]
    }

    fn include(&mut self, p_world: [f64; 3]) {
        self.low_world = std::array::from_fn(|a| self.low_world[a].min(p_world[a]));
        self.high_world = std::array::from_fn(|a| self.high_world[a].max(p_world[a]));
    }

    /// The longest side.
    fn size_world(&self) -> f64 {
        (0..3).map(|a| self.high_world[a] - self.low_world[a]).fold(0.0, f64::max)
    }
}

fn transformed(map: &Affine, p: [f64; 3]) -> [f64; 3] {
    map.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
}

fn linear(map: &Affine) -> Affine {
    map.map(|[x, y, z, _]| [x, y, z, 0.0])
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
