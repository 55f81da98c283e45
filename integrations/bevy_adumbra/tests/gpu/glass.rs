//! Glass: the picture behind it is the same as without the plugin's files, up to the edge of the picture.

use adumbra_bake::FrameChoice;
use bevy::prelude::*;
use bevy_adumbra::prelude::*;

use crate::stage::{HEIGHT, MIDDLE, SQUARE, Stage, baked, half};

/// Draws, and returns all colours.
fn colours(stage: &mut Stage) -> Vec<f32> {
    let picture = stage.picture.clone();
    let bytes = stage.draw(&picture);
    bytes.as_chunks().0.iter().map(|bytes| half(*bytes)).collect()
}

/// A ground of unlit stripes, below panes of glass that cover the picture from left to right.
fn glass(materials: &[StandardMaterial]) -> Stage {
    let mut stage = Stage::new(|_| {});
    let world = stage.app.world_mut();
    let stripe = world.resource_mut::<Assets<Mesh>>().add(Plane3d::default().mesh().size(7.0, 2.0 * SQUARE));
    for i in -9..9 {
        let base_color = if i % 2 == 0 { Color::srgb(0.9, 0.2, 0.1) } else { Color::srgb(0.1, 0.3, 0.8) };
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial {
            base_color,
            unlit: true,
            ..default()
        });
        let at = MIDDLE + Vec3::new(7.0 * i as f32, 0.1, 0.0);
        world.spawn((Mesh3d(stripe.clone()), MeshMaterial3d(material), Transform::from_translation(at)));
    }
    let width = SQUARE / materials.len() as f32;
    let pane = world.resource_mut::<Assets<Mesh>>().add(Plane3d::default().mesh().size(width, 2.0 * SQUARE));
    for (i, material) in materials.iter().enumerate() {
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(material.clone());
        // Tilted, so that it refracts the picture behind it to one side.
        let at = Transform::from_xyz(width * (i as f32 + 0.5) - SQUARE / 2.0, HEIGHT + 40.0, 0.0)
            .with_rotation(Quat::from_rotation_z(0.3));
        world.spawn((
            Mesh3d(pane.clone()),
            MeshMaterial3d(material),
            at,
            bevy::light::NotShadowCaster,
            bevy::light::NotShadowReceiver,
        ));
    }
    stage
}

#[test]
fn glass_shows_the_same_picture_with_and_without_a_file() {
    let clear = StandardMaterial {
        specular_transmission: 0.9,
        perceptual_roughness: 0.0,
        reflectance: 0.0,
        thickness: 30.0,
        ior: 1.5,
        ..default()
    };
    let rough = StandardMaterial { perceptual_roughness: 0.6, ..clear.clone() };
    // Drawn with the blended meshes, so that alone it has no picture behind it.
    let blended = StandardMaterial {
        alpha_mode: AlphaMode::Blend,
        base_color: Color::srgba(1.0, 1.0, 1.0, 0.5),
        ..clear.clone()
    };
    for (name, materials) in [("clear and rough", &[clear, rough][..]), ("blended", &[blended])] {
        let mut stage = glass(materials);
        // Without sunlight, the picture shows the stripes and the light that comes through the glass.
        stage.app.world_mut().get_mut::<DirectionalLight>(stage.light).unwrap().illuminance = 0.0;
        let without = colours(&mut stage);
        stage.give(baked(FrameChoice::Oblique), |_| {});
        let with = colours(&mut stage);
        assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
        let bright = without.iter().filter(|c| **c > 0.05).count();
        assert!(bright > without.len() / 4, "{name}: {bright}");
        let off = without.iter().zip(&with).filter(|(a, b)| (**a - **b).abs() > 0.01).count();
        assert!(off * 500 <= without.len(), "{name}: {off} of {}", without.len());
    }
}
