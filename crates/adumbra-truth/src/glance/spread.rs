//! The extent of a scene: the box that contains nearly all of its triangles, and strays far outside the box.

use adumbra::Bounds;
use adumbra_scene::{Instance, Scene};

/// The share of the triangles that may be outside the box, at each of its sides.
const OUTSIDE: f64 = 0.001;
/// Maximum number of triangles to sample, evenly spaced over all.
const MOST_SAMPLES: u64 = 1 << 17;
/// An instance with at most this many triangles, or with at most a hundredth of all, may be a stray.
const LARGEST_SMALL: u64 = 12;
/// Strays widen a scene if it is more than this many times as wide as the box.
const MUCH_WIDER: f64 = 3.0;

/// The extent of a scene.
#[derive(Clone, Debug)]
pub struct Spread {
    /// The box that contains nearly all triangles.
    pub most: Bounds,
    /// The instance that reaches farthest beyond the box, if the scene is much wider than the box.
    pub stray: Option<Stray>,
}

/// An instance that reaches far beyond the rest of a scene.
#[derive(Clone, Debug)]
pub struct Stray {
    /// Its name.
    pub name: String,
    /// The farthest corner of its box, world units.
    pub reaches: [f64; 3],
    /// Whether it surrounds the rest of the scene horizontally, as a wide ground does.
    pub is_around: bool,
}

impl Spread {
    pub(super) fn of(scene: &Scene) -> Self {
        let whole = scene.bounds();
        let total = scene.instanced_triangles();
        let step = total.div_ceil(MOST_SAMPLES).max(1);
        let mut ends: [[Vec<f64>; 2]; 3] = Default::default();
        let triangles = scene.instances.iter().flat_map(|i| {
            let mesh = &scene.meshes[i.mesh as usize];
            mesh.triangles.iter().map(move |t| t.map(|v| i.to_world(mesh.positions[v as usize])))
        });
        for corners in triangles.step_by(usize::try_from(step).unwrap_or(usize::MAX)) {
            for (axis, [lows, highs]) in ends.iter_mut().enumerate() {
                let [a, b, c] = corners.map(|p| p[axis]);
                lows.push(a.min(b).min(c));
                highs.push(a.max(b).max(c));
            }
        }
        ends.iter_mut().flatten().for_each(|values| values.sort_by(f64::total_cmp));
        let count = ends[0][0].len();
        if count == 0 {
            return Self { most: whole, stray: None };
        }
        let boxes = boxes(scene);
        let middle = |a: usize| f64::midpoint(ends[a][0][count / 2], ends[a][1][count / 2]);
        let middle = [0, 1, 2].map(middle);
        // A single triangle may be a stray even in a scene with few triangles, and a small instance may be
        // one in a larger scene.
        let farthest_of_all = farthest(&boxes, &Bounds { min: middle, max: middle });
        let size = farthest_of_all
            .map_or(0, |(i, _)| scene.meshes[scene.instances[i].mesh as usize].triangles.len() as u64);
        // An instance with most of the triangles is the scene itself.
        let is_small = size <= LARGEST_SMALL.max(total / 100) && 2 * size < total;
        let small = if is_small { size.div_ceil(step) as usize } else { 0 };
        let without = |outside: usize| {
            let outside = outside.min(count / 4);
            let end = |a: usize| [ends[a][0][outside], ends[a][1][count - 1 - outside]];
            let [x, y, z] = [0, 1, 2].map(|a| [end(a)[0].min(end(a)[1]), end(a)[0].max(end(a)[1])]);
            Bounds { min: [x[0], y[0], z[0]], max: [x[1], y[1], z[1]] }
        };
        let makes_wide = |most: &Bounds| longest(&whole) > MUCH_WIDER * longest(most);
        let few = ((count as f64 * OUTSIDE) as usize).max(1);
        let without_small = Some(without(few.max(small))).filter(makes_wide);
        let most = without_small.unwrap_or_else(|| without(few));
        let is_wide = makes_wide(&most);
        let stray = farthest(&boxes, &most).filter(|_| is_wide).map(|(i, reaches)| Stray {
            name: scene.instances[i].name.clone(),
            reaches,
            // A ground is below the rest of the scene, so ignore heights.
            is_around: [0, 2]
                .iter()
                .all(|&a| boxes[i].min[a] <= most.min[a] && boxes[i].max[a] >= most.max[a]),
        });
        Self { most, stray }
    }

    /// The box, extended horizontally over ground on which the shadows of its content fall: by its longest
    /// side, if a wide ground surrounds it.
    pub(super) fn around(&self, whole: &Bounds) -> Bounds {
        let Self { most, stray } = self;
        let by = if stray.as_ref().is_some_and(|stray| stray.is_around) { self.side_world() } else { 0.0 };
        let mut around = *most;
        for a in [0, 2] {
            around.min[a] = (most.min[a] - by).max(whole.min[a]).min(most.min[a]);
            around.max[a] = (most.max[a] + by).min(whole.max[a]).max(most.max[a]);
        }
        around
    }

    /// The longest side of the box.
    pub fn side_world(&self) -> f64 {
        longest(&self.most)
    }

    /// Returns the box, a twentieth larger on each side and rounded to numbers that are easy to type.
    pub fn bounds_to_give(&self) -> Bounds {
        let side = self.side_world();
        let unit = if side > 0.0 { 10_f64.powi((side / 100.0).log10().floor() as i32) } else { 1.0 };
        let out = |value: f64, by: f64| ((value + by * side / 20.0) / unit * by).ceil() * by * unit;
        Bounds { min: self.most.min.map(|c| out(c, -1.0)), max: self.most.max.map(|c| out(c, 1.0)) }
    }
}

fn longest(bounds: &Bounds) -> f64 {
    (0..3).map(|a| bounds.max[a] - bounds.min[a]).fold(0.0, f64::max)
}

/// Returns the instance whose box reaches the farthest beyond another box, and its farthest corner.
fn farthest(boxes: &[Bounds], most: &Bounds) -> Option<(usize, [f64; 3])> {
    let beyond = |p: [f64; 3]| {
        (0..3).map(|a| (most.min[a] - p[a]).max(p[a] - most.max[a])).fold(f64::NEG_INFINITY, f64::max)
    };
    let all = boxes.iter().enumerate().flat_map(|(i, b)| corners(*b).map(move |corner| (i, corner)));
    all.max_by(|(_, p), (_, q)| beyond(*p).total_cmp(&beyond(*q)))
}

fn corners(b: Bounds) -> impl Iterator<Item = [f64; 3]> {
    (0..8).map(move |i| std::array::from_fn(|a| if i >> a & 1 == 0 { b.min[a] } else { b.max[a] }))
}

/// The smallest box around points.
fn around(points: impl Iterator<Item = [f64; 3]>) -> Bounds {
    let nothing = Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
    points.fold(nothing, |b, p| Bounds {
        min: std::array::from_fn(|a| b.min[a].min(p[a])),
        max: std::array::from_fn(|a| b.max[a].max(p[a])),
    })
}

/// A world-space box around each instance. The box of a rotated instance may be larger than necessary.
fn boxes(scene: &Scene) -> Vec<Bounds> {
    let of_mesh = scene.meshes.iter().map(|mesh| around(mesh.positions.iter().map(|p| p.map(f64::from))));
    let of_mesh: Vec<Bounds> = of_mesh.collect();
    let placed =
        |i: &Instance| around(corners(of_mesh[i.mesh as usize]).map(|p| i.to_world(p.map(|c| c as f32))));
    scene.instances.iter().map(placed).collect()
}
