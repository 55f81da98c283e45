//! `bench ao` as users run it, at a reduced size on the scene that needs no files.

use std::fs;

use adumbra_testing::{Folder, lab};
use serde_json::Value;

#[test]
#[ignore = "slow: a whole benchmark"]
fn bench_ao_measures_the_cornell_box() {
    let folder = Folder::new();
    let (scenes, out) = (folder.path("scenes"), folder.path("out"));
    let (code, error) = lab(&[
        "bench", "ao", "--scenes", &scenes, "--only", "cornell", "--size", "160x90", "--frames", "1",
        "--rays", "32", "-o", &out,
    ]);
    assert_eq!(code, 0, "{error}");
    let read = |name: &str| fs::read(folder.path(&format!("out/{name}"))).unwrap();
    let document: Value = serde_json::from_slice(&read("ao.json")).unwrap();
    assert_eq!(document["skipped"], Value::Array(Vec::new()), "every variant is known");
    assert!(document["peers"].is_null());
    let scene = &document["scenes"][0];
    assert_eq!((&scene["name"], &scene["tuned_on"]), (&"cornell".into(), &"fold-b".into()));
    let number = |v: &Value| v.as_f64().unwrap_or_else(|| panic!("{v}"));
    let none = number(&scene["none"]["rmse"]);
    let rows = scene["rows"].as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|r| r["estimator"].as_str().unwrap()).collect();
    assert_eq!(names, ["ssao", "hbao", "alchemy", "issao", "gtao"]);
    for row in rows {
        for key in ["surface_ms", "estimate_ms", "filter_ms", "ms", "raw_ms", "by_alchemy"] {
            assert!(number(&row[key]) > 0.0, "{key}: {row}");
        }
        for kind in ["filtered", "raw"] {
            let compared = &row[kind];
            assert!(number(&compared["errors"]["rmse"]) < none, "{row}");
            assert!(
                (0.3..1.0).contains(&number(&compared["ssim"])) && number(&compared["flip"]) < 0.4,
                "{row}"
            );
            assert!(number(&compared["claims"]["detail_correlation"]) > 0.2, "{row}");
            assert!(number(&compared["flicker"]["mean"]) < 0.1, "{row}");
        }
    }
    assert!(number(&scene["standard_error"]) < number(&scene["standard_error_bound"]));
    // There are eight numbers of taps per estimator, and more taps are never much worse.
    let sweep = scene["sweep"].as_array().unwrap();
    assert_eq!(sweep.len(), 5 * 8);
    for name in names {
        let of = |n: u64| sweep.iter().find(|p| p["estimator"] == name && p["samples"] == n).unwrap();
        assert!(number(&of(64)["rmse"]) < 1.02 * number(&of(4)["rmse"]), "{name}");
    }
    assert!((4.0..=64.0).contains(&number(&scene["equal_time"]["issao_samples"])));
    let variants = scene["variants"].as_array().unwrap();
    let flicker =
        |name: &str| number(&variants.iter().find(|v| v["options"] == name).unwrap()["flicker"]["mean"]);
    assert!(flicker("reuse=on") < flicker(""), "the mean over frames steadies");
    let text = String::from_utf8(read("ao.md")).unwrap();
    assert!(text.contains("## Requirements") && text.contains("| Cornell box | 1.0000 |"), "{text}");
    assert!(read("ao-cornell.png").starts_with(b"\x89PNG") && read("ao-time.svg").starts_with(b"<svg"));
}
