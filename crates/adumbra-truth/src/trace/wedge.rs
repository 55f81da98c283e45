//! A wedge of rays from one point, and the boxes of a BVH that it may meet.

use adumbra::grid::vec3::{cross, dot, normalize};
use obvhs::cwbvh::node::CwBvhNode;

/// How far a box may be outside a plane, in unit space, before it is dropped: covers rounding to `f32`.
const SLACK: f32 = 1.0 / (1 << 18) as f32;
/// The same, relative to the distance of a plane from the centre.
const RELATIVE_SLACK: f32 = 1.0 / (1 << 21) as f32;

/// Rays from a point between four planes through it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wedge {
    /// Normals that point inward, of any length. A normal without length bounds nothing.
    normals: [[f64; 3]; 4],
    /// A direction about the middle, of any length.
    pub(super) middle: [f64; 3],
}

impl Wedge {
    /// The wedge about directions from `first` to `last`, less than 90° apart, and all that are within `bend`
    /// of the chord between them on each axis. Where that is not in one half-space by far, the wedge is
    /// unbounded.
    pub(super) fn around(first: [f64; 3], last: [f64; 3], bend: f64) -> Self {
        let [from, to] = [normalize(first), normalize(last)];
        let middle = std::array::from_fn(|a| from[a] + to[a]);
        let across = cross(from, to);
        let sum = |v: [f64; 3]| v[0].abs() + v[1].abs() + v[2].abs();
        let least = dot(middle, first).min(dot(middle, last)) - bend * sum(middle);
        // Planes are tilted so that no direction is outside, and a little more.
        let tilt = |side: [f64; 3]| {
            let most = bend * sum(side) / least * (1.0 + 1e-9) + 1e-12;
            std::array::from_fn(|a| side[a] + most * middle[a])
        };
        let normals = [cross(across, from), cross(to, across), across, across.map(|c| -c)].map(tilt);
        if least > 0.0 && normals.iter().flatten().all(|c| c.is_finite()) {
            Self { normals, middle }
        } else {
            Self { normals: [[0.0; 3]; 4], middle }
        }
    }
}

/// A wedge in a BVH's unit space.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnitPlanes {
    /// Inward normals whose longest component is 1, or 0.
    normals: [[f32; 3]; 4],
    /// Products of the normals with points that are on the planes, less the slack.
    offsets: [f32; 4],
}

impl UnitPlanes {
    pub(super) fn new(origin: [f64; 3], wedge: &Wedge) -> Self {
        let unit = wedge.normals.map(|n| {
            let longest = n.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
            if longest > 0.0 { n.map(|c| c / longest) } else { [0.0; 3] }
        });
        let offset = |n: [f64; 3]| {
            let offset = dot(n, origin) as f32;
            offset - SLACK - RELATIVE_SLACK * offset.abs()
        };
        Self { normals: unit.map(|n| n.map(|c| c as f32)), offsets: unit.map(offset) }
    }

    /// The children whose boxes are on the inner side of each plane, in part at least, as a mask like that of
    /// [`CwBvhNode::intersect_ray`].
    #[inline]
    pub(super) fn children(&self, node: &CwBvhNode, octant: u32) -> u32 {
        let extent = node.compute_extent().to_array();
        let corner = node.p.to_array();
        let low = [&node.child_min_x, &node.child_min_y, &node.child_min_z].map(|bytes| bytes.map(f32::from));
        let high =
            [&node.child_max_x, &node.child_max_y, &node.child_max_z].map(|bytes| bytes.map(f32::from));
        let mut least = [f32::INFINITY; 8];
        for (normal, offset) in self.normals.iter().zip(self.offsets) {
            let base = normal[0] * corner[0] + normal[1] * corner[1] + normal[2] * corner[2] - offset;
            let mut farthest = [base; 8];
            for a in 0..3 {
                let step = normal[a] * extent[a];
                let planes = if step >= 0.0 { &high[a] } else { &low[a] };
                for (farthest, &plane) in farthest.iter_mut().zip(planes) {
                    *farthest += step * plane;
                }
            }
            for (least, farthest) in least.iter_mut().zip(farthest) {
                *least = least.min(farthest);
            }
        }
        let mut mask = 0;
        for (meta, least) in node.child_meta.iter().zip(least) {
            if least < 0.0 {
                continue;
            }
            let meta = u32::from(*meta);
            let is_inner = meta & 0x18 == 0x18;
            mask |= (meta >> 5) << ((meta & 0x1f) ^ if is_inner { octant } else { 0 });
        }
        mask
    }
}
