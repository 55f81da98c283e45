//! Bakes while the app runs, and lights of glTF files that name their file.

use std::time::Duration;

use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::Bake;
use adumbra_scene::{GeneratedKind, generate, write_glb, write_shadow_name};
use bevy::light::CascadeShadowConfig;
use bevy::prelude::*;
use bevy_adumbra::CascadeCasters;
use bevy_adumbra::prelude::*;

use crate::stage::{MIDDLE, SIDE, SQUARE, Stage, assert_alike, beside_tower, expected, towards_sun, tower};

fn file_in_use(stage: &Stage) -> ShadowFile {
    let world = stage.app.world();
    let handle = &world.get::<BakedShadow>(stage.light).expect("a file").files[0];
    ShadowFile::clone(world.resource::<Assets<BakedShadowFile>>().get(handle).expect("loaded").file())
}

fn progress(stage: &Stage) -> BakeProgress {
    stage.app.world().get::<BakeProgress>(stage.light).expect("a bake").clone()
}

#[test]
fn a_world_is_baked_while_the_app_runs_and_again_when_it_changes() {
    let mut stage = Stage::new(|_| {});
    let tower = tower(&mut stage, 10.0);
    let settings = BakeSettings {
        resolution: 1024,
        first_resolution: 128,
        settle: Duration::from_millis(50),
        ..default()
    };
    stage.app.world_mut().entity_mut(stage.light).insert(RuntimeBake::new(settings));
    let is_done =
        |stage: &Stage| matches!(progress(stage), BakeProgress::Done { .. }) && stage.status().is_active();
    stage.wait_for(is_done);
    let first = file_in_use(&stage);
    assert_eq!(first.settings.resolution, 1024);
    assert_alike_beside(&mut stage, &first, 10.0);
    let cascades =
        |stage: &mut Stage| (stage.cascades(), stage.app.world().resource::<CascadeCasters>().kept);
    // Nothing moves, so no cascade is drawn.
    assert_eq!(cascades(&mut stage), (0, 0));

    // The tower moves. Its shadow comes from the cascades at once, and from a new file soon after.
    stage.app.world_mut().get_mut::<Transform>(tower).unwrap().translation.x = -20.0;
    stage.update();
    stage.update();
    let (count, kept) = cascades(&mut stage);
    assert!(count == 4 && kept > 0, "{count} cascades with {kept} casters");
    let handle = |stage: &Stage| stage.app.world().get::<BakedShadow>(stage.light).unwrap().files[0].id();
    let earlier = handle(&stage);
    stage.wait_for(|stage| is_done(stage) && handle(stage) != earlier);
    stage.update();
    stage.update();
    assert_eq!(cascades(&mut stage), (0, 0));
    let second = file_in_use(&stage);
    assert_alike_beside(&mut stage, &second, -20.0);
}

/// Compares the square beside the tower, whose roof is at x and z = 10.
fn assert_alike_beside(stage: &mut Stage, file: &ShadowFile, x: f32) {
    let expected = expected(file, Filter::Box5);
    let mut found = stage.visibility();
    beside_tower(x, &mut found, &expected);
    assert_alike(&found, &expected, Filter::Box5);
}

#[test]
fn failed_bake_reports_its_error_and_keeps_cascades() {
    let mut stage = Stage::new(|_| {});
    let world = stage.app.world_mut();
    let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::from_length(3.0));
    world.spawn((Mesh3d(cube), ShadowStatic, Transform::from_xyz(0.0, 5.0, 0.0)));
    // A sun below the horizon.
    *world.get_mut::<Transform>(stage.light).unwrap() = Transform::default().looking_to(Vec3::Y, Vec3::Z);
    world.entity_mut(stage.light).insert(RuntimeBake::default());
    stage.wait_for(|stage| matches!(progress(stage), BakeProgress::Failed(BakeError::Sun(_))));
    assert_eq!(stage.app.world().get::<CascadeShadowConfig>(stage.light).unwrap().bounds.len(), 4);
}

#[test]
fn a_light_of_a_gltf_file_loads_the_file_that_it_names() {
    let folder = tempfile::tempdir().unwrap();
    let (scene_path, file_path) = (folder.path().join("p.glb"), folder.path().join("p.adumbra"));
    let scene = generate(GeneratedKind::Primitives, 1);
    let sun = Sun::from_direction(towards_sun()).unwrap();
    write_glb(&scene, &scene_path).unwrap();
    Bake::new(&scene, sun).resolution(256).save(file_path).unwrap();
    write_shadow_name(&scene_path, "p.adumbra", sun).unwrap();
    let mut stage = Stage::with_assets(&folder.path().to_string_lossy());
    let root = stage.app.world().resource::<AssetServer>().load("p.glb#Scene0");
    let light = stage.light;
    stage.app.world_mut().despawn(light);
    stage.app.world_mut().spawn((WorldAssetRoot(root), ShadowStatic));
    for _ in 0..2000 {
        stage.update();
        let mut lights = stage.app.world_mut().query::<(&BakedShadowStatus, &DirectionalLight)>();
        let world = stage.app.world();
        if let Some((_, light)) = lights.iter(world).find(|(status, _)| status.is_active()) {
            assert!(light.shadow_maps_enabled);
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("no light uses the file");
}

/// The shadow of a mover is added to those of the file.
#[test]
fn movers_cast_beside_the_file() {
    let file = crate::stage::baked(adumbra_bake::FrameChoice::Oblique);
    let mut stage = Stage::new(|_| {});
    stage.give(file, |shadow| shadow.filter = ShadowFilter::Nearest);
    let before = stage.visibility();
    let world = stage.app.world_mut();
    let ball = world.resource_mut::<Assets<Mesh>>().add(Sphere::new(6.0));
    let material = MeshMaterial3d(stage.material.clone());
    // Put the ball above the largest sunlit part, and above the camera, which looks down from 90 m: the
    // picture shows its shadow but not the ball.
    let lit_around = |column: u32, row: u32| {
        let pixels = (row - 12..row + 12).flat_map(|y| (column - 12..column + 12).map(move |x| (x, y)));
        pixels.filter(|&(x, y)| before[(y * SIDE + x) as usize] == 1.0).count()
    };
    let middles = (12..SIDE - 12).step_by(4).flat_map(|y| (12..SIDE - 12).step_by(4).map(move |x| (x, y)));
    let (column, row) = middles.max_by_key(|&(x, y)| lit_around(x, y)).expect("pixels");
    let [x, z] = [column, row].map(|n| (n as f32 / SIDE as f32 - 0.5) * SQUARE);
    let towards_sun = Vec3::from_array(towards_sun().map(|c| c as f32)).normalize();
    let at = MIDDLE + Vec3::new(x, 0.0, z) + 110.0 / towards_sun.y * towards_sun;
    world.spawn((Mesh3d(ball), material, Transform::from_translation(at)));
    let after = stage.visibility();
    let pairs = || before.iter().zip(&after);
    let new = pairs().filter(|(before, after)| **before == 1.0 && **after < 0.5).count();
    let lost = pairs().filter(|(before, after)| **before < 0.5 && **after > 0.5).count();
    println!("{new} pixels in the ball's shadow alone");
    assert!(new > 100 && lost == 0, "{new} new, {lost} lost");
}
