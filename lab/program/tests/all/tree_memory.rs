//! `--max-memory` limits the whole of `tree bake` and `tree verify`. A run that succeeds stays within its
//! limit. A run that cannot is refused, and the message states the memory that it needs.

#![cfg(target_os = "linux")]

use adumbra_testing::{Folder, assert_keeps_to_limits, lab_program, scene_file, shared};

fn assert_tree_keeps_to_limits(folder: &Folder, scene: &str, resolution: &str) {
    let (lab, file) = (lab_program(), folder.path("a.adumtree"));
    let bake = ["tree", "bake", scene, "--resolution", resolution, "--progress", "none", "-o", &file];
    assert_keeps_to_limits(&lab, &bake);
    let verify = ["tree", "verify", &file, "--scene", scene, "--samples", "20000", "--min-interior", "0"];
    assert_keeps_to_limits(&lab, &verify);
}

#[test]
#[ignore = "slow: bakes again and again"]
fn tree_memory_stays_within_every_limit() {
    let folder = Folder::new();
    for kind in ["city", "landscape", "primitives", "sphere-grid", "wires"] {
        assert_tree_keeps_to_limits(&folder, &folder.generate(kind), "128");
    }
}

#[test]
#[ignore = "slow: bakes again and again"]
fn tree_memory_on_real_scenes_stays_within_every_limit() {
    let Some(scenes) = shared("scenes") else { return };
    let folder = Folder::new();
    for name in ["box-city-51k", "kaykit_city_21", "dragon_202k", "auster", "oak_medium"] {
        assert_tree_keeps_to_limits(&folder, scene_file(&scenes, name).to_str().unwrap(), "1024");
    }
}
