//! Bevy's cascades to the left of a divider, the file to the right: two cameras, and a light for each.
//!
//! Space shows the file alone, then the cascades alone, then both; frame times are in the log.

mod common;

use bevy::camera::Viewport;
use bevy::camera::visibility::{NoFrustumCulling, RenderLayers};
use bevy::diagnostic::{FrameTimeDiagnosticsPlugin, LogDiagnosticsPlugin};
use bevy::light::CascadeShadowConfigBuilder;
use bevy::prelude::*;
use bevy_adumbra::prelude::*;

/// The half of the window that a camera draws.
#[derive(Component, Clone, Copy, PartialEq)]
enum Half {
    Cascades,
    File,
}

#[derive(Resource, Default, Clone, Copy, PartialEq)]
enum Shown {
    #[default]
    Both,
    File,
    Cascades,
}

fn main() {
    common::app()
        .add_plugins((FrameTimeDiagnosticsPlugin::default(), LogDiagnosticsPlugin::default()))
        .init_resource::<Shown>()
        .add_systems(Startup, setup)
        .add_systems(Update, (show_in_both, (switch, divide).chain()))
        .run();
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    // Keep the suns a tenth of a degree apart: a file belongs to every light that has its sun's direction.
    let towards_sun = Vec3::from_array(common::TOWARDS_SUN.map(|c| c as f32));
    let beside = Quat::from_rotation_y(0.003) * towards_sun;
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        CascadeShadowConfigBuilder { maximum_distance: 500.0, ..default() }.build(),
        Transform::default().looking_to(-beside, Vec3::Y),
        RenderLayers::layer(1),
    ));
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        BakedShadow::new(assets.load("city.adumbra")),
        RenderLayers::layer(2),
    ));
    commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), ShadowStatic));
    for (order, half) in [Half::Cascades, Half::File].into_iter().enumerate() {
        commands.spawn((
            common::camera(),
            half,
            Camera { order: order as isize, ..default() },
            RenderLayers::layer(1 + order),
        ));
    }
}

/// Every mesh is lit in both halves, each by its own light. Bevy's culling frustum ignores sub-camera views,
/// so culling is turned off.
fn show_in_both(mut commands: Commands, new: Query<Entity, Added<Mesh3d>>) {
    for entity in &new {
        commands.entity(entity).insert((RenderLayers::from_layers(&[1, 2]), NoFrustumCulling));
    }
}

fn switch(keys: Option<Res<ButtonInput<KeyCode>>>, mut shown: ResMut<Shown>) {
    if keys.is_some_and(|keys| keys.just_pressed(KeyCode::Space)) {
        *shown = match *shown {
            Shown::Both => Shown::File,
            Shown::File => Shown::Cascades,
            Shown::Cascades => Shown::Both,
        };
    }
}

/// Gives each camera its part of the target. Together they show one picture.
fn divide(shown: Res<Shown>, mut cameras: Query<(&Half, &mut Camera, &mut Transform)>) {
    let first = cameras.iter().find(|(half, ..)| **half == Half::Cascades).map(|(.., transform)| *transform);
    for (half, mut camera, mut transform) in &mut cameras {
        // `walk` moves both cameras. Copy the transform, so that rounding does not separate them.
        if let Some(first) = first.filter(|_| *half == Half::File)
            && *transform != first
        {
            *transform = first;
        }
        let Some(size) = camera.physical_target_size() else { continue };
        let is_active = *shown == Shown::Both || (*shown == Shown::File) == (*half == Half::File);
        camera.is_active = is_active;
        let width = if *shown == Shown::Both { size.x / 2 } else { size.x };
        let x = if *half == Half::File { size.x - width } else { 0 };
        // The part of the whole picture that this half shows.
        camera.sub_camera_view = (width < size.x).then(|| bevy::camera::SubCameraView {
            full_size: size,
            offset: Vec2::new(x as f32, 0.0),
            size: UVec2::new(width, size.y),
        });
        camera.viewport = Some(Viewport {
            physical_position: UVec2::new(x, 0),
            physical_size: UVec2::new(width, size.y),
            ..default()
        });
    }
}
