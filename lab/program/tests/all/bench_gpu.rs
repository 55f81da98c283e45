//! `bench gpu` as users run it, on the available adapter.

use std::fs;

use adumbra_testing::{Folder, lab};
use serde_json::Value;

/// Runs the benchmark on small pictures and files. Returns the tables' JSON and text.
fn run(out: &str, options: &[&str]) -> (Value, String) {
    let small = ["--size", "96x64", "--frames", "1", "--resolution", "512", "--resolutions", "256,512"];
    let fixed = ["bench", "gpu", "--tiles", "2", "-o", out];
    let (code, error) = lab(&[&fixed[..], &small, options].concat());
    assert_eq!(code, 0, "{error}");
    let of = |ending: &str| {
        let mut files = fs::read_dir(out).unwrap().map(|entry| entry.unwrap().path());
        let path = files.find(|path| path.extension().is_some_and(|e| e == ending)).unwrap();
        assert!(path.file_name().unwrap().to_str().unwrap().starts_with("gpu-"), "{path:?}");
        fs::read_to_string(path).unwrap()
    };
    (serde_json::from_str(&of("json")).unwrap(), of("md"))
}

#[test]
#[ignore = "slow: a whole benchmark"]
fn bench_gpu_measures_every_section() {
    let folder = Folder::new();
    let (document, text) = run(&folder.path("out"), &[]);
    let sections = document["sections"].as_array().unwrap();
    let rows: Vec<usize> = sections.iter().map(|s| s["rows"].as_array().unwrap().len()).collect();
    // Filters: five in two frames and two layouts. The large city: four techniques. Resolutions: three
    // filters of two. Hybrid maps: four at three sizes. Ambient occlusion: five estimators with and without a
    // filter.
    assert_eq!(rows[1..], [20, 4, 6, 12, 10], "{}", document["left_out"]);
    assert!(rows[0] >= 15, "every technique");
    assert_eq!(document["left_out"].as_array().unwrap().len(), 0, "{}", document["left_out"]);
    for row in sections.iter().flat_map(|s| s["rows"].as_array().unwrap()) {
        let views = row["views"].as_array().unwrap();
        assert_eq!(views.len(), 2, "{row}");
        for view in views {
            let passes = view["passes"].as_array().unwrap();
            let sum: f64 = passes.iter().map(|pass| pass[1].as_f64().unwrap()).sum();
            // With one frame the median of the sum is the sum of the medians.
            let whole = view["milliseconds"].as_f64().unwrap();
            assert!(whole > 0.0 && (whole - sum).abs() < 1e-6 * whole, "{row}");
        }
        assert!(text.contains(row["technique"].as_str().unwrap()), "{row}");
    }
    let [city, large] = [0, 2].map(|at: usize| sections[at]["triangles"].as_u64().unwrap());
    assert_eq!(large, 4 * city);
}

#[test]
#[ignore = "slow: a whole benchmark"]
fn bench_gpu_ends_in_time_and_lists_omissions() {
    let folder = Folder::new();
    let (document, text) = run(&folder.path("out"), &["--seconds", "1"]);
    let left_out = document["left_out"].as_array().unwrap();
    assert!(left_out.iter().any(|entry| entry[0] == "the large city"), "{document}");
    assert!(text.contains("## Left out"));
}
