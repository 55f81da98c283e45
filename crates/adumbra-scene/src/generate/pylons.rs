//! A power line along a road: 2 km of thin things. Each pylon is a lattice of rods, and its cables, the lamp
//! posts and the wires of a fence are a few centimetres to a few millimetres thick.

use crate::generate::shapes::MeshBuilder;
use crate::generate::{Placement, Stage};
use crate::random::Random;
use crate::{Mesh, Scene};

/// Half the length of the line, metres.
const HALF_LENGTH: f64 = 1000.0;
/// Half the width of the field, metres.
const HALF_WIDTH: f64 = 600.0;
/// Distance between pylons, metres.
const SPAN: f64 = 100.0;
/// Place of the pylons, the road, the lamp posts and the fence across the line, metres.
const PYLON_Z: f64 = 22.0;
const ROAD_Z: f64 = -8.0;
const LAMP_Z: f64 = -13.0;
const FENCE_Z: f64 = -18.0;
/// Height of a pylon, and its half width at the foot and at the top, metres.
const PYLON: [f64; 3] = [30.0, 2.6, 0.4];
/// Heights and half lengths of a pylon's arms, metres.
const ARMS: [[f64; 2]; 3] = [[19.0, 4.5], [23.5, 5.5], [28.0, 4.0]];
/// Length of a piece of fence, and the distance between lamp posts, metres.
const FENCE: f64 = 20.0;
const LAMPS: f64 = 40.0;

pub(super) fn generate(seed: u64) -> Scene {
    let mut random = Random::new(seed, 33);
    let mut stage = Stage::default();
    let ground = ground(stage.material("stubble", 0xD2C49A), stage.material("asphalt", 0x8C8C8E));
    stage.mesh_in_place(ground);
    let steel = stage.material("steel", 0x8C9196);
    let cable = stage.material("cable", 0x3A3D40);
    let wood = stage.material("wood", 0x7A6248);
    let pylon = stage.mesh(pylon(steel));
    let cables = stage.mesh(cables(cable, random.range(2.0, 3.0)));
    let lamp = stage.mesh(lamp(steel));
    let fence = stage.mesh(fence(wood, steel));
    let along = |step: f64| {
        let count = (2.0 * HALF_LENGTH / step) as u32;
        (0..count).map(move |i| (i, -HALF_LENGTH + step * f64::from(i)))
    };
    for (i, x) in along(SPAN) {
        stage.place(pylon, format!("pylon {i}"), Placement::at([x, 0.0, PYLON_Z]));
        stage.place(cables, format!("cables {i}"), Placement::at([x, 0.0, PYLON_Z]));
    }
    stage.place(pylon, "last pylon".to_owned(), Placement::at([HALF_LENGTH, 0.0, PYLON_Z]));
    for (i, x) in along(LAMPS) {
        let x = x + random.range(-1.0, 1.0);
        stage.place(lamp, format!("lamp {i}"), Placement::at([x, 0.0, LAMP_Z]));
    }
    for (i, x) in along(FENCE) {
        stage.place(fence, format!("fence {i}"), Placement::at([x, 0.0, FENCE_Z]));
    }
    stage.finish()
}

fn ground(stubble: u32, asphalt: u32) -> Mesh {
    let end = HALF_LENGTH + 20.0;
    let mut b = MeshBuilder::new("ground", stubble);
    b.cuboid([-end, -1.0, -HALF_WIDTH], [end, 0.0, HALF_WIDTH]);
    b.paint(asphalt).cuboid([-end, -0.5, ROAD_Z - 3.5], [end, 0.05, ROAD_Z + 3.5]);
    b.finish()
}

/// A lattice tower at the origin, with arms across the line.
fn pylon(steel: u32) -> Mesh {
    const STOREYS: u32 = 9;
    let [height, foot, top] = PYLON;
    let corner = |storey: u32, k: usize| {
        let t = f64::from(storey) / f64::from(STOREYS);
        let half = foot + (top - foot) * t;
        let [x, z] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]][k % 4];
        [x * half, height * t - 0.1, z * half]
    };
    let mut b = MeshBuilder::new("pylon", steel);
    for storey in 0..STOREYS {
        for k in 0..4 {
            b.rod(corner(storey, k), corner(storey + 1, k), 0.09, 5);
            b.rod(corner(storey, k), corner(storey + 1, k + 1), 0.04, 4);
            b.rod(corner(storey, k + 1), corner(storey + 1, k), 0.04, 4);
            b.rod(corner(storey + 1, k), corner(storey + 1, k + 1), 0.04, 4);
        }
    }
    for [y, half] in ARMS {
        for side in [-1.0, 1.0] {
            let tip = [0.0, y, side * half];
            for x in [-0.5, 0.5] {
                b.rod([x, y, 0.0], tip, 0.06, 4);
                b.rod([x, y + 1.4, 0.0], tip, 0.05, 4);
            }
            b.rod(tip, [0.0, y - 1.2, side * half], 0.08, 6);
        }
    }
    b.finish()
}

/// The cables from one pylon to the next: six that hang from arms, and one between the tops.
fn cables(material: u32, sag: f64) -> Mesh {
    const PIECES: u32 = 24;
    let mut b = MeshBuilder::new("cables", material);
    let sides = ARMS.into_iter().flat_map(|[y, half]| [[y - 1.2, half], [y - 1.2, -half]]);
    for [y, z] in sides.chain([[PYLON[0] - 0.1, 0.0]]) {
        let at = |i: u32| {
            let t = f64::from(i) / f64::from(PIECES);
            [SPAN * t, y - 4.0 * sag * t * (1.0 - t), z]
        };
        for i in 0..PIECES {
            b.rod(at(i), at(i + 1), 0.025, 5);
        }
    }
    b.finish()
}

fn lamp(steel: u32) -> Mesh {
    let mut b = MeshBuilder::new("lamp", steel);
    b.rod([0.0, -0.1, 0.0], [0.0, 7.0, 0.0], 0.07, 8);
    b.rod([0.0, 6.9, 0.0], [0.0, 7.6, 2.4], 0.04, 6);
    b.block([0.0, 7.5, 2.6], [0.25, 0.12, 0.7]);
    b.finish()
}

/// A piece of fence from the origin along X: posts, and wires between them.
fn fence(wood: u32, steel: u32) -> Mesh {
    const POSTS: u32 = 5;
    let mut b = MeshBuilder::new("fence", wood);
    for i in 0..POSTS {
        let x = FENCE * f64::from(i) / f64::from(POSTS);
        b.rod([x, -0.1, 0.0], [x, 1.3, 0.0], 0.05, 6);
    }
    b.paint(steel);
    for wire in 1..=4 {
        let y = 0.3 * f64::from(wire);
        b.rod([0.0, y, 0.0], [FENCE, y, 0.0], 0.006, 4);
    }
    b.finish()
}
