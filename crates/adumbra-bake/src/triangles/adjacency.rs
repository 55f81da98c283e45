//! Adjacency of a mesh's triangles, from which a block determines which edges can be contours under a given
//! sun.
//!
//! An edge has an *adjacent triangle* if exactly two triangles share it, once in each direction, and both are
//! drawn alike (both cast, neither has holes, both or neither bound a solid). An edge without one is an
//! outline under every sun.

use crate::triangles::cluster::ClusterTriangle;
use adumbra_scene::Mesh;
use adumbra_scene::topology::weld;

/// Marks an edge without an adjacent triangle.
pub(crate) const NO_ADJACENT: u32 = u32::MAX;

/// For each triangle of `triangles`, in their order, and each of its edges 0-1, 1-2, 2-0: returns the
/// adjacent vertex, which is the vertex of the adjacent triangle that is not on the edge, or [`NO_ADJACENT`].
/// Cost: one hash look-up per vertex and one sort of the edges.
pub(crate) fn adjacent_vertices(mesh: &Mesh, triangles: &[ClusterTriangle]) -> Vec<[u32; 3]> {
    let welded = weld(&mesh.positions);
    // Lower vertex, higher vertex, triangle index · 6 + edge · 2 + (1 if the edge runs from the lower to the
    // higher).
    let mut edges = Vec::with_capacity(triangles.len() * 3);
    for (place, t) in triangles.iter().enumerate() {
        let v = mesh.triangles[t.triangle as usize].map(|i| welded[i as usize]);
        for e in 0..3 {
            let (a, b) = (v[e], v[(e + 1) % 3]);
            if a != b {
                edges.push((a.min(b), a.max(b), (place * 6 + e * 2 + usize::from(a < b)) as u64));
            }
        }
    }
    edges.sort_unstable();
    let mut adjacent_vertices = vec![[NO_ADJACENT; 3]; triangles.len()];
    for same in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let &[(_, _, first), (_, _, second)] = same else { continue };
        if first & 1 == second & 1 {
            continue;
        }
        let place = |code: u64| ((code / 6) as usize, (code / 2 % 3) as usize);
        let ((s, s_edge), (t, t_edge)) = (place(first), place(second));
        if drawn_alike(&triangles[s], &triangles[t]) {
            let corner =
                |p: usize, edge: usize| mesh.triangles[triangles[p].triangle as usize][(edge + 2) % 3];
            adjacent_vertices[s][s_edge] = corner(t, t_edge);
            adjacent_vertices[t][t_edge] = corner(s, s_edge);
        }
    }
    adjacent_vertices
}

fn drawn_alike(a: &ClusterTriangle, b: &ClusterTriangle) -> bool {
    let plain = |t: &ClusterTriangle| t.casts && !t.masked;
    plain(a) && plain(b) && a.solid == b.solid
}
