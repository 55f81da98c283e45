//! Parts of random scenes. Each method of [`Modeller`] adds one kind of geometry with its own difficulty.

use std::f64::consts::TAU;

use crate::fuzz::dice::Dice;
use adumbra::grid::vec3::{cross, dot, normalize};
use adumbra_scene::Mesh;
use adumbra_testing::toothed_bar;

type Point = [f64; 3];

/// Corners of a hexahedron's faces, anticlockwise from outside. Bit a of a corner's number is its side along
/// axis a.
const FACES: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Builds one mesh.
pub(crate) struct Modeller<'d> {
    pub(crate) dice: &'d mut Dice,
    pub(crate) mesh: Mesh,
    /// Coordinates are rounded to multiples of this, so that parts coincide; 0 = no rounding.
    pub(crate) grain: f64,
    /// Material of the triangles added next.
    pub(crate) material: u32,
    /// Unit vector towards the sun.
    pub(crate) towards_sun: Point,
    /// Approximate edge length of a voxel.
    pub(crate) voxel: f64,
}

fn sum(a: Point, b: Point, factor: f64) -> Point {
    std::array::from_fn(|k| a[k] + factor * b[k])
}

impl Modeller<'_> {
    /// Adds a triangle, unless rounding leaves it without an area.
    fn triangle(&mut self, corners: [Point; 3]) {
        let grain = self.grain;
        let round = |c: f64| if grain > 0.0 { ((c / grain).round() * grain) as f32 } else { c as f32 };
        let corners = corners.map(|p| p.map(round));
        let edge = |i: usize| [0, 1, 2].map(|a| f64::from(corners[i][a]) - f64::from(corners[0][a]));
        if cross(edge(1), edge(2)) == [0.0; 3] {
            return;
        }
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(corners);
        self.mesh.uvs.extend(corners.map(|[x, y, z]| [0.37 * x + 0.1 * y, 0.41 * z + 0.1 * y]));
        self.mesh.triangles.push([first, first + 1, first + 2]);
        self.mesh.triangle_materials.push(self.material);
    }

    fn quad(&mut self, [a, b, c, d]: [Point; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }

    fn hexahedron(&mut self, corners: [Point; 8], inverted: bool) {
        for mut face in FACES {
            if inverted {
                face.reverse();
            }
            self.quad(face.map(|c| corners[c]));
        }
    }

    /// Adds a parallelepiped from one corner along three edges, with its faces turned outwards.
    fn parallelepiped(&mut self, corner: Point, edges: [Point; 3]) {
        let corners = std::array::from_fn(|c| {
            (0..3).fold(corner, |p, a| sum(p, edges[a], if c >> a & 1 == 1 { 1.0 } else { 0.0 }))
        });
        let inverted = dot(cross(edges[0], edges[1]), edges[2]) < 0.0;
        self.hexahedron(corners, inverted);
    }

    fn cuboid(&mut self, low: Point, size: Point) {
        let axis = |a: usize| std::array::from_fn(|k| if k == a { size[a] } else { 0.0 });
        self.parallelepiped(low, [axis(0), axis(1), axis(2)]);
    }

    /// Adds a random part somewhere in the scene.
    pub(crate) fn add_part(&mut self) {
        let center = [self.dice.within(-8.0..8.0), self.dice.within(-4.0..4.0), self.dice.within(-8.0..8.0)];
        match self.dice.below(19) {
            0 | 1 => self.boxes(center),
            2 => self.warped_hexahedron(center),
            3 => self.ball(center),
            4 | 5 => self.terrain(center),
            6 => self.woven(center),
            7 => self.needle(center),
            8 => self.t_junction(center),
            9 => self.doubled_quad(center),
            10 => self.thin_slab(center),
            11 => self.ground(),
            12 => self.cone(center),
            13 => self.soup(center),
            14 | 15 => self.layers(center),
            16 => self.teeth(center),
            17 => self.bricks(center),
            _ => self.box_on_slope(center),
        }
    }

    fn boxes(&mut self, center: Point) {
        let size = [0.05..5.0, 0.01..5.0, 0.05..5.0].map(|range| self.dice.within(range));
        let corners =
            std::array::from_fn(|c| [0, 1, 2].map(|a| center[a] + size[a] * f64::from(c as u32 >> a & 1)));
        let inverted = self.dice.chance(0.1);
        self.hexahedron(corners, inverted);
        if self.dice.chance(0.1) {
            let inverted = self.dice.chance(0.5);
            self.hexahedron(corners, inverted);
        }
    }

    /// Adds a hexahedron with faces that are not flat and edges that may pass through the inside.
    fn warped_hexahedron(&mut self, center: Point) {
        let size = [0.5..5.0, 0.05..5.0, 0.5..5.0].map(|range| self.dice.within(range));
        let warp = self.dice.within(0.0..1.5);
        let corners = std::array::from_fn(|c| {
            let corner = [0, 1, 2].map(|a| center[a] + size[a] * f64::from(c as u32 >> a & 1));
            self.dice.near(corner, warp)
        });
        let inverted = self.dice.chance(0.1);
        self.hexahedron(corners, inverted);
    }

    fn ball(&mut self, center: Point) {
        let radii = [0.1..4.0, 0.1..6.0, 0.1..4.0].map(|range| self.dice.within(range));
        let (rings, sectors) = (self.dice.count(2..12), self.dice.count(3..16));
        let at = |ring: usize, sector: usize| {
            let (down, around) =
                (0.5 * TAU * ring as f64 / rings as f64, TAU * (sector % sectors) as f64 / sectors as f64);
            let across = if ring == 0 || ring == rings { 0.0 } else { down.sin() };
            let unit = [across * around.cos(), down.cos(), across * around.sin()];
            std::array::from_fn(|a| center[a] + radii[a] * unit[a])
        };
        for ring in 0..rings {
            for sector in 0..sectors {
                self.quad([(0, 0), (0, 1), (1, 1), (1, 0)].map(|(r, s)| at(ring + r, sector + s)));
            }
        }
    }

    /// Adds an open bumpy sheet with holes, in either orientation.
    fn terrain(&mut self, center: Point) {
        let cells = self.dice.count(1..13);
        let width = self.dice.within(2.0..14.0);
        let bumps = if self.dice.chance(0.3) { 0.0 } else { self.dice.within(0.0..2.0) };
        let tilt = [0; 2].map(|_| self.dice.within(-1.5..1.5));
        let heights: Vec<f64> = (0..(cells + 1) * (cells + 1))
            .map(|_| if bumps > 0.0 { self.dice.within(-bumps..bumps) } else { 0.0 })
            .collect();
        let at = |i: usize, j: usize| {
            let [x, z] = [i, j].map(|c| (c as f64 / cells as f64 - 0.5) * width);
            let y = -2.0 + heights[i * (cells + 1) + j] + tilt[0] * x + tilt[1] * z;
            [center[0] + x, center[1] + y, center[2] + z]
        };
        let from_below = self.dice.chance(0.3);
        for i in 0..cells {
            for j in 0..cells {
                if self.dice.chance(0.03) {
                    continue;
                }
                let mut corners = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                if from_below {
                    corners.reverse();
                }
                if self.dice.chance(0.5) {
                    corners.rotate_left(1);
                }
                self.quad(corners);
            }
        }
    }

    /// Adds triangles with few vertices, which share edges in every way: open, closed, folded, more than two
    /// at an edge.
    fn woven(&mut self, center: Point) {
        let vertices: Vec<Point> = (0..self.dice.count(5..9)).map(|_| self.dice.near(center, 3.0)).collect();
        for _ in 0..self.dice.below(20) {
            let corners = [0; 3].map(|_| self.dice.pick(&vertices));
            self.triangle(corners);
        }
    }

    fn needle(&mut self, center: Point) {
        let (from, to) = (self.dice.near(center, 6.0), self.dice.near(center, 6.0));
        let width = self.dice.scale(1e-6..0.1);
        self.triangle([from, to, [to[0] + width, to[1], to[2] - width]]);
    }

    /// Adds a vertex that is on another triangle's edge, except for rounding.
    fn t_junction(&mut self, center: Point) {
        let [a, b] = [0; 2].map(|_| self.dice.near(center, 6.0));
        let c = self.dice.near(center, 3.0);
        let along = self.dice.unit();
        let middle = std::array::from_fn(|k| a[k] + along * (b[k] - a[k]));
        let opposite = std::array::from_fn(|k| a[k] + b[k] - c[k]);
        self.triangle([a, b, c]);
        self.triangle([a, opposite, middle]);
        self.triangle([middle, opposite, b]);
    }

    /// Adds both sides of a sheet, one of them sometimes twice.
    fn doubled_quad(&mut self, center: Point) {
        let mut corners = [0; 4].map(|_| self.dice.near(center, 5.0));
        self.quad(corners);
        if self.dice.chance(0.3) {
            self.quad(corners);
        }
        corners.reverse();
        self.quad(corners);
    }

    fn thin_slab(&mut self, center: Point) {
        let thickness = self.dice.scale(1e-3..1.0);
        let [u, v] = [0; 2].map(|_| self.dice.near([0.0; 3], 4.0));
        self.parallelepiped(center, [u, [0.0, thickness, 0.0], v]);
    }

    fn ground(&mut self) {
        let y = self.dice.within(-9.0..-4.0);
        let half = self.dice.within(6.0..20.0);
        self.quad([[-half, y, -half], [-half, y, half], [half, y, half], [half, y, -half]]);
    }

    /// Adds a solid steep cone.
    fn cone(&mut self, center: Point) {
        let (radius, height) = (self.dice.within(0.3..4.0), self.dice.within(0.5..12.0));
        let sides = self.dice.count(3..13);
        let top = [center[0], center[1] + height, center[2]];
        let at = |side: usize| {
            let around = TAU * (side % sides) as f64 / sides as f64;
            [center[0] + radius * around.cos(), center[1], center[2] + radius * around.sin()]
        };
        for side in 0..sides {
            self.triangle([at(side + 1), at(side), top]);
            self.triangle([at(side), at(side + 1), center]);
        }
    }

    fn soup(&mut self, center: Point) {
        for _ in 0..self.dice.count(1..7) {
            let corners = [0; 3].map(|_| self.dice.near(center, 3.0));
            self.triangle(corners);
        }
    }

    /// Adds parallel layers, open or solid, with gaps of 0.2 to 12 voxels along the light, at any slope to
    /// the light.
    fn layers(&mut self, center: Point) {
        let grain = std::mem::replace(&mut self.grain, 0.0);
        let slope = if self.dice.chance(0.3) { 0.0 } else { self.dice.scale(0.1..15.0) };
        let light = self.towards_sun.map(|c| -c);
        let across = self.dice.near([0.0; 3], 1.0);
        let level = normalize(cross(light, across));
        let uphill = sum(cross(light, level), light, slope);
        let half = self.dice.within(1.0..4.0) / (1.0 + slope).sqrt();
        let mut at = center;
        for n in 0..self.dice.count(2..4) {
            let grown = half * (1.0 + 0.5 * n as f64);
            let [u, v] = [level, uphill].map(|edge| edge.map(|c| 2.0 * grown * c));
            let corner = sum(sum(at, u, -0.5), v, -0.5);
            let mut thickness = 0.0;
            if self.dice.chance(0.4) {
                thickness = self.dice.scale(0.01..20.0) * self.voxel;
                self.parallelepiped(corner, [u, v, light.map(|c| thickness * c)]);
            } else {
                let mut corners =
                    [corner, sum(corner, u, 1.0), sum(sum(corner, u, 1.0), v, 1.0), sum(corner, v, 1.0)];
                if self.dice.chance(0.5) {
                    corners.reverse();
                }
                self.quad(corners);
            }
            let gap = self.dice.scale(0.2..12.0) * self.voxel;
            at = sum(at, light, thickness + gap);
        }
        self.grain = grain;
    }

    /// Adds a solid whose top is a row of teeth, over an open floor a few voxels below.
    fn teeth(&mut self, center: Point) {
        let count = self.dice.count(1..8);
        let pitch = self.dice.scale(0.7..6.0) * self.voxel;
        let [thickness, height, gap] =
            [0.3..3.0, 0.5..8.0, 0.3..8.0].map(|r| self.dice.scale(r) * self.voxel);
        let depth = self.dice.within(1.0..4.0);
        let [x, y, z] = center;
        let valleys = y + thickness;
        for face in toothed_bar(x, count, pitch, [y, valleys, valleys + height], [z, z + depth]) {
            self.quad(face);
        }
        let (right, floor) = (x + 0.5 * pitch * (2 * count) as f64 + 1.0, y - gap);
        self.quad([
            [x - 1.0, floor, z - 1.0],
            [x - 1.0, floor, z + depth + 1.0],
            [right, floor, z + depth + 1.0],
            [right, floor, z - 1.0],
        ]);
    }

    /// Adds solid boxes that touch, laid in courses that are offset from each other.
    fn bricks(&mut self, center: Point) {
        let size = [0.3..2.0, 0.1..1.0, 0.3..2.0].map(|range| self.dice.within(range));
        let (courses, length) = (self.dice.count(1..4), self.dice.count(2..5));
        let shift = self.dice.unit();
        for course in 0..courses {
            for n in 0..length {
                let along = (n as f64 + shift * (course % 2) as f64) * size[0];
                let low = [center[0] + along, center[1], center[2] + course as f64 * size[2]];
                self.cuboid(low, size);
            }
        }
    }

    /// Adds a solid that is partly sunk into a tilted open sheet.
    fn box_on_slope(&mut self, center: Point) {
        let half = self.dice.within(2.0..8.0);
        let tilt = [0; 2].map(|_| self.dice.within(-1.0..1.0));
        let at = |x: f64, z: f64| [center[0] + x, center[1] + tilt[0] * x + tilt[1] * z, center[2] + z];
        self.quad([at(-half, -half), at(-half, half), at(half, half), at(half, -half)]);
        let size = [0.2..3.0, 0.5..8.0, 0.2..3.0].map(|range| self.dice.within(range));
        let sunk = self.dice.unit();
        self.cuboid([center[0], center[1] - sunk * size[1], center[2]], size);
    }
}
