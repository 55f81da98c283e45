//! `bench hrsm` as a user calls it, and what must hold of hybrid maps, at a reduced size on the models that need no files.

mod kit;

use std::fs;

use kit::{Folder, adumbra};
use serde_json::Value;

fn bench(folder: &Folder, only: &str, size: &str) -> Value {
    let (scenes, out) = (folder.path("scenes"), folder.path("out"));
    let (code, error) = adumbra(&[
        "bench", "hrsm", "--scenes", &scenes, "--only", only, "--starts", "1024", "--size", size, "--frames",
        "1", "-o", &out,
    ]);
    assert_eq!(code, 0, "{error}");
    serde_json::from_slice(&fs::read(folder.path("out/hrsm.json")).unwrap()).unwrap()
}

/// Error, acne and memory hold; times at this size say nothing.
fn assert_holds(document: &Value, models: usize) {
    let checks = document["checks"].as_array().unwrap();
    assert_eq!(checks.len(), 4);
    for check in checks {
        assert_eq!(check["holds"], true, "{check}");
    }
    assert_eq!(document["models"].as_array().unwrap().len(), models);
}

fn row<'a>(document: &'a Value, name: &str) -> &'a Value {
    let groups = document["models"][0]["groups"].as_array().unwrap();
    let mut rows = groups.iter().flat_map(|g| g["rows"].as_array().unwrap());
    rows.find(|r| r["name"] == name).unwrap_or_else(|| panic!("no row {name}"))
}

#[test]
fn bench_hrsm_measures_spheres_and_holds() {
    let folder = Folder::new();
    let document = bench(&folder, "spheres", "240x136");
    assert_holds(&document, 1);
    let half = row(&document, "hrsm:1024-512:filter=1");
    let quarter = row(&document, "hrsm:1024-256:filter=1");
    let number = |r: &Value, key: &str| r[key].as_f64().unwrap();
    for key in
        ["depth_ms", "build_ms", "lookup_ms", "shadow_ms", "frame_ms", "still_ms", "lookup_ratio", "rmse"]
    {
        assert!(number(quarter, key) > 0.0, "{key}");
    }
    // A still map is smaller than a shadow map; one that is made anew holds both.
    assert!(number(quarter, "still_share") < 0.35 && number(quarter, "moving_share") > 1.0);
    let shares = quarter["levels"].as_array().unwrap();
    let sum: f64 = shares.iter().map(|s| s.as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-9 && shares[2].as_f64().unwrap() > 0.9, "{shares:?}");
    // Coarser targets gain more over themselves.
    let gain = |r: &Value| r["boundary"]["gain"].as_f64().unwrap();
    assert!(gain(half) > 0.2 && gain(quarter) > gain(half), "{} {}", gain(half), gain(quarter));
    assert!(row(&document, "sm:size=1024")["boundary"].is_null());
    // The sweep and the blocks make the same map.
    let sweep = row(&document, "hrsm:1024-256:filter=1:build=sweep");
    for key in ["still_bytes", "levels", "rmse", "wrong_lit", "wrong_shadowed", "boundary"] {
        assert_eq!(sweep[key], quarter[key], "{key}");
    }
    let text = fs::read_to_string(folder.path("out/hrsm.md")).unwrap();
    for part in
        ["## Must hold", "tables 1 and 2", "| Spheres | 12000 | 1024 | 5.3 | 5 | 0.94 |", "hrsm-levels.png"]
    {
        assert!(text.contains(part), "{part}");
    }
    assert!(folder.exists("out/hrsm-levels.png"));
}

#[test]
fn bench_hrsm_holds_on_the_ball() {
    let folder = Folder::new();
    assert_holds(&bench(&folder, "ball", "240x136"), 1);
}

#[test]
fn bench_hrsm_says_which_model_is_missing() {
    let folder = Folder::new();
    let out = folder.path("out");
    let (code, error) =
        adumbra(&["bench", "hrsm", "--scenes", &folder.path("none"), "--only", "dragon", "-o", &out]);
    assert!(code == 3 && error.contains("dragon_202k"), "{code} {error}");
}
