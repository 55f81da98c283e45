//! Balls that roll through the city cast through Bevy's cascades; the city does not.

mod common;

use bevy::prelude::*;
use bevy_adumbra::{BakedShadow, BakedStatic};

#[derive(Component)]
struct Ball(f32);

fn main() {
    common::app().add_systems(Startup, setup).add_systems(Update, roll).run();
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        BakedShadow::new(assets.load("city.adumbra")),
    ));
    commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), BakedStatic));
    commands.spawn(common::camera());
    let mesh = meshes.add(Sphere::new(3.0));
    let material = materials.add(Color::srgb(0.9, 0.3, 0.2));
    for n in 0..12 {
        commands.spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material.clone()),
            Ball(n as f32),
            Transform::default(),
        ));
    }
}

fn roll(time: Res<Time>, mut balls: Query<(&Ball, &mut Transform)>) {
    for (Ball(n), mut transform) in &mut balls {
        let along = (time.elapsed_secs() * 8.0 + n * 17.0) % 200.0 - 200.0;
        transform.translation = Vec3::new(along, 3.0, 100.0 + (n * 40.0) % 120.0);
    }
}
