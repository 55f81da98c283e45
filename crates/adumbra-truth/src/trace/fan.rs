//! Shadows over a fan of directions: when a sun on its path is hidden from a point, without sampling.
//!
//! A fan is the rays from a point in directions along chords between knots, such as the sun's path at each
//! third of a minute. On a chord the three edge functions of a triangle about the point are linear, so the
//! directions that it hides are an interval whose ends are ratios. The shadow is the union of the intervals
//! of all triangles that the fan may meet. Nothing is sampled, so nothing is missed, however short; holes of
//! masks are the exception.
//!
//! Within an instance no light passes between triangles that share an edge: both compute the same ratio from
//! the same two vertices.

use adumbra::grid::vec3::{cross, dot};

use super::bvh::WedgeTraversal;
use super::triangle::TriangleHit;
use super::wedge::Wedge;
use super::{MAX_LISTED_INSTANCES, Tracer};

/// Gaps of light up to this part of a chord are closed: surfaces of different instances that touch leave such
/// gaps by rounding.
const LARGEST_CRACK: f64 = 1.0 / 65_536.0;

/// Halvings of a mask's step by which the edge of a hole is found.
const MASK_HALVINGS: u32 = 6;

/// Largest number of samples of a mask on a chord.
const MOST_MASK_STEPS: f64 = 65_536.0;

const WORLD: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Directions along the chords between knots. From a point they are a fan of rays.
#[derive(Clone, Debug)]
pub struct Fan {
    knots: Vec<[f64; 3]>,
    mask_step: f64,
    bend: f64,
}

impl Fan {
    /// Takes knots, directions of any length, less than 90° apart in all, that turn one way. `mask_step` is
    /// the distance between samples of alpha masks, in chords: holes that are passed faster may be missed. If
    /// it is not above 0, there is one sample a chord.
    ///
    /// A fan of fewer than 2 knots, or with numbers that are not finite, has no hidden parts.
    pub fn new(knots: Vec<[f64; 3]>, mask_step: f64) -> Self {
        let is_fan = knots.len() > 1 && knots.iter().flatten().all(|c| c.is_finite());
        let knots = if is_fan { knots } else { Vec::new() };
        let mask_step = if mask_step > 0.0 { mask_step } else { f64::INFINITY };
        Self { bend: bend_of(&knots), knots, mask_step }
    }

    /// The knots.
    pub fn knots(&self) -> &[[f64; 3]] {
        &self.knots
    }

    /// How far any direction is, on each axis at most, from where it would be if a single chord joined the
    /// first knot with the last.
    pub fn bend(&self) -> f64 {
        self.bend
    }
}

/// The hidden part of a fan: spans of chords, where 1.5 is the middle of the second chord. They are in order,
/// and do not touch.
#[derive(Clone, Debug, Default)]
pub struct Cover {
    spans: Vec<[f64; 2]>,
    /// The instance that hid something last. It is likely to hide much of the next fan, too.
    last: Option<u32>,
}

impl Cover {
    /// The hidden spans.
    pub fn spans(&self) -> &[[f64; 2]] {
        &self.spans
    }

    /// Removes all spans. What it has learned about the scene stays, and makes the next fan faster.
    pub fn clear(&mut self) {
        self.spans.clear();
    }

    /// Hides a span, of which the beginning is not after the end.
    pub fn add(&mut self, [begin, end]: [f64; 2]) {
        let first = self.spans.partition_point(|span| span[1] + LARGEST_CRACK < begin);
        let after = self.spans.partition_point(|span| span[0] - LARGEST_CRACK <= end);
        if first == after {
            self.spans.insert(first, [begin, end]);
            return;
        }
        self.spans[first] = [self.spans[first][0].min(begin), self.spans[after - 1][1].max(end)];
        self.spans.drain(first + 1..after);
    }

    /// The span outside which everything is hidden, of `chords` chords. `None` if all is hidden.
    fn open(&self, chords: f64) -> Option<[f64; 2]> {
        let (mut begin, mut end) = (0.0, chords);
        if let Some(first) = self.spans.first().filter(|span| span[0] <= LARGEST_CRACK) {
            begin = first[1];
        }
        if let Some(last) = self.spans.last().filter(|span| span[1] >= chords - LARGEST_CRACK) {
            end = last[0];
        }
        (end - begin > LARGEST_CRACK).then_some([begin, end])
    }
}

/// A fan, seen from the space of a BVH.
struct LocalFan<'k> {
    /// Knots in world space.
    knots: &'k [[f64; 3]],
    local_from_world: [[f64; 4]; 3],
    /// Everything from here on is in the space of the BVH: the point, and the first and the last knot.
    origin: [f64; 3],
    ends: [[f64; 3]; 2],
    /// How far any knot is from where it would be if the first and the last were joined by a single chord, on
    /// each axis at most.
    bend: f64,
}

/// The part of a chord that a triangle hides.
struct Hidden {
    chord: usize,
    /// From 0 to 1 along the chord.
    span: [f64; 2],
    /// The weights of the triangle's vertices at both ends of the chord, up to a factor.
    weights: [[f64; 3]; 2],
    front: bool,
}

/// How far the knots of a fan bend from a single chord, world space, on each axis at most.
fn bend_of(knots: &[[f64; 3]]) -> f64 {
    let [first, between @ .., last] = knots else { return 0.0 };
    let step = 1.0 / (knots.len() - 1) as f64;
    let bends = between.iter().enumerate().map(|(number, knot)| {
        let u = (number + 1) as f64 * step;
        let axis = |a: usize| (knot[a] - (1.0 - u) * first[a] - u * last[a]).abs();
        axis(0).max(axis(1)).max(axis(2))
    });
    bends.fold(0.0, f64::max)
}

impl<'k> LocalFan<'k> {
    /// Takes a fan from a point.
    fn new(p: [f64; 3], fan: &'k Fan, local_from_world: [[f64; 4]; 3]) -> Self {
        let m = local_from_world;
        let direction = |d: [f64; 3]| m.map(|r| r[0] * d[0] + r[1] * d[1] + r[2] * d[2]);
        let origin = m.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]);
        let ends = [fan.knots[0], fan.knots[fan.knots.len() - 1]].map(direction);
        let row = |r: [f64; 4]| r[0].abs() + r[1].abs() + r[2].abs();
        let stretch = row(m[0]).max(row(m[1])).max(row(m[2]));
        let size = ends.iter().flatten().fold(0.0_f64, |most, c| most.max(c.abs()));
        // The last term covers rounding.
        Self { knots: &fan.knots, local_from_world, origin, ends, bend: stretch * fan.bend + 1e-13 * size }
    }

    fn chords(&self) -> usize {
        self.knots.len() - 1
    }

    /// The direction at a part of the single chord, 0 to 1.
    fn at(&self, part: f64) -> [f64; 3] {
        std::array::from_fn(|a| (1.0 - part) * self.ends[0][a] + part * self.ends[1][a])
    }

    /// The wedge about a span of chords. Its ends and all between are within twice the bend of its chord.
    fn wedge(&self, [begin, end]: [f64; 2]) -> Wedge {
        let parts = 1.0 / self.chords() as f64;
        Wedge::around(self.at(begin * parts), self.at(end * parts), 2.0 * self.bend)
    }

    /// Calls `found` with each part of a chord within `open` that a triangle hides.
    #[inline]
    fn hidden_by(&self, corners: &[[f32; 3]; 3], open: [f64; 2], mut found: impl FnMut(&Hidden)) {
        let [a, b, c] = corners.map(|v| std::array::from_fn(|i| f64::from(v[i]) - self.origin[i]));
        let bc = cross(b, c);
        let volume = dot(a, bc);
        if volume == 0.0 {
            return;
        }
        let edges = [bc, cross(c, a), cross(a, b)];
        let sign = if volume > 0.0 { 1.0 } else { -1.0 };
        // Where on the single chord the triangle may be, at most: its edge functions on the knots depart from
        // those on that chord by no more than the slack.
        let parts = 1.0 / self.chords() as f64;
        let (mut begin, mut end) = (open[0] * parts, open[1] * parts);
        for edge in edges {
            let slack = self.bend * (edge[0].abs() + edge[1].abs() + edge[2].abs());
            let [from, to] = self.ends.map(|knot| sign * dot(edge, knot) + slack);
            match (from < 0.0, to < 0.0) {
                (true, true) => return,
                (true, false) => begin = begin.max(from / (from - to)),
                (false, true) => end = end.min(from / (from - to)),
                (false, false) => {}
            }
        }
        if begin > end {
            return;
        }
        let m = &self.local_from_world;
        let edges = edges.map(|e| std::array::from_fn(|a| m[0][a] * e[0] + m[1][a] * e[1] + m[2][a] * e[2]));
        let weights = |knot: [f64; 3]| edges.map(|edge| sign * dot(edge, knot));
        // A chord more on both sides covers the rounding of these parts.
        let chords = self.chords() as f64;
        let first = (begin * chords - 1.0).max(open[0]) as usize;
        let last = (end * chords + 1.0).min(open[1]).ceil() as usize;
        let mut next = weights(self.knots[first]);
        for chord in first..last {
            let (from, to) = (next, weights(self.knots[chord + 1]));
            next = to;
            let (mut begin, mut end) = (0.0_f64, 1.0_f64);
            for (from, to) in from.into_iter().zip(to) {
                let crossing = from / (from - to);
                match (from < 0.0, to < 0.0) {
                    (true, true) => end = -1.0,
                    (true, false) => begin = begin.max(crossing),
                    (false, true) => end = end.min(crossing),
                    (false, false) => {}
                }
            }
            if begin <= end {
                found(&Hidden { chord, span: [begin, end], weights: [from, to], front: volume < 0.0 });
            }
        }
    }
}

impl Hidden {
    /// The hit at a place along the chord, 0 to 1.
    fn hit(&self, u: f64) -> TriangleHit {
        let weights: [f64; 3] =
            std::array::from_fn(|i| (1.0 - u) * self.weights[0][i] + u * self.weights[1][i]);
        let sum: f64 = weights.iter().sum();
        TriangleHit { t: f64::NAN, barycentric: weights.map(|w| w / sum), front: self.front }
    }
}

impl Tracer<'_> {
    /// Adds to `cover` the parts of a fan in which the sky is hidden from `origin` by something that casts a
    /// shadow, of those that are not covered yet. Directions in which [`Tracer::occluded`] holds are those. A
    /// point that is not finite sees all of the sky. Cost: one traversal, a few times that of a ray, and some
    /// 20 ns for each triangle that is met.
    pub fn hide(&self, origin: [f64; 3], fan: &Fan, cover: &mut Cover) {
        if fan.knots.is_empty() || !origin.iter().all(|c| c.is_finite()) {
            return;
        }
        let chords = (fan.knots.len() - 1) as f64;
        let enter = |number: usize, cover: &mut Cover| {
            let before = cover.open(chords)?;
            self.add_instance(number, origin, fan, before, cover);
            let open = cover.open(chords)?;
            Some((before != open).then_some(open))
        };
        if self.instances.len() <= MAX_LISTED_INSTANCES {
            (0..self.instances.len()).for_each(|number| {
                enter(number, cover);
            });
            return;
        }
        let last = cover.last.map(|number| number as usize).filter(|&number| number < self.instances.len());
        if let Some(number) = last {
            enter(number, cover);
        }
        let Some(open) = cover.open(chords) else { return };
        let world = LocalFan::new(origin, fan, WORLD);
        self.tlas.walk_wedge(origin, &world.wedge(open), |slot| {
            let number = self.tlas.order()[slot] as usize;
            if Some(number) == last {
                return WedgeTraversal::On;
            }
            match enter(number, cover) {
                None => WedgeTraversal::Stop,
                Some(None) => WedgeTraversal::On,
                Some(Some(open)) => WedgeTraversal::Within(world.wedge(open)),
            }
        });
    }

    /// Adds what an instance hides of the open part of a fan.
    fn add_instance(
        &self,
        number: usize,
        origin: [f64; 3],
        fan: &Fan,
        mut open: [f64; 2],
        cover: &mut Cover,
    ) {
        let instance = &self.instances[number];
        if !instance.casts {
            return;
        }
        let local = LocalFan::new(origin, fan, *instance.mesh_from_world());
        let chords = local.chords() as f64;
        let blas = &self.blases[instance.blas as usize];
        blas.bvh().walk_wedge(local.origin, &local.wedge(open), |slot| {
            let triangle = blas.triangle(slot);
            let mut has_more = false;
            local.hidden_by(blas.corners(slot), open, |hidden| {
                has_more |= self.add_hidden(number, triangle, hidden, fan.mask_step, cover);
            });
            if !has_more {
                return WedgeTraversal::On;
            }
            cover.last = Some(number as u32);
            let before = open;
            match cover.open(chords) {
                None => return WedgeTraversal::Stop,
                Some(now) => open = now,
            }
            if open == before { WedgeTraversal::On } else { WedgeTraversal::Within(local.wedge(open)) }
        });
    }

    /// Adds what a triangle hides of a chord. Returns whether it hides anything.
    fn add_hidden(
        &self,
        number: usize,
        triangle: u32,
        hidden: &Hidden,
        mask_step: f64,
        cover: &mut Cover,
    ) -> bool {
        let instance = &self.instances[number];
        let [begin, end] = hidden.span;
        let start = hidden.chord as f64;
        let is_opaque = |u: f64| self.accept(instance, triangle, &hidden.hit(u), true).is_some();
        let surface = self.surface(instance, triangle);
        if !surface.casts {
            return false;
        }
        if !surface.masked {
            cover.add([start + begin, start + end]);
            return true;
        }
        // Samples at the middles of equal steps, and halvings between two that differ.
        let steps = ((end - begin) / mask_step).ceil().clamp(1.0, MOST_MASK_STEPS);
        let width = (end - begin) / steps;
        let mut opaque_since = None;
        let mut last = begin;
        for step in 0..steps as u32 {
            let u = begin + (f64::from(step) + 0.5) * width;
            let now = is_opaque(u);
            if now != opaque_since.is_some() {
                let edge = if step == 0 { begin } else { halved(last, u, |u| is_opaque(u) == now) };
                match opaque_since.take() {
                    None => opaque_since = Some(edge),
                    Some(since) => cover.add([start + since, start + edge]),
                }
            }
            last = u;
        }
        if let Some(since) = opaque_since {
            cover.add([start + since, start + end]);
        }
        true
    }
}

/// Where between `low` and `high` a condition begins to hold that holds at `high` only.
fn halved(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..MASK_HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

#[cfg(test)]
mod tests;
