//! A room open towards +Z with a tall and a short block, after Goral, Torrance, Greenberg, Battaile,
//! *Modeling the Interaction of Light Between Diffuse Surfaces*, 1984, and the Cornell box as measured later.
//! Its sizes and positions are scaled up ten times (10 cm become 1 m), and it is seen from +Z. The walls are
//! thick, so that bakes and rays agree on what is inside them. The seed moves the blocks slightly.

use crate::generate::shapes::MeshBuilder;
use crate::generate::{Placement, SINK, Scene, Stage};
use crate::random::Random;

/// Half the room's width and depth, and its height, metres.
const HALF: f64 = 2.8;
const HEIGHT: f64 = 5.5;
const WALL: f64 = 0.2;
/// Horizontal side length of both blocks, metres.
const SIDE: f64 = 1.65;
/// Name, height, x and z of the centre, rotation about Y in radians.
const BLOCKS: [(&str, f64, [f64; 2], f64); 2] =
    [("tall block", 3.3, [-0.9, -0.72], 0.3), ("short block", 1.65, [0.93, 1.1], -0.29)];
/// Largest distance and angle by which the seed moves and rotates a block.
const STRAY: f64 = 0.05;

/// The corners of a box's faces, numbered as in [`MeshBuilder::cuboid`], without the open face: left, right,
/// floor, ceiling, back.
const SIDES: [[usize; 4]; 5] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1]];
/// The corners around the open face.
const RIM: [usize; 4] = [4, 5, 7, 6];

pub(super) fn generate(seed: u64) -> Scene {
    let mut random = Random::new(seed, 33);
    let mut stage = Stage::default();
    let outside = stage.material("outside", 0x8F8C86);
    let white = stage.material("white", 0xD9D5CB);
    let left = stage.material("left", 0xB2433B);
    let right = stage.material("right", 0x5A9A4E);

    let mut room = MeshBuilder::new("room", outside);
    let mut corners = |out: f64| -> [u32; 8] {
        std::array::from_fn(|i| {
            let end = |axis: usize, low: f64, high: f64| if i >> axis & 1 == 0 { low } else { high };
            room.vertex([
                end(0, -HALF - out, HALF + out),
                end(1, -out, HEIGHT + out),
                end(2, -HALF - out, HALF),
            ])
        })
    };
    let (outer, inner) = (corners(WALL), corners(0.0));
    for side in SIDES {
        room.quad(side.map(|i| outer[i]));
    }
    for k in 0..4 {
        let (a, b) = (RIM[k], RIM[(k + 1) % 4]);
        room.quad([outer[a], outer[b], inner[b], inner[a]]);
    }
    for (side, material) in SIDES.into_iter().zip([left, right, white, white, white]) {
        let [a, b, c, d] = side.map(|i| inner[i]);
        room.paint(material).quad([d, c, b, a]);
    }
    stage.mesh_in_place(room.finish());

    for (name, height, [x, z], yaw) in BLOCKS {
        let mut block = MeshBuilder::new(name, white);
        block.block([0.0, -SINK, 0.0], [SIDE, height + SINK, SIDE]);
        let mesh = stage.mesh(block.finish());
        let mut stray = || random.range(-STRAY, STRAY);
        let place = Placement::at([x + stray(), 0.0, z + stray()]).turned(yaw + stray());
        stage.place(mesh, name.to_owned(), place);
    }
    stage.finish()
}
