//! Triangulates polygons in space, using only their own corners.
//!
//! A polygon that is covered exactly by a fan from its first corner is left to the caller, which cuts that
//! fan: triangles, convex quads, and most other polygons that are star-shaped around their first corner. Any
//! other polygon is projected along the axis nearest to its normal, which keeps coordinates exact, and cut by
//! ear clipping.

use earcut::Earcut;
use hashbrown::HashMap;

/// Sine of the largest angle by which rounding may flip a triangle of a fan.
const FLAT: f64 = 1e-9;
/// A triangulation is wrong if its area differs from the polygon's by more than this fraction.
const MAX_AREA_ERROR: f64 = 1e-3;
/// Polygons with more corners than this are not ear-clipped, since the time may grow with the square of the
/// corner count.
const MAX_CORNERS: usize = 1 << 14;

type Point = [f64; 3];
type Flat = [f64; 2];

/// Triangulates polygons one after another and counts the failures.
#[derive(Default)]
pub(super) struct Cutter {
    earcut: Earcut<f64>,
    flat: Vec<Flat>,
    indices: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    /// Polygons that were not triangulated because they self-intersect, are far from flat or have too many
    /// corners.
    pub(super) failed: u64,
}

impl Cutter {
    /// The triangles of a polygon as corner indices, with the polygon's winding. Returns `None` if the caller
    /// should cut the fan from the first corner. This includes polygons that cannot be triangulated, which
    /// are counted in [`Cutter::failed`].
    pub(super) fn cut(&mut self, points: &[[f32; 3]]) -> Option<&[[u32; 3]]> {
        if points.len() < 4 || points.iter().flatten().any(|c| !c.is_finite()) {
            return None;
        }
        let normal = newell_normal(points);
        if is_fan(points, normal) {
            return None;
        }
        if points.len() <= MAX_CORNERS && normal != [0.0; 3] && self.clip_ears(points, normal) {
            return Some(&self.triangles);
        }
        self.failed += 1;
        None
    }

    /// Fills `triangles`. Returns false if they do not cover the polygon.
    fn clip_ears(&mut self, points: &[[f32; 3]], normal: Point) -> bool {
        let axis = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
        let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 {
            std::mem::swap(&mut u, &mut v);
        }
        self.flat.clear();
        self.flat.extend(points.iter().map(|p| [p[u], p[v]].map(f64::from)));
        self.earcut.earcut(self.flat.iter().copied(), &[], &mut self.indices);
        self.triangles.clear();
        let flat = &self.flat;
        let mut covered = 0.0;
        for &[a, b, c] in self.indices.as_chunks::<3>().0 {
            let area = doubled_area([a, b, c].map(|i| flat[i as usize]));
            covered += area.abs();
            if area > 0.0 {
                self.triangles.push([a, b, c]);
            } else if area < 0.0 {
                self.triangles.push([a, c, b]);
            }
        }
        let area = normal[axis].abs();
        let (mut largest, mut around, mut last) = (0.0_f64, 0.0, flat[flat.len() - 1]);
        for &p in flat {
            largest = largest.max(p[0].abs()).max(p[1].abs());
            around += (p[0] - last[0]).hypot(p[1] - last[1]);
            last = p;
        }
        // Corner coordinates are rounded, and edges may cross by the same error.
        let rounding = f64::from(f32::EPSILON) * largest * around;
        if (covered - area).abs() > rounding.clamp(1e-9 * area, MAX_AREA_ERROR * area) {
            return false;
        }
        put_back_corners(flat, &mut self.triangles);
        true
    }
}

/// The polygon's normal, with twice its area as length (Newell's method).
fn newell_normal(points: &[[f32; 3]]) -> Point {
    let mut sum = [0.0; 3];
    for [p, q] in spokes(points) {
        let cross = cross(p, q);
        for a in 0..3 {
            sum[a] += cross[a];
        }
    }
    sum
}

/// For each triangle of the fan, the two sides that start at the first corner.
fn spokes(points: &[[f32; 3]]) -> impl Iterator<Item = [Point; 2]> + '_ {
    let from_first = |p: [f32; 3]| std::array::from_fn(|a| f64::from(p[a]) - f64::from(points[0][a]));
    points[1..].windows(2).map(move |pair| [from_first(pair[0]), from_first(pair[1])])
}

/// Whether the fan from the first corner covers the polygon exactly: no triangle is flipped, and together
/// they turn through less than a full circle around that corner. With more than four corners, every triangle
/// must also have nonzero area. A degenerate triangle would be dropped later, along with the corner in the
/// middle of its longest side, and that side would no longer match the neighbour's two edges (a T-junction).
fn is_fan(points: &[[f32; 3]], normal: Point) -> bool {
    let length = dot(normal, normal).sqrt();
    if length == 0.0 {
        // The normal is undefined: only a polygon with no area at all is a fan.
        return spokes(points).all(|[p, q]| cross(p, q) == [0.0; 3]);
    }
    let mut turned = 0.0;
    for [p, q] in spokes(points) {
        let cross = cross(p, q);
        if cross == [0.0; 3] && points.len() > 4 {
            return false;
        }
        let sides = (dot(p, p) * dot(q, q)).sqrt();
        if sides == 0.0 {
            continue;
        }
        let (sine, cosine) = (dot(cross, normal) / (length * sides), dot(p, q) / sides);
        if sine < -FLAT {
            return false;
        }
        turned += libm::atan2(if cosine < 0.0 { sine.max(0.0) } else { sine }, cosine);
    }
    turned < std::f64::consts::TAU - 1e-6
}

/// Ear clipping drops corners that are inside straight edges. Without them an edge would no longer match the
/// neighbour's two edges (a T-junction), so this puts them back.
fn put_back_corners(flat: &[Flat], triangles: &mut Vec<[u32; 3]>) {
    let mut used = vec![false; flat.len()];
    for &corner in triangles.iter().flatten() {
        used[corner as usize] = true;
    }
    let Some(start) = used.iter().position(|&u| u) else { return };
    if used.iter().all(|&u| u) {
        return;
    }
    let mut triangle_at: HashMap<[u32; 2], usize> = HashMap::new();
    for (index, &[a, b, c]) in triangles.iter().enumerate() {
        triangle_at.extend([[a, b], [b, c], [c, a]].map(|edge| (edge, index)));
    }
    let mut from = start as u32;
    let mut between: Vec<u32> = Vec::new();
    for corner in (1..=flat.len()).map(|i| ((start + i) % flat.len()) as u32) {
        if !used[corner as usize] {
            between.push(corner);
            continue;
        }
        keep_inner(flat, from, corner, &mut between);
        if let Some(&index) = triangle_at.get(&[from, corner]).filter(|_| !between.is_empty()) {
            let [a, b, c] = triangles[index];
            let apex = if [a, b] == [from, corner] {
                c
            } else if [b, c] == [from, corner] {
                a
            } else {
                b
            };
            triangles[index] = [from, between[0], apex];
            between.push(corner);
            for pair in between.windows(2) {
                triangle_at.insert([pair[1], apex], triangles.len());
                triangles.push([pair[0], pair[1], apex]);
            }
        }
        between.clear();
        from = corner;
    }
}

/// Keeps the corners that are strictly inside the edge and in order along it.
fn keep_inner(flat: &[Flat], from: u32, to: u32, between: &mut Vec<u32>) {
    let (a, b) = (flat[from as usize], flat[to as usize]);
    let along = |p: Flat| (p[0] - a[0]) * (b[0] - a[0]) + (p[1] - a[1]) * (b[1] - a[1]);
    let (mut last, end) = (0.0, along(b));
    between.retain(|&corner| {
        let p = flat[corner as usize];
        let at = along(p);
        let keeps = doubled_area([a, p, b]) == 0.0 && at > last && at < end;
        if keeps {
            last = at;
        }
        keeps
    });
}

fn doubled_area([a, b, c]: [Flat; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn cross(u: Point, v: Point) -> Point {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn dot(u: Point, v: Point) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}
