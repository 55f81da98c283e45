//! Closed shapes with shared vertices, wound counter-clockwise from outside.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use crate::generate::Mesh;
use adumbra::grid::vec3::{cross, normalize};

/// Builds a mesh. New triangles get the material last set with `paint`.
pub(super) struct MeshBuilder {
    mesh: Mesh,
    material: u32,
}

impl MeshBuilder {
    pub(super) fn new(name: impl Into<String>, material: u32) -> Self {
        Self { mesh: Mesh { name: name.into(), ..Mesh::default() }, material }
    }

    pub(super) fn finish(mut self) -> Mesh {
        if !self.mesh.uvs.is_empty() {
            self.mesh.uvs.resize(self.mesh.positions.len(), [0.0; 2]);
        }
        self.mesh
    }

    pub(super) fn paint(&mut self, material: u32) -> &mut Self {
        self.material = material;
        self
    }

    pub(super) fn vertex(&mut self, p: [f64; 3]) -> u32 {
        self.mesh.positions.push(p.map(|c| c as f32 + 0.0));
        self.mesh.positions.len() as u32 - 1
    }

    pub(super) fn triangle(&mut self, a: u32, b: u32, c: u32) {
        self.mesh.triangles.push([a, b, c]);
        self.mesh.triangle_materials.push(self.material);
    }

    pub(super) fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangle(a, b, c);
        self.triangle(a, c, d);
    }

    /// Adds a quad with the whole of a texture on it; the first two corners are at the texture's lower edge.
    pub(super) fn card(&mut self, corners: [[f64; 3]; 4]) {
        let corners = corners.map(|p| self.vertex(p));
        let last = self.mesh.positions.len();
        self.mesh.uvs.resize(last - 4, [0.0; 2]);
        self.mesh.uvs.extend([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
        self.quad(corners);
    }

    /// Adds a box.
    pub(super) fn cuboid(&mut self, min: [f64; 3], max: [f64; 3]) {
        let v: [u32; 8] = std::array::from_fn(|i| {
            self.vertex([0, 1, 2].map(|a| if i >> a & 1 == 0 { min[a] } else { max[a] }))
        });
        for f in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            self.quad(f.map(|i: usize| v[i]));
        }
    }

    /// Adds a box, given the centre of its base and its size.
    pub(super) fn block(&mut self, [x, y, z]: [f64; 3], [w, h, d]: [f64; 3]) {
        self.cuboid([x - w / 2.0, y, z - d / 2.0], [x + w / 2.0, y + h, z + d / 2.0]);
    }

    /// Adds a rectangular ring with walls of thickness `wall`, such as a parapet.
    pub(super) fn ring(&mut self, min: [f64; 3], max: [f64; 3], wall: f64) {
        let corner = |x: usize, z: usize, y: f64, inset: f64| {
            let px = if x == 0 { min[0] + inset } else { max[0] - inset };
            let pz = if z == 0 { min[2] + inset } else { max[2] - inset };
            [px, y, pz]
        };
        let loops = [(min[1], 0.0), (max[1], 0.0), (max[1], wall), (min[1], wall)].map(|(y, inset)| {
            [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, z)| self.vertex(corner(x, z, y, inset)))
        });
        for l in 0..4 {
            let (a, b) = (loops[l], loops[(l + 1) % 4]);
            for i in 0..4 {
                let j = (i + 1) % 4;
                self.quad([a[i], b[i], b[j], a[j]]);
            }
        }
    }

    /// Adds a capped cylinder, a frustum, or (if `top_radius` is 0) a cone about the vertical through (x, z).
    pub(super) fn frustum(
        &mut self,
        [x, z]: [f64; 2],
        [low, high]: [f64; 2],
        [base_radius, top_radius]: [f64; 2],
        sides: u32,
    ) {
        let ring = |builder: &mut Self, y: f64, radius: f64| -> Vec<u32> {
            (0..sides)
                .map(|i| {
                    let angle = TAU * f64::from(i) / f64::from(sides);
                    builder.vertex([x + radius * libm::cos(angle), y, z + radius * libm::sin(angle)])
                })
                .collect()
        };
        let base = ring(self, low, base_radius);
        let n = base.len();
        if top_radius == 0.0 {
            let apex = self.vertex([x, high, z]);
            for i in 0..n {
                self.triangle(base[i], apex, base[(i + 1) % n]);
            }
        } else {
            let top = ring(self, high, top_radius);
            for i in 0..n {
                let j = (i + 1) % n;
                self.quad([base[i], top[i], top[j], base[j]]);
            }
            for i in 1..n - 1 {
                self.triangle(top[0], top[i + 1], top[i]);
            }
        }
        for i in 1..n - 1 {
            self.triangle(base[0], base[i], base[i + 1]);
        }
    }

    /// Extrudes a simple polygon in (x, y), counter-clockwise seen from +Z, from `near` to `far` along Z.
    pub(super) fn extrude(&mut self, profile: &[[f64; 2]], near: f64, far: f64) {
        let back: Vec<u32> = profile.iter().map(|&[x, y]| self.vertex([x, y, near])).collect();
        let front: Vec<u32> = profile.iter().map(|&[x, y]| self.vertex([x, y, far])).collect();
        for i in 0..profile.len() {
            let j = (i + 1) % profile.len();
            self.quad([back[i], back[j], front[j], front[i]]);
        }
        for [a, b, c] in cut_into_triangles(profile) {
            self.triangle(front[a], front[b], front[c]);
            self.triangle(back[a], back[c], back[b]);
        }
    }

    /// Adds a ball made from an icosahedron whose triangles are split in four `cuts` times. `point` maps a
    /// unit direction to a position.
    pub(super) fn ball(&mut self, cuts: u32, mut point: impl FnMut([f64; 3]) -> [f64; 3]) {
        let (directions, triangles) = icosphere(cuts);
        let first = self.mesh.positions.len() as u32;
        for direction in directions {
            self.vertex(point(direction));
        }
        for [a, b, c] in triangles {
            self.triangle(first + a, first + b, first + c);
        }
    }

    /// Adds a ball about the origin with `segments` around and `rings` from pole to pole: 2 ·
    /// `segments` · (`rings` - 1) triangles, and a vertex at each pole. `point` maps a unit direction to a
    /// position.
    pub(super) fn globe(&mut self, [segments, rings]: [u32; 2], point: impl Fn([f64; 3]) -> [f64; 3]) {
        let north = self.vertex(point([0.0, 1.0, 0.0]));
        for i in 1..rings {
            let down = PI * f64::from(i) / f64::from(rings);
            let (across, y) = (libm::sin(down), libm::cos(down));
            for j in 0..segments {
                let around = TAU * f64::from(j) / f64::from(segments);
                self.vertex(point([across * libm::cos(around), y, across * libm::sin(around)]));
            }
        }
        let south = self.vertex(point([0.0, -1.0, 0.0]));
        let at = |i: u32, j: u32| north + 1 + (i - 1) * segments + j % segments;
        for j in 0..segments {
            self.triangle(north, at(1, j + 1), at(1, j));
            for i in 1..rings - 1 {
                self.quad([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
            }
            self.triangle(at(rings - 1, j), at(rings - 1, j + 1), south);
        }
    }

    /// Adds a straight rod with flat ends: a prism with `sides` corners at distance `radius` from the line
    /// between two distinct points.
    pub(super) fn rod(&mut self, from: [f64; 3], to: [f64; 3], radius: f64, sides: u32) {
        let axis = normalize([0, 1, 2].map(|a| to[a] - from[a]));
        let aside = if axis[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
        let u = normalize(cross(axis, aside));
        let v = cross(axis, u);
        let [base, top] = [from, to].map(|centre| -> Vec<u32> {
            (0..sides)
                .map(|i| {
                    let angle = TAU * f64::from(i) / f64::from(sides);
                    let (c, s) = (radius * libm::cos(angle), radius * libm::sin(angle));
                    self.vertex([0, 1, 2].map(|a| centre[a] + c * u[a] + s * v[a]))
                })
                .collect()
        });
        let n = base.len();
        for i in 0..n {
            let j = (i + 1) % n;
            self.quad([base[i], base[j], top[j], top[i]]);
        }
        for i in 1..n - 1 {
            self.triangle(top[0], top[i], top[i + 1]);
            self.triangle(base[0], base[i + 1], base[i]);
        }
    }

    /// Adds a torus whose axis is along Z.
    pub(super) fn torus(&mut self, centre: [f64; 3], radius: f64, tube: f64, [around, across]: [u32; 2]) {
        let first = self.mesh.positions.len() as u32;
        for i in 0..around {
            let u = TAU * f64::from(i) / f64::from(around);
            for j in 0..across {
                let v = TAU * f64::from(j) / f64::from(across);
                let r = radius + tube * libm::cos(v);
                let p = [r * libm::cos(u), r * libm::sin(u), tube * libm::sin(v)];
                self.vertex([centre[0] + p[0], centre[1] + p[1], centre[2] + p[2]]);
            }
        }
        let at = |i: u32, j: u32| first + (i % around) * across + j % across;
        for i in 0..around {
            for j in 0..across {
                self.quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }

    /// Adds a closed square slab about the origin. Its top, at y = 0, is a checkerboard of `cells` × `cells`
    /// in two materials.
    pub(super) fn board(&mut self, side: f64, thickness: f64, cells: u32, tops: [u32; 2]) {
        let at = |i: u32| side * (f64::from(i) / f64::from(cells) - 0.5);
        let levels = [-thickness, 0.0].map(|y| {
            let first = self.mesh.positions.len() as u32;
            for i in 0..=cells {
                for j in 0..=cells {
                    self.vertex([at(i), y, at(j)]);
                }
            }
            first
        });
        let base = self.material;
        let v = |level: usize, i: u32, j: u32| levels[level] + i * (cells + 1) + j;
        for i in 0..cells {
            for j in 0..cells {
                self.quad([v(0, i, j), v(0, i + 1, j), v(0, i + 1, j + 1), v(0, i, j + 1)]);
                self.paint(tops[((i + j) % 2) as usize]);
                self.quad([v(1, i, j), v(1, i, j + 1), v(1, i + 1, j + 1), v(1, i + 1, j)]);
                self.paint(base);
            }
            let j = i + 1;
            self.quad([v(0, 0, i), v(0, 0, j), v(1, 0, j), v(1, 0, i)]);
            self.quad([v(0, cells, j), v(0, cells, i), v(1, cells, i), v(1, cells, j)]);
            self.quad([v(0, j, 0), v(0, i, 0), v(1, i, 0), v(1, j, 0)]);
            self.quad([v(0, i, cells), v(0, j, cells), v(1, j, cells), v(1, i, cells)]);
        }
    }
}

/// Returns unit directions and triangles of an icosahedron whose triangles are split in four `cuts` times.
/// The triangles are wound counter-clockwise from outside.
pub fn icosphere(cuts: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points: Vec<[f64; 3]> = Vec::new();
    for [s, t] in [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]] {
        points.push([s, t * g, 0.0]);
    }
    for [s, t] in [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]] {
        points.push([0.0, s, t * g]);
    }
    for [s, t] in [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]] {
        points.push([t * g, 0.0, s]);
    }
    let mut points: Vec<[f64; 3]> = points.into_iter().map(normalize).collect();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..cuts {
        let mut middles = BTreeMap::new();
        let mut finer = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let (p, q) = (points[i.min(j) as usize], points[i.max(j) as usize]);
                    points.push(normalize([p[0] + q[0], p[1] + q[1], p[2] + q[2]]));
                    points.len() as u32 - 1
                })
            });
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (points, triangles)
}

/// Ear clipping of a small simple polygon, counter-clockwise.
fn cut_into_triangles(polygon: &[[f64; 2]]) -> Vec<[usize; 3]> {
    let turn = |a: usize, b: usize, c: usize| {
        let [a, b, c] = [a, b, c].map(|i| polygon[i]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut left: Vec<usize> = (0..polygon.len()).collect();
    let mut triangles = Vec::new();
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&i| {
            let (a, b, c) = (left[(i + n - 1) % n], left[i], left[(i + 1) % n]);
            let holds = |p: usize| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            turn(a, b, c) > 0.0 && !left.iter().any(|&p| p != a && p != b && p != c && holds(p))
        });
        // A simple polygon always has an ear, but rounding may hide it.
        let i = ear.unwrap_or(0);
        triangles.push([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
        left.remove(i);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}
