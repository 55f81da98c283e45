//! `--max-memory` limits the whole program: loading, the forecast of the frame, the bake and `verify`. A run
//! that succeeds keeps to its limit, and a run that cannot is refused with the memory that it needs.

use std::fs;

use adumbra_testing::{
    Folder, adumbra, assert_keeps_to_limits, program, run_with_the_memory_it_asks_for, scene_file, shared,
};

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

#[test]
fn bake_with_the_memory_that_it_asks_for_writes_the_same_file() {
    let folder = Folder::new();
    let (scene, free, file) = (folder.generate("primitives"), folder.path("free"), folder.path("least"));
    let bake = ["bake", &scene, "--frame", "light", "--resolution", "256", "--progress", "none"];
    let (code, error) = adumbra(&[&bake[..], &["-o", &free]].concat());
    assert_eq!(code, 0, "{error}");
    run_with_the_memory_it_asks_for(&program(), &[&bake[..], &["-o", &file]].concat());
    assert!(fs::read(&file).unwrap() == fs::read(&free).unwrap(), "another file within the least memory");
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

fn assert_shared_scene_keeps_to_limits(name: &str, resolution: &str) {
    let Some(scenes) = shared("scenes") else { return };
    let scene = scene_file(&scenes, name);
    assert_scene_keeps_to_limits(&Folder::new(), scene.to_str().unwrap(), resolution);
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_shared_box_city_keeps_to_every_limit() {
    assert_shared_scene_keeps_to_limits("box-city-51k", "65536");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_shared_instanced_town_keeps_to_every_limit() {
    assert_shared_scene_keeps_to_limits("kaykit_city_21", "16384");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_shared_dragon_keeps_to_every_limit() {
    assert_shared_scene_keeps_to_limits("dragon_202k", "8192");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_shared_mountains_keeps_to_every_limit() {
    assert_shared_scene_keeps_to_limits("auster", "8192");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: bakes again and again"]
fn memory_of_shared_tree_keeps_to_every_limit() {
    assert_shared_scene_keeps_to_limits("oak_medium", "4096");
}
