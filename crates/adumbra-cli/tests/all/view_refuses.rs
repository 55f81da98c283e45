//! What the window refuses: faulty scripts and options, steps that cannot be done, a start without a display,
//! and writing over its own files.
//!
//! Some tests need Xvfb and xdotool. Without them these print a note and pass, unless
//! `ADUMBRA_REQUIRE_TOOLS` is set, as `cargo xtask test` does.

#![cfg(feature = "view")]

use std::process::Command;

use serde_json::{Value, json};

use adumbra_testing::{Folder, adumbra, program};

use crate::display::display;

#[test]
fn view_script_ends_at_a_step_that_cannot_be_done() {
    let Some(display) = display() else { return };
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let nowhere = folder.path("nowhere/window.png");
    let shot = folder.path("shot.png");
    let cases: [(&[&str], Value, &str); 3] = [
        (&[], json!([{"wait": "loaded"}, {"window_shot": nowhere}, "quit"]), "step 2"),
        // Enough memory to load the scene, but not to bake it.
        (
            &["--max-memory", "500KiB"],
            json!([{"wait": "baked"}, {"screenshot": shot}, "quit"]),
            "the bake failed",
        ),
        (&[], json!([{"wait": "loaded"}, {"key": "F5"}, "quit"]), "F5 does nothing"),
    ];
    for (arguments, steps, fault) in cases {
        let arguments = [&[scene.as_str()], arguments].concat();
        let (code, said) = display.play(&folder, &arguments, &steps);
        assert!(code == 3 && said.contains(fault), "{steps}: {code}: {said}");
    }
}

#[test]
fn view_rejects_a_faulty_script_before_opening_a_window() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let script = folder.write("script.json", br#"["quit", {"lair": "shadow"}]"#);
    let (code, said) = adumbra(&["view", &scene, "--script", &script]);
    assert_eq!(code, 3, "{said}");
    assert!(said.contains("step 2") && said.contains("lair"), "{said}");
    for wrong in [
        ["--split", "2"],
        ["--shadow", "smm"],
        ["--shadow", "voxel:filtr=9"],
        ["--layer", "lair"],
        ["--ao", "lair"],
        ["--resolution", "1000"],
    ] {
        let (code, said) = adumbra(&[&["view", scene.as_str()][..], &wrong].concat());
        assert_eq!(code, 2, "{wrong:?}: {said}");
        assert!(wrong == ["--shadow", "smm"] || said.contains(wrong[0]), "{wrong:?}: {said}");
    }
}

#[test]
fn view_without_a_display_says_what_is_missing() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let output = Command::new(program())
        .args(["view", &scene])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let said = adumbra_testing::stderr(&output);
    if cfg!(target_os = "linux") {
        assert_eq!(output.status.code(), Some(3), "{said}");
        assert!(said.contains("display") && said.contains("Xvfb"), "{said}");
        assert!(!said.contains("os error at"), "{said}");
    }
}

#[test]
#[ignore = "slow: opens windows"]
fn view_does_not_overwrite_its_script_or_scene_files() {
    let Some(display) = display() else { return };
    let folder = Folder::new();
    let scene = folder.write("a.obj", b"mtllib a.mtl\nv 0 0 0\nv 0 0 9\nv 9 0 0\nf 1 2 3\n");
    folder.write("a.mtl", b"newmtl a\n");
    let camera = br#"{"eye": [9, 9, 9], "target": [0, 0, 0], "fov_y": 45, "size": [64, 64]}"#;
    let camera = folder.write("camera.json", camera);
    for name in ["a.obj", "a.mtl", "camera.json", "script.json"] {
        let steps = json!([{"wait": "loaded"}, {"screenshot": folder.path(name)}, "quit"]);
        // `play` writes the script.
        let expected = match name {
            "script.json" => steps.to_string().into(),
            _ => std::fs::read(folder.path(name)).unwrap(),
        };
        let (code, said) = display.play(&folder, &[&scene, "--shadow", "none", "--camera", &camera], &steps);
        assert!(code != 0 && said.contains("give another path"), "{name}: {said}");
        assert_eq!(std::fs::read(folder.path(name)).unwrap(), expected, "{name}");
    }
}
