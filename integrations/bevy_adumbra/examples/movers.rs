//! Balls that fly over a street corner cast through Bevy's cascades; the city does not.

mod common;

use bevy::prelude::*;
use bevy_adumbra::prelude::*;

#[derive(Component)]
struct Ball(f32);

fn main() {
    common::app().add_systems(Startup, setup).add_systems(Update, fly).run();
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
    commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), ShadowStatic));
    commands.spawn(common::camera());
    let mesh = meshes.add(Sphere::new(2.0));
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

/// Moves each ball on its own circle.
fn fly(time: Res<Time>, mut balls: Query<(&Ball, &mut Transform)>) {
    for (Ball(n), mut transform) in &mut balls {
        let angle = 0.5 * time.elapsed_secs() + 1.1 * n;
        let radius = 8.0 + 3.0 * n;
        transform.translation =
            Vec3::new(-95.0 + radius * angle.cos(), 12.0 + 1.5 * n, 105.0 + radius * angle.sin());
    }
}
