//! Shafts of light in fog, from the file: they reach as far as it does.

mod common;

use bevy::light::{FogVolume, VolumetricFog, VolumetricLight};
use bevy::prelude::*;
use bevy_adumbra::prelude::*;

fn main() {
    common::app().add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        VolumetricLight,
        BakedShadow::new(assets.load("city.adumbra")),
    ));
    commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), ShadowStatic));
    commands.spawn((common::camera(), VolumetricFog { ambient_intensity: 0.05, ..default() }));
    commands.spawn((
        FogVolume { density_factor: 0.008, ..default() },
        Transform::from_xyz(-50.0, 30.0, 50.0).with_scale(Vec3::new(400.0, 80.0, 400.0)),
    ));
}
