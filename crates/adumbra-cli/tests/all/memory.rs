//! `--max-memory` limits the whole program: loading, the forecast of the frame, the bake and `verify`. A run that
//! succeeds keeps to its limit, and one that cannot is refused with what it needs.

use adumbra_testing::{Folder, assert_keeps_to_limits, program, scene_file, shared};

/// Bakes in every frame, and verifies one file.
fn assert_scene_keeps_to_limits(folder: &Folder, scene: &str, resolution: &str) {
    let file = folder.path("a.adumbra");
    for frame in ["light", "oblique", "auto"] {
        let bake = ["bake", scene, "--frame", frame, "--resolution", resolution, "--progress", "none"];
        assert_keeps_to_limits(&program(), &[&bake[..], &["-o", &file]].concat());
    }
    let verify = ["verify", &file, "--scene", scene, "--samples", "20000", "--min-interior", "0"];
    assert_keeps_to_limits(&program(), &verify);
}

fn assert_generated_scene_keeps_to_limits(kind: &str) {
    let folder = Folder::new();
    assert_scene_keeps_to_limits(&folder, &folder.generate(kind), "512");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_city_keeps_to_every_limit() {
    assert_generated_scene_keeps_to_limits("city");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_landscape_keeps_to_every_limit() {
    assert_generated_scene_keeps_to_limits("landscape");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_primitives_keeps_to_every_limit() {
    assert_generated_scene_keeps_to_limits("primitives");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_sphere_grid_keeps_to_every_limit() {
    assert_generated_scene_keeps_to_limits("sphere-grid");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_wires_keeps_to_every_limit() {
    assert_generated_scene_keeps_to_limits("wires");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_real_scenes_keeps_to_every_limit() {
    let Some(scenes) = shared("scenes") else { return };
    let folder = Folder::new();
    for (name, resolution) in [
        ("box-city-51k", "65536"),
        ("kaykit_city_21", "16384"),
        ("dragon_202k", "8192"),
        ("auster", "8192"),
        ("oak_medium", "4096"),
    ] {
        let scene = scene_file(&scenes, name);
        assert_scene_keeps_to_limits(&folder, scene.to_str().unwrap(), resolution);
    }
}
