//! Volumetric fog is lit where the file says so.

use adumbra::Filter;
use adumbra_bake::FrameChoice;
use bevy::light::{FogVolume, VolumetricFog, VolumetricLight};
use bevy::prelude::*;
use bevy_adumbra::prelude::*;

use crate::stage::{MIDDLE, SIDE, SQUARE, Stage, baked};

/// Thickness of the layer of fog, metres.
const LAYER: f32 = 40.0;

#[test]
fn fog_is_lit_where_the_file_says() {
    let file = baked(FrameChoice::Oblique);
    let mut stage = Stage::new(|_| {});
    stage.give(file.clone(), |shadow| shadow.filter = ShadowFilter::Nearest);
    let world = stage.app.world_mut();
    world.despawn(stage.square);
    world.entity_mut(stage.light).insert(VolumetricLight);
    world.entity_mut(stage.camera).insert((
        // Far away, so that all rays go almost straight down.
        Projection::from(PerspectiveProjection {
            fov: 2.0 * (SQUARE / 2.0 / 5000.0).atan(),
            far: 1e5,
            ..default()
        }),
        Transform::from_translation(MIDDLE + 5000.0 * Vec3::Y).looking_at(MIDDLE, Vec3::NEG_Z),
        VolumetricFog { ambient_intensity: 0.0, step_count: 64, ..default() },
    ));
    world.spawn((
        FogVolume { density_factor: 0.001, ..default() },
        Transform::from_translation(MIDDLE + LAYER / 2.0 * Vec3::Y)
            .with_scale(Vec3::new(400.0, LAYER, 400.0)),
    ));
    let picture = stage.picture.clone();
    let bytes = stage.draw(&picture);
    let shadow = file.sampler(Filter::Nearest);
    let (mut found, mut lit) = (Vec::new(), Vec::new());
    // Every fourth pixel, away from the border.
    for (x, y) in (8..SIDE - 8).step_by(4).flat_map(|y| (8..SIDE - 8).step_by(4).map(move |x| (x, y))) {
        let at = 8 * (y * SIDE + x) as usize;
        found.push(f64::from(crate::stage::half([bytes[at], bytes[at + 1]])));
        let across = |n: u32| f64::from(((n as f32 + 0.5) / SIDE as f32 - 0.5) * SQUARE);
        let heights = (0..64).map(|n| f64::from(MIDDLE.y + LAYER) * (f64::from(n) + 0.5) / 64.0);
        let visible =
            heights.map(|y_world| f64::from(shadow.visibility([across(x), y_world, across(y)], None)));
        lit.push(visible.sum::<f64>() / 64.0);
    }
    let r = correlation(&found, &lit);
    println!("correlation of fog and visibility {r:.3}");
    assert!(r > 0.97, "{r}");
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let product = |u: &[f64], mu: f64, v: &[f64], mv: f64| -> f64 {
        u.iter().zip(v).map(|(x, y)| (x - mu) * (y - mv)).sum()
    };
    product(a, ma, b, mb) / (product(a, ma, a, ma) * product(b, mb, b, mb)).sqrt()
}
