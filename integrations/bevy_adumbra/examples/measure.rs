//! What a large static world costs Bevy per frame, with its file and with cascades fitted to it.
//!
//!     cargo run --release --example measure -- SCENE.glb FILE.adumbra [FRAMES]
//!
//! Prints a Markdown table: medians of FRAMES frames (7), after one more, without a window, 320 x 180 pixels.

use std::env;
use std::path::Path;
use std::time::Instant;

use adumbra::ShadowFile;
use adumbra_scene::{LoadOptions, load, write_glb};
use bevy::app::PluginsState;
use bevy::asset::{LoadState, RenderAssetUsages};
use bevy::camera::RenderTarget;
use bevy::camera::visibility::CascadesVisibleEntities;
use bevy::ecs::entity::EntityHashSet;
use bevy::light::{CascadeShadowConfig, CascadeShadowConfigBuilder, SimulationLightSystems};
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{Extent3d, PollType, TextureDimension, TextureFormat, TextureUsages};
use bevy::render::renderer::{RenderAdapterInfo, RenderDevice};
use bevy::render::{Render, RenderApp, RenderPlugin, RenderSystems};
use bevy::window::ExitCondition;
use bevy_adumbra::DeviceLimits;
use bevy_adumbra::prelude::*;

/// Milliseconds of a frame's stages, in the order of [`STAGES`].
#[derive(Resource, Default, Clone)]
struct Clock {
    from: Option<Instant>,
    stages: Vec<f64>,
}

const STAGES: [&str; 5] = [
    "culling for the light",
    "the rest of the main world, extraction, views",
    "queue and sort",
    "prepare",
    "encode and submit",
];

impl Clock {
    fn start(mut clock: ResMut<Self>) {
        clock.from = Some(Instant::now());
    }

    fn stop(mut clock: ResMut<Self>) {
        let ms = clock.from.take().map_or(0.0, |from| 1e3 * from.elapsed().as_secs_f64());
        clock.stages.push(ms);
    }

    fn next(mut clock: ResMut<Self>) {
        let now = Instant::now();
        let ms = clock.from.replace(now).map_or(0.0, |from| 1e3 * (now - from).as_secs_f64());
        clock.stages.push(ms);
    }
}

fn main() {
    let args: Vec<String> = env::args().collect();
    let [_, scene, file, rest @ ..] = args.as_slice() else {
        eprintln!("usage: measure SCENE.glb FILE.adumbra [FRAMES]");
        std::process::exit(2);
    };
    let count = rest.first().and_then(|frames| frames.parse().ok()).unwrap_or(7);
    // Without textures, which no shadow pass of this scene reads.
    let copy = tempfile::tempdir().expect("a folder");
    let loaded = load(Path::new(scene), &LoadOptions::default()).expect("a scene");
    let triangles = loaded.instanced_triangles();
    write_glb(&loaded, &copy.path().join("scene.glb")).expect("a copy of the scene");
    let file = ShadowFile::read(file).expect("a shadow file");
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(AssetPlugin { file_path: copy.path().to_string_lossy().into_owned(), ..default() })
            .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
            .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
            .disable::<bevy::winit::WinitPlugin>()
            .disable::<PipelinedRenderingPlugin>(),
    )
    .add_plugins(AdumbraPlugin)
    .init_resource::<Clock>();
    let (before, after) =
        (SimulationLightSystems::UpdateLightFrusta, SimulationLightSystems::CheckLightVisibility);
    app.add_systems(PostUpdate, (Clock::start.after(before).before(after.clone()), Clock::stop.after(after)));
    let render = app.sub_app_mut(RenderApp);
    render.init_resource::<Clock>().add_systems(
        Render,
        (
            Clock::start.before(RenderSystems::Queue).after(RenderSystems::PrepareViews),
            Clock::next.after(RenderSystems::PhaseSort).before(RenderSystems::Prepare),
            Clock::next.after(RenderSystems::Prepare).before(RenderSystems::Render),
            Clock::next.after(RenderSystems::Render).before(RenderSystems::Cleanup),
        ),
    );
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    let light = set_up(&mut app, file);
    println!("{scene}, {triangles} triangles, {}\n", app.world().resource::<RenderAdapterInfo>().name);
    let with_file = frames(&mut app, light, count);
    app.world_mut().entity_mut(light).remove::<BakedShadow>();
    let fitted = CascadeShadowConfigBuilder { maximum_distance: 2500.0, ..default() }.build();
    app.world_mut().entity_mut(light).insert(fitted);
    let with_cascades = frames(&mut app, light, count);
    println!("| per frame | with the file | with cascades |\n|---|---|---|");
    for ((name, a), (_, b)) in with_file.iter().zip(&with_cascades) {
        println!("| {name} | {a} | {b} |");
    }
}

/// Spawns the world, and waits until it is loaded.
fn set_up(app: &mut App, file: ShadowFile) -> Entity {
    let world = app.world_mut();
    let scene: Handle<WorldAsset> = world.resource::<AssetServer>().load("scene.glb#Scene0");
    world.spawn((WorldAssetRoot(scene.clone()), ShadowStatic));
    let limits = *world.resource::<DeviceLimits>();
    let file = BakedShadowFile::new(file, limits).expect("a file that fits");
    let file = world.resource_mut::<Assets<BakedShadowFile>>().add(file);
    let size = Extent3d { width: 320, height: 180, depth_or_array_layers: 1 };
    let format = TextureFormat::Rgba8UnormSrgb;
    let mut image = Image::new_uninit(size, TextureDimension::D2, format, RenderAssetUsages::RENDER_WORLD);
    image.texture_descriptor.usage |= TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let image = world.resource_mut::<Assets<Image>>().add(image);
    world.spawn((
        Camera3d::default(),
        RenderTarget::from(image),
        Projection::from(PerspectiveProjection { far: 3000.0, ..default() }),
        Transform::from_xyz(0.0, 60.0, 300.0).looking_at(Vec3::new(0.0, 0.0, -200.0), Vec3::Y),
    ));
    let light = world
        .spawn((DirectionalLight { shadow_maps_enabled: true, ..default() }, BakedShadow::new(file)))
        .id();
    let mut still = 0;
    let mut before = 0;
    while still < 20 || before == 0 {
        app.update();
        if let Some(LoadState::Failed(error)) = app.world().resource::<AssetServer>().get_load_state(&scene) {
            eprintln!("{error}");
            std::process::exit(1);
        }
        let count = app.world_mut().query::<&Mesh3d>().iter(app.world()).count();
        still = if count == before { still + 1 } else { 0 };
        before = count;
        if count == 0 {
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
    }
    light
}

/// Draws frames, and returns the rows of one column.
fn frames(app: &mut App, light: Entity, count: usize) -> Vec<(String, String)> {
    let mut totals = Vec::new();
    let mut gpu = Vec::new();
    let mut stages: Vec<Vec<f64>> = vec![Vec::new(); STAGES.len()];
    for frame in 0..=count {
        app.world_mut().resource_mut::<Clock>().stages.clear();
        app.sub_app_mut(RenderApp).world_mut().resource_mut::<Clock>().stages.clear();
        let start = Instant::now();
        app.update();
        let ms = 1e3 * start.elapsed().as_secs_f64();
        let device = app.world().resource::<RenderDevice>();
        device.wgpu_device().poll(PollType::Wait { submission_index: None, timeout: None }).expect("poll");
        if frame == 0 {
            continue;
        }
        totals.push(ms);
        gpu.push(1e3 * start.elapsed().as_secs_f64() - ms);
        let culling = app.world().resource::<Clock>().stages.first().copied().unwrap_or_default();
        let render = app.sub_app(RenderApp).world().resource::<Clock>().stages.clone();
        stages[0].push(culling);
        for (to, ms) in stages[2..].iter_mut().zip(&render) {
            to.push(*ms);
        }
        stages[1].push(ms - culling - render.iter().sum::<f64>());
    }
    let world = app.world();
    let visible = world.get::<CascadesVisibleEntities>(light).expect("a light");
    let meshes = world.resource::<Assets<Mesh>>();
    let (mut casters, mut bins, mut triangles) = (0, 0, 0_usize);
    for cascade in visible.entities.values().flatten() {
        let of_cascade: EntityHashSet = cascade.entities.iter().copied().collect();
        let handles = of_cascade.iter().filter_map(|&entity| world.get::<Mesh3d>(entity));
        let handles: Vec<_> = handles.map(|mesh| mesh.id()).collect();
        casters += handles.len();
        let counts = handles.iter().filter_map(|id| meshes.get(*id));
        triangles += counts.map(|m| m.indices().map_or(m.count_vertices(), |i| i.len()) / 3).sum::<usize>();
        let mut distinct = handles;
        distinct.sort_unstable();
        distinct.dedup();
        bins += distinct.len();
    }
    let most = world.get::<CascadeShadowConfig>(light).expect("a light").bounds.len();
    let cascades = if casters == 0 && world.get::<BakedShadow>(light).is_some() { 0 } else { most };
    let ms = |values: &mut Vec<f64>| format!("{:.1} ms", median(values));
    let mut rows = vec![
        ("depth passes".to_owned(), cascades.to_string()),
        ("casters in them".to_owned(), casters.to_string()),
        ("distinct meshes in them: draws after batching".to_owned(), bins.to_string()),
        ("triangles in them".to_owned(), triangles.to_string()),
    ];
    rows.extend(STAGES.iter().zip(&mut stages).map(|(name, values)| ((*name).to_owned(), ms(values))));
    rows.push(("CPU, whole frame".to_owned(), ms(&mut totals)));
    rows.push(("adapter, after submission".to_owned(), ms(&mut gpu)));
    rows
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}
