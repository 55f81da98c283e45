//! The objects of the landscape: trees, rocks and houses, each made of closed parts that reach into the
//! ground.

use crate::generate::shapes::MeshBuilder;
use crate::generate::{SINK, Stage};
use crate::random::Random;

/// Half the longer side of a house including its roof, metres.
pub(super) const HOUSE_HALF: f64 = 5.6;

/// Height of the lower end of trunks, metres: below ground, because trees are on slopes.
const ROOT: f64 = -0.8;

/// Conifers: a trunk and stacked cones.
pub(super) fn conifers(stage: &mut Stage) -> Vec<u32> {
    let bark = stage.material("bark", 0x6B503A);
    let needles = [stage.material("spruce", 0x355E3F), stage.material("fir", 0x416D45)];
    [(needles[0], 3, 9.0, 2.1), (needles[1], 2, 7.0, 2.4)]
        .into_iter()
        .map(|(green, cones, height, radius)| {
            let mut b = MeshBuilder::new(format!("conifer of {cones} cones"), bark);
            b.frustum([0.0; 2], [ROOT, height * 0.35], [0.28, 0.2], 6);
            b.paint(green);
            let step = (height - 1.4) / (f64::from(cones) + 0.6);
            for i in 0..cones {
                let low = 1.4 + step * f64::from(i);
                let width = radius * (1.0 - 0.26 * f64::from(i));
                b.frustum([0.0; 2], [low, low + 1.6 * step], [width, 0.0], 8);
            }
            stage.mesh(b.finish())
        })
        .collect()
}

/// Broad-leaved trees: a trunk and irregular balls.
pub(super) fn round_trees(stage: &mut Stage) -> Vec<u32> {
    let bark = stage.material("light bark", 0x7A624B);
    let greens = [0x6A933F, 0x88A045, 0x57864A].map(|c| stage.material("leaves", c));
    // For each ball: its centre, then its horizontal and vertical radii.
    let crowns: [&[[f64; 5]]; 3] = [
        &[[0.0, 4.4, 0.0, 2.1, 2.3]],
        &[[0.3, 3.9, 0.0, 1.9, 1.6], [-0.7, 5.3, 0.4, 1.5, 1.4]],
        &[[0.0, 5.2, 0.0, 1.5, 2.9]],
    ];
    crowns
        .iter()
        .zip(greens)
        .enumerate()
        .map(|(kind, (crown, green))| {
            let mut random = Random::new(kind as u64, 7);
            let mut b = MeshBuilder::new(format!("round tree {}", kind + 1), bark);
            b.frustum([0.0; 2], [ROOT, 3.6], [0.3, 0.2], 6);
            b.paint(green);
            for &[x, y, z, wide, tall] in *crown {
                b.ball(1, |d| {
                    let r = random.range(0.86, 1.1);
                    [x + d[0] * wide * r, y + d[1] * tall * r, z + d[2] * wide * r]
                });
            }
            stage.mesh(b.finish())
        })
        .collect()
}

/// Rocks of radius about 1: deformed icosahedra.
pub(super) fn rocks(stage: &mut Stage, seed: u64) -> Vec<u32> {
    let greys = [0x8E8A84, 0x7D7A77, 0x9A9387].map(|c| stage.material("stone", c));
    (0..3_u32)
        .zip(greys)
        .map(|(kind, grey)| {
            let mut random = Random::new(seed, 8 + u64::from(kind));
            let mut b = MeshBuilder::new(format!("rock {}", kind + 1), grey);
            b.ball(kind.min(1), |d| {
                let r = random.range(0.75, 1.1);
                d.map(|c| c * r)
            });
            stage.mesh(b.finish())
        })
        .collect()
}

/// Gabled houses, extended 3 m below ground so that they also fit on slopes.
pub(super) fn houses(stage: &mut Stage) -> Vec<u32> {
    let wood = stage.material("door", 0x6E4B35);
    let glass = stage.material("window", 0x4A5B66);
    let brick = stage.material("chimney", 0x8F5A48);
    let looks = [
        (0xE6DCC8, 0xA44F3C, 7.0, 9.0, 2.9),
        (0xD9C29C, 0x6B5A55, 6.0, 8.0, 3.6),
        (0xEEEAE0, 0x8C3F35, 6.4, 7.6, 5.2),
    ];
    looks
        .into_iter()
        .enumerate()
        .map(|(kind, (wall, tile, width, length, eaves))| {
            let plaster = stage.material("plaster", wall);
            let tiles = stage.material("roof", tile);
            let (w, l) = (width / 2.0, length / 2.0);
            let ridge = eaves + 0.8 * w;
            let mut b = MeshBuilder::new(format!("house {}", kind + 1), plaster);
            b.extrude(&[[-w, -3.0], [w, -3.0], [w, eaves], [0.0, ridge], [-w, eaves]], -l, l);
            // The roof's underside is slightly inside the gable, and the eaves project by half a metre.
            let (out, thick) = (w + 0.5, 0.25);
            let edge = eaves - 0.8 * 0.5 - SINK;
            let roof = [
                [-out, edge],
                [0.0, ridge - SINK],
                [out, edge],
                [out, edge + thick],
                [0.0, ridge - SINK + thick],
                [-out, edge + thick],
            ];
            b.paint(tiles).extrude(&roof, -l - 0.5, l + 0.5);
            b.paint(brick).block([w * 0.4, eaves, l * 0.45], [0.8, 0.8 * w + 0.7, 0.8]);
            b.paint(wood).block([0.0, -0.4, l], [1.1, 2.5, 0.12]);
            b.paint(glass);
            for storey in 0..if eaves > 4.5 { 2 } else { 1 } {
                let sill = 1.0 + 2.6 * f64::from(storey);
                for side in [-1.0, 1.0] {
                    for along in [-0.5, 0.5] {
                        b.block([side * w, sill, along * l], [0.1, 1.2, 1.1]);
                    }
                    b.block([side * w * 0.6, sill, l], [0.9, 1.2, 0.1]);
                    b.block([side * w * 0.45, sill, -l], [0.9, 1.2, 0.1]);
                }
            }
            stage.mesh(b.finish())
        })
        .collect()
}
