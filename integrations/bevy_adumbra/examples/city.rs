//! A city whose sun shadows come from one file: three lines.

mod common;

use bevy::prelude::*;
use bevy_adumbra::prelude::*;

fn main() {
    common::app().add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        BakedShadow::new(assets.load("city.adumbra")),
    ));
    commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), ShadowStatic));
    commands.spawn(common::camera());
}
