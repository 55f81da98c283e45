//! The view of a camera, for the choice of pages.

use crate::grid::vec3::{cross, dot};
use crate::grid::{LightGrid, Placement};

/// The view of a camera: its position, the planes that bound its picture, and the size of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Position in the world.
    pub position_world: [f64; 3],
    /// Planes around the visible part of the world: a point p is visible if `n · p + d >= 0` for each plane
    /// `[n.x, n.y, n.z, d]`. Without planes, all points are visible. Normals have any length.
    pub planes: Vec<[f64; 4]>,
    /// Size of a pixel at the camera, world units: 0 in a perspective.
    pub pixel_world: f64,
    /// World units by which a pixel grows per world unit of distance: 0 in a parallel projection.
    pub pixel_per_distance: f64,
}

impl View {
    /// A perspective camera: its position and two directions of any length in the world, the full angle from
    /// the lower to the upper edge of the picture, and the picture's width and height in pixels.
    pub fn perspective(
        position_world: [f64; 3],
        forward: [f64; 3],
        up: [f64; 3],
        fov_y_degrees: f64,
        [width, height]: [u32; 2],
    ) -> Self {
        let (forward, right, up) = axes(forward, up);
        let [width, height] = [width, height].map(|n| f64::from(n.max(1)));
        let half_y = libm::tan(0.5 * fov_y_degrees.to_radians());
        let half_x = half_y * width / height;
        let plane = |side: [f64; 3], half: f64| {
            let normal = [0, 1, 2].map(|a| forward[a] * half + side[a]);
            [normal[0], normal[1], normal[2], -dot(normal, position_world)]
        };
        let planes = vec![
            plane(right, half_x),
            plane(right.map(|c| -c), half_x),
            plane(up, half_y),
            plane(up.map(|c| -c), half_y),
        ];
        Self { position_world, planes, pixel_world: 0.0, pixel_per_distance: 2.0 * half_y / height }
    }

    /// An orthographic camera. Its parameters are those of [`View::perspective`], except that the height of
    /// the picture in world units replaces the angle.
    pub fn parallel(
        position_world: [f64; 3],
        forward: [f64; 3],
        up: [f64; 3],
        height_world: f64,
        [width, height]: [u32; 2],
    ) -> Self {
        let (forward, right, up) = axes(forward, up);
        let [width, height] = [width, height].map(|n| f64::from(n.max(1)));
        let half_y = 0.5 * height_world;
        let half_x = half_y * width / height;
        let plane = |n: [f64; 3], half: f64| [n[0], n[1], n[2], half - dot(n, position_world)];
        let back = |n: [f64; 3]| n.map(|c| -c);
        let planes = vec![
            plane(right, half_x),
            plane(back(right), half_x),
            plane(up, half_y),
            plane(back(up), half_y),
            plane(forward, 0.0),
        ];
        Self { position_world, planes, pixel_world: height_world / height, pixel_per_distance: 0.0 }
    }

    /// A view that needs everything, for a budget that holds a whole file.
    pub fn everything() -> Self {
        Self { position_world: [0.0; 3], planes: Vec::new(), pixel_world: 0.0, pixel_per_distance: 0.0 }
    }

    /// Returns a camera's view of a file that the app has placed. A file that is placed several times needs
    /// one view per placement.
    #[must_use]
    pub fn of_placed(&self, placement: &Placement) -> Self {
        Self {
            position_world: placement.to_file(self.position_world),
            planes: self.planes.iter().map(|&plane| placement.plane_to_file(plane)).collect(),
            pixel_world: self.pixel_world / placement.scale(),
            pixel_per_distance: self.pixel_per_distance,
        }
    }

    /// Returns the size of a pixel at a distance.
    pub(super) fn pixel_at(&self, distance_world: f64) -> f64 {
        self.pixel_world + self.pixel_per_distance * distance_world
    }

    /// Returns the distance at which a pixel has this size; infinite if it has this size nowhere.
    pub(super) fn distance_of(&self, pixel_world: f64) -> f64 {
        let left = pixel_world - self.pixel_world;
        if left <= 0.0 { 0.0 } else { left / self.pixel_per_distance }
    }

    /// Whether a box may be seen.
    pub(super) fn may_see(&self, grid_box: &GridBox<'_>) -> bool {
        self.planes.iter().all(|&[x, y, z, d]| {
            let reach: f64 = grid_box.half_edges.iter().map(|&edge| dot([x, y, z], edge).abs()).sum();
            dot([x, y, z], grid_box.middle) + d + reach >= 0.0
        })
    }
}

/// Returns unit vectors forward, to the right, and up.
fn axes(forward: [f64; 3], up: [f64; 3]) -> ([f64; 3], [f64; 3], [f64; 3]) {
    let unit = |v: [f64; 3]| {
        let length = dot(v, v).sqrt();
        if length > 0.0 { v.map(|c| c / length) } else { v }
    };
    let forward = unit(forward);
    let right = unit(cross(forward, up));
    (forward, right, cross(right, forward))
}

/// A part of a grid: a parallelepiped in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct GridBox<'g> {
    grid: &'g LightGrid,
    /// Grid positions of two opposite corners.
    low: [f64; 3],
    high: [f64; 3],
    middle: [f64; 3],
    /// From the middle to the middle of a side.
    half_edges: [[f64; 3]; 3],
}

impl<'g> GridBox<'g> {
    /// Returns the part of a grid between two grid positions.
    pub(super) fn new(grid: &'g LightGrid, low: [f64; 3], high: [f64; 3]) -> Self {
        let middle = grid.to_world([0, 1, 2].map(|a| 0.5 * (low[a] + high[a])));
        let half = |a: usize| 0.5 * (high[a] - low[a]) * grid.voxel_size;
        let half_edges = [0, 1, 2].map(|a| grid.edges[a].map(|c| c * half(a)));
        Self { grid, low, high, middle, half_edges }
    }

    /// Returns the distance of a point; 0 inside. It begins at the point of the box with the nearest grid
    /// position, which is the nearest one where edges are perpendicular, and moves along one edge after the
    /// other. The result is never too small, and at most a few percent too large.
    pub(super) fn distance(&self, p_world: [f64; 3]) -> f64 {
        const SWEEPS: usize = 12;
        let p_grid = self.grid.to_grid(p_world);
        let nearest: [f64; 3] = [0, 1, 2].map(|a| p_grid[a].clamp(self.low[a], self.high[a]));
        if nearest == p_grid {
            return 0.0;
        }
        let half = |a: usize| (0.5 * (self.high[a] - self.low[a])).max(f64::MIN_POSITIVE);
        let mut along = [0, 1, 2].map(|a| (nearest[a] - 0.5 * (self.low[a] + self.high[a])) / half(a));
        let mut rest: [f64; 3] = [0, 1, 2].map(|a| {
            let to = (0..3).map(|e| along[e] * self.half_edges[e][a]).sum::<f64>();
            p_world[a] - self.middle[a] - to
        });
        for _ in 0..SWEEPS {
            for (along, edge) in along.iter_mut().zip(&self.half_edges) {
                let square = dot(*edge, *edge);
                if square <= 0.0 {
                    continue;
                }
                let to = (*along + dot(*edge, rest) / square).clamp(-1.0, 1.0);
                for (rest, c) in rest.iter_mut().zip(edge) {
                    *rest -= (to - *along) * c;
                }
                *along = to;
            }
        }
        dot(rest, rest).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{Frame, Sun};

    #[test]
    fn pixel_size_is_picture_size_over_pixel_count() {
        let view = View::perspective([1.0, 2.0, 3.0], [0.0, 0.0, -2.0], [0.0, 1.0, 0.0], 90.0, [200, 100]);
        assert!((view.pixel_at(50.0) - 1.0).abs() < 1e-12);
        assert!((view.distance_of(1.0) - 50.0).abs() < 1e-9);
        let flat = View::parallel([0.0; 3], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0], 30.0, [100, 100]);
        assert_eq!(
            [flat.pixel_at(7.0), flat.distance_of(0.2), flat.distance_of(0.4)],
            [0.3, 0.0, f64::INFINITY]
        );
    }

    #[test]
    fn boxes_beside_and_behind_the_camera_are_culled() {
        let sun = Sun::from_angles(120.0, 30.0).unwrap();
        let grid = LightGrid::new(sun, Frame::Oblique { yaw_radians: 0.3 }, 0.5, [0.0; 3], [64; 3]);
        let around = |p_world| {
            let p = grid.to_grid(p_world);
            GridBox::new(&grid, p.map(|c| c - 2.0), p.map(|c| c + 2.0))
        };
        let view = View::perspective([0.0, 5.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], 60.0, [160, 90]);
        for (p_world, is_seen) in [
            ([0.0, 5.0, -20.0], true),
            ([0.0, 5.0, 20.0], false),
            ([30.0, 5.0, -20.0], false),
            ([19.0, 5.0, -20.0], true),
            ([0.0, 25.0, -20.0], false),
        ] {
            assert_eq!(view.may_see(&around(p_world)), is_seen, "{p_world:?}");
        }
    }

    #[test]
    fn view_of_placed_file_matches_camera_on_placed_grid() {
        let turn =
            [[0.0, 0.0, -3.0, 0.0], [0.0, 3.0, 0.0, 0.0], [3.0, 0.0, 0.0, 0.0], [50.0, -2.0, 7.0, 1.0]];
        let placement = Placement::from_matrix(turn).unwrap();
        let grid = LightGrid::new(
            Sun::from_angles(120.0, 30.0).unwrap(),
            Frame::Light,
            0.5,
            [-32.0, -32.0, -64.0],
            [64; 3],
        );
        let placed = grid.placed(&placement);
        let forward = [0.3, -0.2, -1.0];
        for view in [
            View::perspective([48.0, 20.0, 30.0], forward, [0.0, 1.0, 0.0], 50.0, [160, 90]),
            View::parallel([48.0, 20.0, 30.0], forward, [0.0, 1.0, 0.0], 40.0, [160, 90]),
        ] {
            let in_file = view.of_placed(&placement);
            let mut seen = 0;
            for n in 0..512_u32 {
                let low = [n % 8, n / 8 % 8, n / 64].map(|c| 8.0 * f64::from(c));
                let high = low.map(|c| c + 8.0);
                let [ours, theirs] = [GridBox::new(&grid, low, high), GridBox::new(&placed, low, high)];
                assert_eq!(in_file.may_see(&ours), view.may_see(&theirs), "{low:?}");
                seen += u32::from(in_file.may_see(&ours));
                let [near, far] =
                    [ours.distance(in_file.position_world), theirs.distance(view.position_world)];
                assert!((3.0 * near - far).abs() < 1e-6 * (1.0 + far), "{near} {far}");
                let [pixel, pixel_world] = [in_file.pixel_at(near), view.pixel_at(far)];
                assert!((3.0 * pixel - pixel_world).abs() < 1e-9, "{pixel} {pixel_world}");
            }
            assert!((1..512).contains(&seen), "{seen}");
        }
    }

    #[test]
    fn distance_to_box_matches_nearest_sampled_point() {
        let sun = Sun::from_angles(200.0, 25.0).unwrap();
        for frame in [Frame::Light, Frame::Oblique { yaw_radians: -0.8 }] {
            let grid = LightGrid::new(sun, frame, 0.25, [-100.0; 3], [400; 3]);
            let (low, high) = ([10.0, 40.0, 5.0], [90.0, 70.0, 160.0]);
            let grid_box = GridBox::new(&grid, low, high);
            for p_world in [[30.0, 40.0, -20.0], [-12.0, 3.0, 4.0], [0.0, -50.0, 0.0]] {
                let steps = 40;
                let mut nearest = f64::INFINITY;
                for step in 0..(steps + 1_i32).pow(3) {
                    let at = [step % 41, step / 41 % 41, step / (41 * 41)]
                        .map(|n| f64::from(n) / f64::from(steps));
                    let q = grid.to_world([0, 1, 2].map(|a| low[a] + at[a] * (high[a] - low[a])));
                    let d: [f64; 3] = [0, 1, 2].map(|a| q[a] - p_world[a]);
                    nearest = nearest.min(dot(d, d).sqrt());
                }
                let found = grid_box.distance(p_world);
                // The points are up to 1.1 apart.
                assert!((nearest - 0.6..=nearest * 1.05).contains(&found), "{found} {nearest}");
            }
            let inside = grid.to_world([50.0, 50.0, 50.0]);
            assert_eq!(grid_box.distance(inside), 0.0);
        }
    }
}
