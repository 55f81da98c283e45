//! `bench bake --suite fast` as users run it, on a small scene that replaces the smallest of the eight.

use std::fs;

use adumbra_testing::{Folder, lab};
use serde_json::Value;

#[test]
#[ignore = "slow: a whole benchmark"]
fn bench_fast_measures_one_row_and_lists_unmeasured_ones() {
    let folder = Folder::new();
    fs::rename(folder.generate("city"), folder.path("box-city-5k.glb")).unwrap();
    let (scenes, out) = (folder.path(""), folder.path("out"));
    let (code, error) = lab(&[
        "bench",
        "bake",
        "--suite",
        "fast",
        "--scenes",
        &scenes,
        "--only",
        "box-city-5k",
        "--samples",
        "2000",
        "-o",
        &out,
    ]);
    assert_eq!(code, 0, "{error}");
    let document: Value = serde_json::from_slice(&fs::read(folder.path("out/fast.json")).unwrap()).unwrap();
    let rows = document["rows"].as_array().unwrap();
    assert!(rows.len() == 1 && rows[0]["name"] == "box-city-5k-8192", "{rows:?}");
    let number = |key: &str| rows[0][key].as_f64().unwrap_or_else(|| panic!("{key}"));
    for key in ["seconds", "peak_bytes", "file_bytes"] {
        assert!(number(key) > 0.0, "{key}");
    }
    // The fast builder examines only part of the texels.
    assert!((0.0001..0.5).contains(&number("drawn_share")), "{}", number("drawn_share"));
    assert!((0.02..0.98).contains(&number("shadowed_share")) && number("interior_agreement") > 0.999);
    let checks = document["checks"].as_array().unwrap();
    let measured: Vec<_> = checks.iter().filter(|c| !c["measured"].is_null()).collect();
    assert!(measured.len() == 1 && measured[0]["figure"] == "interior_agreement", "{measured:?}");
    assert_eq!(measured[0]["holds"], true);
    // Numbers of requirements on times, memory, file sizes and look-ups.
    let demanded = |figure: &str| checks.iter().filter(|c| c["figure"] == figure).count();
    let counts = ["seconds", "peak_bytes", "file_bytes", "shadowed_share", "time_ratio", "sum_bytes"];
    assert_eq!(counts.map(demanded), [6, 5, 3, 1, 1, 1]);
    assert_eq!((demanded("interior_agreement"), demanded("points_per_second")), (15, 1));
    let text = fs::read_to_string(folder.path("out/fast.md")).unwrap();
    for part in
        ["| box-city-5k-8192 | interior agreement | ", "| not measured | ≤ 8.50 MB | 7.00 MB | – | – |"]
    {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn bench_fast_rejects_unknown_rows() {
    let folder = Folder::new();
    let out = folder.path("out");
    let bench = |options: &[&str]| lab(&[&["bench", "bake", "--scenes", &out, "-o", &out], options].concat());
    let (code, error) = bench(&["--suite", "fast", "--only", "teapot"]);
    assert!(code == 2 && error.contains("jacksboro-65536, ") && error.contains("query"), "{code} {error}");
    let (code, error) = bench(&["--only", "query"]);
    assert!(code == 2 && error.contains("--suite fast"), "{code} {error}");
}
