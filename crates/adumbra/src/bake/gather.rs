//! The surfaces of a root block, projected once, grouped by what hangs together and looks the same way, with their contours.

use super::block::BlockSurface;
use super::casters::Casters;
use super::outline::NO_PARTNER;
use super::project::Projected;
use super::surface::{Surface, surface_of};
use crate::light::LightGrid;

/// The surfaces that may touch root block `tile`, sorted by group. Their order decides nothing.
#[inline(never)] // Counted by `cargo xtask count`.
pub(crate) fn gather(casters: &Casters<'_>, tile: usize, grid: &LightGrid) -> Vec<BlockSurface> {
    let mut found: Vec<([u32; 3], BlockSurface)> = Vec::new();
    for &placed in casters.in_tile(tile) {
        let instance = &casters.scene.instances[placed.instance as usize];
        let mesh = &casters.scene.meshes[instance.mesh as usize];
        let flipped = instance.determinant() < 0.0;
        let corner = |v: u32| grid.to_grid(instance.to_world(mesh.positions[v as usize]));
        for (c, partners) in casters.triangles(placed).iter().zip(casters.partners(placed)) {
            let vertices = mesh.triangles[c.triangle as usize];
            let corners = vertices.map(corner);
            let surface = surface_of(c, placed.instance, instance, Projected::new(corners, flipped));
            let outline = |e: usize| {
                partners[e] == NO_PARTNER || {
                    let partner = [corners[(e + 1) % 3], corners[e], corner(partners[e])];
                    Projected::drawn_facing(partner, flipped) != Some(surface.shape.faces_sun)
                }
            };
            let given = [outline(0), outline(1), outline(2)];
            let contour = if surface.shape.swapped { [given[2], given[1], given[0]] } else { given };
            found.push((
                group_key(&surface, c.component),
                BlockSurface { surface, contour, group: 0, body: 0 },
            ));
        }
    }
    found.sort_unstable_by_key(|(key, s)| (*key, s.surface.triangle));
    let (mut group, mut body) = (0, 0);
    let mut last: Option<[u32; 3]> = None;
    let numbered = found.into_iter().map(|(key, surface)| {
        if let Some(last) = last {
            group += u32::from(last != key);
            body += u32::from(last[..2] != key[..2]);
        }
        last = Some(key);
        BlockSurface { group, body, ..surface }
    });
    numbered.collect()
}

/// What the surfaces of a group have in common: instance, component, and how they are drawn.
fn group_key(s: &Surface, component: u32) -> [u32; 3] {
    let bits = [s.shape.plane.is_some(), s.shape.faces_sun, s.casts, s.solid, s.masked];
    let drawn = bits.iter().fold(0, |word, &bit| word << 1 | u32::from(bit));
    [s.instance, component, drawn]
}
