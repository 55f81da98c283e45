//! A city of closed boxes, 400 m across: blocks between streets, towers in the middle, parks, and objects on
//! the pavements.
//!
//! Each block is one mesh; objects in the streets are instanced.

use crate::generate::city_buildings::{Lot, Palette, Site};
use crate::generate::city_measures::{BLOCK_HALF, PAVEMENT};
use crate::generate::city_street::{Furniture, furnish, plant};
use crate::generate::shapes::MeshBuilder;
use crate::generate::{SINK, Scene, Stage};
use crate::random::Random;

/// Number of blocks along each side, and their spacing in metres.
const BLOCKS: i32 = 5;
const PITCH: f64 = 80.0;
/// Half the side of a block's built-up area, metres.
const BUILT_HALF: f64 = 27.0;

pub(super) fn generate(seed: u64) -> Scene {
    let mut stage = Stage::default();
    let asphalt = stage.material("asphalt", 0x626468);
    let kerb = stage.material("kerb", 0xA9A69F);
    let pavement = stage.material("pavement", 0xBDB8AE);
    let lawn = stage.material("lawn", 0x7D9F52);
    let path = stage.material("path", 0xCDBD98);
    let water = stage.material("pond", 0x5B8FA6);
    let palette = Palette::new(&mut stage);
    let furniture = Furniture::new(&mut stage);

    let side = PITCH * f64::from(BLOCKS);
    let mut ground = MeshBuilder::new("ground", asphalt);
    ground.block([0.0, -1.0, 0.0], [side, 1.0, side]);
    stage.mesh_in_place(ground.finish());

    let mut random = Random::new(seed, 20);
    let parks = [random.below(9), 9 + random.below(16)];
    for i in 0..BLOCKS {
        for j in 0..BLOCKS {
            let number = i * BLOCKS + j;
            let mut random = Random::new(seed, 100 + number as u64);
            let centre = [i, j].map(|k| f64::from(k - BLOCKS / 2) * PITCH);
            let name = format!("block {}-{}", i + 1, j + 1);
            let mut b = MeshBuilder::new(name, kerb);
            let [x, z] = centre;
            let (low, high) = (BLOCK_HALF, BLOCK_HALF - 0.3);
            b.ring([x - low, -SINK, z - low], [x + low, PAVEMENT + 0.02, z + low], 0.35);
            b.paint(pavement).cuboid([x - high, -SINK, z - high], [x + high, PAVEMENT, z + high]);
            if parks.contains(&(number as usize)) {
                b.paint(lawn).block([x, PAVEMENT - SINK, z], [52.0, SINK + 0.06, 52.0]);
                b.paint(path).block([x, PAVEMENT - SINK, z], [53.0, SINK + 0.09, 2.4]);
                b.block([x, PAVEMENT - SINK, z], [2.4, SINK + 0.11, 53.0]);
                b.paint(kerb).frustum([x, z], [PAVEMENT - SINK, PAVEMENT + 0.5], [8.0, 8.0], 24);
                b.paint(water).frustum([x, z], [PAVEMENT, PAVEMENT + 0.53], [7.5, 7.5], 24);
                plant(&mut stage, &furniture, &mut random, centre);
            } else {
                let distance = (x * x + z * z).sqrt() / (PITCH * 2.9);
                let whole =
                    Lot { min: [x - BUILT_HALF, z - BUILT_HALF], max: [x + BUILT_HALF, z + BUILT_HALF] };
                let lots = divide(whole, &mut random);
                let mut site = Site { builder: &mut b, palette: &palette, random: &mut random };
                for lot in lots {
                    site.building(lot, (1.0 - distance).max(0.0));
                }
            }
            stage.mesh_in_place(b.finish());
            furnish(&mut stage, &furniture, &mut random, centre);
        }
    }
    stage.finish()
}

/// Splits a block into lots, always along the longer side, until they have the size of a building.
fn divide(whole: Lot, random: &mut Random) -> Vec<Lot> {
    let (mut work, mut lots) = (vec![whole], Vec::new());
    while let Some(lot) = work.pop() {
        let size = [lot.max[0] - lot.min[0], lot.max[1] - lot.min[1]];
        let a = usize::from(size[1] > size[0]);
        if size[a] < random.range(24.0, 38.0) {
            let gap = random.range(0.2, 1.4);
            lots.push(Lot { min: lot.min.map(|c| c + gap), max: lot.max.map(|c| c - gap) });
            continue;
        }
        let cut = lot.min[a] + size[a] * random.range(0.38, 0.62);
        let (mut first, mut second) = (lot, lot);
        first.max[a] = cut;
        second.min[a] = cut;
        work.extend([first, second]);
    }
    lots
}
