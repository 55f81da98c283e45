//! When bakes begin, and which meshes are in their files.

mod until_baked;

use std::sync::mpsc::channel;

use adumbra::Sun;
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_scene::{GeneratedKind, generate};
use bevy::asset::AssetEvent;
use bevy::ecs::message::Messages;
use bevy::image::Image;
use bevy::math::Quat;
use bevy::math::primitives::Plane3d;
use bevy::mesh::{Mesh, Meshable};
use bevy::prelude::Transform;
use bevy::time::Virtual;

use super::*;

/// A light and a mesh, without a renderer. The mesh is not loaded, so that no bake begins by itself.
struct Stage {
    world: World,
    systems: Schedule,
    light: Entity,
    mesh: Entity,
}

impl Stage {
    fn new() -> Self {
        let mut world = World::new();
        world.init_resource::<Assets<Mesh>>();
        world.init_resource::<Assets<StandardMaterial>>();
        world.init_resource::<Assets<Image>>();
        world.init_resource::<Assets<BakedShadowFile>>();
        world.init_resource::<StaticKeys>();
        world.init_resource::<AssetVersions>();
        world.init_resource::<Messages<AssetEvent<Mesh>>>();
        world.init_resource::<Messages<AssetEvent<StandardMaterial>>>();
        world.init_resource::<Messages<AssetEvent<Image>>>();
        world.init_resource::<DeviceLimits>();
        world.init_resource::<Time<Real>>();
        let light = world.spawn((DirectionalLight::default(), RuntimeBake::default())).id();
        let mesh = world.spawn((Mesh3d::default(), IncludedInBake)).id();
        world.add_observer(pause_bakes);
        let mut systems = Schedule::default();
        systems.add_systems((count_changes, find_meshes, bake_shadows, mark_changes).chain());
        let mut stage = Self { world, systems, light, mesh };
        stage.update();
        stage
    }

    /// Returns a stage whose light has a file of the current scene.
    fn baked() -> Self {
        let mut stage = Self::new();
        stage.finish(true);
        stage
    }

    fn update(&mut self) {
        self.systems.run(&mut self.world);
    }

    /// Finishes a bake of the current scene with a file.
    fn finish(&mut self, is_last: bool) {
        let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
        let options = BakeOptions::new(sun, Size::Resolution(64));
        let file = Bake::with_options(&generate(GeneratedKind::Primitives, 1), &options).in_memory().unwrap();
        let file = BakedShadowFile::new(file, DeviceLimits::default()).unwrap();
        let (sender, results) = channel();
        sender.send(Ok(Finished { file, seconds: 0.0, triangles: 0, blocks: [1, 0], is_last })).unwrap();
        let keys = Arc::clone(&self.world.resource::<StaticKeys>().keys);
        let towards_light = self.world.get::<GlobalTransform>(self.light).unwrap().back().as_vec3();
        let mut light = self.world.get_mut::<RuntimeBake>(self.light).unwrap();
        light.seen = Some(BakeInputs { settings: light.settings, towards_light, keys });
        light.job = Some(Job::of_test(results));
        self.update();
    }

    fn move_mesh(&mut self, x: f32) {
        let mut transform = self.world.get_mut::<GlobalTransform>(self.mesh).unwrap();
        *transform = GlobalTransform::from_xyz(x, 0.0, 0.0);
        self.update();
    }

    /// How many files the light has.
    fn files(&self) -> usize {
        self.world.get::<BakedShadow>(self.light).map_or(0, |shadow| shadow.files.len())
    }

    /// Whether the scene differs from what the newest bake saw.
    fn is_pending(&self) -> bool {
        self.world.get::<RuntimeBake>(self.light).unwrap().pending.is_some()
    }

    /// Whether the mesh casts through the cascades.
    fn is_marked(&self) -> bool {
        self.world.get::<AwaitingBake>(self.mesh).is_some()
    }
}

#[test]
fn rebakes_when_a_mesh_stops_or_starts_casting() {
    let mut stage = Stage::baked();
    assert!(!stage.is_pending());
    stage.world.entity_mut(stage.mesh).insert(NotShadowCaster);
    stage.update();
    assert!(stage.is_pending());
    stage.finish(true);
    assert!(!stage.is_pending());
    stage.world.entity_mut(stage.mesh).remove::<NotShadowCaster>();
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn rebakes_when_a_mesh_or_material_changes_in_place() {
    let mut stage = Stage::new();
    let material = stage.world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
    stage.world.entity_mut(stage.mesh).insert(MeshMaterial3d(material.clone()));
    stage.update();
    stage.finish(true);
    assert!(!stage.is_pending());
    let mesh = stage.world.get::<Mesh3d>(stage.mesh).unwrap().id();
    let of_mesh = AssetEvent::<Mesh>::Modified { id: mesh };
    stage.world.resource_mut::<Messages<AssetEvent<Mesh>>>().write(of_mesh);
    stage.update();
    assert!(stage.is_pending() && stage.is_marked());
    stage.finish(true);
    assert!(!stage.is_pending());
    let holes = bevy::prelude::AlphaMode::Mask(0.5);
    stage.world.resource_mut::<Assets<StandardMaterial>>().get_mut(&material).unwrap().alpha_mode = holes;
    let of_material = AssetEvent::<StandardMaterial>::Modified { id: material.id() };
    stage.world.resource_mut::<Messages<AssetEvent<StandardMaterial>>>().write(of_material);
    stage.update();
    assert!(stage.is_pending());
    stage.finish(true);
    // Materials of other meshes do not affect the bake.
    let other = stage.world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
    let of_other = AssetEvent::<StandardMaterial>::Modified { id: other.id() };
    stage.world.resource_mut::<Messages<AssetEvent<StandardMaterial>>>().write(of_other);
    stage.update();
    assert!(!stage.is_pending());
}

#[test]
fn drops_file_and_bake_when_all_meshes_are_gone() {
    let mut stage = Stage::new();
    stage.update();
    stage.finish(false);
    assert_eq!(stage.files(), 1);
    stage.world.despawn(stage.mesh);
    stage.update();
    assert_eq!(stage.files(), 0);
    let bake = stage.world.get::<RuntimeBake>(stage.light).unwrap();
    assert!(bake.seen.is_none() && bake.job.is_none() && bake.in_use.is_none());
    // The next level is baked.
    stage.mesh = stage.world.spawn((Mesh3d::default(), IncludedInBake)).id();
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn ignores_light_changes_within_rounding() {
    let mut stage = Stage::baked();
    let turn = |stage: &mut Stage, radians: f32| {
        let turned = Transform::from_rotation(Quat::from_rotation_y(radians));
        *stage.world.get_mut::<GlobalTransform>(stage.light).unwrap() = turned.into();
        stage.update();
    };
    turn(&mut stage, 5e-6);
    assert!(!stage.is_pending());
    turn(&mut stage, 1e-3);
    assert!(stage.is_pending());
}

#[test]
fn rebakes_when_an_entity_loses_its_mesh() {
    let mut stage = Stage::new();
    let other = stage.world.spawn((Mesh3d::default(), IncludedInBake)).id();
    stage.update();
    stage.finish(true);
    assert!(!stage.is_pending());
    stage.world.entity_mut(other).remove::<Mesh3d>();
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn keeps_the_file_when_bake_shadow_is_called_again() {
    let mut stage = Stage::baked();
    let settings = BakeSettings { resolution: 4096, ..BakeSettings::default() };
    let light = stage.light;
    stage.world.commands().bake_shadow(light, settings);
    stage.world.flush();
    stage.update();
    let bake = stage.world.get::<RuntimeBake>(light).unwrap();
    assert!(bake.in_use.is_some() && bake.settings == settings);
    assert!(stage.is_pending());
}

#[test]
fn leaves_out_a_missing_mesh_and_rebakes_when_it_loads() {
    let mut stage = Stage::new();
    let file = BakeSettings { first_resolution: 64, resolution: 64, ..BakeSettings::default() };
    stage.world.get_mut::<RuntimeBake>(stage.light).unwrap().settings = file;
    // An asset server exists, and it is not loading the mesh.
    let mut app = bevy::app::App::new();
    app.add_plugins((bevy::app::TaskPoolPlugin::default(), bevy::asset::AssetPlugin::default()));
    let server = app.world().resource::<bevy::asset::AssetServer>().clone();
    stage.world.insert_resource(server);
    stage.update();
    stage.update();
    let progress = |stage: &Stage| stage.world.get::<BakeProgress>(stage.light).unwrap().clone();
    assert_eq!(progress(&stage), BakeProgress::Failed(BakeError::NoTriangles));
    assert!(!stage.is_pending());
    let id = stage.world.get::<Mesh3d>(stage.mesh).unwrap().id();
    stage.world.resource_mut::<Messages<AssetEvent<Mesh>>>().write(AssetEvent::Added { id });
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn rebakes_a_removed_shadow_only_on_request() {
    let mut stage = Stage::baked();
    stage.world.entity_mut(stage.light).remove::<BakedShadow>();
    stage.update();
    stage.move_mesh(1.0);
    assert!(!stage.is_pending());
    let (light, settings) = (stage.light, BakeSettings::default());
    stage.world.commands().bake_shadow(light, settings);
    stage.world.flush();
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn drops_the_file_of_a_level_swapped_in_one_frame() {
    let mut stage = Stage::baked();
    stage.world.despawn(stage.mesh);
    stage.mesh = stage.world.spawn((Mesh3d::default(), IncludedInBake)).id();
    stage.update();
    assert_eq!(stage.files(), 0);
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn ignores_material_changes_that_do_not_affect_shadows() {
    let mut stage = Stage::new();
    let material = stage.world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
    stage.world.entity_mut(stage.mesh).insert(MeshMaterial3d(material.clone()));
    stage.update();
    stage.finish(true);
    let change = |stage: &mut Stage, change: fn(&mut StandardMaterial)| {
        let mut materials = stage.world.resource_mut::<Assets<StandardMaterial>>();
        change(&mut materials.get_mut(&material).unwrap());
        let id = material.id();
        let modified = AssetEvent::<StandardMaterial>::Modified { id };
        stage.world.resource_mut::<Messages<AssetEvent<StandardMaterial>>>().write(modified);
        stage.update();
    };
    change(&mut stage, |material| material.emissive = bevy::color::LinearRgba::WHITE);
    assert!(!stage.is_pending(), "it glows");
    change(&mut stage, |material| material.alpha_mode = bevy::prelude::AlphaMode::Mask(0.5));
    assert!(stage.is_pending(), "it has holes");
}

#[test]
fn waits_for_meshes_when_the_light_comes_first() {
    let mut stage = Stage::baked();
    stage.world.despawn(stage.light);
    stage.update();
    stage.world.despawn(stage.mesh);
    stage.update();
    stage.light = stage.world.spawn((DirectionalLight::default(), RuntimeBake::default())).id();
    stage.update();
    stage.update();
    assert!(!stage.is_pending());
    assert_eq!(stage.world.get::<BakeProgress>(stage.light), Some(&BakeProgress::Waiting));
    stage.mesh = stage.world.spawn((Mesh3d::default(), IncludedInBake)).id();
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn ignores_a_swap_to_a_material_that_casts_alike() {
    let mut stage = Stage::new();
    let [first, second, glass] = [false, false, true].map(|is_glass| {
        let specular_transmission = if is_glass { 1.0 } else { 0.0 };
        let material = StandardMaterial { specular_transmission, ..Default::default() };
        stage.world.resource_mut::<Assets<StandardMaterial>>().add(material)
    });
    stage.world.entity_mut(stage.mesh).insert(MeshMaterial3d(first));
    stage.update();
    stage.finish(true);
    assert!(!stage.is_pending());
    stage.world.entity_mut(stage.mesh).insert(MeshMaterial3d(second));
    stage.update();
    assert!(!stage.is_pending() && !stage.is_marked());
    stage.world.entity_mut(stage.mesh).insert(MeshMaterial3d(glass));
    stage.update();
    assert!(stage.is_pending() && stage.is_marked());
}

#[test]
fn removal_during_a_bake_lasts_until_the_app_asks_again() {
    let mut stage = Stage::new();
    stage.finish(false);
    assert_eq!(stage.files(), 1);
    let light = stage.light;
    stage.world.entity_mut(light).remove::<(BakedShadow, RuntimeBake)>();
    stage.update();
    stage.update();
    assert_eq!(stage.files(), 0);
    assert!(stage.world.get::<BakeProgress>(light).is_none());
    stage.world.commands().bake_shadow(light, BakeSettings::default());
    stage.world.flush();
    stage.update();
    assert!(stage.is_pending());
    stage.finish(true);
    assert!(stage.files() == 1 && !stage.is_marked());
    // Despawn the light during a bake, and spawn another one.
    stage.world.despawn(light);
    stage.light = stage.world.spawn((DirectionalLight::default(), RuntimeBake::default())).id();
    stage.update();
    assert!(stage.files() == 0 && stage.is_pending());
}

#[test]
fn rebakes_when_removed_and_requested_in_one_frame() {
    let mut stage = Stage::baked();
    let light = stage.light;
    // A bake with the earlier settings is under way.
    stage.world.get_mut::<RuntimeBake>(light).unwrap().job = Some(Job::of_test(channel().1));
    stage.world.entity_mut(light).remove::<BakedShadow>();
    stage.world.commands().bake_shadow(light, BakeSettings::default());
    stage.world.flush();
    assert!(stage.world.get::<RuntimeBake>(light).unwrap().job.is_none());
    stage.update();
    assert!(stage.is_pending());
    // A `RuntimeBake` that is removed and inserted again bakes too.
    stage.finish(true);
    stage.world.entity_mut(light).remove::<(BakedShadow, RuntimeBake)>().insert(RuntimeBake::default());
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn bakes_while_virtual_time_is_paused() {
    let mut stage = Stage::new();
    let plane = stage.world.resource_mut::<Assets<Mesh>>().add(Plane3d::default().mesh().size(20.0, 20.0));
    stage.world.entity_mut(stage.mesh).insert(Mesh3d(plane));
    let shines = Transform::default().looking_to(Vec3::new(-0.5, -0.8, -0.35), Vec3::Y);
    let settings = BakeSettings { resolution: 64, first_resolution: 64, ..BakeSettings::default() };
    stage.world.entity_mut(stage.light).insert(GlobalTransform::from(shines));
    stage.world.get_mut::<RuntimeBake>(stage.light).unwrap().settings = settings;
    stage.update();
    stage.finish(true);
    let mut stopped = Time::<Virtual>::default();
    stopped.pause();
    stage.world.insert_resource(stopped);
    // The first update only starts the clock.
    stage.world.resource_mut::<Time<Real>>().update_with_duration(Duration::ZERO);
    stage.move_mesh(1.0);
    stage.update();
    assert!(stage.is_pending() && stage.is_marked());
    stage.world.resource_mut::<Time<Real>>().update_with_duration(Duration::from_millis(600));
    stage.update();
    assert!(!stage.is_pending());
}
