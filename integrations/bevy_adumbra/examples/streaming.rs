//! A flight through a city whose file is streamed: the parts that the camera sees are read, and the log says
//! how much that is.

mod common;

use bevy::diagnostic::LogDiagnosticsPlugin;
use bevy::prelude::*;
use bevy_adumbra::prelude::*;

fn main() {
    common::app()
        .add_plugins(LogDiagnosticsPlugin::default())
        .insert_resource(StreamBudget { bytes: 4 << 20, ..default() })
        .add_systems(Startup, setup)
        .add_systems(Update, fly)
        .run();
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands
        .spawn((
            DirectionalLight { shadow_maps_enabled: true, ..default() },
            BakedShadow::streamed("city.adumbra"),
        ))
        .observe(|change: On<BakedShadowChanged>| info!("the baked shadow is {}", change.status));
    commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), ShadowStatic));
    commands.spawn(common::camera());
}

/// Flies around the city's middle.
fn fly(time: Res<Time>, mut camera: Single<&mut Transform, With<Camera3d>>) {
    let turn = Quat::from_rotation_y(0.1 * time.delta_secs());
    camera.rotate_around(Vec3::ZERO, turn);
}
