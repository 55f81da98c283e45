//! Street objects: lamps, benches, bins, trees made of boxes, parked cars. Each is one mesh, instanced.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::generate::city_measures::{BLOCK_HALF, PAVEMENT};
use crate::generate::shapes::MeshBuilder;
use crate::generate::{Placement, SINK, Stage};
use crate::random::Random;

/// The meshes of the street objects.
pub(super) struct Furniture {
    lamp: u32,
    bench: u32,
    bin: u32,
    trees: Vec<u32>,
    cars: Vec<u32>,
}

impl Furniture {
    pub(super) fn new(stage: &mut Stage) -> Self {
        let iron = stage.material("iron", 0x484D50);
        let light = stage.material("lamp glass", 0xF2E6C4);
        let slats = stage.material("slats", 0x8F6A45);
        let bark = stage.material("bark", 0x6E5540);
        let mut b = MeshBuilder::new("lamp post", iron);
        b.block([0.0, -SINK, 0.0], [0.3, 0.45, 0.3]);
        b.block([0.0, 0.3, 0.0], [0.13, 5.3, 0.13]);
        b.block([0.0, 5.45, 0.7], [0.1, 0.1, 1.6]);
        b.paint(light).block([0.0, 5.36, 1.25], [0.3, 0.14, 0.6]);
        let lamp = stage.mesh(b.finish());

        let mut b = MeshBuilder::new("bench", iron);
        for x in [-0.75, 0.75] {
            b.block([x, -SINK, 0.0], [0.08, 0.45 + SINK, 0.45]);
            b.block([x, 0.4, -0.22], [0.08, 0.5, 0.08]);
        }
        b.paint(slats).block([0.0, 0.42, 0.0], [1.9, 0.07, 0.5]);
        b.block([0.0, 0.6, -0.2], [1.9, 0.28, 0.06]);
        let bench = stage.mesh(b.finish());

        let mut b = MeshBuilder::new("bin", iron);
        b.frustum([0.0; 2], [-SINK, 0.85], [0.24, 0.3], 8);
        let bin = stage.mesh(b.finish());

        let trees = [0x6F9745, 0x5C884A, 0x88A24C]
            .into_iter()
            .enumerate()
            .map(|(kind, green)| {
                let leaves = stage.material("leaves", green);
                let tall = 1.0 + 0.25 * kind as f64;
                let mut b = MeshBuilder::new(format!("tree {}", kind + 1), bark);
                b.block([0.0, -SINK, 0.0], [0.3, 2.7, 0.3]);
                b.paint(leaves).block([0.0, 2.3, 0.0], [2.3, 1.7 * tall, 2.1]);
                b.block([0.35, 3.0, -0.2], [1.9, 1.9 * tall, 1.8]);
                b.block([-0.3, 2.8, 0.45], [1.8, 1.4 * tall, 1.9]);
                stage.mesh(b.finish())
            })
            .collect();

        let glass = stage.material("car glass", 0x3C4850);
        let tyre = stage.material("tyre", 0x2E2E30);
        let cars = [("red", 0xA83A32), ("blue", 0x3F638E), ("white", 0xDADAD6), ("green", 0x5B735C)]
            .into_iter()
            .map(|(colour, srgb)| {
                let paint = stage.material("car paint", srgb);
                let mut b = MeshBuilder::new(format!("{colour} car"), paint);
                b.extrude(&CAR_BODY, -0.88, 0.88);
                b.paint(glass).extrude(&CAR_CABIN, -0.74, 0.74);
                b.paint(paint).block([-0.15, 1.38, 0.0], [1.7, 0.08, 1.42]);
                b.paint(tyre);
                for x in [-1.3, 1.3] {
                    for z in [-0.8, 0.8] {
                        let wheel: Vec<[f64; 2]> = (0..10)
                            .map(|i| {
                                let angle = TAU * (f64::from(i) + 0.5) / 10.0;
                                [x + 0.33 * libm::cos(angle), 0.3 + 0.33 * libm::sin(angle)]
                            })
                            .collect();
                        b.extrude(&wheel, z - 0.12, z + 0.12);
                    }
                }
                stage.mesh(b.finish())
            })
            .collect();
        Self { lamp, bench, bin, trees, cars }
    }
}

/// Side view, with the nose towards +X.
const CAR_BODY: [[f64; 2]; 7] =
    [[-2.1, 0.25], [2.1, 0.25], [2.15, 0.6], [1.95, 0.78], [0.95, 0.92], [-1.7, 0.95], [-2.15, 0.85]];
const CAR_CABIN: [[f64; 2]; 4] = [[-1.5, 0.88], [1.25, 0.85], [0.6, 1.4], [-1.05, 1.4]];

/// Places street objects along the four sides of a block.
pub(super) fn furnish(stage: &mut Stage, furniture: &Furniture, random: &mut Random, centre: [f64; 2]) {
    for side in 0..4_u8 {
        // `along` the kerb, `out` towards the street.
        let spot = |along: f64, out: f64, y: f64| {
            let (x, z) = match side {
                0 => (along, out),
                1 => (out, -along),
                2 => (-along, -out),
                _ => (-out, along),
            };
            Placement::at([centre[0] + x, y, centre[1] + z]).turned(FRAC_PI_2 * f64::from(side))
        };
        for along in [-24.0, -8.0, 8.0, 24.0] {
            stage.place(furniture.lamp, "lamp post".to_owned(), spot(along, BLOCK_HALF - 0.9, PAVEMENT));
        }
        for along in [-16.0, 0.0, 16.0] {
            if random.chance(0.75) {
                let tree = random.pick(&furniture.trees);
                let place = spot(along, BLOCK_HALF - 1.6, PAVEMENT).scaled(random.range(0.85, 1.2));
                stage.place(tree, "tree".to_owned(), place);
            }
            if random.chance(0.4) {
                stage.place(
                    furniture.bench,
                    "bench".to_owned(),
                    spot(along + 3.2, BLOCK_HALF - 1.5, PAVEMENT),
                );
                stage.place(furniture.bin, "bin".to_owned(), spot(along + 4.9, BLOCK_HALF - 1.5, PAVEMENT));
            }
        }
        for slot in -4..=4 {
            if random.chance(0.45) {
                let mut place = spot(f64::from(slot) * 5.8, BLOCK_HALF + 1.35, 0.0);
                if random.chance(0.2) {
                    place.yaw += 2.0 * FRAC_PI_2;
                }
                stage.place(random.pick(&furniture.cars), "car".to_owned(), place);
            }
        }
    }
}

/// Places the trees and benches of a park.
pub(super) fn plant(stage: &mut Stage, furniture: &Furniture, random: &mut Random, centre: [f64; 2]) {
    for i in -4..=4 {
        for j in -4..=4 {
            let [x, z] = [i, j].map(|k| f64::from(k) * 5.6 + random.range(-1.2, 1.2));
            let on_path = x.abs() < 2.8 || z.abs() < 2.8;
            if on_path || x * x + z * z < 120.0 || random.chance(0.3) {
                continue;
            }
            let place = Placement::at([centre[0] + x, PAVEMENT + 0.05, centre[1] + z]).turned(random.angle());
            stage.place(
                random.pick(&furniture.trees),
                "tree".to_owned(),
                place.scaled(random.range(0.9, 1.5)),
            );
        }
    }
    for along in [-20.0, -13.0, 13.0, 20.0] {
        let place = Placement::at([centre[0] + along, PAVEMENT + 0.06, centre[1] + 1.9]);
        stage.place(furniture.bench, "bench".to_owned(), place.turned(2.0 * FRAC_PI_2));
    }
}
