//! `compare` and `bench peers` as a user calls them.

mod kit;

use std::fs;

use kit::{Folder, adumbra, json};

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
    // Traced pictures are kept, and give the same figures.
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
fn compare_refuses_what_makes_no_sense() {
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
        (vec!["--shadow", "none", "--sun-angle", "0"], 2, "--sun-angle"),
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
fn bench_peers_says_which_scene_is_missing() {
    let folder = Folder::new();
    let (scenes, out) = (folder.path(""), folder.path("out"));
    let (code, error) = adumbra(&["bench", "peers", "--scenes", &scenes, "--truth", &scenes, "-o", &out]);
    assert_eq!(code, 3);
    assert!(error.contains("kaykit_city_21"), "{error}");
}
