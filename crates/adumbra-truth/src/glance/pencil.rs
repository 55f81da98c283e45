//! Parallel rays from a few thousand points, and the triangles that they cross. All triangles are visited
//! once, so that no acceleration structure needs to be built and kept in memory.

use adumbra::grid::vec3::{cross, dot, normalize};
use adumbra_scene::{AlphaMode, Instance, Mesh, Scene};
use rayon::prelude::*;

/// Number of triangles per parallel task.
const TASK_TRIANGLES: usize = 1 << 14;

/// Share of the points, at each end of an axis, that may be outside the cells.
const FAR: f64 = 0.02;

/// Rays from points, all in one direction.
pub(super) struct Pencil {
    right: [f64; 3],
    above: [f64; 3],
    along: [f64; 3],
    /// For each point, its two coordinates across the rays and its coordinate along them.
    points: Vec<[f64; 3]>,
    /// The minimum and maximum of the points along each axis across the rays.
    ends: [[f64; 2]; 2],
    /// The lowest corner of the cells, and the sides of a cell. Points outside the cells belong to the
    /// nearest cells.
    low: [f64; 2],
    cell: [f64; 2],
    cells_across: usize,
    /// For each cell, the index of its first point in `order`; then the number of points.
    starts: Vec<u32>,
    order: Vec<u32>,
}

/// Where a ray crosses a triangle.
pub(super) struct Crossing {
    /// The ray's point.
    pub(super) point: usize,
    /// The instance and the triangle of its mesh.
    pub(super) instance: u32,
    pub(super) triangle: u32,
    /// Distance from the point, negative behind it; the ray's direction has length 1.
    pub(super) distance: f64,
    /// Whether the triangle's normal points along the ray, so that the ray meets its back.
    pub(super) is_from_behind: bool,
    weights: [f64; 3],
}

impl Crossing {
    /// The material of the triangle.
    pub(super) fn material(&self, scene: &Scene) -> u32 {
        mesh_of(scene, self.instance).triangle_materials[self.triangle as usize]
    }

    /// Whether the surface is opaque at the crossing.
    pub(super) fn is_opaque(&self, scene: &Scene, ignore_alpha: bool) -> bool {
        let (mesh, material) = (mesh_of(scene, self.instance), self.material(scene));
        if ignore_alpha || scene.materials[material as usize].alpha == AlphaMode::Opaque {
            return true;
        }
        let uvs = mesh.corner_uvs(self.triangle).map(|uv| uv.map(f64::from));
        let uv = [0, 1].map(|i| (0..3).map(|c| self.weights[c] * uvs[c][i]).sum::<f64>() as f32);
        scene.is_opaque(material, uv, mesh.alpha_at(self.triangle, self.weights))
    }

    /// Whether the triangle casts a shadow.
    pub(super) fn casts(&self, scene: &Scene) -> bool {
        scene.instances[self.instance as usize].casts && scene.materials[self.material(scene) as usize].casts
    }
}

fn mesh_of(scene: &Scene, instance: u32) -> &Mesh {
    &scene.meshes[scene.instances[instance as usize].mesh as usize]
}

/// The corners of a triangle in the world.
pub(super) fn corners(scene: &Scene, instance: &Instance, triangle: u32) -> [[f64; 3]; 3] {
    let mesh = &scene.meshes[instance.mesh as usize];
    mesh.triangles[triangle as usize].map(|v| instance.to_world(mesh.positions[v as usize]))
}

impl Pencil {
    /// Sorts points into cells across the direction `along`, which has length 1.
    pub(super) fn new(points: &[[f64; 3]], along: [f64; 3]) -> Self {
        let helper = if along[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let right = normalize(cross(helper, along));
        let above = cross(along, right);
        let points: Vec<[f64; 3]> =
            points.iter().map(|&p| [right, above, along].map(|axis| dot(p, axis))).collect();
        let cells_across = ((points.len() as f64).sqrt() as usize).max(1);
        let sorted = [0, 1].map(|a| {
            let mut all: Vec<f64> = points.iter().map(|p| p[a]).collect();
            all.sort_by(f64::total_cmp);
            all
        });
        // Ignore a few distant points, so that they do not force all others into one cell.
        let at = |a: usize, share: f64| sorted[a].get((share * sorted[a].len() as f64) as usize).copied();
        let low = [0, 1].map(|a| at(a, FAR).unwrap_or_default());
        let high = [0, 1].map(|a| at(a, 1.0 - FAR).unwrap_or_default());
        let cell = [0, 1].map(|a| ((high[a] - low[a]) / cells_across as f64).max(f64::MIN_POSITIVE));
        let ends =
            [0, 1].map(|a| [sorted[a].first(), sorted[a].last()].map(|end| end.copied().unwrap_or_default()));
        let (starts, order) = (Vec::new(), Vec::new());
        let mut pencil = Self { right, above, along, points, ends, low, cell, cells_across, starts, order };
        let of_point: Vec<usize> = pencil.points.iter().map(|p| pencil.cell_at([p[0], p[1]])).collect();
        let mut starts = vec![0_u32; cells_across * cells_across + 1];
        of_point.iter().for_each(|&cell| starts[cell + 1] += 1);
        (1..starts.len()).for_each(|i| starts[i] += starts[i - 1]);
        let mut next = starts.clone();
        pencil.order = vec![0; of_point.len()];
        for (point, &cell) in (0..).zip(&of_point) {
            pencil.order[next[cell] as usize] = point;
            next[cell] += 1;
        }
        pencil.starts = starts;
        pencil
    }

    /// The index of a cell along one axis across the rays, clamped to the existing cells.
    fn cell_along(&self, axis: usize, at: f64) -> usize {
        (((at - self.low[axis]) / self.cell[axis]).max(0.0) as usize).min(self.cells_across - 1)
    }

    fn cell_at(&self, [x, y]: [f64; 2]) -> usize {
        self.cell_along(1, y) * self.cells_across + self.cell_along(0, x)
    }

    /// Visits all triangles of a scene, and folds the crossings of each with the rays. Runs on the current
    /// rayon pool; the order of the crossings depends on its threads.
    pub(super) fn fold<T: Send>(
        &self,
        scene: &Scene,
        empty: impl Fn() -> T + Sync + Send,
        visit: impl Fn(&mut T, &Crossing) + Sync + Send,
        join: impl Fn(T, T) -> T + Sync + Send,
    ) -> T {
        let tasks: Vec<(u32, std::ops::Range<usize>)> = (0..)
            .zip(&scene.instances)
            .flat_map(|(number, instance)| {
                let count = scene.meshes[instance.mesh as usize].triangles.len();
                let pieces = (0..count).step_by(TASK_TRIANGLES);
                pieces.map(move |from| (number, from..count.min(from + TASK_TRIANGLES)))
            })
            .collect();
        let folded = tasks.par_iter().fold(&empty, |mut all, (number, triangles)| {
            let instance = &scene.instances[*number as usize];
            // The faces of mirrored instances are wound the other way.
            let is_mirrored = instance.determinant() < 0.0;
            for triangle in triangles.clone() {
                let corners = corners(scene, instance, triangle as u32);
                self.cross(&corners, |point, distance, is_wound_along, weights| {
                    let (instance, triangle) = (*number, triangle as u32);
                    let is_from_behind = is_wound_along != is_mirrored;
                    visit(
                        &mut all,
                        &Crossing { point, instance, triangle, distance, is_from_behind, weights },
                    );
                });
            }
            all
        });
        folded.reduce(&empty, &join)
    }

    /// Calls `visit(point, distance, is_wound_along, weights)` for each ray that crosses a triangle.
    /// `is_wound_along` is true if the triangle is counter-clockwise when seen against the direction of the
    /// ray.
    fn cross(&self, corners: &[[f64; 3]; 3], mut visit: impl FnMut(usize, f64, bool, [f64; 3])) {
        let [a, b, c] = corners.map(|p| [self.right, self.above, self.along].map(|axis| dot(p, axis)));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let ends = |axis: usize| {
            let [low, high] = [a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis])];
            let is_beyond = high < self.ends[axis][0] || low > self.ends[axis][1];
            (!is_beyond).then(|| self.cell_along(axis, low)..=self.cell_along(axis, high))
        };
        let (Some(columns), Some(rows)) = (ends(0), ends(1)) else { return };
        for row in rows {
            let first = row * self.cells_across;
            let from = self.starts[first + columns.start()] as usize;
            let to = self.starts[first + columns.end() + 1] as usize;
            for &point in &self.order[from..to] {
                let [x, y, depth] = self.points[point as usize];
                let weight = |p: [f64; 3], q: [f64; 3]| {
                    ((q[0] - p[0]) * (y - p[1]) - (x - p[0]) * (q[1] - p[1])) / area
                };
                let weights = [weight(b, c), weight(c, a), weight(a, b)];
                if weights.iter().all(|&w| w >= 0.0) {
                    let at = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
                    visit(point as usize, at - depth, area > 0.0, weights);
                }
            }
        }
    }
}
