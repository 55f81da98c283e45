//! Seams between solids that touch.
//!
//! Rays find no gap there. A column's samples may: snapping moves the corners of one solid off the edge of
//! its neighbour.

use crate::columns::rules::FirstSurface;
use crate::triangles::depth::FixedDepth;
use crate::triangles::surface::Surface;

/// A sunward surface of a solid that covers a texel's centre only when it is grown by the seam width.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct SeamHit {
    texel: u32,
    first: FirstSurface,
    /// Instance and component.
    body: [u32; 2],
}

impl SeamHit {
    pub(crate) fn new(texel: usize, depth: FixedDepth, info: u32, surface: &Surface) -> Self {
        let mut first = FirstSurface::new(depth, info);
        first.set_open();
        Self { texel: texel as u32, first, body: [surface.instance, surface.component] }
    }
}

/// Keeps only the hits at texels where hits of two solids meet. Returns whether any are left.
pub(crate) fn keep_meeting_seams(hits: &mut Vec<SeamHit>) -> bool {
    hits.sort_unstable();
    let mut kept = 0;
    let mut start = 0;
    while start < hits.len() {
        let texel = hits[start].texel;
        let end = start + hits[start..].partition_point(|hit| hit.texel == texel);
        if hits[start..end].iter().any(|hit| hit.body != hits[start].body) {
            hits.copy_within(start..end, kept);
            kept += end - start;
        }
        start = end;
    }
    hits.truncate(kept);
    kept > 0
}

/// Removes the hits of a solid at texels that `surface`, another part of the solid's sunward side, covers
/// itself. They are beside an edge within that side, where there is no seam.
pub(crate) fn drop_covered_seams(hits: &mut Vec<SeamHit>, surface: &Surface, covers: impl Fn(usize) -> bool) {
    if surface.casts && surface.solid && !surface.masked && surface.shape.faces_sun {
        let body = [surface.instance, surface.component];
        hits.retain(|hit| hit.body != body || !covers(hit.texel as usize));
    }
}

/// Closes the seams between solids that touch. A centre that is within the seam width of two solids is
/// covered from the depth at which both are. The inside is unknown there, so the covering surface is open.
/// Calls `close(texel, surface)` at most once per texel.
pub(crate) fn close_seams(hits: &[SeamHit], mut close: impl FnMut(usize, FirstSurface)) {
    for texel in hits.chunk_by(|a, b| a.texel == b.texel) {
        if let Some(second) = texel.iter().find(|hit| hit.body != texel[0].body) {
            close(second.texel as usize, second.first);
        }
    }
}
