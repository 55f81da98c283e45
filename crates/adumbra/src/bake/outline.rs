//! What lies across each edge of a mesh: from it a block knows which edges can be contours under a given sun.
//!
//! An edge has a *partner* where exactly two triangles meet in it, once in each direction, that are drawn alike (both cast,
//! neither has holes, both or neither bound a solid). Whatever edge has none is an outline under every sun.

use super::casters::ClusterTriangle;
use crate::scene::Mesh;
use crate::scene::topology::weld;

/// No partner.
pub(crate) const NO_PARTNER: u32 = u32::MAX;

/// For each triangle of `triangles`, in their order, and each of its edges 0-1, 1-2, 2-0: the vertex of the partner that is
/// not on the edge, or [`NO_PARTNER`]. Cost: one hash look-up a vertex and one sort of the edges.
pub(crate) fn partners(mesh: &Mesh, triangles: &[ClusterTriangle]) -> Vec<[u32; 3]> {
    let welded = weld(&mesh.positions);
    // Lower vertex, higher vertex, place · 6 + edge · 2 + (1 where the edge runs from the lower to the higher).
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
    let mut partners = vec![[NO_PARTNER; 3]; triangles.len()];
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
            partners[s][s_edge] = corner(t, t_edge);
            partners[t][t_edge] = corner(s, s_edge);
        }
    }
    partners
}

fn drawn_alike(a: &ClusterTriangle, b: &ClusterTriangle) -> bool {
    let plain = |t: &ClusterTriangle| t.casts && !t.masked;
    plain(a) && plain(b) && a.solid == b.solid
}
