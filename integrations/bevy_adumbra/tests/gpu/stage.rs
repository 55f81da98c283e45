//! An app without a window that draws points of a level square seen from straight above.

use std::sync::{Arc, Mutex, MutexGuard};

use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::{GeneratedKind, generate};
use bevy::app::PluginsState;
use bevy::asset::RenderAssetUsages;
use bevy::camera::{Hdr, RenderTarget, ScalingMode};
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::light::CascadeShadowConfigBuilder;
use bevy::pbr::ExtractedDirectionalLight;
use bevy::prelude::*;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{Extent3d, PollType, TextureDimension, TextureFormat, TextureUsages};
use bevy::render::renderer::RenderDevice;
use bevy::render::sync_world::MainEntity;
use bevy::render::{RenderApp, RenderPlugin};
use bevy::window::ExitCondition;
use bevy_adumbra::DeviceLimits;
use bevy_adumbra::prelude::*;

/// Pixels along a side of a picture.
pub const SIDE: u32 = 128;
/// Height of the square, and length of its sides in metres, around the middle of the scene.
pub const HEIGHT: f32 = 0.25;
pub const SQUARE: f32 = 120.0;
pub const MIDDLE: Vec3 = Vec3::new(0.0, HEIGHT, 0.0);

/// One app at a time: Bevy's task pools are global to the process.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

pub struct Stage {
    pub app: App,
    pub camera: Entity,
    pub light: Entity,
    pub square: Entity,
    pub material: Handle<StandardMaterial>,
    pub picture: Handle<Image>,
    _one: MutexGuard<'static, ()>,
}

pub fn towards_sun() -> [f64; 3] {
    [0.5, 0.8, 0.35]
}

/// Returns the file of the generated city, which is baked once for each frame that tests ask for.
pub fn baked(frame: FrameChoice) -> ShadowFile {
    static BAKED: Mutex<Vec<(FrameChoice, ShadowFile)>> = Mutex::new(Vec::new());
    let mut baked = BAKED.lock().unwrap_or_else(|e| e.into_inner());
    if let Some((_, file)) = baked.iter().find(|(known, _)| *known == frame) {
        return file.clone();
    }
    let sun = Sun::from_direction(towards_sun()).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(2048)).with(|o| o.frame = frame);
    let file = Bake::with_options(&generate(GeneratedKind::City, 1), &options).in_memory().unwrap();
    baked.push((frame, file.clone()));
    file
}

impl Stage {
    /// Starts an app with a light, a square and a camera above it; `set_up` adds plugins before it starts.
    pub fn new(set_up: impl FnOnce(&mut App)) -> Self {
        Self::start(AssetPlugin::default(), |_| {}, set_up)
    }

    /// Starts an app that loads assets in a given way. `sources` registers asset sources first.
    pub fn with_plugin(assets: AssetPlugin, sources: impl FnOnce(&mut App)) -> Self {
        Self::start(assets, sources, |_| {})
    }

    fn start(assets: AssetPlugin, sources: impl FnOnce(&mut App), set_up: impl FnOnce(&mut App)) -> Self {
        let one = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
        let mut app = App::new();
        sources(&mut app);
        app.insert_resource(ClearColor(Color::NONE)).insert_resource(GlobalAmbientLight::NONE).add_plugins(
            DefaultPlugins
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                })
                .set(assets)
                .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
                .disable::<bevy::winit::WinitPlugin>()
                .disable::<PipelinedRenderingPlugin>(),
        );
        app.add_plugins(AdumbraPlugin);
        set_up(&mut app);
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        let picture = picture(app.world_mut(), UVec2::splat(SIDE), TextureFormat::Rgba16Float);
        let world = app.world_mut();
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial {
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        });
        let camera = world
            .spawn((
                Camera3d::default(),
                Hdr,
                Msaa::Off,
                Tonemapping::None,
                DebandDither::Disabled,
                RenderTarget::from(picture.clone()),
                from_above(SQUARE),
                Transform::from_translation(MIDDLE + 90.0 * Vec3::Y).looking_at(MIDDLE, Vec3::NEG_Z),
            ))
            .id();
        let mesh = world
            .resource_mut::<Assets<Mesh>>()
            .add(Plane3d::default().mesh().size(2.0 * SQUARE, 2.0 * SQUARE));
        // It receives shadows but does not cast, like a decal on the ground.
        let square = world
            .spawn((
                Mesh3d(mesh),
                MeshMaterial3d(material.clone()),
                Transform::from_translation(MIDDLE),
                bevy::light::NotShadowCaster,
            ))
            .id();
        let towards_sun = Vec3::from_array(towards_sun().map(|c| c as f32));
        let light = world
            .spawn((
                DirectionalLight { illuminance: 3000.0, shadow_maps_enabled: true, ..default() },
                CascadeShadowConfigBuilder::default().build(),
                Transform::default().looking_to(-towards_sun, Vec3::Y),
            ))
            .id();
        Self { app, camera, light, square, material, picture, _one: one }
    }

    /// Puts a file on the light.
    pub fn give(
        &mut self,
        file: ShadowFile,
        change: impl FnOnce(&mut BakedShadow),
    ) -> Handle<BakedShadowFile> {
        let world = self.app.world_mut();
        let asset = BakedShadowFile::new(file, DeviceLimits::default()).unwrap();
        let handle = world.resource_mut::<Assets<BakedShadowFile>>().add(asset);
        let mut shadow = BakedShadow::new(handle.clone());
        change(&mut shadow);
        world.entity_mut(self.light).insert(shadow);
        handle
    }

    pub fn update(&mut self) {
        self.app.update();
        let device = self.app.world().resource::<RenderDevice>();
        device.wgpu_device().poll(PollType::Wait { submission_index: None, timeout: None }).expect("poll");
    }

    /// How many cascades of the light the render world has drawn in the last frame.
    pub fn cascades(&mut self) -> usize {
        let light = self.light;
        let world = self.app.sub_app_mut(RenderApp).world_mut();
        let mut lights = world.query::<(&MainEntity, &ExtractedDirectionalLight)>();
        let of_light = lights.iter(world).find(|(entity, _)| entity.id() == light);
        of_light.map_or(0, |(_, light)| light.cascade_shadow_config.bounds.len())
    }

    /// Updates until the light's status is known.
    pub fn update_until_known(&mut self) {
        for _ in 0..20 {
            self.update();
            if self.status() != BakedShadowStatus::Waiting {
                return;
            }
        }
        panic!("the baked shadow is still loading");
    }

    pub fn status(&self) -> BakedShadowStatus {
        self.app.world().get::<BakedShadowStatus>(self.light).expect("a status").clone()
    }

    /// Draws a few frames, and returns the bytes of a picture.
    pub fn draw(&mut self, picture: &Handle<Image>) -> Vec<u8> {
        for _ in 0..4 {
            self.update();
        }
        let data: Arc<Mutex<Option<Vec<u8>>>> = Arc::default();
        let sink = data.clone();
        let readback = move |event: On<ReadbackComplete>| {
            sink.lock().unwrap().get_or_insert_with(|| event.data.clone());
        };
        let reader = self.app.world_mut().spawn(Readback::texture(picture.clone())).observe(readback).id();
        for _ in 0..20 {
            if data.lock().unwrap().is_some() {
                break;
            }
            self.update();
        }
        self.app.world_mut().despawn(reader);
        data.lock().unwrap().take().expect("a picture")
    }

    /// Returns the visibility at each pixel: the picture with shadows divided by the one without.
    pub fn visibility(&mut self) -> Vec<f32> {
        let picture = self.picture.clone();
        let lit = self.draw(&picture);
        let shadows = |stage: &mut Self, enabled| {
            let mut light = stage.app.world_mut().get_mut::<DirectionalLight>(stage.light).unwrap();
            light.shadow_maps_enabled = enabled;
        };
        shadows(self, false);
        let unshadowed = self.draw(&picture);
        shadows(self, true);
        self.update();
        let red = |bytes: &[u8]| -> Vec<f32> { bytes.chunks(8).map(|p| half([p[0], p[1]])).collect() };
        red(&lit).into_iter().zip(red(&unshadowed)).map(|(lit, all)| lit / all).collect()
    }
}

/// Returns an image to draw into.
pub fn picture(world: &mut World, size: UVec2, format: TextureFormat) -> Handle<Image> {
    let size = Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
    let mut image = Image::new_uninit(size, TextureDimension::D2, format, RenderAssetUsages::RENDER_WORLD);
    image.texture_descriptor.usage |= TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    world.resource_mut::<Assets<Image>>().add(image)
}

pub fn from_above(side: f32) -> Projection {
    Projection::from(OrthographicProjection {
        scaling_mode: ScalingMode::Fixed { width: side, height: side },
        far: 200.0,
        ..OrthographicProjection::default_3d()
    })
}

/// Returns the visibility of each pixel's point by look-ups on the CPU.
pub fn expected(file: &ShadowFile, filter: Filter) -> Vec<f32> {
    let shadow = file.sampler(filter);
    expected_by(|p, normal| shadow.visibility(p, normal))
}

/// Returns the visibility of each pixel's point by some look-ups.
pub fn expected_by(visibility: impl Fn([f64; 3], Option<[f64; 3]>) -> f32) -> Vec<f32> {
    let across = |n: u32| ((n as f32 + 0.5) / SIDE as f32 - 0.5) * SQUARE;
    let rows = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    rows.map(|(x, y)| {
        let p = [MIDDLE.x + across(x), HEIGHT, MIDDLE.z + across(y)].map(f64::from);
        visibility(p, Some([0.0, 1.0, 0.0]))
    })
    .collect()
}

/// Puts a ground, and a tower of 30 m at `x` and z = 10, below a static root. Returns the tower.
pub fn tower(stage: &mut Stage, x: f32) -> Entity {
    let world = stage.app.world_mut();
    let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::from_length(30.0));
    let ground = world.resource_mut::<Assets<Mesh>>().add(Plane3d::default().mesh().size(160.0, 160.0));
    let material = MeshMaterial3d(stage.material.clone());
    let root = world.spawn((ShadowStatic, Transform::default(), Visibility::default())).id();
    let tower = (Mesh3d(cube), material.clone(), Transform::from_xyz(x, 15.0, 10.0), ChildOf(root));
    let tower = world.spawn(tower).id();
    world.spawn((Mesh3d(ground), material, Transform::default(), ChildOf(root)));
    tower
}

/// Sets the pixels on the tower's roof to the expected values, because they are not points of the square.
pub fn beside_tower(x: f32, found: &mut [f32], expected: &[f32]) {
    let pixel = |metres: f32| (metres / SQUARE + 0.5) * SIDE as f32;
    for (n, (found, expected)) in (0..).zip(found.iter_mut().zip(expected)) {
        let [column, row] = [n % SIDE, n / SIDE].map(|c| c as f32 + 0.5);
        let is_roof =
            (pixel(x - 16.0)..pixel(x + 16.0)).contains(&column) && (pixel(-6.0)..pixel(26.0)).contains(&row);
        if is_roof {
            *found = *expected;
        }
    }
}

/// Checks that at most 0.2 % of the pixels differ, none by more than a row of taps.
#[track_caller]
pub fn assert_alike(found: &[f32], expected: &[f32], filter: Filter) {
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().all(|v| v.is_finite()), "a pixel has no visibility: it was not lit, or by too much");
    let difference = |(a, b): (&f32, &f32)| (a - b).abs();
    let off = found.iter().zip(expected).filter(|&pair| difference(pair) > 0.004).count();
    let most = found.iter().zip(expected).map(difference).fold(0.0, f32::max);
    let shadowed = expected.iter().filter(|&&v| v < 0.5).count();
    println!("{off} of {} pixels differ, by at most {most}; {shadowed} in shadow", found.len());
    assert!(shadowed > found.len() / 20 && shadowed < found.len() * 19 / 20, "{shadowed} in shadow");
    assert!(off * 500 <= found.len(), "{off} of {} pixels differ", found.len());
    assert!(most <= 1.0 / filter.width() as f32 + 0.004, "a pixel differs by {most}");
}

pub fn half([low, high]: [u8; 2]) -> f32 {
    let bits = u16::from_le_bytes([low, high]);
    let exponent = i32::from(bits >> 10 & 31);
    let fraction = f32::from(bits & 0x3ff) / 1024.0;
    match exponent {
        0 => fraction * 2.0_f32.powi(-14),
        31 => f32::INFINITY,
        _ => (1.0 + fraction) * 2.0_f32.powi(exponent - 15),
    }
}
