//! Gathers the surfaces of a root block: projected once, grouped by connectivity and facing, with their
//! contours.

use crate::columns::rules::ColumnRules;
use crate::fast::block::{BlockSurface, SnappedRect};
use crate::triangles::adjacency::NO_ADJACENT;
use crate::triangles::casters::Casters;
use crate::triangles::project::Projected;
use crate::triangles::surface::{Surface, surface_of};
use adumbra::grid::LightGrid;

/// Gathers the surfaces of root block `root_block` that touch `near`, sorted by group, and within a group in
/// the order of the clusters.
#[inline(never)] // Counted by `cargo xtask count`.
pub(crate) fn gather(
    casters: &Casters<'_>,
    root_block: usize,
    near: &SnappedRect,
    grid: &LightGrid,
    rules: &ColumnRules,
) -> Vec<BlockSurface> {
    let mut found = Vec::new();
    let mut order: Vec<(GroupKey, u32)> = Vec::new();
    let mut corners_grid = VertexCache::default();
    for &placed in casters.in_bin(root_block) {
        let instance = &casters.scene.instances[placed.instance as usize];
        let mesh = &casters.scene.meshes[instance.mesh as usize];
        let flipped = instance.determinant() < 0.0;
        let mut corner = |v: u32| {
            corners_grid
                .get(placed.instance, v, || grid.to_grid(instance.to_world(mesh.positions[v as usize])))
        };
        for (c, adjacent_vertices) in casters.triangles(placed).iter().zip(casters.adjacent_vertices(placed))
        {
            let corners = mesh.triangles[c.triangle as usize].map(&mut corner);
            if near.misses_box_of(&corners) {
                continue;
            }
            let shape = Projected::new(corners, flipped);
            if !near.touches(&shape) {
                continue;
            }
            let surface = surface_of(c, placed.instance, instance, shape);
            let given = [0, 1, 2].map(|e| {
                adjacent_vertices[e] == NO_ADJACENT || {
                    let adjacent = [corners[(e + 1) % 3], corners[e], corner(adjacent_vertices[e])];
                    Projected::drawn_facing(adjacent, flipped) != Some(surface.shape.faces_sun)
                }
            });
            let contour = if surface.shape.swapped { [given[2], given[1], given[0]] } else { given };
            order.push((group_key(&surface, c.component), found.len() as u32));
            let receiver = rules.receiver(&surface);
            found.push(BlockSurface { surface, receiver, contour, group: 0, body: 0 });
        }
    }
    order.sort_unstable();
    let (mut group, mut body) = (0, 0);
    let mut last: Option<GroupKey> = None;
    let sorted = order.into_iter().map(|(key, place)| {
        if let Some(last) = last {
            group += u32::from(last != key);
            body += u32::from(last[..2] != key[..2]);
        }
        last = Some(key);
        BlockSurface { group, body, ..found[place as usize] }
    });
    sorted.collect()
}

/// Instance, component, and how the surface is drawn.
type GroupKey = [u32; 3];

/// Recently used vertices in grid space. A mesh's triangles share most of their vertices.
struct VertexCache(Vec<([u32; 2], [f64; 3])>);

impl Default for VertexCache {
    fn default() -> Self {
        Self(vec![([u32::MAX; 2], [0.0; 3]); 1 << 10])
    }
}

impl VertexCache {
    fn get(&mut self, instance: u32, vertex: u32, project: impl FnOnce() -> [f64; 3]) -> [f64; 3] {
        let slot = vertex as usize % self.0.len();
        let slot = &mut self.0[slot];
        if slot.0 != [instance, vertex] {
            *slot = ([instance, vertex], project());
        }
        slot.1
    }
}

/// Returns the properties that the surfaces of a group share: instance, component, and how they are drawn.
fn group_key(s: &Surface, component: u32) -> GroupKey {
    let bits = [s.shape.plane.is_some(), s.shape.faces_sun, s.casts, s.solid, s.masked];
    let drawn = bits.iter().fold(0, |word, &bit| word << 1 | u32::from(bit));
    [s.instance, component, drawn]
}
