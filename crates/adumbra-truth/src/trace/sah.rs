//! Builds a binary BVH top down with binned surface-area splits. Source: Wald, *On fast Construction of
//! SAH-based Bounding Volume Hierarchies*, 2007.
//!
//! obvhs builds bottom up (PLOC). If boxes coincide or nest, it pairs only one box per round, so the time
//! grows with the square of their number and the depth with their number. Here the depth is bounded whatever
//! the boxes: below [`SAH_DEPTH`], ranges are simply halved.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};

/// Number of bins along an axis.
const BINS: usize = 16;

/// Depth down to which splits use surface area. Below it ranges are halved, so no tree is deeper than this
/// plus 32.
const SAH_DEPTH: u32 = 48;

/// Builds the tree over `boxes`, with one box per leaf. Cost: about 0.5 µs per box.
pub(super) fn build(boxes: &[Aabb]) -> Bvh2 {
    let mut items: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = Vec::with_capacity((2 * boxes.len()).saturating_sub(1));
    if !boxes.is_empty() {
        nodes.push(Bvh2Node::default());
    }
    let mut open = vec![(0, 0, boxes.len(), 0)];
    while let Some((node, start, end, depth)) = open.pop() {
        let Some(range) = items.get_mut(start..end).filter(|r| !r.is_empty()) else { continue };
        let whole = range.iter().fold(Aabb::empty(), |b, &i| b.union(&boxes[i as usize]));
        if range.len() == 1 {
            nodes[node] = Bvh2Node::new(whole, 1, start as u32);
            continue;
        }
        let middle = start + split(boxes, range, depth);
        let children = nodes.len();
        nodes[node] = Bvh2Node::new(whole, 0, children as u32);
        nodes.extend([Bvh2Node::default(); 2]);
        open.push((children + 1, middle, end, depth + 1));
        open.push((children, start, middle, depth + 1));
    }
    Bvh2 { nodes, primitive_indices: items, ..Bvh2::default() }
}

/// Reorders `range` (two or more boxes) so that its first boxes go left. Returns their number, which is
/// neither zero nor all.
fn split(boxes: &[Aabb], range: &mut [u32], depth: u32) -> usize {
    // Twice the box's centre.
    let center = |i: u32| boxes[i as usize].min + boxes[i as usize].max;
    let low = range.iter().fold(Vec3A::INFINITY, |m, &i| m.min(center(i)));
    let high = range.iter().fold(Vec3A::NEG_INFINITY, |m, &i| m.max(center(i)));
    let per_unit = BINS as f32 / (high - low);
    let bin_of = |i: u32, axis: usize| (((center(i) - low) * per_unit)[axis] as usize).min(BINS - 1);
    if range.len() > 2
        && depth < SAH_DEPTH
        && let Some((axis, bin)) = best_bin(boxes, range, bin_of)
    {
        return partition(range, |i| bin_of(i, axis) < bin);
    }
    let axis = (high - low).max_position();
    let half = range.len() / 2;
    range.select_nth_unstable_by(half, |&i, &j| center(i)[axis].total_cmp(&center(j)[axis]).then(i.cmp(&j)));
    half
}

/// The cheapest split, as an axis and the first bin that goes right; `None` if all centres fall into one bin.
fn best_bin(boxes: &[Aabb], range: &[u32], bin_of: impl Fn(u32, usize) -> usize) -> Option<(usize, usize)> {
    let mut bins = [[(Aabb::empty(), 0_u32); BINS]; 3];
    for &i in range {
        for (axis, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[bin_of(i, axis)];
            *bin = (bin.0.union(&boxes[i as usize]), bin.1 + 1);
        }
    }
    let mut best = None;
    let mut least = f32::INFINITY;
    for (axis, bins) in bins.iter().enumerate() {
        let mut right_cost = [f32::INFINITY; BINS];
        let mut right = (Aabb::empty(), 0);
        for bin in (1..BINS).rev() {
            right = (right.0.union(&bins[bin].0), right.1 + bins[bin].1);
            if right.1 > 0 {
                right_cost[bin] = right.0.half_area() * right.1 as f32;
            }
        }
        let mut left = (Aabb::empty(), 0);
        for bin in 1..BINS {
            left = (left.0.union(&bins[bin - 1].0), left.1 + bins[bin - 1].1);
            if left.1 == 0 {
                continue;
            }
            let cost = left.0.half_area() * left.1 as f32 + right_cost[bin];
            if cost < least {
                (least, best) = (cost, Some((axis, bin)));
            }
        }
    }
    best
}

/// Moves the items that go left to the front; returns their number.
fn partition(range: &mut [u32], left: impl Fn(u32) -> bool) -> usize {
    let mut count = 0;
    for i in 0..range.len() {
        if left(range[i]) {
            range.swap(count, i);
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(bvh: &Bvh2, node: usize) -> u32 {
        let n = &bvh.nodes[node];
        let child = n.first_index as usize;
        if n.prim_count > 0 { 0 } else { 1 + depth(bvh, child).max(depth(bvh, child + 1)) }
    }

    #[test]
    fn sah_depth_is_bounded_and_every_box_is_in_its_parents() {
        let cube = |half: f32| Aabb::new(Vec3A::splat(-half), Vec3A::splat(half));
        let coincident = vec![cube(1.0); 5_000];
        let nested: Vec<Aabb> = (0..5_000_i16).map(|i| cube(1.0 + f32::from(i))).collect();
        let shrinking: Vec<Aabb> = (0..200_i16)
            .map(|i| Aabb::new(Vec3A::ZERO, Vec3A::splat(libm::exp2f(20.0 - 0.7 * f32::from(i)))))
            .collect();
        for boxes in [coincident, nested, shrinking, Vec::new(), vec![cube(1.0)]] {
            let bvh = build(&boxes);
            assert_eq!(bvh.nodes.len(), (2 * boxes.len()).saturating_sub(1));
            let mut held = bvh.primitive_indices.clone();
            held.sort_unstable();
            assert!(held.iter().copied().eq(0..boxes.len() as u32));
            if !boxes.is_empty() {
                assert!(depth(&bvh, 0) <= SAH_DEPTH + 32, "{}", depth(&bvh, 0));
            }
            for node in bvh.nodes.iter() {
                let inside = |b: &Aabb| node.aabb.union(b) == node.aabb;
                if node.prim_count == 1 {
                    assert!(inside(&boxes[bvh.primitive_indices[node.first_index as usize] as usize]));
                } else {
                    let child = node.first_index as usize;
                    assert!(inside(&bvh.nodes[child].aabb) && inside(&bvh.nodes[child + 1].aabb));
                }
            }
        }
    }
}
