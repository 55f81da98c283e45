//! When bakes begin, and which meshes are in their files.

use std::sync::mpsc::channel;

use adumbra::Sun;
use adumbra_bake::{BakeOptions, Size, Watch, bake};
use adumbra_scene::{GeneratedKind, generate};
use bevy::asset::AssetEvent;
use bevy::ecs::message::Messages;
use bevy::image::Image;
use bevy::math::Quat;
use bevy::mesh::Mesh;
use bevy::prelude::Transform;

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
        let light = world.spawn((DirectionalLight::default(), BakeShadow::default())).id();
        let mesh = world.spawn((Mesh3d::default(), InBake)).id();
        let mut systems = Schedule::default();
        systems.add_systems((count_changes, find_meshes, bake_shadows, mark_changes).chain());
        let mut stage = Self { world, systems, light, mesh };
        stage.update();
        stage
    }

    /// Starts with a file of what there is.
    fn baked() -> Self {
        let mut stage = Self::new();
        stage.finish(true);
        stage
    }

    fn update(&mut self) {
        self.systems.run(&mut self.world);
    }

    /// Has a bake of what there is now finish a file.
    fn finish(&mut self, is_last: bool) {
        let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
        let options = BakeOptions::new(sun, Size::Resolution(64));
        let file = bake(&generate(GeneratedKind::Primitives, 1), &options, Watch::none()).unwrap().file;
        let file = BakedShadowFile::new(file, DeviceLimits::default()).unwrap();
        let (sender, results) = channel();
        sender.send(Ok(Finished { file, seconds: 0.0, triangles: 0, blocks: [1, 0], is_last })).unwrap();
        let keys = Arc::clone(&self.world.resource::<StaticKeys>().keys);
        let towards_light = self.world.get::<GlobalTransform>(self.light).unwrap().back().as_vec3();
        let mut light = self.world.get_mut::<BakeShadow>(self.light).unwrap();
        light.seen = Some(Seen { settings: light.settings, towards_light, keys });
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

    /// Whether the newest bake saw something else than there is now.
    fn is_pending(&self) -> bool {
        self.world.get::<BakeShadow>(self.light).unwrap().pending.is_some()
    }

    /// Whether the mesh casts through the cascades.
    fn is_marked(&self) -> bool {
        self.world.get::<NotYetBaked>(self.mesh).is_some()
    }
}

#[test]
fn a_mesh_that_casts_no_more_or_again_is_baked_anew() {
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
fn a_mesh_or_a_material_that_is_changed_in_place_is_baked_anew() {
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
    // Materials of other meshes are none of the bake's.
    let other = stage.world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
    let of_other = AssetEvent::<StandardMaterial>::Modified { id: other.id() };
    stage.world.resource_mut::<Messages<AssetEvent<StandardMaterial>>>().write(of_other);
    stage.update();
    assert!(!stage.is_pending());
}

#[test]
fn meshes_in_use_are_those_of_the_newest_file_be_it_coarse() {
    let mut stage = Stage::baked();
    assert!(!stage.is_marked());
    stage.move_mesh(1.0);
    assert!(stage.is_marked());
    stage.finish(false);
    assert!(!stage.is_marked());
    // Back to where the file before has it.
    stage.move_mesh(0.0);
    assert!(stage.is_marked());
}

#[test]
fn once_all_meshes_are_gone_so_are_the_file_and_the_bake() {
    let mut stage = Stage::new();
    stage.update();
    stage.finish(false);
    assert_eq!(stage.files(), 1);
    stage.world.despawn(stage.mesh);
    stage.update();
    assert_eq!(stage.files(), 0);
    let bake = stage.world.get::<BakeShadow>(stage.light).unwrap();
    assert!(bake.seen.is_none() && bake.job.is_none() && bake.in_use.is_none());
    // The next level is baked.
    stage.mesh = stage.world.spawn((Mesh3d::default(), InBake)).id();
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn a_light_that_differs_by_rounding_alone_is_not_baked_anew() {
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
fn a_mesh_that_is_none_any_more_is_baked_anew() {
    let mut stage = Stage::new();
    let other = stage.world.spawn((Mesh3d::default(), InBake)).id();
    stage.update();
    stage.finish(true);
    assert!(!stage.is_pending());
    stage.world.entity_mut(other).remove::<Mesh3d>();
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn settings_that_are_given_again_keep_what_was_baked() {
    let mut stage = Stage::baked();
    let settings = BakeSettings { resolution: 4096, ..BakeSettings::default() };
    let light = stage.light;
    stage.world.commands().bake_shadow(light, settings);
    stage.world.flush();
    stage.update();
    let bake = stage.world.get::<BakeShadow>(light).unwrap();
    assert!(bake.in_use.is_some() && bake.settings == settings);
    assert!(stage.is_pending());
}

#[test]
fn a_mesh_that_is_not_there_is_left_out_and_baked_once_it_comes() {
    let mut stage = Stage::new();
    let file = BakeSettings { first_resolution: 64, resolution: 64, ..BakeSettings::default() };
    stage.world.get_mut::<BakeShadow>(stage.light).unwrap().settings = file;
    // There is a server, and it loads neither of them.
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
fn what_the_app_has_removed_comes_back_once_it_asks_again() {
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
fn a_level_that_is_swapped_in_one_frame_takes_its_file_along() {
    let mut stage = Stage::baked();
    stage.world.despawn(stage.mesh);
    stage.mesh = stage.world.spawn((Mesh3d::default(), InBake)).id();
    stage.update();
    assert_eq!(stage.files(), 0);
    stage.update();
    assert!(stage.is_pending());
}

#[test]
fn only_changes_that_a_bake_sees_are_baked() {
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
fn a_light_that_comes_before_its_level_waits_for_it() {
    let mut stage = Stage::baked();
    stage.world.despawn(stage.light);
    stage.update();
    stage.world.despawn(stage.mesh);
    stage.update();
    stage.light = stage.world.spawn((DirectionalLight::default(), BakeShadow::default())).id();
    stage.update();
    stage.update();
    assert!(!stage.is_pending());
    assert_eq!(stage.world.get::<BakeProgress>(stage.light), Some(&BakeProgress::Waiting));
    stage.mesh = stage.world.spawn((Mesh3d::default(), InBake)).id();
    stage.update();
    assert!(stage.is_pending());
}
