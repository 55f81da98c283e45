//! Common situations in apps: loading screens, presets of hours, view models, levels that restart.

use adumbra::Filter;
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::{GeneratedKind, generate};
use bevy::camera::visibility::RenderLayers;
use bevy::camera::{Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::light::NotShadowCaster;
use bevy::prelude::*;
use bevy_adumbra::DeviceLimits;
use bevy_adumbra::prelude::*;

use crate::stage::{MIDDLE, SQUARE, Stage, assert_alike, baked, expected, from_above, towards_sun};

fn oblique() -> adumbra::ShadowFile {
    baked(FrameChoice::Oblique)
}

/// A camera like that of the stage.
fn camera(stage: &Stage, order: isize) -> impl Bundle + use<> {
    let clear_color = if order == 0 { ClearColorConfig::Default } else { ClearColorConfig::None };
    (
        Camera { order, clear_color, ..default() },
        Hdr,
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
        RenderTarget::from(stage.picture.clone()),
    )
}

fn above() -> (Projection, Transform) {
    let at = Transform::from_translation(MIDDLE + 90.0 * Vec3::Y).looking_at(MIDDLE, Vec3::NEG_Z);
    (from_above(SQUARE), at)
}

#[test]
#[ignore = "slow: draws many frames"]
fn shadows_are_in_the_first_frame_after_a_2d_loading_screen() {
    let file = oblique();
    let mut stage = Stage::new(|_| {});
    let old = stage.camera;
    stage.app.world_mut().despawn(old);
    let overlay = camera(&stage, 1);
    stage.app.world_mut().spawn((Camera2d, overlay));
    stage.give(file.clone(), |_| {});
    stage.update_until_known();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
    for _ in 0..3 {
        stage.update();
    }
    let of_level = camera(&stage, 0);
    stage.camera = stage.app.world_mut().spawn((Camera3d::default(), of_level, above())).id();
    assert_alike(&stage.visibility(), &expected(&file, Filter::Box5), Filter::Box5);
}

#[test]
#[ignore = "slow: draws many frames"]
fn switches_presets_once_the_new_file_is_loaded() {
    let suns = [towards_sun(), [-0.4, 0.7, 0.2]];
    let sun = adumbra::Sun::from_direction(suns[1]).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(256));
    let evening = Bake::with_options(&generate(GeneratedKind::City, 1), &options).in_memory().unwrap();
    let mut stage = Stage::new(|_| {});
    let of_app = Quat::from_rotation_x(-1.0);
    stage.app.world_mut().get_mut::<Transform>(stage.light).unwrap().rotation = of_app;
    let morning = stage.give(oblique(), |_| {});
    stage.update_until_known();
    let assert_at = |stage: &Stage, sun: [f64; 3]| {
        let back = stage.app.world().get::<GlobalTransform>(stage.light).unwrap().back().as_vec3();
        assert!(back.distance(Vec3::from_array(sun.map(|c| c as f32)).normalize()) < 1e-4);
    };
    let take = |stage: &mut Stage, file: &Handle<BakedShadowFile>| {
        stage.app.world_mut().entity_mut(stage.light).insert(BakedShadow::new(file.clone()));
        stage.update();
    };
    let handle = stage.app.world().resource::<Assets<BakedShadowFile>>().reserve_handle();
    take(&mut stage, &handle);
    assert_eq!((stage.status(), stage.cascades()), (BakedShadowStatus::Waiting, 4));
    assert_at(&stage, suns[0]);
    let asset = BakedShadowFile::new(evening, DeviceLimits::default()).unwrap();
    stage.app.world_mut().resource_mut::<Assets<BakedShadowFile>>().insert(&handle, asset).unwrap();
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
    assert_at(&stage, suns[1]);
    take(&mut stage, &morning);
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
    assert_at(&stage, suns[0]);
    stage.app.world_mut().entity_mut(stage.light).remove::<BakedShadow>();
    stage.update();
    assert_eq!(stage.app.world().get::<Transform>(stage.light).unwrap().rotation, of_app);
}

#[test]
#[ignore = "slow: draws many frames"]
fn view_model_on_a_separate_layer_keeps_baked_shadows() {
    let file = oblique();
    let mut stage = Stage::new(|_| {});
    stage.give(file.clone(), |_| {});
    let second = camera(&stage, 1);
    let material = MeshMaterial3d(stage.material.clone());
    let world = stage.app.world_mut();
    let ball = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(Sphere::new(0.1)));
    let at = Transform::from_translation(MIDDLE + 5.0 * Vec3::Y);
    world.entity_mut(stage.light).insert(RenderLayers::from_layers(&[0, 1]));
    world.spawn((Camera3d::default(), second, above(), RenderLayers::layer(1)));
    world.spawn((ball.clone(), material.clone(), at, RenderLayers::layer(1), NotShadowCaster));
    let mover = world.spawn((ball, material, at)).id();
    stage.update_until_known();
    stage.update();
    assert_eq!((stage.status(), stage.cascades()), (BakedShadowStatus::Active { files: 1 }, 4));
    stage.app.world_mut().entity_mut(mover).insert(RenderLayers::layer(2));
    stage.update();
    assert_eq!(stage.cascades(), 0);
    assert_alike(&stage.visibility(), &expected(&file, Filter::Box5), Filter::Box5);
}

#[test]
#[ignore = "slow: draws many frames"]
fn level_restarted_in_one_frame_has_its_file_in_that_frame() {
    let file = oblique();
    let mut stage = Stage::new(|_| {});
    let handle = stage.give(file.clone(), |_| {});
    stage.update_until_known();
    for n in 0..20 {
        let old = stage.light;
        let world = stage.app.world_mut();
        world.despawn(old);
        let light = DirectionalLight { illuminance: 3000.0, shadow_maps_enabled: true, ..default() };
        stage.light = world.spawn((light, BakedShadow::new(handle.clone()))).id();
        stage.update();
        assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 }, "{n}");
    }
    assert_alike(&stage.visibility(), &expected(&file, Filter::Box5), Filter::Box5);
}
