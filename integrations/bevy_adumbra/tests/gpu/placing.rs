//! Files that follow roots which the app moves, turns and scales, compared with look-ups on the CPU.

use adumbra::{Filter, Placement};
use adumbra_bake::FrameChoice;
use bevy::prelude::*;
use bevy_adumbra::CascadeCasters;
use bevy_adumbra::prelude::*;

use crate::stage::{MIDDLE, SQUARE, Stage, assert_alike, baked, expected_by};

/// Places that an app may give a file: where, turned about Y, X and Z, and how large.
const PLACES: [([f32; 3], [f32; 3], f32); 10] = [
    ([-40.0, 2.0, 16.0], [0.4, 0.0, 0.0], 0.1),
    ([-3.0, 0.5, 8.0], [2.8, -0.2, 0.1], 3.28),
    ([100.0, -20.0, 3000.0], [0.0, 0.0, 0.0], 1.0),
    ([0.0, 0.0, 0.0], [1.1, 0.0, 0.0], 1.0),
    ([0.0, 0.0, 0.0], [0.0, -1.570_796_4, 0.0], 1.0),
    ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.01),
    ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 100.0),
    ([5.0, 7.0, -9.0], [0.3, -2.0, 0.5], 1.0),
    ([1000.0, 0.0, -500.0], [1.0, 2.0, 3.0], 0.5),
    ([12.0, -3.0, 40.0], [0.0, 2.2, 0.0], 1.0),
];

/// Draws the square at each place. The camera and one of two copies of the file move there with it; the
/// copies take turns.
fn assert_follows(places: &[([f32; 3], [f32; 3], f32)]) {
    let file = baked(FrameChoice::Oblique);
    let mut stage = Stage::new(|_| {});
    let handle = stage.give(file.clone(), |_| {});
    let roots = [0, 1]
        .map(|_| stage.app.world_mut().spawn((FileRoot::new(handle.clone()), Transform::default())).id());
    for (n, (at, [y, x, z], scale)) in places.iter().enumerate() {
        let place = Transform {
            translation: Vec3::from_array(*at),
            rotation: Quat::from_euler(EulerRot::YXZ, *y, *x, *z),
            scale: Vec3::splat(*scale),
        };
        let away = Transform { translation: place.translation + 1e4 * scale * Vec3::X, ..place };
        let world = stage.app.world_mut();
        for (root, transform) in roots.iter().zip(if n % 2 == 0 { [place, away] } else { [away, place] }) {
            *world.get_mut::<Transform>(*root).unwrap() = transform;
        }
        *world.get_mut::<Transform>(stage.square).unwrap() = place * Transform::from_translation(MIDDLE);
        let above = Transform::from_translation(MIDDLE + 90.0 * Vec3::Y).looking_at(MIDDLE, Vec3::NEG_Z);
        *world.get_mut::<Transform>(stage.camera).unwrap() = (place * above).with_scale(Vec3::ONE);
        let mut from_above = crate::stage::from_above(scale * SQUARE);
        if let Projection::Orthographic(projection) = &mut from_above {
            projection.far = 200.0 * scale;
        }
        *world.get_mut::<Projection>(stage.camera).unwrap() = from_above;
        let columns = place.to_matrix().to_cols_array_2d().map(|column| column.map(f64::from));
        let placement = Placement::from_matrix(columns).unwrap();
        let placed = file.sampler(Filter::Box5).placed(&placement);
        let normal = placement.direction_to_world([0.0, 1.0, 0.0]);
        let expected = expected_by(|p, _| placed.visibility(placement.to_world(p), Some(normal)));
        // The first root turns the light, and the file is in use at both roots.
        assert_alike(&stage.visibility(), &expected, Filter::Box5);
        assert_eq!(stage.status(), BakedShadowStatus::Active { files: 2 }, "{n}");
    }
}

#[test]
fn a_file_follows_its_root_and_its_copy() {
    assert_follows(&PLACES[..2]);
}

#[test]
#[ignore = "slow: draws many frames"]
fn a_file_follows_its_root_wherever_it_goes() {
    assert_follows(&PLACES);
}

#[test]
fn reports_a_stretched_root_and_keeps_other_roots_in_use() {
    let file = baked(FrameChoice::Oblique);
    let mut stage = Stage::new(|_| {});
    let handle = stage.give(file, |_| {});
    let world = stage.app.world_mut();
    let wide =
        world.spawn((FileRoot::new(handle.clone()), Transform::from_scale(Vec3::new(1.0, 2.0, 1.0)))).id();
    stage.update_until_known();
    assert!(
        matches!(stage.status(), BakedShadowStatus::Unusable(BakedShadowError::Root(_))),
        "{}",
        stage.status()
    );
    let root = stage.app.world_mut().spawn((FileRoot::new(handle.clone()), Transform::default())).id();
    stage.update();
    let status = stage.status();
    assert!(matches!(status, BakedShadowStatus::Incomplete { files: 1, missing: 1, .. }), "{status}");
    assert!(
        status.to_string().contains("1 of 2 files are missing: a file cannot follow its FileRoot"),
        "{status}"
    );
    stage.app.world_mut().despawn(wide);
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
    // Between two levels the file is nowhere.
    stage.app.world_mut().despawn(root);
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Waiting);
    // A level that is entered again, somewhere else, has its file in the first frame.
    let light = stage.light;
    stage.app.world_mut().despawn(light);
    stage.update();
    let at = Transform::from_xyz(50.0, 0.0, 0.0).with_rotation(Quat::from_rotation_y(1.0));
    let world = stage.app.world_mut();
    world.spawn((FileRoot::new(handle.clone()), at));
    let light = DirectionalLight { shadow_maps_enabled: true, ..default() };
    stage.light = world.spawn((light, BakedShadow::new(handle))).id();
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
}

/// Static meshes outside of the files in use cast through the cascades while the light has other files.
#[test]
fn meshes_of_loading_or_turned_away_files_stay_in_cascades() {
    let mut stage = Stage::new(|_| {});
    let handle = stage.give(baked(FrameChoice::Oblique), |_| {});
    let far = Vec3::new(2000.0, 0.0, 0.0);
    let world = stage.app.world_mut();
    let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::from_length(2.0));
    let at = Transform::from_translation(MIDDLE + far + Vec3::new(0.0, 5.0, 0.0));
    world.spawn((Mesh3d(cube), MeshMaterial3d(stage.material.clone()), at, ShadowStatic));
    stage.app.world_mut().get_mut::<Transform>(stage.camera).unwrap().translation += far;
    stage.update_until_known();
    let kept = |stage: &mut Stage| {
        stage.update();
        stage.update();
        assert!(stage.status().is_active(), "{}", stage.status());
        stage.app.world().resource::<CascadeCasters>().kept
    };
    assert_eq!(kept(&mut stage), 0, "its light has no other file");
    let loading = stage.app.world().resource::<Assets<BakedShadowFile>>().reserve_handle();
    stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap().files.push(loading);
    assert!(kept(&mut stage) > 0, "a file is loading");
    stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap().files.truncate(1);
    assert_eq!(kept(&mut stage), 0);
    stage.app.world_mut().spawn((FileRoot::new(handle.clone()), Transform::default()));
    let turned = Transform::from_translation(far).with_rotation(Quat::from_rotation_y(1.5));
    stage.app.world_mut().spawn((FileRoot::new(handle), turned));
    assert!(kept(&mut stage) > 0, "the copy is turned away from the light");
}

/// Twelve places of one file, of which eight are in use: meshes in the others go on casting through the
/// cascades.
#[test]
fn meshes_of_missing_files_stay_in_cascades() {
    let file = baked(FrameChoice::Oblique);
    let mut stage = Stage::new(|_| {});
    let handle = stage.give(file, |_| {});
    let world = stage.app.world_mut();
    for i in 0..12 {
        world.spawn((FileRoot::new(handle.clone()), Transform::from_xyz(2000.0 * i as f32, 0.0, 0.0)));
    }
    let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::from_length(2.0));
    let at = Transform::from_translation(MIDDLE + Vec3::new(0.0, 5.0, 0.0));
    let mesh = (Mesh3d(cube.clone()), MeshMaterial3d(stage.material.clone()), at, ShadowStatic);
    let world = stage.app.world_mut();
    world.spawn(mesh.clone());
    for _ in 0..3 {
        stage.update();
    }
    let status = stage.status();
    assert!(
        matches!(
            status,
            BakedShadowStatus::Incomplete {
                files: 8,
                missing: 4,
                fault: BakedShadowError::TooManyFiles { limit: 8 }
            }
        ),
        "{status}"
    );
    let kept = |stage: &Stage| stage.app.world().resource::<CascadeCasters>().kept;
    assert_eq!(kept(&stage), 0, "the first place is in use");
    // A mesh that reaches beyond the files in use.
    let wide = stage.app.world_mut().resource_mut::<Assets<Mesh>>().add(Cuboid::new(3000.0, 1.0, 2.0));
    let wide = stage
        .app
        .world_mut()
        .spawn((Mesh3d(wide), MeshMaterial3d(stage.material.clone()), at, ShadowStatic))
        .id();
    for _ in 0..3 {
        stage.update();
    }
    assert!(kept(&stage) > 0, "a part of it is in no file");
    stage.app.world_mut().despawn(wide);
    // Move the camera to the last place, and put a mesh there.
    let move_by = Vec3::new(2000.0 * 11.0, 0.0, 0.0);
    let world = stage.app.world_mut();
    world.spawn((mesh.0, mesh.1, at.with_translation(at.translation + move_by), ShadowStatic));
    world.get_mut::<Transform>(stage.camera).unwrap().translation += move_by;
    for _ in 0..3 {
        stage.update();
    }
    assert!(kept(&stage) > 0, "its file is missing");
}

/// The statuses that the light has had.
#[derive(Resource, Default)]
struct Statuses(Vec<BakedShadowStatus>);

#[test]
fn realigns_a_turned_light_or_reports_it_misaligned_once() {
    let mut stage = Stage::new(|_| {});
    stage.give(baked(FrameChoice::Oblique), |_| {});
    stage.app.init_resource::<Statuses>();
    let push = |change: On<BakedShadowChanged>, mut all: ResMut<Statuses>| all.0.push(change.status.clone());
    stage.app.world_mut().entity_mut(stage.light).observe(push);
    let turn = |stage: &mut Stage| {
        for _ in 0..5 {
            stage.app.world_mut().get_mut::<Transform>(stage.light).unwrap().rotate_y(0.1);
            stage.update();
        }
    };
    stage.update();
    turn(&mut stage);
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
    stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap().align = false;
    turn(&mut stage);
    let BakedShadowStatus::Misaligned { degrees } = stage.status() else { panic!("{}", stage.status()) };
    assert!(degrees > 10.0);
    let all = &stage.app.world().resource::<Statuses>().0;
    assert!(
        matches!(all[..], [BakedShadowStatus::Active { files: 1 }, BakedShadowStatus::Misaligned { .. }]),
        "{all:?}"
    );
    // Aligned again, the light gets back the rotation that the app has set last once it has no file.
    stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap().align = true;
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
    let last = Quat::from_rotation_x(-1.0);
    stage.app.world_mut().get_mut::<Transform>(stage.light).unwrap().rotation = last;
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
    stage.app.world_mut().entity_mut(stage.light).remove::<BakedShadow>();
    stage.update();
    assert_eq!(stage.app.world().get::<Transform>(stage.light).unwrap().rotation, last);
}
