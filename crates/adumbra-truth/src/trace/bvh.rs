//! A BVH that is traversed with `f64` rays: the compressed wide BVH of obvhs (after Ylitie, Karras, Laine,
//! *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, 2017) with conservative `f32`
//! tests.
//!
//! Boxes are stored in *unit space*, in which the root box is centred and its longest half side is in 0.5 ..
//! 1, and are padded by [`PADDING`]. A ray is clipped to the root box in `f64` before it is rounded. All
//! numbers in a box test are therefore of order one, and its error, whatever the world's offset, is far below
//! the padding. The traversal is implemented here because the stack of obvhs overflows on deep trees and its
//! traversal cannot be nested.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode};

use crate::trace::sah;
use crate::trace::wedge::{UnitPlanes, Wedge};

/// Padding of every box in unit space. It bounds the sum of three errors: origin and planes rounded to `f32`
/// (2^-24), reciprocals and products of numbers up to 2 (about 2^-22), and the grid step of obvhs, whose
/// exponent comes from a rounded logarithm (2^-21).
const PADDING: f32 = 1.0 / (1 << 19) as f32;

/// How far the start of the box ray is moved back in unit space, because obvhs drops boxes that end closer
/// than 1e-4.
const SET_BACK: f64 = 1.0 / 4096.0;

/// Extension of the end of the box ray in unit space.
const END_SLACK: f64 = 1.0 / (1 << 18) as f64;

/// Padding of the root box for clipping in `f64`.
const CUT_MARGIN: f64 = 1.0 / 1024.0;

/// Minimum magnitude of a direction component in box tests (the longest component is 1), which keeps
/// reciprocals finite. Over the length of a ray in unit space the difference is negligible.
const MIN_COMPONENT: f64 = 1.0 / (1_u64 << 60) as f64;

/// Number of node groups that a traversal can stack before it uses the heap; a tree of a billion boxes needs
/// a dozen.
const STACK: usize = 32;

/// The bounding box of a primitive: lower and upper corner.
pub(super) type Box3 = [[f64; 3]; 2];

/// A visitor's instruction to the traversal.
pub(super) enum Traversal {
    /// Continue.
    On,
    /// Continue, but only up to this t.
    Until(f64),
    /// End the traversal.
    Stop,
}

/// As [`Traversal`], through a wedge.
pub(super) enum WedgeTraversal {
    /// Continue.
    On,
    /// Continue, but only in this wedge.
    Within(Wedge),
    /// End the traversal.
    Stop,
}

/// A BVH. [`Bvh::order`] gives the primitive in each slot.
#[derive(Debug, Default)]
pub(super) struct Bvh {
    bvh: CwBvh,
    center: [f64; 3],
    scale: f64,
    half: [f64; 3],
}

impl Bvh {
    /// Builds the tree over `boxes`, which must be finite. Cost: about 1 µs per box, on one thread.
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

    /// Maps the slots that [`Bvh::walk`] passes to its visitor to primitive indices.
    pub(super) fn order(&self) -> &[u32] {
        &self.bvh.primitive_indices
    }

    /// Heap memory, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        (size_of_val(self.bvh.nodes.as_slice()) + size_of_val(self.order())) as u64
    }

    /// Calls `visit` with each primitive whose box the ray may hit within `t_min ..= t_max`, each once,
    /// roughly front to back. Returns whether the visitor stopped the traversal.
    #[inline]
    pub(super) fn walk(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        (t_min, t_max): (f64, f64),
        mut visit: impl FnMut(usize) -> Traversal,
    ) -> bool {
        let Some((mut ray, cut)) = self.box_ray(origin, direction, t_min, t_max) else { return false };
        let octant = octant_of(direction) * 0x0101_0101;
        let children = |ray: &obvhs::ray::Ray, node: &CwBvhNode| node.intersect_ray(ray, octant);
        self.descend(&mut ray, octant & 0xff, children, |ray, slot| {
            match visit(slot) {
                Traversal::On => {}
                Traversal::Until(t) => ray.tmax = ray.tmax.min(cut.end(t)),
                Traversal::Stop => return true,
            }
            false
        })
    }

    /// Calls `visit` with each primitive whose box may have points in a wedge of rays from `origin`, each
    /// once, roughly front to back. The visitor may narrow the wedge. Returns whether it stopped the
    /// traversal.
    #[inline]
    pub(super) fn walk_wedge(
        &self,
        origin: [f64; 3],
        wedge: &Wedge,
        mut visit: impl FnMut(usize) -> WedgeTraversal,
    ) -> bool {
        let in_unit = |p: [f64; 3]| std::array::from_fn(|a| (p[a] - self.center[a]) * self.scale);
        let origin = in_unit(origin);
        let octant = octant_of(wedge.middle);
        let mut planes = UnitPlanes::new(origin, wedge);
        let children = |planes: &UnitPlanes, node: &CwBvhNode| planes.children(node, octant);
        self.descend(&mut planes, octant, children, |planes, slot| {
            match visit(slot) {
                WedgeTraversal::On => {}
                WedgeTraversal::Within(wedge) => *planes = UnitPlanes::new(origin, &wedge),
                WedgeTraversal::Stop => return true,
            }
            false
        })
    }

    /// Calls `visit` with each primitive below nodes that `children` finds, which returns the mask of a
    /// node's children as [`CwBvhNode::intersect_ray`] does. Children come in the order of `octant`. Both see
    /// `state`, which `visit` may change. Returns whether `visit` ended the traversal.
    #[inline]
    fn descend<S>(
        &self,
        state: &mut S,
        octant: u32,
        children: impl Fn(&S, &CwBvhNode) -> u32,
        mut visit: impl FnMut(&mut S, usize) -> bool,
    ) -> bool {
        let mut stack = Stack::new();
        // A group: index of the first child node; bits 31..24 the children to visit, by priority; bits 7..0
        // which children are inner nodes.
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
            let slot = (child - 24) ^ octant;
            let index = first_child + (hits & !(u32::MAX << slot)).count_ones();
            let Some(node) = self.bvh.nodes.get(index as usize) else { return false };
            let mask = children(state, node);
            group = (node.child_base_idx, (mask & 0xff00_0000) | u32::from(node.imask));
            let mut primitives = mask & 0x00ff_ffff;
            while primitives != 0 {
                let local = 31 - primitives.leading_zeros();
                primitives &= !(1 << local);
                if visit(state, (node.primitive_base_idx + local) as usize) {
                    return true;
                }
            }
        }
    }

    /// The ray in unit space, clipped to the root box; `None` if it misses, has no direction, or is not
    /// finite.
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
        let unit = unit.map(|c| if c.abs() < MIN_COMPONENT { MIN_COMPONENT.copysign(c) } else { c });
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

/// The order in which a direction passes a node's children, as obvhs numbers them.
fn octant_of(direction: [f64; 3]) -> u32 {
    [4, 2, 1].iter().zip(direction).map(|(bit, d)| if d < 0.0 { 0 } else { *bit }).sum()
}

/// Converts t along the ray to t along the box ray.
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

/// Pending node groups; those that do not fit the array go to the heap.
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

/// The bounding box of both.
pub(super) fn union(a: Box3, b: Box3) -> Box3 {
    [std::array::from_fn(|i| a[0][i].min(b[0][i])), std::array::from_fn(|i| a[1][i].max(b[1][i]))]
}

/// The power of two that scales `half` into 0.5 .. 1; 1 for zero.
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
    fn box_tree_stack_continues_on_the_heap() {
        let mut stack = Stack::new();
        (0..100).for_each(|i| stack.push((i, i)));
        assert!((0..100).rev().all(|i| stack.pop() == Some((i, i))));
        assert_eq!(stack.pop(), None);
    }

    #[test]
    fn box_tree_visits_each_box_once_from_any_origin() {
        let boxes = (0..1000).map(|i| [[f64::from(i), 0.0, 0.0], [f64::from(i) + 0.5, 1.0, 1.0]]);
        let tree = Bvh::build(boxes);
        let visited = |origin, direction, range| {
            let mut seen = Vec::new();
            tree.walk(origin, direction, range, |i| {
                seen.push(tree.order()[i]);
                Traversal::On
            });
            seen.sort_unstable();
            seen
        };
        let all: Vec<u32> = (0..1000).collect();
        assert_eq!(visited([-5.0, 0.5, 0.5], [1.0, 0.0, 0.0], (0.0, f64::INFINITY)), all);
        assert_eq!(visited([5.0, 0.5, 0.5], [-1e-9, 0.0, -0.0], (f64::NEG_INFINITY, f64::INFINITY)), all);
        // Boxes are stored on a coarse grid, so adjacent ones may be visited too.
        let near_7 = visited([7.5, 9.0, 0.5], [0.0, -1.0, 0.0], (0.0, f64::INFINITY));
        assert!(near_7.contains(&7) && near_7.len() < 10, "{near_7:?}");
        assert!(visited([7.25, 9.0, 0.5], [0.0, 1.0, 0.0], (0.0, f64::INFINITY)).is_empty());
        assert!(visited([7.25, 0.5, 0.5], [0.0, 1.0, 0.0], (0.0, 0.0)).contains(&7));
        assert!(visited([0.0; 3], [0.0; 3], (0.0, 1.0)).is_empty());
        assert!(visited([f64::NAN; 3], [1.0; 3], (0.0, 1.0)).is_empty());
    }
}
