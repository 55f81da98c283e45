//! A power line along a road: 2 km of thin things. The rods of a pylon are 8 to 18 cm thick, lamp posts
//! 14 cm, cables 5 cm and the wires of a fence 12 mm.

use crate::generate::shapes::MeshBuilder;
use crate::generate::{Placement, SINK, Stage};
use crate::random::Random;
use crate::{Mesh, Scene};

/// Half the length of the line, metres.
const HALF_LENGTH: f64 = 1000.0;
/// Half the width of the field, metres.
const HALF_WIDTH: f64 = 600.0;
/// Distance between pylons, metres.
const SPAN: f64 = 100.0;
// Places across the line, metres.
const PYLON_Z: f64 = 22.0;
const ROAD_Z: f64 = -8.0;
const LAMP_Z: f64 = -13.0;
const FENCE_Z: f64 = -18.0;
/// Height of a pylon, and its half width at the foot and at the top, metres.
const PYLON: [f64; 3] = [30.0, 2.6, 0.4];
/// Heights and half lengths of a pylon's arms, metres.
const ARMS: [[f64; 2]; 3] = [[19.0, 4.5], [23.5, 5.5], [28.0, 4.0]];
/// Height of an arm where it meets the tower, and length of the insulator at its tip, metres.
const ARM_HEIGHT: f64 = 1.4;
const INSULATOR: f64 = 1.2;
/// Length of a piece of fence, metres.
const FENCE: f64 = 20.0;
/// Distance between lamp posts, metres.
const LAMPS: f64 = 40.0;

pub(super) fn generate(seed: u64) -> Scene {
    let mut random = Random::new(seed, 34);
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
    let end_post = stage.mesh(end_post(wood));
    let along = |step: f64| {
        let count = (2.0 * HALF_LENGTH / step) as u32;
        (0..count).map(move |i| (i, -HALF_LENGTH + step * f64::from(i)))
    };
    for (i, x) in along(SPAN) {
        stage.place(pylon, format!("pylon {i}"), Placement::at([x, 0.0, PYLON_Z]));
        stage.place(cables, format!("cables {i}"), Placement::at([x, 0.0, PYLON_Z]));
    }
    stage.place(pylon, "end pylon".to_owned(), Placement::at([HALF_LENGTH, 0.0, PYLON_Z]));
    for (i, x) in along(LAMPS) {
        let x = x + random.range(-1.0, 1.0);
        stage.place(lamp, format!("lamp {i}"), Placement::at([x, 0.0, LAMP_Z]));
    }
    for (i, x) in along(FENCE) {
        stage.place(fence, format!("fence {i}"), Placement::at([x, 0.0, FENCE_Z]));
    }
    stage.place(end_post, "end post".to_owned(), Placement::at([HALF_LENGTH, 0.0, FENCE_Z]));
    stage.finish()
}

fn ground(stubble: u32, asphalt: u32) -> Mesh {
    let end = HALF_LENGTH + 20.0;
    let mut b = MeshBuilder::new("ground", stubble);
    b.cuboid([-end, -1.0, -HALF_WIDTH], [end, 0.0, HALF_WIDTH]);
    b.paint(asphalt).cuboid([-HALF_LENGTH, -SINK, ROAD_Z - 3.5], [HALF_LENGTH, 0.05, ROAD_Z + 3.5]);
    b.finish()
}

/// Half the width of a pylon at a height.
fn half_width(y: f64) -> f64 {
    let [height, foot, top] = PYLON;
    foot + (top - foot) * y / height
}

/// A lattice tower at the origin, with arms across the line.
fn pylon(steel: u32) -> Mesh {
    const STOREYS: u32 = 9;
    let corner = |storey: u32, k: usize| {
        let y = PYLON[0] * f64::from(storey) / f64::from(STOREYS);
        let half = half_width(y);
        let [x, z] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]][k % 4];
        [x * half, y - SINK, z * half]
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
            for (y, radius) in [(y, 0.06), (y + ARM_HEIGHT, 0.05)] {
                // The legs are sunk, so that they are as wide as this a little lower.
                let leg = half_width(y + SINK);
                for x in [-leg, leg] {
                    b.rod([x, y, side * leg], tip, radius, 4);
                }
            }
            b.rod(tip, [0.0, y - INSULATOR, side * half], 0.08, 6);
        }
    }
    b.finish()
}

/// The cables from one pylon to the next: six that hang from arms, and one between the tops.
fn cables(material: u32, sag: f64) -> Mesh {
    const PIECES: u32 = 24;
    let mut b = MeshBuilder::new("cables", material);
    let sides = ARMS.into_iter().flat_map(|[y, half]| [[y - INSULATOR, half], [y - INSULATOR, -half]]);
    for [y, z] in sides.chain([[PYLON[0] - SINK, 0.0]]) {
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
    b.rod([0.0, -SINK, 0.0], [0.0, 7.0, 0.0], 0.07, 8);
    b.rod([0.0, 6.9, 0.0], [0.0, 7.56, 2.4], 0.04, 6);
    b.block([0.0, 7.5, 2.6], [0.25, 0.12, 0.7]);
    b.finish()
}

/// A piece of fence from the origin along X: posts, and wires between them.
fn fence(wood: u32, steel: u32) -> Mesh {
    const POSTS: u32 = 5;
    let mut b = MeshBuilder::new("fence", wood);
    for i in 0..POSTS {
        post(&mut b, FENCE * f64::from(i) / f64::from(POSTS));
    }
    b.paint(steel);
    for wire in 1..=4 {
        let y = 0.3 * f64::from(wire);
        b.rod([0.0, y, 0.0], [FENCE, y, 0.0], 0.006, 4);
    }
    b.finish()
}

fn end_post(wood: u32) -> Mesh {
    let mut b = MeshBuilder::new("end post", wood);
    post(&mut b, 0.0);
    b.finish()
}

fn post(b: &mut MeshBuilder, x: f64) {
    b.rod([x, -SINK, 0.0], [x, 1.3, 0.0], 0.05, 6);
}
