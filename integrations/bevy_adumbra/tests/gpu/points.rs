//! Points in every kind of view and material, compared with look-ups on the CPU.

use adumbra::{Bias, Error, Filter, RangeError, RangeField};
use adumbra_bake::FrameChoice;
use bevy::camera::visibility::CascadesVisibleEntities;
use bevy::camera::{RenderTarget, Viewport};
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::light::CascadeShadowConfig;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::pbr::{DefaultOpaqueRendererMethod, ExtendedMaterial, MaterialExtension, MaterialPlugin};
use bevy::prelude::*;
use bevy::reflect::TypePath;
use bevy::render::RenderApp;
use bevy::render::render_resource::{AsBindGroup, CachedPipelineState, PipelineCache, TextureFormat};
use bevy_adumbra::prelude::*;
use bevy_adumbra::{CascadeCasters, DeviceLimits, IncludedInBake};

use crate::stage::{MIDDLE, SIDE, SQUARE, Stage, assert_alike, baked, expected, from_above, picture};

fn oblique() -> adumbra::ShadowFile {
    baked(FrameChoice::Oblique)
}

#[test]
fn pictures_match_look_ups_for_each_frame_choice() {
    let mut stage = Stage::new(|_| {});
    let cases = [
        (FrameChoice::Oblique, Filter::Nearest),
        (FrameChoice::Light, Filter::Box5),
        (FrameChoice::Oblique, Filter::Box9),
    ];
    for (frame, filter) in cases {
        let file = baked(frame);
        stage.give(file.clone(), |shadow| shadow.filter = filter.into());
        assert_alike(&stage.visibility(), &expected(&file, filter), filter);
        assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
    }
}

#[test]
#[ignore = "slow: draws many frames"]
fn deferred_multisampled_and_transparent_surfaces_are_shadowed() {
    let file = oblique();
    let expected = expected(&file, Filter::Box5);
    let mut stage = Stage::new(|_| {});
    stage.give(file, |_| {});
    stage.app.world_mut().entity_mut(stage.camera).insert(Msaa::Sample4);
    assert_alike(&stage.visibility(), &expected, Filter::Box5);
    stage.app.world_mut().entity_mut(stage.camera).insert(Msaa::Off);
    let material = stage.material.clone();
    let blend = |stage: &mut Stage, mode| {
        let mut materials = stage.app.world_mut().resource_mut::<Assets<StandardMaterial>>();
        materials.get_mut(&material).unwrap().alpha_mode = mode;
    };
    blend(&mut stage, AlphaMode::Blend);
    assert_alike(&stage.visibility(), &expected, Filter::Box5);
    blend(&mut stage, AlphaMode::Opaque);
    let world = stage.app.world_mut();
    world.insert_resource(DefaultOpaqueRendererMethod::deferred());
    world.entity_mut(stage.camera).insert((DepthPrepass, DeferredPrepass));
    // Change the material, so that it is prepared again.
    world.resource_mut::<Assets<StandardMaterial>>().get_mut(&material).unwrap().reflectance = 0.0;
    assert_alike(&stage.visibility(), &expected, Filter::Box5);
}

#[derive(Asset, TypePath, AsBindGroup, Clone, Default)]
struct Unchanged {}

impl MaterialExtension for Unchanged {}

#[test]
fn extended_materials_are_shadowed() {
    let file = oblique();
    let mut stage = Stage::new(|app| {
        app.add_plugins(MaterialPlugin::<ExtendedMaterial<StandardMaterial, Unchanged>>::default());
    });
    stage.give(file.clone(), |shadow| shadow.filter = ShadowFilter::Box3);
    let world = stage.app.world_mut();
    let base = StandardMaterial { perceptual_roughness: 1.0, reflectance: 0.0, ..default() };
    let material = ExtendedMaterial { base, extension: Unchanged {} };
    let material =
        world.resource_mut::<Assets<ExtendedMaterial<StandardMaterial, Unchanged>>>().add(material);
    world
        .entity_mut(stage.square)
        .remove::<MeshMaterial3d<StandardMaterial>>()
        .insert(MeshMaterial3d(material));
    assert_alike(&stage.visibility(), &expected(&file, Filter::Box3), Filter::Box3);
}

/// Two cameras side by side, and one of another size and format.
#[test]
fn all_cameras_are_shadowed() {
    let file = oblique();
    let mut stage = Stage::new(|_| {});
    stage.give(file.clone(), |_| {});
    let all = expected(&file, Filter::Box5);
    let world = stage.app.world_mut();
    let other = picture(world, UVec2::splat(SIDE), TextureFormat::Rgba8UnormSrgb);
    let above = Transform::from_translation(MIDDLE + 90.0 * Vec3::Y).looking_at(MIDDLE, Vec3::NEG_Z);
    world.spawn((
        Camera3d::default(),
        Camera { order: 1, ..default() },
        Msaa::Off,
        RenderTarget::from(other.clone()),
        from_above(SQUARE),
        above,
    ));
    let half = |x| Viewport {
        physical_position: UVec2::new(x, 0),
        physical_size: UVec2::new(SIDE / 2, SIDE),
        ..default()
    };
    world.get_mut::<Camera>(stage.camera).unwrap().viewport = Some(half(0));
    assert_alike_in_columns(&stage.visibility(), &all, 0..SIDE / 2);
    // The other picture is darker where there is shadow.
    let bytes = stage.draw(&other);
    let is_dark = |pixel: &[u8]| pixel[0] < 20;
    let wrong = bytes.chunks(4).zip(&all).filter(|(p, v)| (**v == 0.0) != is_dark(p)).count();
    assert!(wrong * 500 <= all.len(), "{wrong}");
}

/// Compares one half of a picture, in which the camera sees the whole square squeezed to half its width.
fn assert_alike_in_columns(found: &[f32], expected: &[f32], columns: std::ops::Range<u32>) {
    let (mut off, mut all) = (0, 0);
    for y in 0..SIDE {
        for x in columns.clone() {
            let v = found[(y * SIDE + x) as usize];
            // The two columns of points around the middle of this pixel.
            let [a, b] = [0, 1].map(|n| expected[(y * SIDE + 2 * (x - columns.start) + n) as usize]);
            all += 1;
            off += usize::from(v < a.min(b) - 0.5 || v > a.max(b) + 0.5);
        }
    }
    assert!(off * 200 <= all, "{off} of {all}");
}

#[test]
fn shadows_are_kept_beside_glass() {
    let file = oblique();
    let expected = expected(&file, Filter::Box5);
    let mut stage = Stage::new(|_| {});
    stage.give(file, |_| {});
    let before = stage.visibility();
    assert_alike(&before, &expected, Filter::Box5);
    let world = stage.app.world_mut();
    let ball = world.resource_mut::<Assets<Mesh>>().add(Sphere::new(2.0));
    let glass = world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial {
        specular_transmission: 0.9,
        perceptual_roughness: 0.0,
        ..default()
    });
    world.spawn((
        Mesh3d(ball),
        MeshMaterial3d(glass),
        bevy::light::NotShadowCaster,
        Transform::from_translation(MIDDLE + 3.0 * Vec3::Y),
    ));
    let after = stage.visibility();
    // The ball covers (4 / SQUARE)² · π / 4 of the picture.
    let covered = (SIDE as f32 * 4.0 / SQUARE).powi(2);
    let changed = before.iter().zip(&after).filter(|(a, b)| (**a - **b).abs() > 0.004).count();
    assert!((changed as f32) < covered, "{changed} pixels changed beside a ball of {covered}");
}

/// A camera that is not HDR draws glass too: words are read back from an sRGB texture.
#[test]
#[ignore = "slow: draws many frames"]
fn shadows_are_kept_beside_glass_without_hdr() {
    let file = oblique();
    let expected = expected(&file, Filter::Nearest);
    let mut stage = Stage::new(|_| {});
    stage.give(file, |shadow| shadow.filter = ShadowFilter::Nearest);
    let world = stage.app.world_mut();
    let other = picture(world, UVec2::splat(SIDE), TextureFormat::Rgba8UnormSrgb);
    world.entity_mut(stage.camera).remove::<bevy::camera::Hdr>().insert(RenderTarget::from(other.clone()));
    let glass = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial { specular_transmission: 0.9, ..default() });
    let ball = world.resource_mut::<Assets<Mesh>>().add(Sphere::new(0.1));
    world.spawn((
        Mesh3d(ball),
        MeshMaterial3d(glass),
        bevy::light::NotShadowCaster,
        Transform::from_translation(MIDDLE + 3.0 * Vec3::Y),
    ));
    let bytes = stage.draw(&other);
    let wrong = bytes.chunks(4).zip(&expected).filter(|(p, v)| (**v == 0.0) != (p[0] == 0)).count();
    println!("{wrong} of {} pixels differ", expected.len());
    assert!(wrong * 500 <= expected.len(), "{wrong}");
}

/// Meshes in the file leave the cascades, and come back in the frame in which the light turns away.
#[test]
fn statics_leave_the_cascades_while_the_file_is_in_use() {
    let file = oblique();
    let mut stage = Stage::new(|_| {});
    let world = stage.app.world_mut();
    let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::from_length(2.0));
    let material = MeshMaterial3d(stage.material.clone());
    let at = |x: f32| Transform::from_translation(MIDDLE + Vec3::new(x, 5.0, 0.0));
    let root = world.spawn((ShadowStatic, Transform::default(), Visibility::default())).id();
    for x in [-10.0, 0.0] {
        world.spawn((Mesh3d(cube.clone()), material.clone(), at(x), ChildOf(root)));
    }
    let mover = world.spawn((Mesh3d(cube), material, at(10.0))).id();
    for _ in 0..3 {
        stage.update();
    }
    assert_eq!(*stage.app.world().resource::<CascadeCasters>(), CascadeCasters::default());
    stage.give(file, |shadow| shadow.align = false);
    stage.update();
    stage.update();
    let casters = |stage: &Stage| *stage.app.world().resource::<CascadeCasters>();
    let CascadeCasters { found, kept } = casters(&stage);
    assert!(kept > 0 && found > kept, "{found} {kept}");
    // The light turns away: in the same frame nothing is left out.
    let turned = Transform::default().looking_to(Vec3::new(-0.3, -1.0, 0.2), Vec3::Y);
    *stage.app.world_mut().get_mut::<Transform>(stage.light).unwrap() = turned;
    stage.update();
    assert!(matches!(stage.status(), BakedShadowStatus::Misaligned { .. }), "{:?}", stage.status());
    assert_eq!(casters(&stage), CascadeCasters::default());
    // It turns back, and nothing moves any more: there are no cascades.
    let towards_sun = Vec3::from_array(crate::stage::towards_sun().map(|c| c as f32));
    let world = stage.app.world_mut();
    *world.get_mut::<Transform>(stage.light).unwrap() =
        Transform::default().looking_to(-towards_sun, Vec3::Y);
    let component =
        |stage: &Stage| stage.app.world().get::<CascadeShadowConfig>(stage.light).unwrap().bounds.len();
    stage.update();
    assert_eq!((stage.status(), stage.cascades()), (BakedShadowStatus::Active { files: 1 }, 4));
    // A hidden mesh casts no shadow.
    *stage.app.world_mut().get_mut::<Visibility>(mover).unwrap() = Visibility::Hidden;
    stage.update();
    assert_eq!((stage.cascades(), component(&stage)), (0, 4));
    *stage.app.world_mut().get_mut::<Visibility>(mover).unwrap() = Visibility::Visible;
    stage.update();
    assert_eq!(stage.cascades(), 4);
    stage.app.world_mut().despawn(mover);
    stage.update();
    assert_eq!((stage.cascades(), component(&stage)), (0, 4));
    stage.app.world_mut().get_mut::<Transform>(stage.light).unwrap().rotate_y(0.1);
    stage.update();
    assert_eq!(stage.cascades(), 4);
    // The light loses its file while it rests: everything casts through the cascades again.
    stage.app.world_mut().get_mut::<Transform>(stage.light).unwrap().rotate_y(-0.1);
    stage.update();
    assert_eq!((stage.status(), stage.cascades()), (BakedShadowStatus::Active { files: 1 }, 0));
    // A moon without a file has static meshes in its cascades while the sun is hidden.
    let down = Transform::default().looking_to(Vec3::new(0.3, -1.0, 0.1), Vec3::Y);
    let shining = DirectionalLight { shadow_maps_enabled: true, ..default() };
    let moon = stage.app.world_mut().spawn((shining, down)).id();
    stage.app.world_mut().entity_mut(stage.light).insert(Visibility::Hidden);
    stage.update();
    stage.update();
    let casters_of = |stage: &Stage, light: Entity| {
        let visible = stage.app.world().get::<CascadesVisibleEntities>(light).unwrap();
        visible.entities.values().flatten().map(|cascade| cascade.entities.len()).sum::<usize>()
    };
    assert!(casters_of(&stage, moon) > 0);
    stage.app.world_mut().despawn(moon);
    stage.app.world_mut().entity_mut(stage.light).insert(Visibility::Visible);
    stage.update();
    stage.update();
    assert_eq!((stage.status(), stage.cascades()), (BakedShadowStatus::Active { files: 1 }, 0));
    // A static mesh that is taken out of its root, and one that gets a skeleton, cast again.
    let house = stage
        .app
        .world_mut()
        .query_filtered::<Entity, With<IncludedInBake>>()
        .iter(stage.app.world())
        .next()
        .unwrap();
    stage.app.world_mut().entity_mut(house).remove::<ChildOf>();
    stage.update();
    assert!(stage.app.world().get::<IncludedInBake>(house).is_none() && stage.cascades() == 4);
    stage.app.world_mut().entity_mut(house).insert(ChildOf(root));
    stage.update();
    stage.update();
    assert_eq!(stage.cascades(), 0);
    stage.app.world_mut().entity_mut(house).insert(SkinnedMesh::default());
    stage.update();
    assert!(stage.app.world().get::<IncludedInBake>(house).is_none());
    stage.app.world_mut().entity_mut(house).remove::<SkinnedMesh>();
    stage.app.world_mut().entity_mut(stage.light).remove::<BakedShadow>();
    stage.update();
    stage.update();
    assert_eq!((casters(&stage), stage.cascades()), (CascadeCasters::default(), 4));
    assert!(stage.app.world().get::<BakedShadowStatus>(stage.light).is_none());
    assert!(casters_of(&stage, stage.light) > 0);
}

/// Surfaces are not drawn while their pipelines are recompiled, so pipelines must not be recompiled later.
#[test]
fn compiles_shaders_before_the_file_is_loaded() {
    let mut stage = Stage::new(|_| {});
    let handle = stage.app.world().resource::<Assets<BakedShadowFile>>().reserve_handle();
    let shadow = BakedShadow { sun_degrees: Some(2.0), ..BakedShadow::new(handle.clone()) };
    stage.app.world_mut().entity_mut(stage.light).insert(shadow);
    let compiled = |stage: &Stage| {
        let pipelines = stage.app.sub_app(RenderApp).world().resource::<PipelineCache>();
        pipelines.pipelines().filter(|pipeline| matches!(pipeline.state, CachedPipelineState::Ok(_))).count()
    };
    for _ in 0..6 {
        stage.update();
    }
    assert!(compiled(&stage) > 0);
    let waiting = |stage: &Stage| {
        stage.app.sub_app(RenderApp).world().resource::<PipelineCache>().waiting_pipelines().count()
    };
    assert_eq!(waiting(&stage), 0);
    let asset = BakedShadowFile::new(oblique(), DeviceLimits::default()).unwrap();
    stage.app.world_mut().resource_mut::<Assets<BakedShadowFile>>().insert(&handle, asset).unwrap();
    for _ in 0..3 {
        stage.update();
        assert_eq!(waiting(&stage), 0, "pipelines are compiled again");
    }
    assert!(stage.status().is_active(), "{}", stage.status());
}

#[test]
fn filter_bias_and_sun_degrees_change_while_running() {
    let file = oblique();
    let mut stage = Stage::new(|_| {});
    stage.give(file.clone(), |_| {});
    let shadow = |stage: &mut Stage, change: &dyn Fn(&mut BakedShadow)| {
        change(&mut stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap());
        stage.visibility()
    };
    for filter in [Filter::Nearest, Filter::Box3, Filter::Box17] {
        let found = shadow(&mut stage, &|s| s.filter = filter.into());
        assert_alike(&found, &expected(&file, filter), filter);
    }
    let bias = Bias { constant_texels: 6.0, ..file.settings.bias };
    let mut lifted = file.clone();
    lifted.settings.bias = bias;
    let found = shadow(&mut stage, &|s| (s.filter, s.bias) = (ShadowFilter::Box5, Some(bias.into())));
    assert_alike(&found, &expected(&lifted, Filter::Box5), Filter::Box5);
    // Penumbrae: intermediate values at the edges of the hard shadow, and the same mean.
    let hard = expected(&file, Filter::Nearest);
    let found = shadow(&mut stage, &|s| (s.bias, s.sun_degrees) = (None, Some(2.0)));
    let mean = |v: &[f32]| v.iter().sum::<f32>() / v.len() as f32;
    let between = found.iter().filter(|v| (0.05..0.95).contains(*v)).count();
    assert!((mean(&found) - mean(&hard)).abs() < 0.03, "{} {}", mean(&found), mean(&hard));
    assert!(between > found.len() / 50, "{between}");
    let wrong = found.iter().zip(&hard).filter(|(a, b)| (*a - *b).abs() > 0.8).count();
    assert!(wrong * 100 < found.len(), "{wrong}");
    // Settings that are not possible are reported.
    let mut wrong_field = |change: &dyn Fn(&mut BakedShadow)| {
        change(&mut stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap());
        stage.update();
        match stage.status() {
            BakedShadowStatus::Unusable(BakedShadowError::Setting(error)) => match &*error {
                Error::Range(RangeError { field, .. }) => *field,
                error => panic!("{error}"),
            },
            status => panic!("{status:?}"),
        }
    };
    assert_eq!(wrong_field(&|s| s.sun_degrees = Some(21.0)), RangeField::SunDegrees);
    let bias = ShadowBias { constant_texels: 17.0, ..default() };
    assert_eq!(wrong_field(&|s| (s.sun_degrees, s.bias) = (None, Some(bias))), RangeField::BiasTerm);
}
