//! Blocks of columns, and exact tests of which triangles near them touch, cross and cover them.
//!
//! All tests use the snapped coordinates that decide which texel centres a triangle covers, so they cannot
//! disagree with the sampling. A test may err only towards "touches" and "crosses".

use crate::columns::rules::{ColumnRules, ReceiverKind, ReceiverPlane};
use crate::triangles::depth::{FixedDepth, Plane, SUBTEXEL, fixed_depth};
use crate::triangles::project::Projected;
use crate::triangles::surface::Surface;

/// Distance in 1/256 texel outside the footprints of a block's texels at which an edge still counts as
/// crossing the block: snapping moves corners by half a step.
const CROSSING_MARGIN: i64 = 3;

/// Slack for depths that are computed over a block and sampled at its texels, 1/256 voxel.
pub(crate) const DEPTH_SLACK: FixedDepth = 2;

/// A square of 2^level × 2^level texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) level: u32,
    /// First texel.
    pub(crate) x: u32,
    pub(crate) y: u32,
}

/// A surface of a root block, with data that is shared by all blocks below it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockSurface {
    pub(crate) surface: Surface,
    /// The surface as a receiver, if it is one.
    pub(crate) receiver: Option<ReceiverPlane>,
    /// Which edges, in the order of [`Projected::snapped`], have no adjacent triangle that is drawn and faces
    /// as this one does. Only there can the number of layers change.
    pub(crate) contour: [bool; 3],
    /// Surfaces with equal `group` are connected and face the same way.
    pub(crate) group: u32,
    /// Surfaces with equal `body` belong to the same connected component. The groups of a component have
    /// consecutive numbers.
    pub(crate) body: u32,
}

/// A rectangle in 1/256 texel, including its boundary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SnappedRect {
    low: [i64; 2],
    high: [i64; 2],
}

/// The box around a triangle, 1/256 texel. Coordinates outside the grid may be cut.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SnappedBox {
    low: [i32; 2],
    high: [i32; 2],
}

impl SnappedBox {
    #[inline]
    pub(crate) fn of(triangle: &Projected) -> Self {
        // Grids are less than 2^27 wide in these units, and blocks reach little beyond them.
        const LIMIT: i64 = 1 << 30;
        let [p, q, r] = triangle.snapped.map(|corner| corner.map(|c| c.clamp(-LIMIT, LIMIT) as i32));
        Self { low: [0, 1].map(|a| p[a].min(q[a]).min(r[a])), high: [0, 1].map(|a| p[a].max(q[a]).max(r[a])) }
    }
}

impl Block {
    /// Returns the quarter `x_bit << 1 | y_bit`.
    pub(crate) fn quarter(&self, quarter: u32) -> Self {
        let level = self.level - 1;
        Self { level, x: self.x + ((quarter >> 1) << level), y: self.y + ((quarter & 1) << level) }
    }

    /// Returns the block grown by `margin` (1/256 texel).
    pub(crate) fn snapped(&self, margin: i64) -> SnappedRect {
        let low = [self.x, self.y].map(|c| i64::from(c) * SUBTEXEL - margin);
        let side = (SUBTEXEL << self.level) + 2 * margin;
        SnappedRect { low, high: low.map(|c| c + side) }
    }

    /// Returns the rectangle in which edges count as crossing. It reaches as far as receivers that sample the
    /// block's columns; otherwise a layer that ends beside the block would be taken for one that continues.
    pub(crate) fn crossing_rect(&self, rules: &ColumnRules) -> SnappedRect {
        let outside = rules.footprint_half_texels(ReceiverKind::Footprint) - 0.5;
        self.snapped((outside * SUBTEXEL as f64).ceil() as i64 + CROSSING_MARGIN)
    }
}

impl SnappedRect {
    /// Whether the triangle touches the rectangle. May return true for a triangle that is only near it.
    #[inline]
    pub(crate) fn touches(&self, triangle: &Projected) -> bool {
        self.meets(&SnappedBox::of(triangle)) && self.touches_within_box(triangle)
    }

    /// Whether the boxes meet.
    #[inline]
    pub(crate) fn meets(&self, SnappedBox { low, high }: &SnappedBox) -> bool {
        (0..2).all(|a| i64::from(high[a]) >= self.low[a] && i64::from(low[a]) <= self.high[a])
    }

    /// [`Self::touches`] for a triangle whose box the rectangle meets.
    pub(crate) fn touches_within_box(&self, triangle: &Projected) -> bool {
        let c = &triangle.snapped;
        // Separation by an edge: corners are anticlockwise, so the inside is where the edge function is
        // positive. A degenerate triangle has both sides.
        (0..3).all(|e| self.reaches_left_of(c[e], c[(e + 1) % 3]))
    }

    /// Whether the box of these corners, texels, is beside the rectangle. Cheaper than projecting the
    /// triangle.
    pub(crate) fn misses_box_of(&self, corners_grid: &[[f64; 3]; 3]) -> bool {
        (0..2).any(|a| {
            let [p, q, r] = corners_grid.map(|c| c[a] * SUBTEXEL as f64);
            // Snapping moves corners by half a step.
            p.max(q).max(r) + 1.0 < self.low[a] as f64 || p.min(q).min(r) - 1.0 > self.high[a] as f64
        })
    }

    /// Whether the edge from `a` to `b` touches the rectangle.
    pub(crate) fn crossed_by(&self, a: [i64; 2], b: [i64; 2]) -> bool {
        (0..2).all(|k| a[k].max(b[k]) >= self.low[k] && a[k].min(b[k]) <= self.high[k])
            && self.reaches_left_of(a, b)
            && self.reaches_left_of(b, a)
    }

    /// Whether a corner of the rectangle is on the line from `a` to `b` or to its left:
    /// `dx·(y - a.y) - dy·(x - a.x)` is not negative there.
    fn reaches_left_of(&self, a: [i64; 2], b: [i64; 2]) -> bool {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let y = if dx >= 0 { self.high[1] } else { self.low[1] } - a[1];
        let x = if dy >= 0 { self.low[0] } else { self.high[0] } - a[0];
        match (dx.checked_mul(y), dy.checked_mul(x)) {
            (Some(up), Some(right)) => up >= right,
            _ => i128::from(dx) * i128::from(y) >= i128::from(dy) * i128::from(x),
        }
    }
}

/// Depth bounds of a surface over a block, 1/256 voxel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceRange {
    /// Bounds of the depths over the block's texels and their footprints. Depths that are sampled there are
    /// strictly within the bounds.
    pub(crate) low: FixedDepth,
    pub(crate) high: FixedDepth,
    /// Bounds of where look-ups from the surface sample the block's columns; `None` if it receives no light.
    pub(crate) sampled: Option<SampledRange>,
}

impl SurfaceRange {
    /// Whether the surface is so far behind a resolved depth that neither what it covers nor what it receives
    /// decides a column.
    pub(crate) fn is_behind(&self, resolved: FixedDepth) -> bool {
        self.low > resolved && self.sampled.is_none_or(|s| is_sampled_behind(s.lifted_low, resolved))
    }

    /// Returns the nearest depth that look-ups from the surface sample, or [`FixedDepth::MAX`] if it receives
    /// no light.
    pub(crate) fn lifted(&self) -> FixedDepth {
        self.sampled.map_or(FixedDepth::MAX, |s| s.lifted_low)
    }
}

/// Whether look-ups that sample at `lifted` or deeper find the shadow of every column that ends at `resolved`
/// or before.
pub(crate) fn is_sampled_behind(lifted: FixedDepth, resolved: FixedDepth) -> bool {
    lifted > resolved.saturating_add(SUBTEXEL as FixedDepth)
}

/// Bounds of where look-ups from a surface sample the columns of a block, 1/256 voxel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampledRange {
    /// Neither a part of the surface nor its plane at a centre that it covers is deeper.
    pub(crate) deepest: FixedDepth,
    /// No look-up samples nearer.
    pub(crate) lifted_low: FixedDepth,
    /// No look-up samples deeper.
    pub(crate) lifted_high: FixedDepth,
}

impl SampledRange {
    /// Returns bounds that enclose both.
    pub(crate) fn joined(self, other: Self) -> Self {
        Self {
            deepest: self.deepest.max(other.deepest),
            lifted_low: self.lifted_low.min(other.lifted_low),
            lifted_high: self.lifted_high.max(other.lifted_high),
        }
    }
}

/// A plane before which no column of a block has a first surface.
pub(crate) struct Front {
    pub(crate) plane: Plane,
    /// How far behind the plane filters may read before a column must be shadowed for them, voxels.
    pub(crate) free_voxels: f64,
}

impl BlockSurface {
    /// Returns the surface's depth bounds over the block.
    #[inline]
    pub(crate) fn range_over(&self, block: &Block, rules: &ColumnRules) -> SurfaceRange {
        let footprint = rules.footprint_half_texels(ReceiverKind::Footprint);
        let half_side = f64::from(1_u32 << block.level) / 2.0;
        let center = [block.x, block.y].map(|c| f64::from(c) + half_side);
        let [low, high] = self.surface.shape.range_near(center, half_side + footprint);
        let sampled = self.receiver.map(|ReceiverPlane { plane, lift_voxels, rounding_voxels }| {
            // Points of the surface are at most this far from the centres at which its plane is evaluated.
            let rise = footprint * plane.gradient_sum();
            // A centre that only the snapped corners cover is up to half a step outside the triangle, where
            // its plane continues.
            let snapping = plane.gradient_sum() / (2 * SUBTEXEL) as f64;
            SampledRange {
                deepest: fixed_depth(high + snapping) + DEPTH_SLACK,
                lifted_low: fixed_depth(low - rise - lift_voxels - rounding_voxels) - DEPTH_SLACK,
                lifted_high: fixed_depth(high + rise - lift_voxels) + DEPTH_SLACK,
            }
        });
        SurfaceRange { low: fixed_depth(low) - DEPTH_SLACK, high: fixed_depth(high) + DEPTH_SLACK, sampled }
    }

    /// Returns the first and the last voxel in which filters around the surface may read the block's columns,
    /// or `None` if the surface receives no light or its filters read none of the columns. With `front`,
    /// reads of voxels that it leaves free do not count.
    pub(crate) fn contacts_over(
        &self,
        block: &Block,
        front: Option<&Front>,
        rules: &ColumnRules,
    ) -> Option<[u32; 2]> {
        let receiver = self.receiver.as_ref()?;
        let shape = &self.surface.shape;
        let plane = &receiver.plane;
        // The block's centres within reach of the triangle's box, plus one texel for rounding.
        let reach = rules.contact_reach_texels() + 1.0;
        let corner = [block.x, block.y].map(f64::from);
        let side = f64::from(1_u32 << block.level);
        let mut center = [0.0; 2];
        let mut half = [0.0; 2];
        for axis in 0..2 {
            let [p, q, r] = shape.corners.map(|c| c[axis]);
            let low = (p.min(q).min(r) - reach).max(corner[axis] + 0.5);
            let high = (p.max(q).max(r) + reach).min(corner[axis] + side - 0.5);
            if low > high {
                return None;
            }
            (center[axis], half[axis]) = (0.5 * (low + high), 0.5 * (high - low));
        }
        let rise = |gradient: [f64; 2]| gradient[0].abs() * half[0] + gradient[1].abs() * half[1];
        let z = plane.at(center[0], center[1]);
        let across = rise(plane.gradient);
        let slack = 1e-9 * (across + z.abs()) + 2.0 / SUBTEXEL as f64;
        if let Some(Front { plane: front, free_voxels }) = front {
            let turn = [0, 1].map(|a| plane.gradient[a] - front.gradient[a]);
            let behind = z - front.at(center[0], center[1]) + rise(turn) + slack;
            if behind - receiver.lift_voxels < *free_voxels {
                return None;
            }
        }
        let beside = reach * plane.gradient_sum();
        let low = (z - across).max(shape.z_min - beside) - slack;
        let high = (z + across).min(shape.z_max + beside) + slack;
        let voxel = |z: f64| rules.contact_at(receiver, z);
        (low <= high).then(|| [voxel(low), voxel(high)])
    }

    /// Whether this surface may change the number of layers within `rect`.
    #[inline]
    pub(crate) fn contour_crosses(&self, rect: &SnappedRect) -> bool {
        let c = &self.surface.shape.snapped;
        (0..3).any(|e| self.contour[e] && rect.crossed_by(c[e], c[(e + 1) % 3]))
    }
}
