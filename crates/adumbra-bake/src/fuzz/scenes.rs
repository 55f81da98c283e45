//! A fuzzer case: scene and options, both determined by a seed.

use std::f64::consts::PI;

use crate::fuzz::dice::Dice;
use crate::fuzz::parts::Modeller;
use crate::options::{BakeOptions, FrameChoice, Size};
use adumbra::grid::{Bounds, Sun};
use adumbra::{Bias, Receivers};
use adumbra_scene::{AlphaMode, Instance, Material, Mesh, Pixels, Scene, Texture, Wrap};

/// Side of the space in which parts are placed, before scaling.
const SPACE: f64 = 24.0;

/// The input to bake and check.
pub(crate) struct Case {
    pub(crate) scene: Scene,
    pub(crate) options: BakeOptions,
}

/// Placement of the scene in the world.
struct Frame {
    scale: f64,
    offset: f64,
}

impl Case {
    /// Creates the case of a seed, which is the same on every machine and in every run.
    pub(crate) fn new(seed: u64) -> Self {
        let dice = &mut Dice::new(seed, 0);
        let frame = Frame {
            scale: if dice.chance(0.2) { dice.scale(1e-4..1e4) } else { 1.0 },
            offset: if dice.chance(0.15) { dice.within(-1e7..1e7) } else { 0.0 },
        };
        let resolution = 1 << dice.count(3..9);
        let voxel = SPACE / f64::from(resolution);
        let sun = sun(dice);
        let scene = scene(dice, &frame, &sun, voxel);
        let options = options(dice, &frame, sun, resolution, voxel * frame.scale);
        Self { scene, options }
    }
}

fn sun(dice: &mut Dice) -> Sun {
    let any = |dice: &mut Dice, elevation| [dice.within(-1.0..1.0), elevation, dice.within(-1.0..1.0)];
    let towards = match dice.below(9) {
        0 => [0.0, 1.0, 0.0],
        1 => [1e-12, 1.0, 0.0],
        2 => {
            let elevation = dice.within(0.002..0.05);
            any(dice, elevation)
        }
        3 => [1.0, 1.0, 0.0],
        4 => [0.0, 1.0, 1.0],
        _ => {
            let elevation = dice.within(0.05..1.0);
            any(dice, elevation)
        }
    };
    Sun::from_direction(towards).expect("every one of them is above the horizon")
}

fn materials(dice: &mut Dice) -> Vec<Material> {
    let plain = |name| Material::opaque(name, [1.0; 4]);
    let cutoff = dice.pick(&[0.5, 0.1]);
    vec![
        plain("opaque"),
        Material { casts: false, ..plain("does not cast") },
        Material { alpha: AlphaMode::Mask { cutoff }, texture: Some(0), ..plain("masked") },
        Material { transmissivity: 0.9, ..plain("glass") },
    ]
}

fn texture(dice: &mut Dice) -> Texture {
    let side = dice.count(1..9) as u32;
    let alpha = (0..side * side).map(|_| dice.pick(&[0, 255])).collect();
    let wrap = [0; 2].map(|_| dice.pick(&[Wrap::Repeat, Wrap::Mirror, Wrap::Clamp]));
    Texture {
        name: "holes".to_owned(),
        width: side,
        height: side,
        pixels: Pixels::Alpha(alpha),
        wrap,
        nearest: dice.chance(0.5),
    }
}

fn scene(dice: &mut Dice, frame: &Frame, sun: &Sun, voxel: f64) -> Scene {
    let mut scene = Scene { materials: materials(dice), textures: vec![texture(dice)], ..Scene::default() };
    let grain = dice.pick(&[0.0, 0.0, 0.5, 0.25, 1.0]);
    for number in 0..dice.count(1..4) {
        let mut modeller =
            Modeller { mesh: Mesh::default(), grain, material: 0, towards_sun: sun.towards(), voxel, dice };
        // A scene without a triangle cannot be loaded.
        while modeller.mesh.triangles.is_empty() {
            for _ in 0..modeller.dice.count(1..6) {
                modeller.material = if modeller.dice.chance(0.7) { 0 } else { modeller.dice.below(4) as u32 };
                modeller.add_part();
            }
        }
        scene.meshes.push(modeller.mesh);
        for _ in 0..dice.count(1..4) {
            let casts = !dice.chance(0.08);
            let world_from_mesh = placing(dice, frame, grain);
            scene.instances.push(Instance {
                name: String::new(),
                mesh: number as u32,
                world_from_mesh,
                casts,
            });
        }
    }
    scene
}

/// Returns a transform: identity, sheared, mirrored, scaled along each axis, or flattened; possibly with a
/// translation.
fn placing(dice: &mut Dice, frame: &Frame, grain: f64) -> [[f64; 4]; 3] {
    let mut rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    match dice.below(8) {
        0..=3 => {}
        4 => {
            for c in rows.iter_mut().flat_map(|row| &mut row[..3]) {
                *c += dice.within(-0.7..0.7);
            }
        }
        5 => {
            let axis = dice.below(3);
            rows[axis][axis] = -1.0;
        }
        6 => {
            for (a, row) in rows.iter_mut().enumerate() {
                row[a] = dice.within(-2.0..2.0);
            }
        }
        _ => {
            let axis = dice.below(3);
            rows[axis][axis] = dice.pick(&[0.0, 1e-7]);
        }
    }
    if dice.chance(0.5) {
        for row in &mut rows {
            let moved = dice.within(-6.0..6.0);
            row[3] = if grain > 0.0 { (moved / grain).round() * grain } else { moved };
        }
    }
    for c in rows.iter_mut().flatten() {
        *c *= frame.scale;
    }
    rows[0][3] += frame.offset;
    rows[2][3] -= frame.offset;
    rows
}

fn options(dice: &mut Dice, frame: &Frame, sun: Sun, resolution: u32, voxel_world: f64) -> BakeOptions {
    let size = if dice.chance(0.25) {
        Size::VoxelSize(voxel_world)
    } else {
        Size::Resolution(u64::from(resolution))
    };
    let bounds = dice.chance(0.15).then(|| {
        let low = [0; 3].map(|_| dice.within(-8.0..4.0));
        let high = low.map(|c| c + dice.within(0.5..8.0));
        let place = |p: [f64; 3]| {
            let p = p.map(|c| c * frame.scale);
            [p[0] + frame.offset, p[1], p[2] - frame.offset]
        };
        Bounds { min: place(low), max: place(high) }
    });
    let switch_within_voxels = match dice.below(8) {
        0 => BakeOptions::MAX_SWITCH_WITHIN,
        1..=3 => dice.below(12) as u32,
        _ => 0,
    };
    BakeOptions {
        thickness_world: if dice.chance(0.3) { dice.within(0.0..3.0) * frame.scale } else { 0.0 },
        assume_ground: dice.chance(0.6).into(),
        closed_regions: dice.chance(0.85),
        ignore_alpha: dice.chance(0.15),
        receivers: if dice.chance(0.15) { Receivers::Static } else { Receivers::All },
        switch_within_voxels,
        bounds,
        bias: bias(dice),
        max_memory_bytes: dice.chance(0.02).then_some(256 << 20),
        frame: match dice.below(5) {
            0 | 1 => FrameChoice::Light,
            2 => FrameChoice::Oblique,
            3 => FrameChoice::ObliqueAt(dice.within(-PI..PI)),
            _ => FrameChoice::Auto,
        },
        ..BakeOptions::new(sun, size)
    }
}

fn bias(dice: &mut Dice) -> Bias {
    let default = Bias::default();
    match dice.below(6) {
        0 => Bias { constant_texels: dice.within(0.0..4.0), ..default },
        1 => Bias { constant_texels: dice.within(1.0..3.0), slope_texels: dice.within(0.0..2.0), ..default },
        2 => Bias { normal_offset_texels: dice.within(0.0..2.0), ..default },
        _ => default,
    }
}
