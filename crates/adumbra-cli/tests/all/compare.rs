//! `compare` as a user calls it.

#![cfg(feature = "render")]

use std::fs;

use adumbra_testing::{Folder, adumbra, json, shared};

#[test]
fn compare_leaves_tables_and_pictures() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let out = folder.path("out");
    let arguments = [
        "compare",
        &scene,
        "--shadow",
        "none",
        "--shadow",
        "truth",
        "--size",
        "96x64",
        "--frames",
        "2",
        "--sun-samples",
        "4",
        "--path",
        "orbit",
        "--path-frames",
        "3",
        "--json",
        "-o",
        &out,
    ];
    let report = json(&arguments);
    let names: Vec<_> = report["techniques"]
        .as_array()
        .unwrap()
        .iter()
        .map(|t| t["name"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(names, ["none", "truth"]);
    for field in
        ["gpu_ms", "depth_ms", "lookup_ms", "bytes", "rmse", "ssim", "flip", "wrong_lit", "wrong_shadowed"]
    {
        assert!(report["techniques"][0][field].is_number(), "{field}");
    }
    assert_eq!(report["camera"]["name"], "overview");
    assert_eq!(report["path"]["frames"], 3);
    for file in [
        "report.md",
        "report.json",
        "sheet.png",
        "truth-hard.png",
        "none.png",
        "none.difference.png",
        "truth.png",
        "path.csv",
        "path.svg",
    ] {
        assert!(folder.exists(&format!("out/{file}")), "{file}");
    }
    let kept: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path("out/report.json")).unwrap()).unwrap();
    assert_eq!(kept, report);
    assert_eq!(fs::read_to_string(folder.path("out/path.csv")).unwrap().lines().count(), 4);
    // Traced pictures are cached and give the same figures.
    assert!(fs::read_dir(folder.path("out/truth-cache")).unwrap().count() >= 2);
    let again = json(&arguments);
    assert_eq!(again["techniques"][0]["rmse"], report["techniques"][0]["rmse"]);
    assert_eq!(again["pixels"], report["pixels"]);
}

#[test]
fn compare_finds_a_street_and_walks_a_file() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let (out, cache) = (folder.path("out"), folder.path("cache"));
    let path = folder.write(
        "path.json",
        br#"{"frames": 2, "keyframes": [{"eye": [0, 30, 90], "target": [0, 0, 0]}, {"eye": [9, 30, 90], "target": [0, 0, 0]}]}"#,
    );
    let report = json(&[
        "compare", &scene, "--camera", "street", "--shadow", "none", "--size", "64x36", "--frames", "1",
        "--path", &path, "--cache", &cache, "--json", "-o", &out,
    ]);
    assert_eq!(report["camera"]["name"], "street");
    assert_eq!(report["path"]["frames"], 2);
    assert!(folder.exists("cache") && !folder.exists("out/truth-cache"));
}

#[test]
fn sun_degrees_applies_to_every_technique_that_takes_it() {
    let folder = Folder::new();
    let (scene, out) = (folder.generate("primitives"), folder.path("out"));
    let report = json(&[
        "compare",
        &scene,
        "--sun-degrees",
        "3",
        "--sun-samples",
        "4",
        "--resolution",
        "256",
        "--size",
        "48x32",
        "--frames",
        "1",
        "--shadow",
        "pcss:size=256",
        "--shadow",
        "voxel:soft",
        "--shadow",
        "voxel:soft:sun-degrees=1",
        "--shadow",
        "blur:base=voxel/soft",
        "--shadow",
        "voxel:filter=3",
        "--json",
        "-o",
        &out,
    ]);
    let rows: Vec<_> =
        report["techniques"].as_array().unwrap().iter().map(|t| (&t["name"], &t["truth"])).collect();
    let expected = [
        ("pcss:size=256:sun-degrees=3", "disc"),
        ("voxel:soft:sun-degrees=3", "disc"),
        ("voxel:soft:sun-degrees=1", "disc"),
        ("blur:base=voxel/soft/sun-degrees=3", "disc"),
        ("voxel:filter=3", "hard"),
    ];
    assert_eq!(rows.len(), expected.len());
    for ((name, truth), (expected, reference)) in rows.into_iter().zip(expected) {
        assert_eq!((name.as_str(), truth.as_str()), (Some(expected), Some(reference)));
    }
}

#[test]
fn check_surfaces_rejects_figures_of_too_few_pixels() {
    let folder = Folder::new();
    // The rods are far thinner than a pixel, so the rasterizer and the rays do not hit the same ones.
    let scene = folder.generate("wires");
    let out = folder.path("out");
    let base = ["compare", &scene, "--shadow", "none", "--size", "32x24", "--frames", "1", "-o", &out];
    for (more, code) in [(vec![], 0), (vec!["--check-surfaces"], 1)] {
        let (found, error) = adumbra(&[&base[..], &more].concat());
        assert_eq!(found, code, "{error}");
        assert!(error.contains("excluded") && folder.exists("out/report.md"), "{error}");
    }
    let scene = folder.generate("city");
    let base = ["compare", &scene, "--shadow", "none", "--size", "64x48", "--frames", "1", "-o", &out];
    let (code, error) = adumbra(&[&base[..], &["--check-surfaces"]].concat());
    assert_eq!((code, error.contains("excluded")), (0, false), "{error}");
}

#[test]
fn compare_rejects_invalid_options() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let out = folder.path("out");
    let base = ["compare", &scene, "-o", &out];
    let bad_path = folder.write("bad.json", b"{\"frames\": 3, \"keyframes\": []}");
    for (more, code, words) in [
        (vec!["--shadow", "nosuch"], 2, "nosuch"),
        (vec!["--shadow", "none", "--shadow", "none"], 2, "twice"),
        (vec!["--shadow", "none", "--camera", "roof"], 2, "street"),
        (vec!["--shadow", "none", "--camera", "absent.npz"], 3, "absent.npz"),
        (vec!["--shadow", "none", "--camera", "street", "--eye", "1,2,3"], 2, "--eye"),
        (vec!["--shadow", "none", "--sun-degrees", "0"], 2, "--sun-degrees"),
        (vec!["--shadow", "none", "--size", "8x8"], 2, "--size"),
        (vec!["--shadow", "none", "--size", "32x32", "--path", &bad_path], 3, "no keyframes"),
        (vec!["--shadow", "none", "--device", "cpu"], 2, "--device cpu"),
        (vec![], 2, "--shadow"),
    ] {
        let (found, error) = adumbra(&[&base[..], &more].concat());
        assert_eq!(found, code, "{more:?}: {error}");
        assert!(error.contains(words), "{more:?}: {error}");
    }
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_compare_takes_camera_and_sun_of_a_truth_file() {
    let (Some(truth), Some(scenes)) = (shared("truth"), shared("scenes")) else { return };
    let folder = Folder::new();
    let (scene, camera) = (scenes.join("zdm2.glb"), truth.join("zdm2.npz"));
    let (scene, camera) = (scene.to_str().unwrap(), camera.to_str().unwrap());
    let out = folder.path("out");
    let base = [
        "compare", scene, "--camera", camera, "--shadow", "none", "--size", "64x48", "--frames", "1",
        "--json", "-o", &out,
    ];
    let report = json(&base);
    assert_eq!(report["camera"]["name"], "zdm2.npz");
    assert_eq!(report["camera"]["width"], 64);
    let other = json(&[&base[..], &["--sun", "0,1,0"]].concat());
    assert_eq!(other["sun"], serde_json::json!([0.0, 1.0, 0.0]));
    assert_ne!(report["sun"], other["sun"]);
}
