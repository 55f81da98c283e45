//! Subdivides a mesh without changing its surface. Edges are cut at their midpoints, so that a model reaches
//! the triangle count that a measurement needs and looks the same.
//!
//! Whether an edge is cut depends only on the positions of its ends. Both sides of a seam in the texture
//! coordinates are therefore cut alike, and a closed mesh stays closed.

use hashbrown::{HashMap, HashSet};

use crate::{Mesh, topology};

/// The largest triangle count whose vertices can be indexed even if no two triangles share a vertex.
const MAX_TRIANGLES: usize = u32::MAX as usize / 3;

impl Mesh {
    /// Subdivides until there are `wanted` triangles, at most 1,431,655,765. A mesh that already has that
    /// many is left unchanged.
    ///
    /// Every edge is cut, round after round, as long as four times the triangle count is at most `wanted`. A
    /// last round cuts only the longest edges; ties are broken by the order of their first vertices. Cutting
    /// an edge adds one triangle per adjacent triangle, and an edge that would add too many is skipped. A
    /// mesh with one or two triangles per edge therefore ends at `wanted` or one below.
    ///
    /// New vertices and their texture coordinates are midpoints rounded to `f32`, and come after the old
    /// vertices. New triangles inherit material and winding. If edges are only a few rounding steps long, new
    /// triangles may become degenerate. Cost: a sort of the edges and one hash look-up per corner; about a
    /// second for two million triangles.
    pub fn subdivide_to(&mut self, wanted: usize) {
        let wanted = wanted.min(MAX_TRIANGLES);
        if self.triangles.is_empty() || self.triangles.len() >= wanted {
            return;
        }
        while self.triangles.len() * 4 <= wanted {
            cut_edges(self, |_| true);
        }
        let welded = topology::weld(&self.positions);
        let edge = |ends: [u32; 2]| sorted(ends.map(|v| welded[v as usize]));
        let longest = longest_edges(self, edge, wanted - self.triangles.len());
        cut_edges(self, |ends| longest.contains(&edge(ends)));
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The longest edges whose cuts together add at most `triangles` triangles. `edge` maps an edge's ends to its
/// key.
fn longest_edges(
    mesh: &Mesh,
    edge: impl Fn([u32; 2]) -> [u32; 2],
    mut triangles: usize,
) -> HashSet<[u32; 2]> {
    // An edge's key and its length. The length is equal for every pair of indices with that key, since the
    // positions are equal.
    let mut edges: Vec<([u32; 2], f64)> = mesh
        .triangles
        .iter()
        .flat_map(|&t| sides(t))
        .map(|ends| (edge(ends), squared_length(mesh, ends)))
        .filter(|&([a, b], _)| a != b)
        .collect();
    edges.sort_unstable_by_key(|e| e.0);
    let mut counted: Vec<_> =
        edges.chunk_by(|e, f| e.0 == f.0).map(|same| (same[0].1, same[0].0, same.len())).collect();
    drop(edges);
    counted.sort_unstable_by(|e, f| f.0.total_cmp(&e.0).then(e.1.cmp(&f.1)));
    let fits = |&(_, _, beside): &(f64, [u32; 2], usize)| {
        let fits = beside <= triangles;
        triangles -= if fits { beside } else { 0 };
        fits
    };
    counted.into_iter().filter(fits).map(|(_, name, _)| name).collect()
}

fn squared_length(mesh: &Mesh, ends: [u32; 2]) -> f64 {
    let [p, q] = ends.map(|v| mesh.positions[v as usize].map(f64::from));
    (0..3).map(|a| (p[a] - q[a]).powi(2)).sum()
}

/// Cuts the edges for which `chosen` returns true; it receives their ends in either order.
fn cut_edges(mesh: &mut Mesh, chosen: impl Fn([u32; 2]) -> bool) {
    let mut middles = HashMap::new();
    let old = std::mem::take(&mut mesh.triangles);
    let old_materials = std::mem::take(&mut mesh.triangle_materials);
    let mut parts = Vec::with_capacity(4);
    for (&triangle, material) in old.iter().zip(old_materials) {
        let cuts = sides(triangle).map(|ends| {
            chosen(ends).then(|| *middles.entry(sorted(ends)).or_insert_with(|| mesh.add_middle(ends)))
        });
        cut_triangle(mesh, triangle, cuts, &mut parts);
        mesh.triangle_materials.resize(mesh.triangle_materials.len() + parts.len(), material);
        mesh.triangles.append(&mut parts);
    }
}

/// Splits a triangle. `cuts` holds the midpoints of its sides, starting at the first corner.
fn cut_triangle(mesh: &Mesh, [a, b, c]: [u32; 3], cuts: [Option<u32>; 3], parts: &mut Vec<[u32; 3]>) {
    match cuts {
        [None, None, None] => parts.push([a, b, c]),
        [Some(ab), Some(bc), Some(ca)] => {
            parts.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        [Some(ab), None, None] => parts.extend([[a, ab, c], [ab, b, c]]),
        [None, Some(bc), Some(ca)] => {
            // The remaining quad is cut along its shorter diagonal.
            parts.push([ca, bc, c]);
            if squared_length(mesh, [a, bc]) <= squared_length(mesh, [b, ca]) {
                parts.extend([[a, b, bc], [a, bc, ca]]);
            } else {
                parts.extend([[a, b, ca], [b, bc, ca]]);
            }
        }
        // Rotations of the two cases above.
        [ab, bc, ca] => cut_triangle(mesh, [b, c, a], [bc, ca, ab], parts),
    }
}
