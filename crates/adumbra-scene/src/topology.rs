//! Finds the solid parts of a mesh. The inside of a solid cannot be seen, so a bake may return any answer
//! there.
//!
//! Vertices are welded by exact position (normals and texture coordinates are ignored, and -0 equals 0).
//! Triangles that share an edge form a connected component. A component is *closed* if every directed edge
//! occurs as often as its reverse. A closed component of positive volume whose materials are opaque and cast
//! is *solid*. A closed component of negative volume is solid only as a cavity inside a solid of positive
//! volume, where its winding cuts it out. An outermost shell of negative volume (a room seen from inside, a
//! sky dome) is never solid.
//!
//! The result does not depend on the order of the triangles, except for the numbering of the components.

mod inside;
#[cfg(test)]
mod tests;

use crate::{Material, Mesh};
use adumbra::grid::vec3::{cross, dot};
use hashbrown::HashMap;

/// If the volume is below this fraction of the summed magnitudes of its terms, it is rounding error: the
/// component encloses nothing.
const ZERO_VOLUME_SHARE: f64 = 1e-12;

/// The components of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// The component of each triangle, an index into `components`.
    pub component_of_triangle: Vec<u32>,
    /// Components in the order of their first triangles.
    pub components: Vec<Component>,
}

/// A connected component: triangles joined by shared edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Number of triangles.
    pub triangles: u32,
    /// Whether every directed edge occurs as often as its reverse.
    pub closed: bool,
    /// Volume in the mesh's own units, positive if triangles are counter-clockwise seen from outside. It has
    /// no meaning if the component is not closed.
    pub signed_volume: f64,
    /// Whether the component is a solid, whose inside cannot be seen, or a cavity in one.
    pub solid: bool,
}

impl Topology {
    /// Whether `triangle` bounds a solid.
    pub fn is_solid(&self, triangle: usize) -> bool {
        self.components[self.component_of_triangle[triangle] as usize].solid
    }

    /// Number of triangles in closed components.
    pub(crate) fn closed_triangles(&self) -> u64 {
        self.count(|c| c.closed)
    }

    /// Number of triangles in solid components.
    pub(crate) fn solid_triangles(&self) -> u64 {
        self.count(|c| c.solid)
    }

    /// Fraction of the triangles that are in closed components, 0 to 1; 0 for an empty mesh.
    pub fn closed_share(&self) -> f64 {
        self.closed_triangles() as f64 / self.component_of_triangle.len().max(1) as f64
    }

    /// Fraction of the triangles that are in solid components, 0 to 1; 0 for an empty mesh.
    pub fn solid_share(&self) -> f64 {
        self.solid_triangles() as f64 / self.component_of_triangle.len().max(1) as f64
    }

    fn count(&self, keep: impl Fn(&Component) -> bool) -> u64 {
        self.components.iter().filter(|c| keep(c)).map(|c| u64::from(c.triangles)).sum()
    }
}

/// Finds the components of `mesh` and determines which are closed and which are solid. Mirroring by an
/// instance is ignored.
///
/// Cost: one hash look-up per vertex, one sort of the edges, and a point-in-solid test for each shell of
/// negative volume. Memory: [`working_bytes`].
pub fn analyse(mesh: &Mesh, materials: &[Material]) -> Topology {
    let mut topology = join_by_edges(&mesh.triangles, &weld(&mesh.positions));
    let (starts, members) = group_by_component(&topology);
    let mut boxes = Vec::with_capacity(topology.components.len());
    let mut terms = Vec::new();
    for (c, component) in topology.components.iter_mut().enumerate() {
        let triangles = &members[starts[c] as usize..starts[c + 1] as usize];
        let bounds = component_bounds(mesh, triangles);
        boxes.push(bounds);
        component.signed_volume = signed_volume(mesh, triangles, &bounds, &mut terms);
        component.solid = component.closed
            && component.signed_volume > 0.0
            && triangles.iter().all(|&t| bounds_solid(mesh, materials, t));
    }
    let shells: Vec<u32> = (0..topology.components.len())
        .filter(|&c| {
            let triangles = &members[starts[c] as usize..starts[c + 1] as usize];
            topology.components[c].closed
                && topology.components[c].signed_volume < 0.0
                && triangles.iter().all(|&t| bounds_solid(mesh, materials, t))
        })
        .map(|c| c as u32)
        .collect();
    let parts = inside::Components { mesh, starts: &starts, members: &members, boxes: &boxes };
    for cavity in inside::shells_inside_solids(&parts, &topology.components, &shells) {
        topology.components[cavity as usize].solid = true;
    }
    topology
}

/// Returns the approximate peak memory of [`analyse`] in bytes, including its result. All memory except the
/// result is freed on return. Finding the edges of a mesh takes no more.
pub fn working_bytes(mesh: &Mesh) -> u64 {
    let [triangles, vertices] = [mesh.triangles.len(), mesh.positions.len()].map(|n| n as u64);
    // The table of positions doubles when it is seven eighths full, and is then copied.
    let buckets = (vertices * 8 / 7).next_power_of_two();
    let table = buckets * (size_of::<([u32; 3], u32)>() as u64 + 1) * 3 / 2;
    // The edges and the sets that they join, or later the components, their boxes and their triangles.
    let edges = triangles * 64;
    vertices * 4 + table.max(edges)
}

fn bounds_solid(mesh: &Mesh, materials: &[Material], triangle: u32) -> bool {
    let material = &materials[mesh.triangle_materials[triangle as usize] as usize];
    material.can_be_solid() && material.casts
}

/// An index of each vertex's position; equal positions have equal indices.
pub fn weld(positions: &[[f32; 3]]) -> Vec<u32> {
    let mut numbers = HashMap::with_capacity(positions.len() / 2);
    positions
        .iter()
        .map(|p| {
            let next = numbers.len() as u32;
            // Adding 0 turns -0 into 0.
            *numbers.entry(p.map(|c| (c + 0.0).to_bits())).or_insert(next)
        })
        .collect()
}

/// Finds the components, with only `triangles` and `closed` filled in.
fn join_by_edges(triangles: &[[u32; 3]], welded: &[u32]) -> Topology {
    // Lower vertex, higher vertex, triangle · 2 + (1 if the edge runs from the lower to the higher).
    let mut edges = Vec::with_capacity(triangles.len() * 3);
    for (t, triangle) in triangles.iter().enumerate() {
        let v = triangle.map(|i| welded[i as usize]);
        for (a, b) in [(v[0], v[1]), (v[1], v[2]), (v[2], v[0])] {
            if a != b {
                edges.push([a.min(b), a.max(b), (t as u32) << 1 | u32::from(a < b)]);
            }
        }
    }
    edges.sort_unstable();
    let mut roots: Vec<u32> = (0..triangles.len() as u32).collect();
    let mut open_triangles = Vec::new();
    for same in edges.chunk_by(|a, b| a[..2] == b[..2]) {
        let first = same[0][2] >> 1;
        let forward = same.iter().filter(|e| e[2] & 1 == 1).count();
        if forward * 2 != same.len() {
            open_triangles.push(first);
        }
        for edge in &same[1..] {
            unite(&mut roots, first, edge[2] >> 1);
        }
    }
    drop(edges);

    let mut topology = Topology { component_of_triangle: vec![0; triangles.len()], components: Vec::new() };
    for t in 0..triangles.len() {
        // A root is the first triangle of its set, so its component already has an index.
        let root = find(&mut roots, t as u32) as usize;
        let c = if root == t {
            topology.components.push(Component {
                triangles: 0,
                closed: true,
                signed_volume: 0.0,
                solid: false,
            });
            topology.components.len() - 1
        } else {
            topology.component_of_triangle[root] as usize
        };
        topology.component_of_triangle[t] = c as u32;
        topology.components[c].triangles += 1;
    }
    for t in open_triangles {
        topology.components[topology.component_of_triangle[t as usize] as usize].closed = false;
    }
    topology
}

fn find(roots: &mut [u32], mut t: u32) -> u32 {
    while roots[t as usize] != t {
        let above = roots[roots[t as usize] as usize];
        roots[t as usize] = above;
        t = above;
    }
    t
}

fn unite(roots: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(roots, a), find(roots, b));
    roots[a.max(b) as usize] = a.min(b);
}

/// Triangles sorted by component: component c has `members[starts[c]..starts[c + 1]]`.
fn group_by_component(topology: &Topology) -> (Vec<u32>, Vec<u32>) {
    let mut starts = Vec::with_capacity(topology.components.len() + 1);
    let mut total = 0;
    for c in &topology.components {
        starts.push(total);
        total += c.triangles;
    }
    let mut next = starts.clone();
    starts.push(total);
    let mut members = vec![0; topology.component_of_triangle.len()];
    for (t, &c) in topology.component_of_triangle.iter().enumerate() {
        let slot = &mut next[c as usize];
        members[*slot as usize] = t as u32;
        *slot += 1;
    }
    (starts, members)
}

/// Lower and upper corner of the bounding box of some triangles.
type PartBounds = [[f32; 3]; 2];

fn component_bounds(mesh: &Mesh, triangles: &[u32]) -> PartBounds {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for &v in triangles.iter().flat_map(|&t| &mesh.triangles[t as usize]) {
        let p = mesh.positions[v as usize];
        for a in 0..3 {
            bounds[0][a] = bounds[0][a].min(p[a]);
            bounds[1][a] = bounds[1][a].max(p[a]);
        }
    }
    bounds
}

/// The corners of a triangle, rotated so that the smallest comes first: equal for all three rotations of its
/// indices.
fn corners(mesh: &Mesh, triangle: u32) -> [[f64; 3]; 3] {
    let [a, b, c] = mesh.triangles[triangle as usize].map(|v| mesh.positions[v as usize].map(f64::from));
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Volume about the box's centre. The terms are sorted, then added with Neumaier's compensated summation.
fn signed_volume(mesh: &Mesh, triangles: &[u32], bounds: &PartBounds, terms: &mut Vec<f64>) -> f64 {
    let centre = [0, 1, 2].map(|a| (f64::from(bounds[0][a]) + f64::from(bounds[1][a])) / 2.0);
    terms.clear();
    terms.extend(triangles.iter().map(|&t| {
        let [a, b, c] = corners(mesh, t).map(|p| [p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]]);
        dot(a, cross(b, c)) / 6.0
    }));
    terms.sort_unstable_by(f64::total_cmp);
    let (mut sum, mut lost, mut magnitude) = (0.0_f64, 0.0, 0.0);
    for &term in terms.iter() {
        let next = sum + term;
        lost += if sum.abs() >= term.abs() { (sum - next) + term } else { (term - next) + sum };
        sum = next;
        magnitude += term.abs();
    }
    let volume = sum + lost;
    if volume.abs() <= ZERO_VOLUME_SHARE * magnitude { 0.0 } else { volume }
}
