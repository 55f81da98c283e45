//! `bench hrsm` as users run it, and requirements on hybrid maps, at a reduced size on the models that need
//! no files.

use std::fs;

use adumbra_testing::{Folder, lab};
use serde_json::Value;

fn bench(folder: &Folder, only: &str, size: &str) -> Value {
    let (scenes, out) = (folder.path("scenes"), folder.path("out"));
    let (code, error) = lab(&[
        "bench", "hrsm", "--scenes", &scenes, "--only", only, "--starts", "1024", "--size", size, "--frames",
        "1", "-o", &out,
    ]);
    assert_eq!(code, 0, "{error}");
    serde_json::from_slice(&fs::read(folder.path("out/hrsm.json")).unwrap()).unwrap()
}

/// Asserts the requirements on error, acne and memory. Times are meaningless at this size.
fn assert_holds(document: &Value, models: usize) {
    let checks = document["checks"].as_array().unwrap();
    let (look_up, others) = checks.split_last().unwrap();
    assert_eq!(others.len(), 5);
    for check in others {
        assert_eq!(check["holds"], true, "{check}");
    }
    assert!(look_up["holds"].is_null() && look_up["measured"] == "not measured", "{look_up}");
    let covers = document["covers"].as_str().unwrap();
    assert!(covers.contains("START 1024. Not measured: Dragon") && covers.contains("START 4096"), "{covers}");
    assert_eq!(document["models"].as_array().unwrap().len(), models);
}

fn row<'a>(document: &'a Value, name: &str) -> &'a Value {
    let groups = document["models"][0]["groups"].as_array().unwrap();
    let mut rows = groups.iter().flat_map(|g| g["rows"].as_array().unwrap());
    rows.find(|r| r["name"] == name).unwrap_or_else(|| panic!("no row {name}"))
}

#[test]
#[ignore = "slow: a whole benchmark"]
fn bench_hrsm_meets_requirements_on_spheres() {
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
    // A cached map is smaller than a shadow map. A map that is rebuilt every frame holds both.
    assert!(number(quarter, "still_share") < 0.35 && number(quarter, "moving_share") > 1.0);
    let shares = quarter["levels"].as_array().unwrap();
    let shares: Vec<f64> = shares.iter().map(|s| s.as_f64().unwrap()).collect();
    assert!(shares.len() == 3 && shares.iter().all(|s| (0.0..=1.0).contains(s)), "{shares:?}");
    assert!(shares[0] > 0.0 && shares[2] > 0.9, "{shares:?}");
    // The shares of the levels account for the map's size: the coarsest level, and four words per block that
    // split.
    let finest_blocks = shares[0] * 1024.0 * 1024.0 / 4.0;
    let middle_blocks = (shares[1] * 512.0 * 512.0 + finest_blocks) / 4.0;
    let expected = 4.0 * (256.0 * 256.0 + 4.0 * (finest_blocks + middle_blocks));
    let beside = number(quarter, "still_bytes") - expected;
    assert!((0.0..4096.0).contains(&beside), "{beside} of {expected}");
    let [least, most] = [0, 1].map(|i| quarter["lookup_ratio_range"][i].as_f64().unwrap());
    assert!(least <= number(quarter, "lookup_ratio") && number(quarter, "lookup_ratio") <= most);
    // Coarser targets gain more relative to themselves.
    let gain = |r: &Value| r["boundary"]["gain"].as_f64().unwrap();
    assert!(gain(half) > 0.2 && gain(quarter) > gain(half), "{} {}", gain(half), gain(quarter));
    assert!(row(&document, "sm:size=1024")["boundary"].is_null());
    // The sweep and the per-block build make the same map.
    let sweep = row(&document, "hrsm:1024-256:filter=1:build=sweep");
    for key in ["still_bytes", "levels", "rmse", "wrong_lit", "wrong_shadowed", "boundary"] {
        assert_eq!(sweep[key], quarter[key], "{key}");
    }
    let text = fs::read_to_string(folder.path("out/hrsm.md")).unwrap();
    for part in [
        "## Requirements",
        "tables 1 and 2",
        "| Spheres | 12000 | 1024 | 5.3 | 5 | 0.94 |",
        "hrsm-levels.png",
        "### Why the paper",
        "| 1024-256 | 5 × 5 |",
    ] {
        assert!(text.contains(part), "{part}");
    }
    assert!(folder.exists("out/hrsm-levels.png"));
}

#[test]
#[ignore = "slow: a whole benchmark"]
fn bench_hrsm_meets_requirements_on_ball() {
    let folder = Folder::new();
    // Pixels are no larger than the two texels around an edge within which errors are not counted.
    assert_holds(&bench(&folder, "ball", "480x270"), 1);
}

#[test]
fn bench_hrsm_rejects_invalid_start() {
    let folder = Folder::new();
    let out = folder.path("out");
    let (code, error) = lab(&["bench", "hrsm", "--scenes", &out, "--starts", "1500", "-o", &out]);
    assert!(code == 2 && error.contains("1024, 2048, 4096 or 8192"), "{code} {error}");
}

#[test]
fn bench_hrsm_names_missing_model() {
    let folder = Folder::new();
    let out = folder.path("out");
    let (code, error) =
        lab(&["bench", "hrsm", "--scenes", &folder.path("none"), "--only", "dragon", "-o", &out]);
    assert!(code == 3 && error.contains("dragon_202k"), "{code} {error}");
}
