//! Options that all verbs share: values out of range are usage errors, every long verb takes `--threads`,
//! `--max-memory` and `--json`, and files that techniques need are baked if none is given.

use std::process::Command;

use adumbra_testing::{Folder, adumbra, json, program, stderr};

#[test]
fn values_out_of_range_are_usage_errors() {
    let folder = Folder::new();
    let (scene, out, picture) = (folder.generate("primitives"), folder.path("out"), folder.path("a.png"));
    let bake = ["bake", &scene, "-o", &out];
    let render = ["render", &scene, "--shadow", "voxel", "--size", "32x32", "-o", &picture];
    let compare = ["compare", &scene, "--shadow", "voxel", "--size", "32x32", "-o", &out];
    let demo = ["demo", "--out", &out];
    let with_a_sun = [&bake[..], &render, &compare].into_iter().flat_map(|call| {
        [["--sun", "0,0,0"], ["--sun", "0,nan,0"], ["--resolution", "1000"]].map(|wrong| (call, wrong))
    });
    let others = [(&bake[..], ["--sun", "0,-1,0"]), (&demo, ["--resolution", "1000"])];
    for (call, wrong) in with_a_sun.chain(others) {
        let (code, error) = adumbra(&[call, &wrong].concat());
        assert_eq!(code, 2, "{call:?} {wrong:?}: {error}");
        assert!(error.contains("error: "), "{call:?} {wrong:?}: {error}");
    }
}

#[test]
fn every_long_verb_takes_threads_memory_and_json() {
    threads_memory_and_json_go_with(false);
}

#[test]
#[ignore = "slow: the whole demo"]
fn demo_takes_threads_memory_and_json() {
    threads_memory_and_json_go_with(true);
}

/// Runs every long verb, and the demo last.
fn threads_memory_and_json_go_with(demo: bool) {
    let folder = Folder::new();
    let (scene, file, picture) = (folder.path("city.glb"), folder.path("a.adumbra"), folder.path("a.png"));
    let (raw, out, hours) = (folder.path("raw.adumbra"), folder.path("out"), folder.path("hours.csv"));
    let (points, answers) = (folder.write_f32("p.f32", &[0.0, 500.0, 0.0]), folder.path("v.f32"));
    let calls: &[(&[&str], &str)] = &[
        (&["generate", "city", "-o", &scene], "triangles"),
        (&["inspect", &scene], "triangles"),
        (&["bake", &scene, "--resolution", "256", "-o", &file], "file_bytes"),
        (&["verify", &file, "--scene", &scene, "--samples", "10000", "--min-interior", "0"], "agreement"),
        (&["query", &file, "--points", &points, "-o", &answers], "points"),
        (&["convert", &file, "--encoding", "raw", "-o", &raw], "bytes"),
        (
            &[
                "sun-hours",
                &scene,
                "--grid",
                "20",
                "--lat",
                "48",
                "--lon",
                "11",
                "--date",
                "2026-06-21",
                "--from",
                "7",
                "--to",
                "9",
                "-o",
                &hours,
            ],
            "mean_hours",
        ),
        (&["sky", &scene, "--grid", "20", "-o", &hours], "mean_sky_view_factor"),
        (&["render", &scene, "--shadow-file", &file, "--size", "32x32", "-o", &picture], "width"),
        (
            &["compare", &scene, "--shadow", "none", "--size", "32x32", "--frames", "1", "-o", &out],
            "sun_samples",
        ),
        (&["demo", "--resolution", "512", "--out", &out], "interior_agreement"),
    ];
    for (call, field) in calls.iter().filter(|(call, _)| call[0] != "demo" || demo) {
        let said = json(&[*call, &["--threads", "2", "--max-memory", "2GiB", "--json"]].concat());
        assert!(said[field].is_number(), "{call:?}: {said}");
    }
    for (call, _) in calls {
        let (code, error) = adumbra(&[*call, &["--max-memory", "1KiB"]].concat());
        assert_eq!(code, 4, "{call:?}: {error}");
        let (code, error) = adumbra(&[*call, &["--threads", "0"]].concat());
        assert_eq!(code, 2, "{call:?}: {error}");
    }
}

#[test]
fn render_with_json_prints_one_object_for_several_pictures() {
    let folder = Folder::new();
    let (scene, picture) = (folder.generate("primitives"), folder.path("a.png"));
    let said = json(&[
        "render",
        &scene,
        "--shadow",
        "none",
        "--shadow",
        "sm:size=256",
        "--size",
        "32x32",
        "--json",
        "-o",
        &picture,
    ]);
    let pictures = said["pictures"].as_array().unwrap();
    let techniques: Vec<_> = pictures.iter().map(|p| p["technique"].as_str().unwrap()).collect();
    assert_eq!(techniques, ["none", "sm:size=256"]);
}

#[test]
fn render_bakes_the_file_that_a_technique_needs() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let draw = |shadow: &str, more: &[&str], name: &str| {
        let picture = folder.path(name);
        let base =
            ["render", &scene, "--shadow", shadow, "--size", "96x64", "--antialias", "1", "-o", &picture];
        let (code, error) = adumbra(&[&base[..], more].concat());
        assert_eq!(code, 0, "{error}");
        (error, std::fs::read(&picture).unwrap())
    };
    let file = folder.path("a.adumbra");
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "256", "-o", &file]);
    assert_eq!(code, 0, "{error}");
    let note = "note: no light-aligned --shadow-file; baking one with 256 texels";
    for shadow in ["voxel:filter=3", "voxel+csm:csm=size=256", "blur:base=voxel"] {
        let (said, on_demand) = draw(shadow, &["--resolution", "256"], "on-the-way.png");
        assert!(said.contains(note), "{shadow}: {said}");
        let (said, given) = draw(shadow, &["--shadow-file", &file], "given.png");
        assert!(!said.contains("baking"), "{shadow}: {said}");
        assert!(on_demand == given, "{shadow} draws another picture of a file that is baked on the way");
    }
    let (said, _) = draw("voxel:soft", &["--resolution", "256"], "soft.png");
    assert!(said.contains("baking one with 256 texels"), "{said}");
    let (said, _) = draw("csm:size=256", &[], "maps.png");
    assert!(!said.contains("baking"), "{said}");
}

#[test]
fn unset_runtime_folder_causes_no_driver_messages() {
    let folder = Folder::new();
    let (scene, picture) = (folder.generate("primitives"), folder.path("a.png"));
    let output = Command::new(program())
        .args(["render", &scene, "--shadow", "none", "--size", "32x32", "-o", &picture])
        .env_remove("XDG_RUNTIME_DIR")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(stderr(&output), "");
}
