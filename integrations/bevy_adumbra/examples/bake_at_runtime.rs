//! Towers that are built while the app runs: their shadows are baked on separate threads. Space adds a tower.

mod common;

use bevy::light::CascadeShadowConfigBuilder;
use bevy::prelude::*;
use bevy_adumbra::prelude::*;

#[derive(Resource)]
struct Town {
    root: Entity,
    mesh: Handle<Mesh>,
    material: Handle<StandardMaterial>,
    towers: u32,
}

fn main() {
    common::app().add_systems(Startup, setup).add_systems(Update, (build, report)).run();
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let light = commands
        .spawn((
            DirectionalLight { shadow_maps_enabled: true, ..default() },
            CascadeShadowConfigBuilder { maximum_distance: 400.0, ..default() }.build(),
            Transform::default().looking_to(-Vec3::new(0.5, 0.8, 0.35), Vec3::Y),
        ))
        .id();
    commands.bake_shadow(light, BakeSettings { resolution: 4096, ..default() });
    let root = commands.spawn((ShadowStatic, Transform::default(), Visibility::default())).id();
    let ground = meshes.add(Plane3d::default().mesh().size(300.0, 300.0));
    let material = materials.add(Color::srgb(0.8, 0.8, 0.75));
    commands.spawn((Mesh3d(ground), MeshMaterial3d(material.clone()), ChildOf(root)));
    commands.spawn((common::camera(), Name::new("camera")));
    commands.insert_resource(Town { root, mesh: meshes.add(Cuboid::from_length(1.0)), material, towers: 0 });
}

/// Builds twelve towers one by one, then one whenever Space is pressed.
fn build(mut commands: Commands, mut town: ResMut<Town>, keys: Option<Res<ButtonInput<KeyCode>>>) {
    let is_asked = keys.is_some_and(|keys| keys.just_pressed(KeyCode::Space));
    if town.towers >= 12 && !is_asked {
        return;
    }
    let n = town.towers as f32;
    town.towers += 1;
    let height = 12.0 + (n * 7.3) % 30.0;
    let at = Vec3::new((n * 37.0) % 160.0 - 130.0, height / 2.0, (n * 61.0) % 160.0 - 40.0);
    commands.spawn((
        Mesh3d(town.mesh.clone()),
        MeshMaterial3d(town.material.clone()),
        Transform::from_translation(at).with_scale(Vec3::new(10.0, height, 10.0)),
        ChildOf(town.root),
    ));
}

fn report(progress: Query<&BakeProgress, Changed<BakeProgress>>) {
    for progress in &progress {
        info!("bake: {progress}");
    }
}
