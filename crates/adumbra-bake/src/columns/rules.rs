//! The rules for where a column may switch: §3 of the specification, one rule per function.
//!
//! A column has an *entry* (the first surface from the light) and an *exit*. It may switch from lit to
//! shadowed anywhere between them. Voxel k is defined lit if k < e, defined shadowed if k >= x, and free
//! otherwise, with `e = ceil(entry - 1/2)` and `x = max(e, ceil(exit - 1/2))`. A column without a surface has
//! e = the grid's depth. An x at or beyond the grid's end is [`FREE_TO_END`].

use crate::triangles::depth::{FixedDepth, Plane, SUBTEXEL, SUBTEXEL_BITS, fixed_depth, floor_fixed_depth};
use crate::triangles::project::Projected;
use crate::triangles::surface::Surface;
use adumbra::grid::vec3::dot;
use adumbra::query::receiver;
use adumbra::{Bias, LightGrid, MAX_PLANE_SLOPE, Receivers};

/// The nearest surface of a column, ordered by depth; then solids before open surfaces; then by increasing
/// bias.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct FirstSurface {
    depth: FixedDepth,
    /// | bits | meaning |
    /// |---|---|
    /// | 31 | 1 = open, 0 = bounds a solid |
    /// | 15..0 | bias at the surface's slope, 1/256 voxel |
    ///
    /// Worked value: an open surface with a bias of 1.5 voxels has `0x8000_0180`.
    info: u32,
}

const OPEN_BIT: u32 = 1 << 31;

impl FirstSurface {
    /// No surface.
    pub(crate) const NONE: Self = Self { depth: FixedDepth::MAX, info: u32::MAX };

    /// `info` is from [`ColumnRules::surface_info`].
    #[inline(always)]
    pub(crate) fn new(depth: FixedDepth, info: u32) -> Self {
        Self { depth, info }
    }

    #[inline(always)]
    pub(crate) fn is_none(self) -> bool {
        self.depth == FixedDepth::MAX
    }

    #[inline(always)]
    pub(crate) fn is_solid(self) -> bool {
        self.info & OPEN_BIT == 0
    }

    pub(crate) fn set_open(&mut self) {
        self.info |= OPEN_BIT;
    }

    /// Returns the depth, or [`FixedDepth::MAX`] if there is no surface.
    #[inline(always)]
    pub(crate) fn depth(self) -> FixedDepth {
        self.depth
    }

    /// Returns the argument `info` of [`Self::new`].
    #[inline(always)]
    pub(crate) fn info(self) -> u32 {
        self.info
    }

    /// Returns the bias at the surface's slope, 1/256 voxel.
    #[inline(always)]
    pub(crate) fn bias(self) -> FixedDepth {
        (self.info & 0xffff) as FixedDepth
    }
}

/// The bake options that decide a column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ColumnRules {
    pub(crate) bias: Bias,
    /// How far below an open surface a shadow may begin, 1/256 voxel. The bias at the surface's slope applies
    /// instead if it is larger.
    pub(crate) thickness: FixedDepth,
    /// How far before level ground look-ups from it sample, 1/256 voxel. `None` if points below the last
    /// surface of a column need no answer.
    pub(crate) level_lift: Option<FixedDepth>,
    pub(crate) receivers: Receivers,
    /// Voxels along the light.
    pub(crate) depth_voxels: u32,
    pub(crate) normal_offset: NormalOffset,
}

/// How far a normal offset moves points in the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormalOffset {
    texels: f64,
    /// See [`adumbra::Frame::axes`].
    axes: [[f64; 3]; 3],
    /// The least distance along the light, voxels.
    least_lift_voxels: f64,
    /// The largest distance along x or y, texels.
    across_texels: f64,
}

impl NormalOffset {
    pub(crate) fn new(bias: &Bias, grid: &LightGrid) -> Self {
        let texels = bias.normal_offset_texels;
        let [x, y, z] = grid.axes;
        let longest = dot(x, x).max(dot(y, y)).sqrt();
        Self {
            texels,
            axes: grid.axes,
            // Axes x and y are perpendicular to the light, so all normals have this component along it. A
            // normal along the light has no other component.
            least_lift_voxels: texels * dot(z, grid.sun.towards()).abs(),
            across_texels: texels * longest,
        }
    }

    /// Returns the distance along the light from a plane of this gradient to the parallel plane at the
    /// offset, voxels.
    fn lift_voxels(&self, [gx, gy]: [f64; 2]) -> f64 {
        if self.texels == 0.0 {
            return 0.0;
        }
        // The plane's normal in the world, scaled to a dot product of 1 with one voxel along the light.
        let [x, y, z] = self.axes;
        let normal: [f64; 3] = std::array::from_fn(|a| gx * x[a] + gy * y[a] - z[a]);
        self.texels * dot(normal, normal).sqrt()
    }
}

/// The x of a column in which no voxel of the grid must be shadowed. [`BESIDE_GRID`] also has this meaning.
pub const FREE_TO_END: u32 = u32::MAX - 1;
/// The x of a column outside the grid, with e = 0. Nothing samples such a column.
pub const BESIDE_GRID: u32 = u32::MAX;

/// Half the side of a texel's footprint, with 1/256 for snapping.
const FOOTPRINT_HALF: f64 = 0.5 + 1.0 / SUBTEXEL as f64;
/// Distance in texels at which a filter around a receiver may read: the reach of a 9 × 9 filter.
const FILTER_REACH: f64 = 4.0;
/// How far rounding of the gradient to 1/256 may move the depth of a filter's tap, voxels: by half of 1/256
/// per texel of distance, along both axes.
const FILTER_ROUNDING: f64 = (FILTER_REACH + 0.5) / 256.0;
/// Filters around a receiver read columns at most this far from it, texels, and find shadow there this many
/// voxels behind the first voxel that may be in shadow, or deeper. Voxels nearer to the column's surface are
/// free. More of them are free in farther columns, because fewer taps read those.
const CONTACTS: [(f64, u32); CONTACT_RINGS] = [(0.5, 2), (2.0, 6), (FILTER_REACH, 24)];
/// Number of distances in [`CONTACTS`].
pub(crate) const CONTACT_RINGS: usize = 3;
/// The least number of voxels behind a first voxel at which a filter must find shadow.
const LEAST_CONTACT_VOXELS: u32 = CONTACTS[0].1;

/// The reason why look-ups from a surface near a column sample the column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReceiverKind {
    /// Points of the surface are in the texel's footprint.
    Footprint,
    /// A filter around points of the surface reads the texel, at the depth of the surface's plane there.
    Filtered,
}

/// The parameters that look-ups from one surface share, whichever column they sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReceiverPlane {
    /// The plane on which they sample columns.
    pub(crate) plane: Plane,
    /// How far before the plane they sample, from the surface's own bias, voxels.
    pub(crate) lift_voxels: f64,
    /// How far fixed-point rounding may move the sampled depth, voxels: the gradient's rounding over half a
    /// texel, plus the position's rounding times the gradient.
    pub(crate) rounding_voxels: f64,
}

/// The depths at which look-ups from one surface sample one column, 1/256 voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sampled {
    /// The surface's plane at the texel's centre.
    pub(crate) plane: FixedDepth,
    /// The nearest depth that the look-ups sample: the plane, lifted by the surface's own bias.
    pub(crate) lifted: FixedDepth,
}

impl ReceiverPlane {
    /// Returns where look-ups sample the column whose centre is (x, y).
    pub(crate) fn sampled(&self, kind: ReceiverKind, x: f64, y: f64) -> Sampled {
        self.sampled_at(kind, self.plane.at(x, y))
    }

    /// Returns where look-ups sample a column in which the plane is at this depth, voxels.
    #[inline(always)]
    pub(crate) fn sampled_at(&self, kind: ReceiverKind, z: f64) -> Sampled {
        let before = match kind {
            ReceiverKind::Footprint => 0.0,
            ReceiverKind::Filtered => FILTER_ROUNDING,
        };
        let lifted = z - self.lift_voxels - before - self.rounding_voxels;
        Sampled { plane: fixed_depth(z), lifted: floor_fixed_depth(lifted) }
    }
}

impl ColumnRules {
    /// Half the side of the square around a texel's centre from which surfaces of this kind sample the texel,
    /// texels.
    pub(crate) fn footprint_half_texels(&self, kind: ReceiverKind) -> f64 {
        // A normal offset also moves the point across the light's plane.
        let half = FOOTPRINT_HALF + self.normal_offset.across_texels;
        match kind {
            ReceiverKind::Footprint => half,
            ReceiverKind::Filtered => half + FILTER_REACH,
        }
    }

    /// How far outside its outline a triangle may decide a column's first surface, or what is behind it,
    /// texels.
    pub(crate) fn reach_texels(&self) -> f64 {
        self.footprint_half_texels(match self.receivers {
            Receivers::All => ReceiverKind::Footprint,
            Receivers::Static => ReceiverKind::Filtered,
        })
    }

    /// Returns the low word of a [`FirstSurface`].
    pub(crate) fn surface_info(&self, slope: f64, solid: bool) -> u32 {
        self.bias_fixed(slope) as u32 | if solid { 0 } else { OPEN_BIT }
    }

    /// Returns the bias along the light at this slope, 1/256 voxel, clamped to 16 bits.
    pub(crate) fn bias_fixed(&self, slope: f64) -> FixedDepth {
        (self.bias.along_light(slope) * SUBTEXEL as f64).min(65_535.0) as FixedDepth
    }

    /// Returns [`Self::thickness`] for a thickness in voxels.
    pub(crate) fn thickness_of(voxels: f64) -> FixedDepth {
        (voxels * SUBTEXEL as f64).min(1e9) as FixedDepth
    }

    /// Returns the surface as a receiver. Returns `None` if it receives no sunlight because it is the far
    /// side of a solid, or if it is steeper than look-ups support.
    pub(crate) fn receiver(&self, surface: &Surface) -> Option<ReceiverPlane> {
        if surface.casts && surface.solid && !surface.shape.faces_sun {
            return None;
        }
        let plane = surface.shape.true_plane()?;
        (plane.slope() <= MAX_PLANE_SLOPE).then(|| self.receiver_on(plane))
    }

    /// Returns the parameters of look-ups from a surface on this plane.
    pub(crate) fn receiver_on(&self, plane: Plane) -> ReceiverPlane {
        ReceiverPlane {
            lift_voxels: self.bias.along_light(plane.slope())
                + self.normal_offset.lift_voxels(plane.gradient),
            rounding_voxels: 1.0 / 256.0 + (plane.gradient_sum() + 1.0) / 4096.0,
            plane,
        }
    }

    /// Returns the depth before which the shadow of column (i, j) must have begun for a receiver that touches
    /// the column's footprint, or [`FixedDepth::MAX`] if the receiver requires none.
    ///
    /// A look-up from a receiver tests whether anything is before its lifted point. So if that point is
    /// behind the column's first surface, the column must be shadowed there. There are two exceptions. If the
    /// receiver's plane is before the base, the receiver is the first surface itself, or runs through the
    /// solid that begins there. If the first surface is between the plane and the lifted point, it is nearer
    /// to the receiver than the bias, and no look-up from the receiver can see it.
    ///
    /// A receiver that misses the texel's centre is sampled where its plane continues. It counts only if its
    /// own part within the footprint is behind the base too; otherwise a wall's foot would require shadow
    /// under the ground on which it stands. Within a footprint, the neighbours of an open first surface may
    /// be deeper by up to its bias without counting as behind it.
    pub(crate) fn receiver_behind(
        &self,
        kind: ReceiverKind,
        (triangle, receiver): (&Projected, &ReceiverPlane),
        [i, j]: [i64; 2],
        base: FixedDepth,
        first: FirstSurface,
    ) -> FixedDepth {
        let center = [i, j].map(|c| c as f64 + 0.5);
        let sampled = receiver.sampled(kind, center[0], center[1]);
        if first.is_none() || sampled.plane <= base || sampled.lifted <= first.depth() {
            return FixedDepth::MAX;
        }
        let sinks = if first.is_solid() { 0 } else { first.bias() };
        let is_behind = |depth: f64| fixed_depth(depth) > base.saturating_add(sinks);
        let part_is_behind = || {
            let half = self.footprint_half_texels(kind);
            is_behind(triangle.z_max) && is_behind(triangle.deepest_within(&receiver.plane, center, half))
        };
        if triangle.covers(i, j) || part_is_behind() { sampled.lifted } else { FixedDepth::MAX }
    }

    /// Returns rules that assume a ground, or that answer the points below the last surface of a column.
    /// These points are not on static surfaces, so rules for static receivers do not answer them.
    pub(crate) fn with_ground(self, is_assumed: bool, grid: &LightGrid) -> Self {
        let answers_below = !is_assumed && self.receivers == Receivers::All;
        let level = || {
            let gradient = receiver(grid, &self.bias, [0.0; 3], Some([0.0, 1.0, 0.0])).gradient;
            let ReceiverPlane { lift_voxels, rounding_voxels, .. } =
                self.receiver_on(Plane::at_origin(gradient));
            -floor_fixed_depth(-lift_voxels - rounding_voxels)
        };
        Self { level_lift: answers_below.then(level), ..self }
    }

    /// Returns the largest x if only static receivers must be answered. `next` is the nearest depth at which
    /// one of them requires shadow.
    pub(crate) fn static_end(&self, first: FirstSurface, next: FixedDepth) -> u32 {
        if first.is_none() || next == FixedDepth::MAX {
            return FREE_TO_END;
        }
        self.sampled_voxel(next)
    }

    /// Returns the voxel that answers a look-up at this depth. Behind the grid, the last voxel answers.
    #[inline(always)]
    pub(crate) fn sampled_voxel(&self, depth: FixedDepth) -> u32 {
        self.voxel(depth).min(self.depth_voxels - 1)
    }

    /// Returns the voxel that contains this depth, clamped to the grid and its end.
    #[inline(always)]
    fn voxel(&self, depth: FixedDepth) -> u32 {
        (depth >> SUBTEXEL_BITS).max(0).min(self.depth_voxels as i32) as u32
    }

    /// Returns the column's `[e, x]`: voxel k is defined lit if k < e and defined shadowed if k >= x.
    ///
    /// Points in space, whose look-ups have no slope, get the switch nearest to the first surface, and no
    /// later than its exit. A receiver behind, at whose lifted point `next` shadow must have begun, takes
    /// precedence: e is reduced for it. But e is not reduced below what points before the first surface need,
    /// whose look-ups sample at least the constant bias before it. Where no ground is assumed,
    /// [`Self::below`] is such a receiver.
    #[inline(always)]
    pub(crate) fn column(&self, first: FirstSurface, base: FixedDepth, next: FixedDepth) -> [u32; 2] {
        // The grid's depth if there is no surface.
        let e = self.quantize(first.depth());
        let next = next.min(self.below(first, base));
        let nothing_behind = first.is_none() | (next == FixedDepth::MAX);
        let end = self.latest_switch(self.exit(first, base)).max(e);
        let is_free = first.is_none() | nothing_behind & self.is_last(first.depth());
        let x = if is_free { FREE_TO_END } else { end };
        let needed = self.sampled_voxel(next).max(self.least_switch(first));
        let needed = if nothing_behind { FREE_TO_END } else { needed };
        [e.min(needed), x.min(needed)]
    }

    /// How far outside its outline a triangle's filters read, texels.
    pub(crate) fn contact_reach_texels(&self) -> f64 {
        self.footprint_half_texels(ReceiverKind::Filtered)
    }

    /// Returns the distances of [`CONTACTS`] as margins of snapped triangles, 1/256 texel, nearest first.
    pub(crate) fn contact_margins(&self) -> [i64; CONTACT_RINGS] {
        let footprint = self.footprint_half_texels(ReceiverKind::Footprint);
        CONTACTS.map(|(reach, _)| ((reach + footprint) * SUBTEXEL as f64).ceil() as i64)
    }

    /// Returns the voxel in which a filter around a receiver reads a column in which its plane is at this
    /// depth, voxels.
    #[inline(always)]
    pub(crate) fn contact_at(&self, receiver: &ReceiverPlane, plane_voxels: f64) -> u32 {
        self.sampled_voxel(receiver.sampled_at(ReceiverKind::Filtered, plane_voxels).lifted)
    }

    /// Returns the x of a column `[e, x]` in which a filter around a receiver within
    /// `ring` reads voxel `contact`.
    ///
    /// The other rules ask what look-ups from a column's own receivers find. But in the columns of a wall, at
    /// the depth of its foot, filters of the ground beside it find the inside of the wall. If that were lit,
    /// the contact shadow would pale.
    #[inline(always)]
    pub(crate) fn bounded([e, x]: [u32; 2], ring: usize, contact: u32) -> u32 {
        if contact >= e.saturating_add(CONTACTS[ring].1) { x.min(contact) } else { x }
    }

    /// Returns the first voxel in which a column with this e may have to be shadowed for a filter.
    #[inline(always)]
    pub(crate) fn contact_from(e: u32) -> u32 {
        e.saturating_add(LEAST_CONTACT_VOXELS)
    }

    /// Whether a first surface at this depth, with nothing behind it, is assumed to be the ground. A surface
    /// before the grid is not: the bounds hide the surfaces behind it.
    #[inline(always)]
    pub(crate) fn is_last(&self, depth: FixedDepth) -> bool {
        self.level_lift.is_none() & (depth >= 0)
    }

    /// Returns where the shadow must have begun for points in space: at the solid's end, or an open surface's
    /// thickness below it.
    #[inline(always)]
    pub(crate) fn exit(&self, first: FirstSurface, base: FixedDepth) -> FixedDepth {
        let open_exit = first.depth().saturating_add(self.open_thickness(first));
        if first.is_solid() { base } else { open_exit }
    }

    /// Returns the nearest depth at which look-ups from below a column's exit sample it, or
    /// [`FixedDepth::MAX`] if they need no answer.
    ///
    /// Where the ground that an app draws meets the foot of a wall, look-ups from level ground right behind
    /// the solid's end sample before that end. Below an open surface, only look-ups that sample behind the
    /// exit are answered. Otherwise the shadow would begin at the surface everywhere, at up to three times
    /// the bytes. Look-ups that sample less than a voxel behind the first surface count as before it. So e
    /// stays, and surfaces below something thin get no acne.
    #[inline(always)]
    pub(crate) fn below(&self, first: FirstSurface, base: FixedDepth) -> FixedDepth {
        self.below_exit(self.exit(first, base), first.depth(), first.is_solid())
    }

    /// Returns [`Self::below`] for an exit, the depth of the first surface, and whether that bounds a solid.
    #[inline(always)]
    pub(crate) fn below_exit(&self, exit: FixedDepth, first: FixedDepth, is_solid: bool) -> FixedDepth {
        let nearest = first.saturating_add(SUBTEXEL as FixedDepth);
        let lead = |lift: FixedDepth| if is_solid { lift } else { 0 };
        self.level_lift.map_or(FixedDepth::MAX, |lift| exit.saturating_sub(lead(lift)).max(nearest))
    }

    /// Returns how far below an open first surface its shadow may begin, 1/256 voxel.
    #[inline(always)]
    fn open_thickness(&self, first: FirstSurface) -> FixedDepth {
        self.thickness.max(first.bias())
    }

    /// Returns the least distance by which look-ups from any surface are before it, voxels.
    #[inline(always)]
    pub(crate) fn least_lift_voxels(&self) -> f64 {
        self.bias.constant_texels + self.normal_offset.least_lift_voxels
    }

    /// Returns the first voxel that no look-up from the first surface, or from anything before it, samples.
    #[inline(always)]
    fn least_switch(&self, first: FirstSurface) -> u32 {
        let lift = (self.least_lift_voxels() * SUBTEXEL as f64) as FixedDepth;
        self.voxel(first.depth().saturating_sub(lift).saturating_add(SUBTEXEL as FixedDepth))
    }

    /// Returns x for an exit: [`FREE_TO_END`] at or beyond the grid's end.
    #[inline(always)]
    pub(crate) fn latest_switch(&self, exit: FixedDepth) -> u32 {
        let x = self.quantize(exit);
        if x < self.depth_voxels { x } else { FREE_TO_END }
    }

    /// Returns `ceil(depth - 1/2)` in whole voxels, clamped to the grid.
    #[inline(always)]
    pub(crate) fn quantize(&self, depth: FixedDepth) -> u32 {
        self.voxel(depth.saturating_add(SUBTEXEL as FixedDepth / 2 - 1))
    }
}
