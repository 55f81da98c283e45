//! A pavilion of thin rods with railings, braces, a net and a slack cable: casters as thin as a shadow map's
//! texels, as in Figure 5 of Li, Yang, Zhao and Chen, *Hybrid-resolution shadow map*, 2016.

use std::f64::consts::TAU;

use crate::generate::shapes::MeshBuilder;
use crate::generate::{Scene, Stage};
use crate::random::Random;

/// Number of posts, on a circle. The bay before the first post and the bay opposite it are doors.
const POSTS: usize = 8;
/// Radius of that circle, metres.
const RADIUS: f64 = 3.0;
const EAVES: f64 = 3.2;
const APEX: [f64; 3] = [0.0, 4.4, 0.0];
/// The net's extent along X (start, end), the heights of its lowest and highest wires, and its z, metres.
const NET: [f64; 5] = [-3.4, 3.4, 0.1, 1.3, 3.9];
/// Spacing of the net's wires along X, metres.
const MESH_WIDTH: f64 = 0.1;
/// Position of the foot of the mast that holds the cable: x and z, metres.
const MAST: [f64; 2] = [-3.6, -3.6];

pub(super) fn generate(seed: u64) -> Scene {
    let mut random = Random::new(seed, 32);
    let mut stage = Stage::default();
    let builders = [
        frame(stage.material("frame", 0x4A5560)),
        railing(stage.material("railing", 0x3B6F5C), &mut random),
        wires(stage.material("wire", 0x8A3F32), &mut random),
        net(stage.material("net", 0x5E5A52)),
    ];
    for builder in builders {
        stage.mesh_in_place(builder.finish());
    }
    stage.finish()
}

/// A point at height `y` on the post circle, its radius scaled by `share`. A fractional `post` interpolates
/// to the next post.
fn on_circle(post: f64, y: f64, share: f64) -> [f64; 3] {
    let corner = |k: f64| {
        let angle = TAU * (k + 0.5) / POSTS as f64;
        [RADIUS * share * libm::cos(angle), RADIUS * share * libm::sin(angle)]
    };
    let (a, b, t) = (corner(post.floor()), corner(post.floor() + 1.0), post - post.floor());
    [a[0] + (b[0] - a[0]) * t, y, a[1] + (b[1] - a[1]) * t]
}

fn frame(material: u32) -> MeshBuilder {
    let mut b = MeshBuilder::new("frame", material);
    let halfway = (EAVES + APEX[1]) / 2.0;
    for k in 0..POSTS {
        let (here, next) = (k as f64, (k + 1) as f64);
        b.rod(on_circle(here, 0.0, 1.0), on_circle(here, EAVES, 1.0), 0.04, 8);
        b.rod(on_circle(here, EAVES, 1.0), on_circle(next, EAVES, 1.0), 0.025, 6);
        b.rod(on_circle(here, EAVES, 1.0), APEX, 0.02, 6);
        b.rod(on_circle(here, halfway, 0.5), on_circle(next, halfway, 0.5), 0.012, 6);
    }
    b.rod(APEX, [0.0, 5.0, 0.0], 0.012, 6);
    b.rod([MAST[0], 0.0, MAST[1]], [MAST[0], 3.6, MAST[1]], 0.035, 8);
    b
}

/// The bays that are not doors, identified by their first posts.
fn bays() -> impl Iterator<Item = f64> {
    (0..POSTS).filter(|k| (k + 1) % (POSTS / 2) != 0).map(|k| k as f64)
}

fn railing(material: u32, random: &mut Random) -> MeshBuilder {
    const BALUSTERS: u32 = 20;
    let mut b = MeshBuilder::new("railing", material);
    for k in bays() {
        for (y, radius) in [(0.1, 0.012), (0.95, 0.018)] {
            b.rod(on_circle(k, y, 1.0), on_circle(k + 1.0, y, 1.0), radius, 6);
        }
        for i in 1..BALUSTERS {
            let share = f64::from(i) / f64::from(BALUSTERS);
            let lean = random.range(-0.006, 0.006);
            b.rod(on_circle(k + share, 0.1, 1.0), on_circle(k + share + lean, 0.95, 1.0), 0.012, 6);
        }
    }
    b
}

/// Crossed braces above the railing, and a cable from the mast to the roof.
fn wires(material: u32, random: &mut Random) -> MeshBuilder {
    const SEGMENTS: u32 = 16;
    let mut b = MeshBuilder::new("wires", material);
    for k in bays() {
        for [foot, head] in [[k, k + 1.0], [k + 1.0, k]] {
            let (low, high) = (random.range(0.95, 1.15), random.range(2.95, 3.15));
            b.rod(on_circle(foot, low, 1.0), on_circle(head, high, 1.0), 0.008, 5);
        }
    }
    let sag = random.range(0.3, 0.9);
    let cable = |i: u32| {
        let t = f64::from(i) / f64::from(SEGMENTS);
        let y = 3.55 + (APEX[1] - 3.55) * t - 4.0 * sag * t * (1.0 - t);
        [MAST[0] * (1.0 - t), y, MAST[1] * (1.0 - t)]
    };
    for i in 0..SEGMENTS {
        b.rod(cable(i), cable(i + 1), 0.008, 5);
    }
    b
}

/// A net of wires in both directions at 45 degrees, between stakes.
fn net(material: u32) -> MeshBuilder {
    let [left, right, low, high, z] = NET;
    let mut b = MeshBuilder::new("net", material);
    for i in 0..=4 {
        let x = left + (right - left) * f64::from(i) / 4.0;
        b.rod([x, 0.0, z], [x, high + 0.1, z], 0.025, 6);
    }
    b.rod([left, high, z], [right, high, z], 0.008, 5);
    let (width, height) = (right - left, high - low);
    let columns = (width / MESH_WIDTH) as i32;
    for i in -((height / MESH_WIDTH) as i32)..columns {
        let along = MESH_WIDTH * f64::from(i);
        let (from, to) = ((-along).max(0.0), height.min(width - along));
        if to - from > MESH_WIDTH / 2.0 {
            for (start, way) in [(left, 1.0), (right, -1.0)] {
                let at = |t: f64| [start + way * (along + t), low + t, z];
                b.rod(at(from), at(to), 0.006, 4);
            }
        }
    }
    b
}
