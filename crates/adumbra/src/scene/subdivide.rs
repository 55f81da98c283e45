//! More triangles for the same surface: edges are cut at their midpoints, so that a model reaches the triangle count that
//! a measurement asks for and looks as before.
//!
//! Whether an edge is cut is decided by the positions of its ends alone, so both sides of a seam in the texture
//! coordinates are cut alike and a closed mesh stays closed.

use hashbrown::{HashMap, HashSet};

use super::{Mesh, topology};

/// The most triangles asked for that can be numbered, should no two share a vertex.
const MOST_TRIANGLES: usize = u32::MAX as usize / 3;

impl Mesh {
    /// Cuts triangles until there are `wanted`, at most 1,431,655,765; a mesh that has as many or more is left alone.
    ///
    /// Every edge is cut, round after round, while four times the triangles are no more than `wanted`; at last the longest
    /// edges only, equal ones in the order of their first vertices. An edge adds as many triangles as it has beside it, and
    /// one that would add too many is passed over: a mesh of one or two triangles an edge ends at `wanted` or one below.
    ///
    /// New vertices are midpoints rounded to `f32`, texture coordinates too, and follow the old ones; parts of a triangle have
    /// its material and winding. Where edges are a few roundings long, parts may lose their area. Cost: a sort of
    /// the edges and a hash look-up a corner; about a second for two million triangles.
    pub fn subdivide_to(&mut self, wanted: usize) {
        let wanted = wanted.min(MOST_TRIANGLES);
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

/// The longest edges that together have no more than `triangles` beside them. `edge` names an edge by its ends.
fn longest_edges(
    mesh: &Mesh,
    edge: impl Fn([u32; 2]) -> [u32; 2],
    mut triangles: usize,
) -> HashSet<[u32; 2]> {
    // An edge's name and its length: the ends' positions are the same under any of its spellings.
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

/// Cuts the edges that are `chosen` by their ends, given in either order.
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

/// The parts of a triangle whose sides, from the first corner on, have these middles.
fn cut_triangle(mesh: &Mesh, [a, b, c]: [u32; 3], cuts: [Option<u32>; 3], parts: &mut Vec<[u32; 3]>) {
    match cuts {
        [None, None, None] => parts.push([a, b, c]),
        [Some(ab), Some(bc), Some(ca)] => {
            parts.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        [Some(ab), None, None] => parts.extend([[a, ab, c], [ab, b, c]]),
        [None, Some(bc), Some(ca)] => {
            // The four-cornered rest is cut along its shorter diagonal.
            parts.push([ca, bc, c]);
            if squared_length(mesh, [a, bc]) <= squared_length(mesh, [b, ca]) {
                parts.extend([[a, b, bc], [a, bc, ca]]);
            } else {
                parts.extend([[a, b, ca], [b, bc, ca]]);
            }
        }
        // The other spellings of the last two.
        [ab, bc, ca] => cut_triangle(mesh, [b, c, a], [bc, ca, ab], parts),
    }
}
