//! A tree of boxes that a ray in `f64` walks: obvhs's compressed wide BVH (after Ylitie, Karras, Laine, *Efficient
//! Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, 2017) with conservative `f32` tests.
//!
//! Boxes are kept in *unit space*, where the whole is centred and its longest half side lies in 0.5 .. 1, and are
//! grown by [`PADDING`]. A ray is cut to the whole in `f64` before it is rounded, so every figure of a box test is of
//! order one and its error, whatever the world's offset, is far below the padding. The walk is ours: obvhs's has a
//! stack that a deep tree overruns, and cannot be nested.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};

use super::sah;

/// Added to every box in unit space. Bounds the sum of: origin and planes rounded to `f32` (2^-24), reciprocals and
/// products of figures up to 2 (about 2^-22), obvhs's grid step, whose exponent comes from a rounded logarithm
/// (2^-21).
const PADDING: f32 = 1.0 / (1 << 19) as f32;

/// How far the box ray's start is set back in unit space: obvhs drops boxes that end nearer than 1e-4.
const SET_BACK: f64 = 1.0 / 4096.0;

/// Added to the box ray's end in unit space.
const END_SLACK: f64 = 1.0 / (1 << 18) as f64;

/// Grows the whole for the cut in `f64`.
const CUT_MARGIN: f64 = 1.0 / 1024.0;

/// A direction's component below this (the longest is 1) is taken as this in box tests, to keep reciprocals finite.
/// Over the length of a ray in unit space that is nothing.
const SMALLEST_COMPONENT: f64 = 1.0 / (1_u64 << 60) as f64;

/// Groups of nodes that wait in a walk before the heap is used; a tree of a billion boxes needs a dozen.
const STACK: usize = 32;

/// Box of a primitive: smallest and largest corner.
pub(super) type Box3 = [[f64; 3]; 2];

/// What a visitor wants of the walk.
pub(super) enum Step {
    /// Go on.
    On,
    /// Go on, but only up to this t.
    Until(f64),
    /// End the walk.
    Stop,
}

/// The tree. Primitives are numbered by [`BoxTree::order`].
#[derive(Debug, Default)]
pub(super) struct BoxTree {
    bvh: CwBvh,
    center: [f64; 3],
    scale: f64,
    half: [f64; 3],
}

impl BoxTree {
    /// Builds the tree over `boxes`, which must be finite. Cost: about 1 µs a box, one thread.
    pub(super) fn build(boxes: impl ExactSizeIterator<Item = Box3> + Clone) -> Self {
        let whole = boxes.clone().fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], union);
        if boxes.len() == 0 {
            return Self::default();
        }
        let center: [f64; 3] = std::array::from_fn(|a| 0.5 * whole[0][a] + 0.5 * whole[1][a]);
        let half: [f64; 3] = std::array::from_fn(|a| 0.5 * whole[1][a] - 0.5 * whole[0][a]);
        let scale = unit_scale(half[0].max(half[1]).max(half[2]));
        let padded: Vec<Aabb> = boxes
            .map(|[low, high]| {
                let unit = |p: [f64; 3]| {
                    Vec3A::from_array(std::array::from_fn(|a| ((p[a] - center[a]) * scale) as f32))
                };
                Aabb::new(unit(low) - PADDING, unit(high) + PADDING)
            })
            .collect();
        let bvh = bvh2_to_cwbvh(&sah::build(&padded), 3, true, false);
        Self { bvh, center, scale, half: half.map(|h| h * scale + CUT_MARGIN) }
    }

    /// The primitives in the order in which [`BoxTree::walk`] numbers them.
    pub(super) fn order(&self) -> &[u32] {
        &self.bvh.primitive_indices
    }

    /// Bytes on the heap.
    pub(super) fn memory_bytes(&self) -> u64 {
        (size_of_val(self.bvh.nodes.as_slice()) + size_of_val(self.order())) as u64
    }

    /// Calls `visit` with each primitive whose box the ray may meet within `t_min ..= t_max`, roughly front to back,
    /// each once. Returns whether the visitor stopped it.
    #[inline]
    pub(super) fn walk(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        (t_min, t_max): (f64, f64),
        mut visit: impl FnMut(usize) -> Step,
    ) -> bool {
        let Some((mut ray, cut)) = self.box_ray(origin, direction, t_min, t_max) else { return false };
        let octant = [4, 2, 1].iter().zip(ray.direction.to_array());
        let octant = octant.map(|(bit, d)| if d < 0.0 { 0 } else { bit * 0x0101_0101_u32 }).sum::<u32>();
        let mut stack = Stack::new();
        // A group: index of the first child node; bits 31..24 the children to visit, by priority; bits 7..0 which
        // children are inner nodes.
        let mut group = (0_u32, 0x8000_0000_u32);
        loop {
            if group.1 & 0xff00_0000 == 0 {
                match stack.pop() {
                    Some(waiting) => group = waiting,
                    None => return false,
                }
            }
            let (first_child, hits) = group;
            let child = 31 - hits.leading_zeros();
            group.1 &= !(1 << child);
            if group.1 & 0xff00_0000 != 0 {
                stack.push(group);
            }
            let slot = (child - 24) ^ (octant & 0xff);
            let index = first_child + (hits & !(u32::MAX << slot)).count_ones();
            let Some(node) = self.bvh.nodes.get(index as usize) else { return false };
            let mask = node.intersect_ray(&ray, octant);
            group = (node.child_base_idx, (mask & 0xff00_0000) | u32::from(node.imask));
            let mut primitives = mask & 0x00ff_ffff;
            while primitives != 0 {
                let local = 31 - primitives.leading_zeros();
                primitives &= !(1 << local);
                match visit((node.primitive_base_idx + local) as usize) {
                    Step::On => {}
                    Step::Until(t) => ray.tmax = ray.tmax.min(cut.end(t)),
                    Step::Stop => return true,
                }
            }
        }
    }

    /// The ray in unit space, cut to the whole; none where it misses, or has no direction, or is not finite.
    fn box_ray(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        t_min: f64,
        t_max: f64,
    ) -> Option<(obvhs::ray::Ray, Cut)> {
        let o: [f64; 3] = std::array::from_fn(|a| (origin[a] - self.center[a]) * self.scale);
        let d = direction.map(|c| c * self.scale);
        let (mut enter, mut leave) = (t_min, t_max);
        for a in 0..3 {
            if d[a] == 0.0 {
                if o[a].abs() > self.half[a] {
                    return None;
                }
                continue;
            }
            let (t0, t1) = ((-self.half[a] - o[a]) / d[a], (self.half[a] - o[a]) / d[a]);
            enter = enter.max(t0.min(t1));
            leave = leave.min(t0.max(t1));
        }
        let speed = d.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let unit = d.map(|c| c / speed);
        let start: [f64; 3] = std::array::from_fn(|a| o[a] + d[a] * enter - unit[a] * SET_BACK);
        if enter > leave || !start.iter().chain(&unit).all(|c| c.is_finite()) {
            return None;
        }
        let unit =
            unit.map(|c| if c.abs() < SMALLEST_COMPONENT { SMALLEST_COMPONENT.copysign(c) } else { c });
        let cut = Cut { enter, speed };
        let vector = |v: [f64; 3]| Vec3A::from_array(v.map(|c| c as f32));
        let ray = obvhs::ray::Ray {
            origin: vector(start),
            direction: vector(unit),
            inv_direction: vector(unit.map(f64::recip)),
            tmin: 0.0,
            tmax: cut.end(leave),
        };
        Some((ray, cut))
    }
}

/// How t along the ray becomes t along the box ray.
#[derive(Clone, Copy)]
struct Cut {
    enter: f64,
    speed: f64,
}

impl Cut {
    fn end(self, t: f64) -> f32 {
        ((t - self.enter) * self.speed + SET_BACK + END_SLACK) as f32
    }
}

/// Groups that wait; the heap takes what the array cannot.
struct Stack {
    near: [(u32, u32); STACK],
    len: usize,
    far: Vec<(u32, u32)>,
}

impl Stack {
    fn new() -> Self {
        Self { near: [(0, 0); STACK], len: 0, far: Vec::new() }
    }

    #[inline]
    fn push(&mut self, group: (u32, u32)) {
        if let Some(place) = self.near.get_mut(self.len) {
            *place = group;
            self.len += 1;
        } else {
            self.far.push(group);
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<(u32, u32)> {
        if self.len == STACK
            && let Some(group) = self.far.pop()
        {
            return Some(group);
        }
        self.len = self.len.checked_sub(1)?;
        self.near.get(self.len).copied()
    }
}

/// The box around both.
pub(super) fn union(a: Box3, b: Box3) -> Box3 {
    [std::array::from_fn(|i| a[0][i].min(b[0][i])), std::array::from_fn(|i| a[1][i].max(b[1][i]))]
}

/// A power of two that brings `half` into 0.5 .. 1; 1 for zero.
fn unit_scale(half: f64) -> f64 {
    let (_, exponent) = libm::frexp(half);
    if half > 0.0 { libm::ldexp(1.0, (-exponent).clamp(-1000, 1000)) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_tree_scale_is_a_power_of_two() {
        assert_eq!(unit_scale(0.0), 1.0);
        assert_eq!(unit_scale(0.75), 1.0);
        assert_eq!(unit_scale(300.0), 1.0 / 512.0);
        assert_eq!(unit_scale(1e-3), 512.0);
    }

    #[test]
    fn box_tree_stack_goes_on_in_the_heap() {
        let mut stack = Stack::new();
        (0..100).for_each(|i| stack.push((i, i)));
        assert!((0..100).rev().all(|i| stack.pop() == Some((i, i))));
        assert_eq!(stack.pop(), None);
    }

    #[test]
    fn box_tree_visits_each_box_once_and_starts_anywhere() {
        let boxes = (0..1000).map(|i| [[f64::from(i), 0.0, 0.0], [f64::from(i) + 0.5, 1.0, 1.0]]);
        let tree = BoxTree::build(boxes);
        let visited = |origin, direction, range| {
            let mut seen = Vec::new();
            tree.walk(origin, direction, range, |i| {
                seen.push(tree.order()[i]);
                Step::On
            });
            seen.sort_unstable();
            seen
        };
        let all: Vec<u32> = (0..1000).collect();
        assert_eq!(visited([-5.0, 0.5, 0.5], [1.0, 0.0, 0.0], (0.0, f64::INFINITY)), all);
        assert_eq!(visited([5.0, 0.5, 0.5], [-1e-9, 0.0, -0.0], (f64::NEG_INFINITY, f64::INFINITY)), all);
        // Boxes are kept on a coarse grid, so that a neighbour may come too.
        let near_7 = visited([7.5, 9.0, 0.5], [0.0, -1.0, 0.0], (0.0, f64::INFINITY));
        assert!(near_7.contains(&7) && near_7.len() < 10, "{near_7:?}");
        assert!(visited([7.25, 9.0, 0.5], [0.0, 1.0, 0.0], (0.0, f64::INFINITY)).is_empty());
        assert!(visited([7.25, 0.5, 0.5], [0.0, 1.0, 0.0], (0.0, 0.0)).contains(&7));
        assert!(visited([0.0; 3], [0.0; 3], (0.0, 1.0)).is_empty());
        assert!(visited([f64::NAN; 3], [1.0; 3], (0.0, 1.0)).is_empty());
    }
}
