//! A large low-poly landscape: a valley with a river, woods, rocks and a village, 400 m across.
//!
//! The terrain is one open mesh; everything on it is an instance of one of a few meshes made of closed parts.

use crate::generate::landscape_props::HOUSE_HALF;
use crate::generate::noise::{fractal_noise, smooth_step, value_noise};
use crate::generate::shapes::MeshBuilder;
use crate::generate::{Mesh, Placement, Scene, Stage, landscape_props as props};
use crate::random::Random;

/// Number of terrain cells along each side, and their side in metres, which is exact in `f32`.
const CELLS: usize = 128;
const CELL: f64 = 3.125;
const HALF: f64 = CELLS as f64 * CELL / 2.0;
/// Height of the water; the river bed is filled up to it.
const WATER: f64 = 0.0;

const TREES: usize = 1500;
const ROCKS: usize = 260;
const HOUSES: usize = 16;

pub(super) fn generate(seed: u64) -> Scene {
    let mut stage = Stage::default();
    let terrain = Terrain::new(seed);
    let mesh = terrain.mesh(&mut stage);
    stage.mesh_in_place(mesh);
    let houses = place_houses(&mut stage, &terrain, seed);
    place_trees(&mut stage, &terrain, seed, &houses);
    place_rocks(&mut stage, &terrain, seed, &houses);
    stage.finish()
}

/// Heights at the corners of the cells, row by row along x.
struct Terrain {
    seed: u64,
    heights: Vec<f64>,
}

impl Terrain {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed, 3);
        let bends = [random.angle(), random.angle()];
        let mut heights = Vec::with_capacity((CELLS + 1) * (CELLS + 1));
        for j in 0..=CELLS {
            for i in 0..=CELLS {
                let [x, z] = corner(i, j);
                heights.push(f64::from(height(seed, bends, x, z) as f32));
            }
        }
        Self { seed, heights }
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.heights[j * (CELLS + 1) + i]
    }

    /// Height of the terrain triangle at (x, z), and its slope there.
    fn surface(&self, x: f64, z: f64) -> (f64, f64) {
        let cell = |c: f64| (((c + HALF) / CELL) as usize).min(CELLS - 1);
        let (i, j) = (cell(x), cell(z));
        let [x0, z0] = corner(i, j);
        let (u, v) = ((x - x0) / CELL, (z - z0) / CELL);
        let [a, b, c, d] = [self.at(i, j), self.at(i + 1, j), self.at(i, j + 1), self.at(i + 1, j + 1)];
        // The cell is split along the diagonal from (0, 0) to (1, 1).
        let (du, dv) = if u > v { (b - a, d - b) } else { (d - c, c - a) };
        (a + u * du + v * dv, (du * du + dv * dv).sqrt() / CELL)
    }

    fn mesh(&self, stage: &mut Stage) -> Mesh {
        let water = stage.material("water", 0x4C84A0);
        let sand = stage.material("sand", 0xC8B484);
        let grass = [
            stage.material("meadow", 0x86A44E),
            stage.material("grass", 0x739447),
            stage.material("wood floor", 0x5E7F42),
        ];
        let rock = stage.material("rock face", 0x8B8780);
        let scree = stage.material("high ground", 0xA6A292);
        let mut builder = MeshBuilder::new("terrain", water);
        for j in 0..=CELLS {
            for i in 0..=CELLS {
                let [x, z] = corner(i, j);
                builder.vertex([x, self.at(i, j), z]);
            }
        }
        let index = |i: usize, j: usize| (j * (CELLS + 1) + i) as u32;
        for j in 0..CELLS {
            for i in 0..CELLS {
                for three in [[(i, j), (i + 1, j + 1), (i + 1, j)], [(i, j), (i, j + 1), (i + 1, j + 1)]] {
                    let heights = three.map(|(i, j)| self.at(i, j));
                    let low = heights[0].min(heights[1]).min(heights[2]);
                    let high = heights[0].max(heights[1]).max(heights[2]);
                    let middle = (heights[0] + heights[1] + heights[2]) / 3.0;
                    let [x, z] = corner(i, j);
                    let tint = fractal_noise(self.seed ^ 0x71, x / 45.0, z / 45.0, 3);
                    builder.paint(if high <= WATER {
                        water
                    } else if low < WATER + 0.7 {
                        sand
                    } else if high - low > CELL * 1.05 {
                        rock
                    } else if middle + 6.0 * tint > 46.0 {
                        scree
                    } else {
                        grass[if tint > 0.16 { 0 } else { usize::from(tint < -0.12) + 1 }]
                    });
                    let [a, b, c] = three.map(|(i, j)| index(i, j));
                    builder.triangle(a, b, c);
                }
            }
        }
        builder.finish()
    }
}

fn corner(i: usize, j: usize) -> [f64; 2] {
    [i as f64 * CELL - HALF, j as f64 * CELL - HALF]
}

/// Terrain height: hills that slope down to a winding river along Z.
fn height(seed: u64, bends: [f64; 2], x: f64, z: f64) -> f64 {
    let river = 38.0 * libm::sin(z * 0.0125 + bends[0]) + 16.0 * libm::sin(z * 0.031 + bends[1]);
    let width = 8.0 + 5.0 * value_noise(seed ^ 0x33, z / 60.0, 0.5);
    let distance = (x - river).abs() - width;
    let hills = fractal_noise(seed, x / 110.0, z / 110.0, 5);
    let slope = smooth_step(18.0, 150.0, distance);
    let meadow = 1.0 + 0.035 * distance.max(0.0) + 0.8 * value_noise(seed ^ 0x55, x / 22.0, z / 22.0);
    let bank = -2.5 + smooth_step(-3.0, 9.0, distance) * (2.5 + meadow);
    (bank + slope * (22.0 + 34.0 * hills)).max(WATER)
}

/// A random point on the terrain, away from its rim.
fn somewhere(random: &mut Random) -> [f64; 2] {
    [random.range(8.0 - HALF, HALF - 8.0), random.range(8.0 - HALF, HALF - 8.0)]
}

fn near(points: &[[f64; 2]], [x, z]: [f64; 2], distance: f64) -> bool {
    points.iter().any(|p| (p[0] - x) * (p[0] - x) + (p[1] - z) * (p[1] - z) < distance * distance)
}

/// Places a village on flat ground; returns the positions of the houses.
fn place_houses(stage: &mut Stage, terrain: &Terrain, seed: u64) -> Vec<[f64; 2]> {
    let mut random = Random::new(seed, 4);
    let meshes = props::houses(stage);
    let buildable = |[x, z]: [f64; 2]| {
        let heights = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [0.0, 0.0]]
            .map(|[u, v]| terrain.surface(x + u * HOUSE_HALF, z + v * HOUSE_HALF).0);
        let low = heights.iter().fold(f64::INFINITY, |m, &h| m.min(h));
        let high = heights.iter().fold(f64::NEG_INFINITY, |m, &h| m.max(h));
        (low > WATER + 1.0 && high - low < 2.2).then_some(high)
    };
    let mut centre = [0.0, 0.0];
    for _ in 0..400 {
        centre = [random.range(-120.0, 120.0), random.range(-120.0, 120.0)];
        if buildable(centre).is_some() {
            break;
        }
    }
    let mut houses: Vec<[f64; 2]> = Vec::new();
    for _ in 0..6000 {
        if houses.len() == HOUSES {
            break;
        }
        let (reach, angle) = (random.range(0.0, 85.0), random.angle());
        let at = [centre[0] + reach * libm::cos(angle), centre[1] + reach * libm::sin(angle)];
        let (yaw, mesh, scale) = (random.angle(), random.pick(&meshes), random.range(0.9, 1.15));
        if at.iter().any(|c| c.abs() > HALF - 15.0) || near(&houses, at, 17.0) {
            continue;
        }
        if let Some(y) = buildable(at) {
            let place = Placement::at([at[0], y - 0.1, at[1]]).turned(yaw).scaled(scale);
            stage.place(mesh, format!("house {}", houses.len() + 1), place);
            houses.push(at);
        }
    }
    houses
}

fn place_trees(stage: &mut Stage, terrain: &Terrain, seed: u64, houses: &[[f64; 2]]) {
    let mut random = Random::new(seed, 5);
    let (conifers, round) = (props::conifers(stage), props::round_trees(stage));
    let mut placed = 0;
    for _ in 0..TREES * 12 {
        if placed == TREES {
            break;
        }
        let at = somewhere(&mut random);
        let (yaw, scale, lot) = (random.angle(), random.range(0.65, 1.35), random.unit());
        let wood = fractal_noise(seed ^ 0x99, at[0] / 60.0, at[1] / 60.0, 3);
        let (y, slope) = terrain.surface(at[0], at[1]);
        let grows = y > WATER + 1.2 && slope < 0.9 && y < 62.0;
        if !grows || lot > smooth_step(-0.25, 0.35, wood).max(0.03) || near(houses, at, 9.0) {
            continue;
        }
        let mesh = if random.chance(smooth_step(4.0, 22.0, y)) {
            random.pick(&conifers)
        } else {
            random.pick(&round)
        };
        let place = Placement::at([at[0], y, at[1]]).turned(yaw).scaled(scale);
        placed += 1;
        stage.place(mesh, format!("tree {placed}"), place);
    }
}

fn place_rocks(stage: &mut Stage, terrain: &Terrain, seed: u64, houses: &[[f64; 2]]) {
    let mut random = Random::new(seed, 6);
    let rocks = props::rocks(stage, seed);
    let mut placed = 0;
    for _ in 0..ROCKS * 12 {
        if placed == ROCKS {
            break;
        }
        let at = somewhere(&mut random);
        let (y, slope) = terrain.surface(at[0], at[1]);
        // Many small rocks and few large ones; more of them on steep ground or near the water.
        let size = random.unit();
        let radius = 0.4 + 2.2 * size * size * size;
        let wanted = if slope > 0.55 || y < WATER + 1.5 { 0.9 } else { 0.12 };
        if !random.chance(wanted) || near(houses, at, 10.0) {
            continue;
        }
        let mut place = Placement::at([at[0], y - 0.25 * radius, at[1]]).turned(random.angle());
        place.scale = [radius, radius * random.range(0.6, 1.0), radius * random.range(0.7, 1.0)];
        placed += 1;
        stage.place(random.pick(&rocks), format!("rock {placed}"), place);
    }
}
