//! The loader against the format's test vectors, in an app without a renderer: needs no GPU.

use std::time::{Duration, Instant};

use adumbra::ShadowFile;
use adumbra_testing::{faulty_vectors, named_vectors, vectors};
use bevy::app::TaskPoolPlugin;
use bevy::asset::{AssetPlugin, LoadState, UnapprovedPathMode};
use bevy::prelude::*;
use bevy_adumbra::prelude::*;

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        AssetPlugin {
            file_path: vectors("").to_string_lossy().into_owned(),
            unapproved_path_mode: UnapprovedPathMode::Allow,
            ..default()
        },
        AdumbraPlugin,
    ));
    app.finish();
    app.cleanup();
    app
}

/// Loads a file and returns the error, if it has one.
fn load(app: &mut App, path: String) -> Option<String> {
    let handle: Handle<BakedShadowFile> = app.world().resource::<AssetServer>().load(&path);
    let start = Instant::now();
    loop {
        app.update();
        match app.world().resource::<AssetServer>().load_state(&handle) {
            LoadState::Loaded => return None,
            LoadState::Failed(error) => return Some(error.to_string()),
            _ => assert!(start.elapsed() < Duration::from_secs(300), "{path} does not load"),
        }
    }
}

#[test]
fn loads_every_valid_vector() {
    let mut app = app();
    for (name, bytes) in named_vectors("valid", 10) {
        let error = load(&mut app, format!("valid/{name}.adumbra"));
        assert!(ShadowFile::from_bytes(&bytes).is_ok() && error.is_none(), "{name}: {error:?}");
    }
}

#[test]
fn broken_files_fail_with_the_reason_and_a_remedy() {
    let mut app = app();
    for vector in faulty_vectors("invalid") {
        let path = vector.path.strip_prefix(vectors("")).expect("a vector");
        let error = load(&mut app, path.to_string_lossy().into_owned());
        let error = error.unwrap_or_else(|| panic!("{} loads", path.display()));
        assert!(error.contains("not a valid shadow file: ") && error.contains("bake it again"), "{error}");
    }
}
