//! `bench ao` as a user calls it, at a reduced size on the scene that needs no files.

mod kit;

use std::fs;

use kit::{Folder, adumbra};
use serde_json::Value;

#[test]
fn bench_ao_measures_the_cornell_box() {
    let folder = Folder::new();
    let (scenes, out) = (folder.path("scenes"), folder.path("out"));
    let (code, error) = adumbra(&[
        "bench", "ao", "--scenes", &scenes, "--only", "cornell", "--size", "160x90", "--frames", "1",
        "--rays", "32", "-o", &out,
    ]);
    assert_eq!(code, 0, "{error}");
    let read = |name: &str| fs::read(folder.path(&format!("out/{name}"))).unwrap();
    let document: Value = serde_json::from_slice(&read("ao.json")).unwrap();
    assert_eq!(document["left_out"], Value::Array(Vec::new()), "every variant is known");
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
            let judged = &row[kind];
            assert!(number(&judged["errors"]["rmse"]) < none, "{row}");
            assert!((0.3..1.0).contains(&number(&judged["ssim"])) && number(&judged["flip"]) < 0.4, "{row}");
            assert!(number(&judged["claims"]["detail_correlation"]) > 0.2, "{row}");
            assert!(number(&judged["flicker"]["mean"]) < 0.1, "{row}");
        }
    }
    assert!(number(&scene["standard_error"]) < number(&scene["standard_error_bound"]));
    // Eight numbers of taps for each, and more of them are never much worse.
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
    assert!(text.contains("## Must hold") && text.contains("| Cornell box | 1.0000 |"), "{text}");
    assert!(read("ao-cornell.png").starts_with(b"\x89PNG") && read("ao-time.svg").starts_with(b"<svg"));
}
