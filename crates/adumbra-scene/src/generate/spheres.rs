//! The sphere field: spheres of many sizes on and above a square board, all instances of one mesh.

use crate::generate::shapes::MeshBuilder;
use crate::generate::{Placement, SINK, Scene, Stage};
use crate::random::Random;

/// Number of spheres along each side.
const COUNT: u32 = 15;
/// Spacing of the spheres, metres.
const PITCH: f64 = 4.0;

pub(super) fn generate(seed: u64) -> Scene {
    let mut random = Random::new(seed, 1);
    let mut stage = Stage::default();
    let edge = stage.material("board edge", 0x6F6A62);
    let tops = [stage.material("board light", 0xC9C3B5), stage.material("board dark", 0xA8A69C)];
    let orange = stage.material("sphere", 0xE29A5B);

    let mut board = MeshBuilder::new("ground", edge);
    board.board(f64::from(COUNT + 1) * PITCH, 1.0, COUNT + 1, tops);
    stage.mesh_in_place(board.finish());

    let mut sphere = MeshBuilder::new("sphere", orange);
    sphere.ball(3, |d| d);
    let sphere = stage.mesh(sphere.finish());

    for i in 0..COUNT {
        for j in 0..COUNT {
            let radius = random.range(0.5, 1.6);
            let free = (PITCH / 2.0 - radius).max(0.0);
            let mut along =
                |k: u32| (f64::from(k) - f64::from(COUNT - 1) / 2.0) * PITCH + random.range(-free, free);
            let (x, z) = (along(i), along(j));
            let floating = if random.chance(0.4) { random.range(0.5, 7.0) } else { -SINK };
            let place = Placement::at([x, radius + floating, z]).turned(random.angle()).scaled(radius);
            stage.place(sphere, format!("sphere {i} {j}"), place);
        }
    }
    stage.finish()
}
