//! A forest as games build them: trunks that carry crossed cards with a texture of leaves, whose alpha cuts
//! them out.
//!
//! Only the trunks and the ground are solid. A tree has 1,000 cards, and the forest 1,000 trees, so a million
//! cards or two million triangles are placed.

use crate::generate::leaf_image::leaf_spray;
use crate::generate::shapes::MeshBuilder;
use crate::generate::{Placement, SINK, Scene, Stage};
use crate::random::Random;
use crate::{AlphaMode, Material};
use adumbra::grid::vec3::{cross, normalize};

/// Trees along x and z.
const TREES: [u32; 2] = [40, 25];
/// Distance of the trees, metres.
const PITCH: f64 = 6.0;
/// Width of the ground beside the outermost trees, metres.
const EDGE: f64 = 4.0;
/// Pairs of crossed cards of a tree.
const PAIRS: u32 = 500;
/// Half the side of a card, metres.
const CARD_HALF: [f64; 2] = [0.25, 0.45];

/// The shape of a crown.
struct Crown {
    name: &'static str,
    /// Heights of its lower and its upper end, metres.
    ends: [f64; 2],
    /// The largest radius, metres.
    radius: f64,
    /// Whether it becomes narrower from its lower end on.
    is_cone: bool,
}

const CROWNS: [Crown; 4] = [
    Crown { name: "spruce", ends: [1.5, 16.0], radius: 2.6, is_cone: true },
    Crown { name: "fir", ends: [2.5, 19.0], radius: 3.0, is_cone: true },
    Crown { name: "beech", ends: [3.0, 13.0], radius: 3.4, is_cone: false },
    Crown { name: "hornbeam", ends: [2.0, 9.5], radius: 2.9, is_cone: false },
];

pub(super) fn generate(seed: u64) -> Scene {
    let mut stage = Stage::default();
    let earth = stage.material("forest floor", 0x6A6248);
    let bark = stage.material("bark", 0x6B503A);
    stage.scene.textures.push(leaf_spray(seed));
    let leaves = stage.scene.materials.len() as u32;
    stage.scene.materials.push(Material {
        alpha: AlphaMode::Mask { cutoff: 0.5 },
        texture: Some(0),
        ..Material::opaque("leaves", [1.0; 4])
    });

    let mut ground = MeshBuilder::new("ground", earth);
    let [width, depth] = TREES.map(|count| f64::from(count) * PITCH + 2.0 * EDGE);
    ground.block([0.0, -1.0, 0.0], [width, 1.0, depth]);
    stage.mesh_in_place(ground.finish());

    let kinds: Vec<u32> = CROWNS
        .iter()
        .zip(0..)
        .map(|(crown, kind)| {
            let mut random = Random::new(seed, 61 + kind);
            let mut tree = MeshBuilder::new(crown.name, bark);
            let top = crown.ends[0] + 0.9 * (crown.ends[1] - crown.ends[0]);
            tree.frustum([0.0; 2], [-SINK, top], [0.24, 0.04], 6);
            tree.paint(leaves);
            for _ in 0..PAIRS {
                add_pair(&mut tree, crown, &mut random);
            }
            stage.mesh(tree.finish())
        })
        .collect();

    let mut random = Random::new(seed, 60);
    for i in 0..TREES[0] {
        for j in 0..TREES[1] {
            let mut along = |n: u32, count: u32| {
                (f64::from(n) - f64::from(count - 1) / 2.0) * PITCH + random.range(-0.35, 0.35) * PITCH
            };
            let (x, z) = (along(i, TREES[0]), along(j, TREES[1]));
            let place = Placement::at([x, 0.0, z]).turned(random.angle()).scaled(random.range(0.8, 1.15));
            stage.place(random.pick(&kinds), format!("tree {i} {j}"), place);
        }
    }
    stage.finish()
}

/// Adds two cards that cross at right angles along a twig, in the outer half of the crown.
fn add_pair(tree: &mut MeshBuilder, crown: &Crown, random: &mut Random) {
    let [low, high] = crown.ends;
    let share = random.unit();
    // Fraction of the crown's height below which `share` of its surface is.
    let (up, width) = if crown.is_cone {
        let left = (1.0 - share).sqrt();
        (1.0 - left, left)
    } else {
        (share, 2.0 * (share * (1.0 - share)).sqrt())
    };
    let around = random.angle();
    let outwards = [libm::cos(around), 0.0, libm::sin(around)];
    let radius = crown.radius * width * random.range(0.25, 1.0).sqrt();
    let foot = [outwards[0] * radius, low + up * (high - low), outwards[2] * radius];
    let twig = normalize([
        outwards[0] + random.range(-0.5, 0.5),
        random.range(-0.4, 0.9),
        outwards[2] + random.range(-0.5, 0.5),
    ]);
    let turn = random.angle();
    let level = normalize(cross(twig, [0.0, 1.0, 0.0]));
    let upright = cross(level, twig);
    let (s, c) = (libm::sin(turn), libm::cos(turn));
    let half = random.range(CARD_HALF[0], CARD_HALF[1]);
    for [along_level, along_upright] in [[c, s], [-s, c]] {
        let side = [0, 1, 2].map(|a| along_level * level[a] + along_upright * upright[a]);
        let corner = |across: f64, along: f64| {
            [0, 1, 2].map(|a| foot[a] + half * (across * side[a] + along * twig[a]))
        };
        tree.card([corner(-1.0, 0.0), corner(1.0, 0.0), corner(1.0, 2.0), corner(-1.0, 2.0)]);
    }
}
