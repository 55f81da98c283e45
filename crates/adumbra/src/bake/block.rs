//! Squares of columns, and the triangles near them: exact tests of what touches, crosses and covers.
//!
//! All in the snapped coordinates that decide which texel centres a triangle covers, so nothing here can disagree with the
//! sampling: a test may err only towards "touches" and "crosses".

use super::columns::{ColumnRules, ReceiverKind, ReceiverPlane};
use super::project::{FixedDepth, Projected, SUBTEXEL, fixed_depth};
use super::surface::Surface;

/// How far outside the footprints of a block's texels an edge still counts as crossing the block, in 1/256 texel: corners move by
/// half a step when they are snapped.
const CROSSING_MARGIN: i64 = 3;

/// Slack of depths that are computed over a block and sampled at its texels, in 1/256 voxel.
pub(crate) const DEPTH_SLACK: FixedDepth = 2;

/// A square of 2^level × 2^level texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) level: u32,
    /// First texel.
    pub(crate) x: u32,
    pub(crate) y: u32,
}

/// A surface of a root block, with what is the same for all blocks below it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockSurface {
    pub(crate) surface: Surface,
    /// What it is as a receiver, if it is one.
    pub(crate) receiver: Option<ReceiverPlane>,
    /// Which edges, in the order of [`Projected::snapped`], have no partner that is drawn on the same side: only there can the
    /// number of layers change.
    pub(crate) contour: [bool; 3],
    /// Surfaces of equal group hang together and look the same way.
    pub(crate) group: u32,
    /// Surfaces of equal body hang together; the groups of a body have numbers in a row.
    pub(crate) body: u32,
}

/// A rectangle in 1/256 texel, its ends included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SnappedRect {
    low: [i64; 2],
    high: [i64; 2],
}

impl Block {
    /// The quarter `x_bit << 1 | y_bit`.
    pub(crate) fn quarter(&self, quarter: u32) -> Self {
        let level = self.level - 1;
        Self { level, x: self.x + ((quarter >> 1) << level), y: self.y + ((quarter & 1) << level) }
    }

    /// The block and all within `margin` (1/256 texel) of it.
    pub(crate) fn snapped(&self, margin: i64) -> SnappedRect {
        let low = [self.x, self.y].map(|c| i64::from(c) * SUBTEXEL - margin);
        let side = (SUBTEXEL << self.level) + 2 * margin;
        SnappedRect { low, high: low.map(|c| c + side) }
    }

    /// Where an edge counts as crossing: wherever a receiver may lie that samples the block's columns, or a layer that ends beside
    /// the block would be taken for one that goes on.
    pub(crate) fn crossing_rect(&self, rules: &ColumnRules) -> SnappedRect {
        let outside = rules.footprint_half_texels(ReceiverKind::Footprint) - 0.5;
        self.snapped((outside * SUBTEXEL as f64).ceil() as i64 + CROSSING_MARGIN)
    }
}

impl SnappedRect {
    /// Whether the triangle comes into the rectangle; may say yes where it only comes near.
    pub(crate) fn touches(&self, triangle: &Projected) -> bool {
        let c = &triangle.snapped;
        for a in 0..2 {
            if c.iter().all(|p| p[a] < self.low[a]) || c.iter().all(|p| p[a] > self.high[a]) {
                return false;
            }
        }
        // Beside an edge: anticlockwise, so inside is where the side is positive; a line has both sides.
        (0..3).all(|e| self.reaches_left_of(c[e], c[(e + 1) % 3]))
    }

    /// Whether the edge from `a` to `b` comes into the rectangle.
    pub(crate) fn crossed_by(&self, a: [i64; 2], b: [i64; 2]) -> bool {
        (0..2).all(|k| a[k].max(b[k]) >= self.low[k] && a[k].min(b[k]) <= self.high[k])
            && self.reaches_left_of(a, b)
            && self.reaches_left_of(b, a)
    }

    /// Whether a corner lies on the line from `a` to `b` or to its left: `dx·(y - a.y) - dy·(x - a.x)` is not negative there.
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

/// Where a surface lies over a block, 1/256 voxel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceRange {
    /// Depths over the block's texels and their footprints, or more: what is sampled there lies strictly within.
    pub(crate) low: FixedDepth,
    pub(crate) high: FixedDepth,
    /// Where look-ups from it sample the block's columns; none where it receives no light.
    pub(crate) sampled: Option<SampledRange>,
}

impl SurfaceRange {
    /// Whether it lies so far behind a settled depth that neither what it covers nor what it receives decides a column.
    pub(crate) fn is_behind(&self, settled: FixedDepth) -> bool {
        self.low > settled && self.sampled.is_none_or(|s| is_sampled_behind(s.lifted_low, settled))
    }

    /// The nearest depth that look-ups from it sample; [`FixedDepth::MAX`] where it receives no light.
    pub(crate) fn lifted(&self) -> FixedDepth {
        self.sampled.map_or(FixedDepth::MAX, |s| s.lifted_low)
    }
}

/// Whether look-ups that sample at `lifted` or deeper find the shadow of every column that ends at `settled` or before.
pub(crate) fn is_sampled_behind(lifted: FixedDepth, settled: FixedDepth) -> bool {
    lifted > settled.saturating_add(SUBTEXEL as FixedDepth)
}

/// Where look-ups from a surface sample the columns of a block, bounds in 1/256 voxel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampledRange {
    /// Neither a part of it lies deeper, nor its plane at a centre that it covers.
    pub(crate) deepest: FixedDepth,
    /// No look-up samples nearer.
    pub(crate) lifted_low: FixedDepth,
    /// None samples deeper.
    pub(crate) lifted_high: FixedDepth,
}

impl SampledRange {
    /// Bounds of both.
    pub(crate) fn joined(self, other: Self) -> Self {
        Self {
            deepest: self.deepest.max(other.deepest),
            lifted_low: self.lifted_low.min(other.lifted_low),
            lifted_high: self.lifted_high.max(other.lifted_high),
        }
    }
}

impl BlockSurface {
    /// Where it lies over the block.
    pub(crate) fn range_over(&self, block: &Block, rules: &ColumnRules) -> SurfaceRange {
        let footprint = rules.footprint_half_texels(ReceiverKind::Footprint);
        let half_side = f64::from(1_u32 << block.level) / 2.0;
        let center = [block.x, block.y].map(|c| f64::from(c) + half_side);
        let [low, high] = self.surface.shape.range_near(center, half_side + footprint);
        let sampled = self.receiver.map(|ReceiverPlane { plane, lift_voxels, rounding_voxels }| {
            // Its points are at most that far from the centres where its plane is asked.
            let rise = footprint * plane.gradient_sum();
            // A centre that only the snapped corners cover lies half a step beside the triangle, where its plane runs on.
            let snapping = plane.gradient_sum() / (2 * SUBTEXEL) as f64;
            SampledRange {
                deepest: fixed_depth(high + snapping) + DEPTH_SLACK,
                lifted_low: fixed_depth(low - rise - lift_voxels - rounding_voxels) - DEPTH_SLACK,
                lifted_high: fixed_depth(high + rise - lift_voxels) + DEPTH_SLACK,
            }
        });
        SurfaceRange { low: fixed_depth(low) - DEPTH_SLACK, high: fixed_depth(high) + DEPTH_SLACK, sampled }
    }

    /// Whether the number of layers may change within `rect` because of this surface.
    pub(crate) fn contour_crosses(&self, rect: &SnappedRect) -> bool {
        let c = &self.surface.shape.snapped;
        (0..3).any(|e| self.contour[e] && rect.crossed_by(c[e], c[(e + 1) % 3]))
    }
}
