//! Classifies a whole block of columns from the triangles near it, without sampling every column.
//!
//! The bounds are those of the block descent: E, at least the largest e of the block's columns, and X, at
//! most their smallest x. The block is *resolved* if X >= E. The bounds rest on one fact. Surfaces that are
//! connected and face the same way cover every texel centre of a block equally often, unless an edge at which
//! that side ends (a contour of a solid, the border of an open surface) crosses the block. So one sample
//! decides whether such a group covers the block, and if it does, its depth range there bounds the first
//! surface. All other bounds are conservative: one that is too weak costs time but never changes an answer.

use crate::columns::rules::{ColumnRules, FREE_TO_END, ReceiverKind};
use crate::fast::block::{
    Block, BlockSurface, DEPTH_SLACK, Front, SampledRange, SurfaceRange, is_sampled_behind,
};
use crate::triangles::depth::{FixedDepth, SUBTEXEL};

/// Slack for a footprint's half side because of the snapping of corners, texels.
const FOOTPRINT_SLACK: f64 = 1.0 / 64.0;

/// The result for a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Classification {
    /// Every column may switch anywhere in `[e, x]`.
    Resolved([u32; 2]),
    /// The block must be subdivided or drawn. No first surface is deeper than `resolved`, no solid that is
    /// hit first ends deeper, and every column has a receiver behind it, so surfaces behind `resolved` no
    /// longer matter. [`FixedDepth::MAX`] if nothing is known.
    Unresolved { resolved: FixedDepth },
}

/// Buffers that a worker reuses from block to block.
#[derive(Default)]
pub(crate) struct ClassifyBuffers {
    groups: Vec<Group>,
    /// Depth ranges of solids.
    solids: Vec<[FixedDepth; 2]>,
    /// Depth bounds over the block of each surface in the list.
    pub(crate) ranges: Vec<SurfaceRange>,
}

/// The surfaces of one group near a block.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Range of indices into the list.
    from: u32,
    to: u32,
    /// Equal for all groups of the same component of the same instance.
    body: u32,
    kind: Kind,
    /// Depth range over the block and its footprints.
    z_low: FixedDepth,
    z_high: FixedDepth,
    /// Whether a contour of the group crosses the block.
    contour: bool,
    /// Componentwise range of the planes' gradients.
    gradient_low: [f64; 2],
    gradient_high: [f64; 2],
    /// The smallest bias at any slope of the group.
    bias: FixedDepth,
    /// Bounds of where look-ups from the group sample the block's columns, if any do.
    sampled: Option<SampledRange>,
}

/// How the surfaces of a group are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Not sampled: edge-on, or not a caster.
    Receiver,
    /// The side of a solid at which light enters.
    SolidFront,
    /// The side of a solid at which light leaves.
    SolidBack,
    /// An open surface without holes.
    Open,
    /// A surface with holes.
    Masked,
}

/// Classifies `block` by the surfaces near it. `list` has ascending indices into `surfaces`: all surfaces
/// within reach of the columns' footprints that are no deeper than what is known to be resolved.
/// `known_behind` is the nearest depth at which the deeper ones are sampled, or
/// [`FixedDepth::MAX`] if there are none. `beside` has receivers farther away, whose filters may read the
/// block's columns.
#[inline(never)] // Counted by `cargo xtask count`.
pub(crate) fn classify(
    block: &Block,
    surfaces: &[BlockSurface],
    list: &[u32],
    beside: &[u32],
    known_behind: FixedDepth,
    rules: &ColumnRules,
    buffers: &mut ClassifyBuffers,
) -> Classification {
    gather_groups(block, surfaces, list, rules, buffers);
    let groups = &mut buffers.groups;
    let (i, j) = (i64::from(block.x), i64::from(block.y));
    let layers = |g: &Group| {
        list[g.from as usize..g.to as usize]
            .iter()
            .filter(|&&s| surfaces[s as usize].surface.shape.covers(i, j))
            .count()
    };
    // A group without a contour here covers all columns or none. A group that covers none is the first
    // surface of no column.
    let mut covering: Option<Cover> = None;
    for (n, g) in groups.iter_mut().enumerate() {
        if g.contour || g.kind == Kind::Receiver || g.kind == Kind::Masked {
            continue;
        }
        let count = layers(g);
        if count == 0 {
            g.kind = Kind::Receiver;
        } else if covering.as_ref().is_none_or(|nearest| g.z_high < nearest.e) {
            covering = Some(Cover { e: g.z_high, group: n, layers: count });
        }
    }
    let Some(cover) = covering else {
        let empty = groups.iter().all(|g| g.kind == Kind::Receiver);
        return if empty {
            Classification::Resolved([rules.depth_voxels, FREE_TO_END])
        } else {
            Classification::Unresolved { resolved: FixedDepth::MAX }
        };
    };
    let first_voxel = rules.quantize(cover.e);
    let mut x = earliest_end(groups, known_behind, &cover, rules);
    if x >= first_voxel {
        x = earliest_contact(block, surfaces, (list, beside), groups, &cover, x, rules);
    }
    if x >= first_voxel {
        Classification::Resolved([first_voxel, x])
    } else {
        Classification::Unresolved {
            resolved: resolved_depth(groups, known_behind, cover.e, &mut buffers.solids),
        }
    }
}

/// Returns the nearest depth, not before `e`, that no solid extends across: every solid that was entered has
/// been left there. Returns [`FixedDepth::MAX`] if some column may have no surface behind it, or if a first
/// surface may be open.
fn resolved_depth(
    groups: &[Group],
    known_behind: FixedDepth,
    e: FixedDepth,
    solids: &mut Vec<[FixedDepth; 2]>,
) -> FixedDepth {
    solids.clear();
    let mut last = None;
    for g in groups.iter().filter(|g| matches!(g.kind, Kind::SolidFront | Kind::SolidBack)) {
        match solids.last_mut() {
            Some(range) if last == Some(g.body) => *range = [range[0].min(g.z_low), range[1].max(g.z_high)],
            _ => solids.push([g.z_low, g.z_high]),
        }
        last = Some(g.body);
    }
    solids.sort_unstable();
    let depth =
        solids.iter().fold(e, |depth, &[low, high]| if low <= depth { depth.max(high) } else { depth });
    // The thickness of an open surface depends on how far behind it the next surface is, column by column.
    let open_first = |g: &Group| matches!(g.kind, Kind::Open | Kind::Masked) && g.z_low <= e;
    if groups.iter().any(open_first) {
        return FixedDepth::MAX;
    }
    // A group that has no contour here and was not reclassified as a receiver covers every column.
    let is_behind = |s: &SampledRange| is_sampled_behind(s.lifted_low, depth);
    let covers = |g: &Group| g.kind != Kind::Receiver && !g.contour;
    let covered = groups.iter().any(|g| covers(g) && g.sampled.as_ref().is_some_and(is_behind));
    let known = known_behind != FixedDepth::MAX && is_sampled_behind(known_behind, depth);
    if covered || known { depth } else { FixedDepth::MAX }
}

/// The group that covers every column of a block and whose farthest surface is nearest.
struct Cover {
    /// No first surface is deeper.
    e: FixedDepth,
    /// Index of the group.
    group: usize,
    /// How often it covers each column.
    layers: usize,
}

impl Cover {
    /// Whether a group may provide the first surface of a column.
    fn could_be_first(&self, g: &Group) -> bool {
        g.kind != Kind::Receiver && g.z_low <= self.e
    }

    /// Whether it is the first surface of all columns, in one layer.
    fn is_alone(&self, groups: &[Group]) -> bool {
        self.layers == 1 && groups.iter().filter(|g| self.could_be_first(g)).count() == 1
    }
}

/// Returns a lower bound on the x of all columns.
fn earliest_end(groups: &[Group], known_behind: FixedDepth, cover: &Cover, rules: &ColumnRules) -> u32 {
    let could_be_first = |g: &&Group| cover.could_be_first(g);
    let is_solid = |g: &&Group| matches!(g.kind, Kind::SolidFront | Kind::SolidBack);
    let smallest = |values: &mut dyn Iterator<Item = FixedDepth>| values.min().unwrap_or(FixedDepth::MAX);

    // A column whose first surface bounds a solid leaves it at the back of some solid.
    let solid_first = groups.iter().filter(could_be_first).any(|g| is_solid(&g));
    let solid_exit = smallest(&mut groups.iter().filter(|g| g.kind == Kind::SolidBack).map(|g| g.z_low));
    // Where two solids touch, the seam between them is open.
    let seams = seams_may_be_closed(groups.iter().filter(could_be_first).filter(is_solid));
    let open_low = smallest(
        &mut groups.iter().filter(could_be_first).filter(|g| seams || !is_solid(g)).map(|g| g.z_low),
    );
    let bias = smallest(&mut groups.iter().filter(could_be_first).map(|g| g.bias));
    let first_low = smallest(&mut groups.iter().filter(could_be_first).map(|g| g.z_low));
    let (mut exit, mut below) = (FixedDepth::MAX, FixedDepth::MAX);
    if solid_first {
        exit = solid_exit;
        below = rules.below_exit(solid_exit, first_low, true);
    }
    if open_low != FixedDepth::MAX {
        let open_exit = open_low.saturating_add(rules.thickness.max(bias));
        exit = exit.min(open_exit);
        below = below.min(rules.below_exit(open_exit, open_low, false));
    }

    // A first surface that is one smooth layer over the whole block is not behind itself.
    let first = &groups[cover.group];
    let smooth =
        cover.is_alone(groups) && first.rise_of_neighbours(rules) <= f64::from(first.bias - DEPTH_SLACK);
    let base_low = if solid_first { solid_exit.min(open_low) } else { open_low };
    let mut end = FREE_TO_END;
    for (_, g) in groups.iter().enumerate().filter(|(n, _)| !(smooth && *n == cover.group)) {
        let Some(sampled) = g.sampled else { continue };
        if sampled.deepest > base_low && sampled.lifted_high > first_low {
            end = end.min(rules.sampled_voxel(sampled.lifted_low.max(first_low)));
        }
    }
    if known_behind != FixedDepth::MAX {
        end = end.min(rules.sampled_voxel(known_behind));
    }
    if below != FixedDepth::MAX {
        end = end.min(rules.sampled_voxel(below));
    }
    if end == FREE_TO_END && rules.is_last(first_low) { end } else { end.min(rules.latest_switch(exit)) }
}

/// Returns `x`, or a lower bound on the voxels in which filters read the block's columns behind their first
/// surfaces, if that is less.
fn earliest_contact(
    block: &Block,
    surfaces: &[BlockSurface],
    (list, beside): (&[u32], &[u32]),
    groups: &[Group],
    cover: &Cover,
    x: u32,
    rules: &ColumnRules,
) -> u32 {
    let could_be_first = |g: &&Group| cover.could_be_first(g);
    let first_low = groups.iter().filter(could_be_first).map(|g| g.z_low).min().unwrap_or(FixedDepth::MAX);
    let from = ColumnRules::contact_from(rules.quantize(first_low));
    if x <= from {
        return x;
    }
    let of_group = |g: &Group| &list[g.from as usize..g.to as usize];
    let firsts = groups.iter().filter(could_be_first).flat_map(of_group);
    let front = front(block, firsts.map(|&s| &surfaces[s as usize]));
    // Filters around the first surfaces themselves read before them, if they are one smooth layer.
    let smooth = cover.is_alone(groups) && groups[cover.group].bends_within(rules);
    let skipped = |g: &Group| smooth && cover.could_be_first(g);
    let near = groups.iter().filter(|g| !skipped(g)).flat_map(of_group);
    let contacts =
        near.chain(beside).filter_map(|&s| surfaces[s as usize].contacts_over(block, front.as_ref(), rules));
    contacts.filter(|[_, high]| *high >= from).map(|[low, _]| low.max(from)).fold(x, u32::min)
}

/// Whether outlines of two solids cross the block, so that [`crate::columns::seams::close_seams`] may find
/// both at one texel.
fn seams_may_be_closed<'a>(solids: impl Iterator<Item = &'a Group>) -> bool {
    let mut bodies = solids.filter(|g| g.contour && g.kind == Kind::SolidFront).map(|g| g.body);
    let one = bodies.next();
    bodies.any(|body| Some(body) != one)
}

impl Group {
    /// Returns how much deeper than the surface at a texel's centre the plane of a neighbour in the same
    /// smooth layer may be there, 1/256 voxel.
    fn rise_of_neighbours(&self, rules: &ColumnRules) -> f64 {
        let bend: f64 = (0..2).map(|a| self.gradient_high[a] - self.gradient_low[a]).sum();
        let half = rules.footprint_half_texels(ReceiverKind::Footprint) + FOOTPRINT_SLACK;
        half * bend * SUBTEXEL as f64
    }

    /// Whether filters around this layer find no shadow in it: over their reach, the layer bends by less than
    /// the free distance.
    fn bends_within(&self, rules: &ColumnRules) -> bool {
        let bend: f64 = (0..2).map(|a| self.gradient_high[a] - self.gradient_low[a]).sum();
        (rules.contact_reach_texels() + 1.0) * bend < free_voxels() + rules.least_lift_voxels()
    }
}

/// How far behind a first surface filters may read before a column must be shadowed for them, less slack,
/// voxels.
fn free_voxels() -> f64 {
    // A first voxel that may be in shadow begins up to half a voxel before its surface.
    f64::from(ColumnRules::contact_from(0)) - 1.0
}

/// Returns the plane of one of these surfaces, moved before all others over the block. `None` if one has no
/// plane.
fn front<'a>(block: &Block, mut surfaces: impl Iterator<Item = &'a BlockSurface>) -> Option<Front> {
    let half_side = f64::from(1_u32 << block.level) / 2.0;
    let [x, y] = [block.x, block.y].map(|c| f64::from(c) + half_side);
    let one = surfaces.next()?.surface.shape.plane?;
    let mut before = 0.0_f64;
    for s in surfaces {
        let plane = s.surface.shape.plane?;
        let turn: f64 = (0..2).map(|a| (plane.gradient[a] - one.gradient[a]).abs()).sum();
        before = before.max(one.at(x, y) - plane.at(x, y) + half_side * turn);
    }
    Some(Front { plane: one, free_voxels: free_voxels() - before })
}

fn gather_groups(
    block: &Block,
    surfaces: &[BlockSurface],
    list: &[u32],
    rules: &ColumnRules,
    ClassifyBuffers { groups, ranges, .. }: &mut ClassifyBuffers,
) {
    groups.clear();
    ranges.clear();
    let crossing = block.crossing_rect(rules);
    let mut last = None;
    for (place, &s) in list.iter().enumerate() {
        let surface = &surfaces[s as usize];
        if last != Some(surface.group) {
            last = Some(surface.group);
            groups.push(Group::new(place as u32, surface));
        }
        let Some(group) = groups.last_mut() else { continue };
        group.to = place as u32 + 1;
        ranges.push(group.add(surface, block, rules));
        group.contour = group.contour || (group.kind != Kind::Receiver && surface.contour_crosses(&crossing));
    }
}

impl Group {
    fn new(from: u32, first: &BlockSurface) -> Self {
        let s = &first.surface;
        let kind = match (s.casts && s.shape.plane.is_some(), s.masked, s.solid) {
            (false, ..) => Kind::Receiver,
            (true, true, _) => Kind::Masked,
            (true, false, true) if s.shape.faces_sun => Kind::SolidFront,
            (true, false, true) => Kind::SolidBack,
            (true, false, false) => Kind::Open,
        };
        Self {
            from,
            to: from,
            body: first.body,
            kind,
            z_low: FixedDepth::MAX,
            z_high: FixedDepth::MIN,
            contour: kind == Kind::Masked,
            gradient_low: [f64::INFINITY; 2],
            gradient_high: [f64::NEG_INFINITY; 2],
            bias: FixedDepth::MAX,
            sampled: None,
        }
    }

    /// Adds a surface and returns its depth bounds over the block.
    fn add(&mut self, surface: &BlockSurface, block: &Block, rules: &ColumnRules) -> SurfaceRange {
        let shape = &surface.surface.shape;
        if let Some(plane) = &shape.plane {
            for a in 0..2 {
                self.gradient_low[a] = self.gradient_low[a].min(plane.gradient[a]);
                self.gradient_high[a] = self.gradient_high[a].max(plane.gradient[a]);
            }
        }
        let range = surface.range_over(block, rules);
        self.bias = self.bias.min(rules.bias_fixed(shape.slope));
        self.z_low = self.z_low.min(range.low);
        self.z_high = self.z_high.max(range.high);
        if let Some(new) = range.sampled {
            self.sampled = Some(self.sampled.map_or(new, |s| s.joined(new)));
        }
        range
    }
}
