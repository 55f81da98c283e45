//! A small scene of simple shapes: one of each, rotated and scaled by the seed.

use std::f64::consts::PI;

use crate::generate::shapes::MeshBuilder;
use crate::generate::{Mesh, Placement, SINK, Scene, Stage};
use crate::random::Random;

pub(super) fn generate(seed: u64) -> Scene {
    let mut random = Random::new(seed, 2);
    let mut stage = Stage::default();
    let edge = stage.material("board edge", 0x6B665E);
    let tops = [stage.material("board light", 0xCFCBC0), stage.material("board dark", 0xB3AFA5)];
    let mut board = MeshBuilder::new("ground", edge);
    board.board(24.0, 0.5, 12, tops);
    stage.mesh_in_place(board.finish());

    let shapes = [
        shape(&mut stage, "box", 0xC44E44, |b| b.block([0.0, -SINK, 0.0], [2.4, 2.0, 2.4])),
        shape(&mut stage, "sphere", 0x4F86B8, |b| {
            b.ball(3, |d| [d[0] * 1.5, d[1] * 1.5 + 1.5 - SINK, d[2] * 1.5]);
        }),
        shape(&mut stage, "cylinder", 0x5FA86B, |b| {
            b.frustum([0.0; 2], [-SINK, 3.4], [1.0, 1.0], 48);
        }),
        shape(&mut stage, "cone", 0xD9A53F, |b| b.frustum([0.0; 2], [-SINK, 3.2], [1.5, 0.0], 48)),
        shape(&mut stage, "torus", 0x8C6BB1, |b| b.torus([0.0, 1.95 - SINK, 0.0], 1.4, 0.55, [48, 24])),
        shape(&mut stage, "pyramid", 0xD07F5A, |b| b.frustum([0.0; 2], [-SINK, 2.4], [2.0, 0.0], 4)),
        shape(&mut stage, "stair", 0x7C968A, |b| b.extrude(&stair(), -1.2, 1.2)),
        shape(&mut stage, "arch", 0xB8A084, |b| b.extrude(&arch(), -0.7, 0.7)),
    ];
    // The tall shapes are towards the back, each in its own cell of three by three; the middle cell stays
    // free.
    let cells = [[0, 2], [1, 2], [2, 0], [2, 1], [0, 1], [2, 2], [1, 0], [0, 0]];
    for ((name, mesh), [i, j]) in shapes.into_iter().zip(cells) {
        let mut along = |k: i32| f64::from(k - 1) * 7.0 + random.range(-0.8, 0.8);
        let (x, z) = (along(i), along(j));
        let yaw = random.range(-0.5, 0.5);
        let scale = random.range(0.9, 1.2);
        stage.place(mesh, name.to_owned(), Placement::at([x, 0.0, z]).turned(yaw).scaled(scale));
    }
    stage.finish()
}

fn shape(
    stage: &mut Stage,
    name: &'static str,
    srgb: u32,
    build: impl FnOnce(&mut MeshBuilder),
) -> (&'static str, u32) {
    let material = stage.material(name, srgb);
    let mut builder = MeshBuilder::new(name, material);
    build(&mut builder);
    let mesh: Mesh = builder.finish();
    (name, stage.mesh(mesh))
}

/// Profile of six steps up along +X.
fn stair() -> Vec<[f64; 2]> {
    let mut profile = vec![[-1.8, -SINK], [1.8, -SINK]];
    for step in (0..6).rev() {
        let (x, y) = (-1.8 + 0.6 * f64::from(step), 0.35 * f64::from(step + 1));
        profile.extend([[x + 0.6, y], [x, y]]);
    }
    profile
}

/// Profile of two feet with a round opening between them.
fn arch() -> Vec<[f64; 2]> {
    const SEGMENTS: u32 = 16;
    let mut profile = vec![[1.3, -SINK], [2.1, -SINK], [2.1, 3.5], [-2.1, 3.5], [-2.1, -SINK], [-1.3, -SINK]];
    for i in 0..=SEGMENTS {
        let angle = PI * (1.0 - f64::from(i) / f64::from(SEGMENTS));
        profile.push([1.3 * libm::cos(angle), 1.5 + 1.3 * libm::sin(angle)]);
    }
    profile
}
