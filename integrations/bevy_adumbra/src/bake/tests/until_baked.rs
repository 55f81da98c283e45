//! Which meshes cast through the cascades until a file, or the keys of a light that is followed, have them.

use std::time::Instant;

use adumbra::Filter;
use bevy::ecs::system::RunSystemOnce;

use super::*;
use crate::StreamBudget;
use crate::components::ShadowStatic;
use crate::moving::{SunKeys, write_keys};
use crate::statics::mark_meshes;
use crate::stream::PoolUploads;

#[test]
fn marks_meshes_against_the_newest_file_even_if_coarse() {
    let mut stage = Stage::baked();
    assert!(!stage.is_marked());
    stage.move_mesh(1.0);
    assert!(stage.is_marked());
    stage.finish(false);
    assert!(!stage.is_marked());
    // Move back to the position in the earlier file.
    stage.move_mesh(0.0);
    assert!(stage.is_marked());
}

#[test]
fn a_mesh_that_is_disabled_and_enabled_again_casts_until_it_is_baked() {
    let mut stage = Stage::baked();
    let other = stage.world.spawn((Mesh3d::default(), IncludedInBake)).id();
    stage.update();
    stage.finish(true);
    stage.world.entity_mut(stage.mesh).insert(Disabled);
    stage.update();
    assert!(stage.is_pending(), "its shadow is to go");
    *stage.world.get_mut::<GlobalTransform>(other).unwrap() = GlobalTransform::from_xyz(1.0, 0.0, 0.0);
    stage.update();
    // This bake leaves out the disabled mesh.
    stage.finish(true);
    assert!(!stage.is_pending());
    stage.world.entity_mut(stage.mesh).remove::<Disabled>();
    stage.update();
    assert!(stage.is_pending() && stage.is_marked());
}

/// `moved_mesh_stays_in_cascades_until_its_keys_are_shown`, in `tests/gpu/follow.rs`, tests the same with
/// rendered pictures.
#[test]
fn moved_mesh_casts_until_its_keys_are_written() {
    let mut stage = Stage::new();
    let world = &mut stage.world;
    world.init_resource::<StreamBudget>();
    world.init_resource::<PoolUploads>();
    let plane: Mesh = Plane3d::default().mesh().size(20.0, 20.0).into();
    let plane = world.resource_mut::<Assets<Mesh>>().add(plane);
    world.entity_mut(stage.mesh).insert(Mesh3d(plane));
    let settings = BakeSettings { resolution: 64, settle: Duration::ZERO, ..BakeSettings::default() };
    let shines = Transform::default().looking_to(Vec3::new(-0.5, -0.8, -0.35), Vec3::Y);
    let follows = (BakedShadow::follow_sun(), RuntimeBake::new(settings), GlobalTransform::from(shines));
    world.entity_mut(stage.light).insert(follows);
    let mut follow = Schedule::default();
    follow.add_systems((count_changes, find_meshes, follow_suns, mark_changes).chain());
    follow_until(&mut stage, &mut follow, |stage| {
        write_all_keys(stage);
        stage.world.get::<RuntimeBake>(stage.light).unwrap().in_use.is_some()
    });
    // Only a new bake clears a failure.
    let failed = BakeProgress::Failed(BakeError::NoTriangles);
    stage.world.entity_mut(stage.light).insert(failed.clone());
    *stage.world.get_mut::<GlobalTransform>(stage.mesh).unwrap() = GlobalTransform::from_xyz(5.0, 0.0, 0.0);
    follow_until(&mut stage, &mut follow, |stage| {
        assert!(stage.is_marked());
        matches!(stage.world.get(stage.light), Some(BakeProgress::Following { .. }))
    });
    assert!(!stage.world.get::<SunKeys>(stage.light).unwrap().is_settled());
    // A failure while keys are written stays.
    stage.world.entity_mut(stage.light).insert(failed.clone());
    follow_until(&mut stage, &mut follow, |stage| {
        write_all_keys(stage);
        assert_eq!(stage.world.get(stage.light), Some(&failed));
        !stage.is_marked()
    });
}

/// Follows the light until `is_done`, which is asked after each frame.
fn follow_until(stage: &mut Stage, follow: &mut Schedule, is_done: impl Fn(&mut Stage) -> bool) {
    let begin = Instant::now();
    loop {
        follow.run(&mut stage.world);
        if is_done(stage) {
            return;
        }
        let progress = stage.world.get::<BakeProgress>(stage.light);
        assert!(begin.elapsed() < Duration::from_mins(5), "{progress:?}");
    }
}

fn write_all_keys(stage: &mut Stage) {
    let is_written = |stage: &Stage| {
        let keys = stage.world.get::<SunKeys>(stage.light);
        keys.is_none_or(|keys| keys.is_settled() || keys.sampler(Filter::Nearest).is_none())
    };
    while !is_written(stage) {
        stage.world.run_system_once(write_keys).unwrap();
        // Take the writes, as the render world does.
        stage.world.resource_mut::<PoolUploads>().writes.clear();
    }
}

#[test]
fn a_mesh_that_is_replaced_casts_until_it_is_baked() {
    let mut stage = Stage::baked();
    let rubble = stage.world.resource_mut::<Assets<Mesh>>().add(Plane3d::default());
    stage.world.entity_mut(stage.mesh).insert(Mesh3d(rubble));
    stage.update();
    assert!(stage.is_pending() && stage.is_marked());
    stage.finish(true);
    assert!(!stage.is_pending() && !stage.is_marked());
}

#[test]
fn a_piece_that_is_picked_up_and_put_down_casts_until_it_is_baked() {
    let mut stage = Stage::new();
    stage.systems = Schedule::default();
    stage.systems.add_systems((mark_meshes, count_changes, find_meshes, bake_shadows, mark_changes).chain());
    let root = stage.world.spawn(ShadowStatic).id();
    stage.world.entity_mut(stage.mesh).insert(ChildOf(root));
    stage.world.spawn((Mesh3d::default(), ShadowStatic));
    stage.update();
    stage.finish(true);
    assert!(!stage.is_pending() && !stage.is_marked());
    let is_static = |stage: &Stage| stage.world.get::<IncludedInBake>(stage.mesh).is_some();
    stage.world.entity_mut(root).remove::<ShadowStatic>();
    stage.update();
    assert!(!is_static(&stage) && stage.is_pending());
    stage.finish(true);
    stage.move_mesh(3.0);
    assert!(!stage.is_pending(), "what is carried is in no bake");
    stage.world.entity_mut(root).insert(ShadowStatic);
    stage.update();
    assert!(is_static(&stage) && stage.is_marked() && stage.is_pending());
    stage.finish(true);
    assert!(!stage.is_marked());
}

#[test]
fn a_copy_of_a_baked_mesh_casts_until_it_is_baked() {
    let mut stage = Stage::baked();
    let mesh = stage.mesh;
    let copy = stage.world.commands().entity(mesh).clone_and_spawn().id();
    stage.world.flush();
    *stage.world.get_mut::<GlobalTransform>(copy).unwrap() = GlobalTransform::from_xyz(5.0, 0.0, 0.0);
    stage.update();
    assert!(stage.world.get::<IncludedInBake>(copy).is_some());
    assert!(stage.world.get::<AwaitingBake>(copy).is_some() && !stage.is_marked() && stage.is_pending());
    stage.finish(true);
    assert!(stage.world.get::<AwaitingBake>(copy).is_none());
}
