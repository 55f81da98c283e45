//! Bakes as an asset step.

use std::fs;
use std::path::Path;

use adumbra::{Encoding, Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_scene::{GeneratedKind, Scene, generate, to_glb, write_glb};
use bevy::asset::{AssetMode, AssetPlugin, LoadState};
use bevy::prelude::*;
use bevy_adumbra::prelude::*;

use crate::stage::{Stage, assert_alike, expected, towards_sun};

const SETTINGS: &str = r#"(scene: "models/world.glb", towards_sun: (0.5, 0.8, 0.35), resolution: 1024)"#;

/// Writes a world and its `.shadow.ron` into a folder of assets.
fn write(scene: &Scene, assets: &Path, settings: &str) {
    fs::create_dir_all(assets.join("models")).unwrap();
    write_glb(scene, &assets.join("models/world.glb")).unwrap();
    fs::write(assets.join("world.shadow.ron"), settings).unwrap();
}

fn baked(scene: &Scene) -> ShadowFile {
    let sun = Sun::from_direction(towards_sun()).unwrap();
    Bake::with_options(scene, &BakeOptions::new(sun, Size::Resolution(1024))).in_memory().unwrap()
}

/// An app that processes its assets in a folder.
fn processing(folder: &Path) -> Stage {
    let assets = AssetPlugin {
        mode: AssetMode::Processed,
        file_path: folder.join("assets").to_string_lossy().into_owned(),
        processed_file_path: folder.join("imported").to_string_lossy().into_owned(),
        watch_for_changes_override: Some(true),
        use_asset_processor_override: Some(true),
        ..default()
    };
    Stage::with_plugin(assets, |_| {})
}

fn load(stage: &mut Stage) -> Handle<BakedShadowFile> {
    let handle = stage.app.world().resource::<AssetServer>().load("world.shadow.ron");
    stage.app.world_mut().entity_mut(stage.light).insert(BakedShadow::new(handle.clone()));
    handle
}

fn triangles(stage: &Stage, handle: &Handle<BakedShadowFile>) -> u64 {
    let files = stage.app.world().resource::<Assets<BakedShadowFile>>();
    files.get(handle).map_or(0, |file| file.file().settings.triangles)
}

#[test]
fn a_scene_is_baked_as_an_asset_step_and_again_when_it_changes() {
    let folder = tempfile::tempdir().unwrap();
    let (assets, imported) = (folder.path().join("assets"), folder.path().join("imported/world.shadow.ron"));
    let (first, second) = (generate(GeneratedKind::City, 1), generate(GeneratedKind::City, 2));
    write(&first, &assets, SETTINGS);
    let file = baked(&first);
    let mut stage = processing(folder.path());
    let handle = load(&mut stage);
    stage.wait_for(|stage| stage.status().is_active());
    assert_alike(&stage.visibility(), &expected(&file, Filter::Box5), Filter::Box5);
    // The imported file is the one that `adumbra bake` writes.
    assert_eq!(fs::read(&imported).unwrap(), file.to_bytes(Encoding::default()).unwrap());
    assert!(file.settings.triangles != baked(&second).settings.triangles);

    // The scene is saved again, with other houses.
    fs::write(assets.join("models/world.glb"), to_glb(&second)).unwrap();
    let file = baked(&second);
    stage.wait_for(|stage| triangles(stage, &handle) == file.settings.triangles);
    stage.update();
    assert_alike(&stage.visibility(), &expected(&file, Filter::Box5), Filter::Box5);
    let written = fs::metadata(&imported).unwrap().modified().unwrap();

    // Another run bakes nothing.
    drop(stage);
    let mut stage = processing(folder.path());
    let handle = load(&mut stage);
    stage.wait_for(|stage| stage.status().is_active());
    assert_eq!(triangles(&stage, &handle), file.settings.triangles);
    assert_eq!(fs::metadata(&imported).unwrap().modified().unwrap(), written);
}

#[test]
fn without_the_processor_a_load_bakes() {
    let folder = tempfile::tempdir().unwrap();
    let scene = generate(GeneratedKind::Primitives, 1);
    write(&scene, folder.path(), SETTINGS);
    let mut stage = Stage::with_assets(&folder.path().to_string_lossy());
    let handle = load(&mut stage);
    stage.wait_for(|stage| stage.status().is_active());
    assert_eq!(triangles(&stage, &handle), baked(&scene).settings.triangles);
}

#[test]
#[ignore = "slow: draws many frames"]
fn rejects_bad_settings_with_the_reason() {
    let mistakes = [
        (r#"(scene: "models/world.glb")"#, "towards_sun"),
        (r#"(scene: "models/world.glb", towards_sun: (0, -1, 0))"#, "sun"),
        (r#"(scene: "models/world.glb", towards_sun: (0, 1, 0), resolution: 5)"#, "power of two"),
        (r#"(scene: "models/world.glb", towards_sun: (0, 1, 0), size: 5)"#, "size"),
        (r#"(scene: "nowhere.glb", towards_sun: (0, 1, 0))"#, "nowhere.glb"),
        (r#"(scene: "world.shadow.ron", towards_sun: (0, 1, 0))"#, "not a .glb or .gltf"),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (settings, reason) in mistakes {
        write(&generate(GeneratedKind::Primitives, 1), folder.path(), settings);
        let mut stage = Stage::with_assets(&folder.path().to_string_lossy());
        let handle = load(&mut stage);
        let state = |stage: &Stage| stage.app.world().resource::<AssetServer>().get_load_state(&handle);
        stage.wait_for(|stage| matches!(state(stage), Some(LoadState::Failed(_))));
        let Some(LoadState::Failed(error)) = state(&stage) else { unreachable!("it failed") };
        assert!(error.to_string().contains(reason), "{settings}: {error}");
    }
}
