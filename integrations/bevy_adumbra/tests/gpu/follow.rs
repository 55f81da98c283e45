//! Lights that are followed: keys are baked ahead of them while the app runs.

use std::cell::Cell;
use std::time::Duration;

use adumbra::Filter;
use bevy::prelude::*;
use bevy_adumbra::CascadeCasters;
use bevy_adumbra::prelude::*;

use crate::stage::{Stage, assert_alike, beside_tower, expected_by, towards_sun, tower};

/// Turns the light by an angle around the vertical axis from where it was at the beginning, at an elevation.
fn turn(stage: &mut Stage, degrees: f32, elevation_degrees: f32) {
    let begin = Vec3::from_array(towards_sun().map(|c| c as f32));
    let azimuth = begin.z.atan2(begin.x) + degrees.to_radians();
    let (up, across) = elevation_degrees.to_radians().sin_cos();
    let towards = Vec3::new(across * azimuth.cos(), up, across * azimuth.sin());
    let mut transform = stage.app.world_mut().get_mut::<Transform>(stage.light).unwrap();
    *transform = Transform::default().looking_to(-towards, Vec3::X);
}

fn progress(stage: &Stage) -> BakeProgress {
    stage.app.world().get::<BakeProgress>(stage.light).expect("a bake").clone()
}

fn is_settled(stage: &Stage) -> bool {
    let keys = stage.app.world().get::<SunKeys>(stage.light);
    progress(stage) == BakeProgress::Following { is_baking: false, coarser: 1 }
        && keys.is_some_and(SunKeys::is_settled)
        && stage.status().is_active()
}

/// Compares the picture with look-ups on the CPU between the same keys.
fn assert_drawn(stage: &mut Stage, filter: Filter) {
    let sampler = stage.app.world().get::<SunKeys>(stage.light).unwrap().sampler(filter).expect("keys");
    let expected = expected_by(|p, normal| sampler.look_up(p, normal));
    let mut found = stage.visibility();
    beside_tower(10.0, &mut found, &expected);
    // Each tap of a march weighs a ninth.
    let widest = if filter == Filter::Nearest { Filter::Nearest } else { Filter::Box3 };
    assert_alike(&found, &expected, widest);
}

#[test]
#[ignore = "slow: draws many frames"]
fn a_light_is_followed_wherever_it_turns() {
    let mut stage = Stage::new(|_| {});
    let tower = tower(&mut stage, 10.0);
    let settings = BakeSettings { resolution: 1024, settle: Duration::from_millis(50), ..default() };
    let world = stage.app.world_mut();
    let shadow = BakedShadow { filter: ShadowFilter::Nearest, ..BakedShadow::follow_sun() };
    world.entity_mut(stage.light).insert((shadow, RuntimeBake::new(settings)));
    turn(&mut stage, 0.0, 50.0);
    stage.wait_for(is_settled);
    assert_drawn(&mut stage, Filter::Nearest);

    // The sun moves on, and jumps: every frame has an answer.
    for degrees in (1..40).map(|i| 0.25 * i as f32).chain([80.0]) {
        turn(&mut stage, degrees, 50.0);
        stage.update();
        assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 }, "at {degrees} degrees");
    }
    turn(&mut stage, 11.0, 50.0);
    stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap().filter = ShadowFilter::Box5;
    stage.wait_for(is_settled);
    assert_drawn(&mut stage, Filter::Box5);

    // A mesh that moves casts through the cascades until it is in the keys.
    let casters = |stage: &Stage| stage.app.world().resource::<CascadeCasters>().kept;
    assert_eq!(casters(&stage), 0);
    stage.app.world_mut().get_mut::<Transform>(tower).unwrap().translation.y += 1.0;
    stage.update();
    stage.update();
    assert!(casters(&stage) > 0 && stage.status().is_active());
    stage.wait_for(|stage| casters(stage) == 0 && is_settled(stage));

    // Night, and settings that are not possible.
    turn(&mut stage, 0.0, -10.0);
    stage.update();
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Night);
    turn(&mut stage, 11.0, 50.0);
    stage.update();
    stage.update();
    assert!(stage.status().is_active(), "the keys are still there");
    stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap().sun_degrees = Some(0.5);
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Unusable(BakedShadowError::SoftFollow));
    stage.app.world_mut().entity_mut(stage.light).remove::<(RuntimeBake, SunKeys)>();
    stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap().sun_degrees = None;
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Unusable(BakedShadowError::NothingFollows));
}

#[test]
#[ignore = "slow: draws many frames"]
fn moved_mesh_stays_in_cascades_until_its_keys_are_shown() {
    let mut stage = Stage::new(|_| {});
    let tower = tower(&mut stage, 10.0);
    let settings = BakeSettings { resolution: 256, settle: Duration::from_millis(50), ..default() };
    stage
        .app
        .world_mut()
        .entity_mut(stage.light)
        .insert((BakedShadow::follow_sun(), RuntimeBake::new(settings)));
    turn(&mut stage, 0.0, 50.0);
    stage.wait_for(is_settled);
    // New keys are written over several frames.
    stage.app.world_mut().resource_mut::<StreamBudget>().upload_bytes_per_frame = 64;
    stage.app.world_mut().get_mut::<Transform>(tower).unwrap().translation.x -= 20.0;
    stage.update();
    stage.update();
    let kept = |stage: &Stage| stage.app.world().resource::<CascadeCasters>().kept;
    assert!(kept(&stage) > 0);
    let frames_of_writing = Cell::new(0);
    stage.wait_for(|stage| {
        let keys = stage.app.world().get::<SunKeys>(stage.light).unwrap();
        if !keys.is_settled() {
            frames_of_writing.set(frames_of_writing.get() + 1);
            assert!(kept(stage) > 0, "it left the cascades before its keys were shown");
        }
        kept(stage) == 0
    });
    assert!(frames_of_writing.get() > 1, "{frames_of_writing:?}");
}
