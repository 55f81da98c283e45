//! What can be said of a whole block of columns from the triangles near it, without sampling one.
//!
//! The bounds are those of the block descent: E, at least the largest e of the block's columns, and X, at most their
//! smallest x; the block is *resolved* where X >= E. They rest on one fact. Surfaces that hang together and look the same way
//! cover every texel centre of a block equally often unless an edge at which the one side ends (a contour of a solid, the
//! border of an open surface) comes into the block. So one sample tells whether such a group covers the block, and then its
//! depth range there bounds the first surface. Everything else errs outwards: a bound that is too weak costs time, never an
//! answer.

use super::block::{Block, BlockSurface, DEPTH_SLACK, SampledRange, SurfaceRange, is_sampled_behind};
use super::columns::{ColumnRules, FREE_TO_END, ReceiverKind};
use super::project::{FixedDepth, SUBTEXEL};

/// Slack of a footprint's half side for the snapping of corners, texels.
const FOOTPRINT_SLACK: f64 = 1.0 / 64.0;

/// What is known of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Every column may switch anywhere in `[e, x]`.
    Resolved([u32; 2]),
    /// Look closer. No first surface lies deeper than `settled`, no solid that is met first ends deeper, and every column has
    /// a receiver behind it: surfaces there matter no more. [`FixedDepth::MAX`] where nothing is known.
    Unresolved { settled: FixedDepth },
}

/// Buffers that one worker reuses from block to block.
#[derive(Default)]
pub(crate) struct JudgeBuffers {
    groups: Vec<Group>,
    /// Depth ranges of solids.
    solids: Vec<[FixedDepth; 2]>,
    /// Where each surface of the list lies over the block.
    pub(crate) ranges: Vec<SurfaceRange>,
}

/// The surfaces of one group near a block.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Places in the list.
    from: u32,
    to: u32,
    /// Groups of the same component of the same instance have the same.
    body: u32,
    kind: Kind,
    /// Range of depth over the block and its footprints.
    z_low: FixedDepth,
    z_high: FixedDepth,
    /// A contour of it comes into the block.
    contour: bool,
    /// Ranges of the planes' gradients.
    gradient_low: [f64; 2],
    gradient_high: [f64; 2],
    /// The smallest bias at a slope of the group.
    bias: FixedDepth,
    /// Bounds of where look-ups from it sample the block's columns, if any do.
    sampled: Option<SampledRange>,
}

/// How the surfaces of a group are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Not sampled: edge-on, or it does not cast.
    Receiver,
    /// The side of a solid that the light enters.
    SolidFront,
    /// The side that it leaves.
    SolidBack,
    /// An open surface without holes.
    Open,
    /// A surface with holes.
    Masked,
}

/// Judges `block` by the surfaces near it: `list` has the places in `surfaces`, ascending, of all that come within reach of
/// its columns' footprints and lie no deeper than what is known to be settled; `known_behind` is the nearest depth of those
/// that do, [`FixedDepth::MAX`] where there are none.
#[inline(never)] // Counted by `cargo xtask count`.
pub(crate) fn judge(
    block: &Block,
    surfaces: &[BlockSurface],
    list: &[u32],
    known_behind: FixedDepth,
    rules: &ColumnRules,
    buffers: &mut JudgeBuffers,
) -> Verdict {
    gather_groups(block, surfaces, list, rules, buffers);
    let groups = &mut buffers.groups;
    let (i, j) = (i64::from(block.x), i64::from(block.y));
    let layers = |g: &Group| {
        list[g.from as usize..g.to as usize]
            .iter()
            .filter(|&&s| surfaces[s as usize].surface.shape.covers(i, j))
            .count()
    };
    // What has no contour here covers all or nothing; what covers nothing is nobody's first surface.
    let mut covering: Option<(FixedDepth, usize, usize)> = None;
    for (n, g) in groups.iter_mut().enumerate() {
        if g.contour || g.kind == Kind::Receiver || g.kind == Kind::Masked {
            continue;
        }
        let count = layers(g);
        if count == 0 {
            g.kind = Kind::Receiver;
        } else if covering.is_none_or(|(nearest, ..)| g.z_high < nearest) {
            covering = Some((g.z_high, n, count));
        }
    }
    let Some((e, cover, cover_layers)) = covering else {
        let empty = groups.iter().all(|g| g.kind == Kind::Receiver);
        return if empty {
            Verdict::Resolved([rules.depth_voxels, FREE_TO_END])
        } else {
            Verdict::Unresolved { settled: FixedDepth::MAX }
        };
    };
    let first_voxel = rules.quantize(e);
    let x = earliest_end(groups, known_behind, e, (cover, cover_layers), rules);
    if x >= first_voxel {
        Verdict::Resolved([first_voxel, x])
    } else {
        Verdict::Unresolved { settled: settled(groups, known_behind, e, &mut buffers.solids) }
    }
}

/// The nearest depth, not before `e`, that no solid reaches across: there every solid that was entered has been left.
/// [`FixedDepth::MAX`] where not every column is known to have a surface behind it, or a first surface may be open.
fn settled(
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
    // How far behind an open surface the next one lies decides its thickness, column by column.
    let open_first = |g: &Group| matches!(g.kind, Kind::Open | Kind::Masked) && g.z_low <= e;
    if groups.iter().any(open_first) {
        return FixedDepth::MAX;
    }
    // What has no contour here and is not left out covers every column.
    let is_behind = |s: &SampledRange| is_sampled_behind(s.lifted_low, depth);
    let covers = |g: &Group| g.kind != Kind::Receiver && !g.contour;
    let covered = groups.iter().any(|g| covers(g) && g.sampled.as_ref().is_some_and(is_behind));
    let known = known_behind != FixedDepth::MAX && is_sampled_behind(known_behind, depth);
    if covered || known { depth } else { FixedDepth::MAX }
}

/// A voxel that no column's x comes before, given that every first surface is at `e` or nearer.
fn earliest_end(
    groups: &[Group],
    known_behind: FixedDepth,
    e: FixedDepth,
    (cover, cover_layers): (usize, usize),
    rules: &ColumnRules,
) -> u32 {
    let could_be_first = |g: &&Group| g.kind != Kind::Receiver && g.z_low <= e;
    let is_solid = |g: &&Group| matches!(g.kind, Kind::SolidFront | Kind::SolidBack);
    let smallest = |values: &mut dyn Iterator<Item = FixedDepth>| values.min().unwrap_or(FixedDepth::MAX);

    // A column whose first surface is a solid's leaves it at a back of some solid.
    let solid_first = groups.iter().filter(could_be_first).any(|g| is_solid(&g));
    let solid_exit = smallest(&mut groups.iter().filter(|g| g.kind == Kind::SolidBack).map(|g| g.z_low));
    // Where two solids touch, the seam between them is open.
    let seams = seams_may_be_closed(groups.iter().filter(could_be_first).filter(is_solid));
    let open_low = smallest(
        &mut groups.iter().filter(could_be_first).filter(|g| seams || !is_solid(g)).map(|g| g.z_low),
    );
    let bias = smallest(&mut groups.iter().filter(could_be_first).map(|g| g.bias));
    let mut exit = FixedDepth::MAX;
    if solid_first {
        exit = exit.min(solid_exit);
    }
    if open_low != FixedDepth::MAX {
        exit = exit.min(open_low.saturating_add(rules.thickness_fixed().max(bias)));
    }

    // A first surface that is one smooth layer over the whole block does not lie behind itself.
    let first = &groups[cover];
    let alone = cover_layers == 1 && groups.iter().filter(could_be_first).count() == 1;
    let smooth = alone && first.rise_of_neighbours(rules) <= f64::from(first.bias - DEPTH_SLACK);
    let base_low = if solid_first { solid_exit.min(open_low) } else { open_low };
    let first_low = smallest(&mut groups.iter().filter(could_be_first).map(|g| g.z_low));
    let mut end = FREE_TO_END;
    for (_, g) in groups.iter().enumerate().filter(|(n, _)| !(smooth && *n == cover)) {
        let Some(sampled) = g.sampled else { continue };
        if sampled.deepest > base_low && sampled.lifted_high > first_low {
            end = end.min(rules.sampled_voxel(sampled.lifted_low.max(first_low)));
        }
    }
    if known_behind != FixedDepth::MAX {
        end = end.min(rules.sampled_voxel(known_behind));
    }
    if end == FREE_TO_END && rules.assume_ground { end } else { end.min(rules.latest_switch(exit)) }
}

/// Whether outlines of two solids come into the block, so that [`super::columns::close_seams`] may find both at one texel.
fn seams_may_be_closed<'a>(solids: impl Iterator<Item = &'a Group>) -> bool {
    let mut bodies = solids.filter(|g| g.contour && g.kind == Kind::SolidFront).map(|g| g.body);
    let one = bodies.next();
    bodies.any(|body| Some(body) != one)
}

impl Group {
    /// How much farther than the surface at a texel's centre the plane of a neighbour in the same smooth layer may lie there, in 1/256
    /// voxel.
    fn rise_of_neighbours(&self, rules: &ColumnRules) -> f64 {
        let bend: f64 = (0..2).map(|a| self.gradient_high[a] - self.gradient_low[a]).sum();
        let half = rules.footprint_half_texels(ReceiverKind::Footprint) + FOOTPRINT_SLACK;
        half * bend * SUBTEXEL as f64
    }
}

fn gather_groups(
    block: &Block,
    surfaces: &[BlockSurface],
    list: &[u32],
    rules: &ColumnRules,
    JudgeBuffers { groups, ranges, .. }: &mut JudgeBuffers,
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

    /// Takes a surface in; says where it lies over the block.
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
