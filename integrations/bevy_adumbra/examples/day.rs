//! The sun leaves the file's direction and comes back. Away from it, shadows come from Bevy's cascades.

mod common;

use bevy::light::CascadeShadowConfigBuilder;
use bevy::prelude::*;
use bevy_adumbra::prelude::*;

fn main() {
    common::app().add_systems(Startup, setup).add_systems(Update, turn).run();
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    let cascades = CascadeShadowConfigBuilder { maximum_distance: 500.0, ..default() };
    commands
        .spawn((
            DirectionalLight { shadow_maps_enabled: true, ..default() },
            cascades.build(),
            BakedShadow { align: false, ..BakedShadow::new(assets.load("city.adumbra")) },
        ))
        .observe(|change: On<BakedShadowChanged>| info!("the baked shadow is {}", change.status));
    commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), ShadowStatic));
    commands.spawn(common::camera());
}

/// Four seconds at the file's sun, then eight seconds away and back.
fn turn(time: Res<Time>, mut light: Single<&mut Transform, With<DirectionalLight>>) {
    let away = ((time.elapsed_secs() % 12.0 - 4.0).max(0.0) / 8.0 * std::f32::consts::TAU).cos();
    let angle = 0.4 * (1.0 - away);
    let towards_sun = Vec3::from_array(common::TOWARDS_SUN.map(|c| c as f32));
    let turned = Quat::from_rotation_y(angle) * towards_sun;
    let new = Transform::default().looking_to(-turned, Vec3::Y);
    if light.rotation != new.rotation {
        **light = new;
    }
}
