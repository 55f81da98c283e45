//! Shared by the examples: a generated city with its shadow file, a walk through it, and pictures without a
//! window.
#![allow(dead_code, reason = "each example uses a part of this")]

use std::f32::consts::PI;
use std::path::{Path, PathBuf};
use std::{env, fs};

use adumbra::Sun;
use adumbra_bake::Bake;
use adumbra_scene::{GeneratedKind, generate, write_glb};
use bevy::app::ScheduleRunnerPlugin;
use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy::window::{ExitCondition, WindowResolution};
use bevy_adumbra::prelude::*;

/// Direction towards the sun that the city's file is baked for.
pub const TOWARDS_SUN: [f64; 3] = [0.5, 0.8, 0.35];

const SIZE: UVec2 = UVec2::new(640, 360);
/// Frames before a picture is taken.
const FRAMES: u32 = 6;

/// Returns an app with the default plugins and `AdumbraPlugin`, and makes the city if it is not there.
///
/// With `--screenshot FILE` it draws without a window, writes a picture after a few seconds of its time, and
/// ends.
pub fn app() -> App {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/assets");
    make_city(&assets);
    let args: Vec<String> = env::args().collect();
    let screenshot = args.iter().position(|a| a == "--screenshot").and_then(|at| args.get(at + 1));
    let mut app = App::new();
    let plugins = DefaultPlugins.set(AssetPlugin {
        file_path: assets.to_string_lossy().into_owned(),
        watch_for_changes_override: Some(true),
        ..default()
    });
    match screenshot {
        Some(path) => {
            let window =
                WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
            let plugins = plugins
                .set(window)
                .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
                .disable::<bevy::winit::WinitPlugin>();
            app.add_plugins((plugins, ScheduleRunnerPlugin::run_loop(std::time::Duration::ZERO)))
                .insert_resource(Picture { path: path.into(), image: None, frames: 0 })
                .add_systems(Update, draw_a_picture);
        }
        None => {
            let window = Window {
                title: "adumbra".to_owned(),
                resolution: WindowResolution::new(SIZE.x, SIZE.y),
                ..default()
            };
            app.add_plugins(plugins.set(WindowPlugin { primary_window: Some(window), ..default() }));
        }
    }
    app.add_plugins(AdumbraPlugin)
        .add_systems(Update, walk)
        .insert_resource(ClearColor(Color::srgb(0.6, 0.75, 0.9)));
    app
}

/// Makes the city and bakes its shadows, as `adumbra generate city` and `adumbra bake` do.
fn make_city(assets: &Path) {
    let (scene_file, file) = (assets.join("city.glb"), assets.join("city.adumbra"));
    if scene_file.exists() && file.exists() {
        return;
    }
    println!("making {} and {}", scene_file.display(), file.display());
    fs::create_dir_all(assets).expect("a folder for the city");
    let city = generate(GeneratedKind::City, 1);
    write_glb(&city, &scene_file).expect("the city is written");
    let sun = Sun::from_direction(TOWARDS_SUN).expect("a sun above the horizon");
    Bake::new(&city, sun).resolution(8192).save(&file).expect("the city is baked");
}

/// A camera at a street corner, with some light from the sky.
pub fn camera() -> impl Bundle {
    (
        Camera3d::default(),
        Transform::from_xyz(-150.0, 38.0, 175.0).looking_at(Vec3::new(-75.0, 4.0, 75.0), Vec3::Y),
        Projection::from(PerspectiveProjection { far: 2000.0, ..default() }),
        AmbientLight { brightness: 400.0, ..default() },
    )
}

/// W, A, S, D, Q and E move the camera, arrow keys turn it; Shift is faster.
fn walk(
    keys: Option<Res<ButtonInput<KeyCode>>>,
    time: Res<Time>,
    mut cameras: Query<&mut Transform, With<Camera3d>>,
) {
    let Some(keys) = keys else { return };
    let axis = |plus, minus| f32::from(keys.pressed(plus)) - f32::from(keys.pressed(minus));
    let fast = if keys.pressed(KeyCode::ShiftLeft) { 80.0 } else { 20.0 };
    for mut transform in &mut cameras {
        let step = Vec3::new(
            axis(KeyCode::KeyD, KeyCode::KeyA),
            axis(KeyCode::KeyE, KeyCode::KeyQ),
            axis(KeyCode::KeyS, KeyCode::KeyW),
        );
        let step = transform.rotation * step * fast * time.delta_secs();
        transform.translation += step;
        let turn = 0.4 * PI * time.delta_secs();
        transform.rotate_y(turn * axis(KeyCode::ArrowLeft, KeyCode::ArrowRight));
        transform.rotate_local_x(turn * axis(KeyCode::ArrowUp, KeyCode::ArrowDown));
    }
}

#[derive(Resource)]
struct Picture {
    path: PathBuf,
    image: Option<Handle<Image>>,
    frames: u32,
}

/// Points every camera at an image, and writes it once everything is loaded.
fn draw_a_picture(
    mut commands: Commands,
    mut picture: ResMut<Picture>,
    mut images: ResMut<Assets<Image>>,
    mut cameras: Query<(Entity, &mut Camera, Ref<Camera3d>)>,
    (shots, roots, meshes): (Query<&Screenshot>, Query<&WorldAssetRoot>, Query<&Mesh3d>),
    lights: Query<&BakedShadowStatus>,
    mut exit: MessageWriter<AppExit>,
) {
    let image = picture.image.get_or_insert_with(|| {
        let size = Extent3d { width: SIZE.x, height: SIZE.y, depth_or_array_layers: 1 };
        let format = TextureFormat::Rgba8UnormSrgb;
        let mut image =
            Image::new_uninit(size, TextureDimension::D2, format, RenderAssetUsages::RENDER_WORLD);
        image.texture_descriptor.usage |= TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        images.add(image)
    });
    let image = image.clone();
    // Draw nothing until everything is loaded: with a software adapter a frame takes seconds.
    let has_meshes = roots.is_empty() || !meshes.is_empty();
    let is_ready = has_meshes && !lights.is_empty() && lights.iter().any(BakedShadowStatus::is_active);
    for (entity, mut camera, camera_3d) in &mut cameras {
        if camera_3d.is_added() {
            commands.entity(entity).insert(RenderTarget::from(image.clone()));
            camera.is_active = false;
        } else if is_ready && picture.frames == 0 {
            camera.is_active = true;
        }
    }
    picture.frames += u32::from(is_ready);
    if picture.frames == FRAMES {
        commands.spawn(Screenshot::image(image)).observe(save_to_disk(picture.path.clone()));
    } else if picture.frames > FRAMES && shots.is_empty() {
        exit.write(AppExit::Success);
    }
}
