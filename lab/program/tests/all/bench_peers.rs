//! `bench peers` as users run it.

use std::fs;

use adumbra_testing::{Folder, lab, shared};

#[test]
#[ignore = "slow: real scenes"]
fn shared_bench_peers_lists_engines_and_own_rows() {
    let (Some(truth), Some(scenes)) = (shared("truth"), shared("scenes")) else { return };
    let folder = Folder::new();
    let out = folder.path("out");
    let (code, error) = lab(&[
        "bench",
        "peers",
        "--scenes",
        scenes.to_str().unwrap(),
        "--truth",
        truth.to_str().unwrap(),
        "--shadow",
        "none",
        "-o",
        &out,
    ]);
    assert_eq!(code, 0, "{error}");
    let table: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path("out/peers.json")).unwrap()).unwrap();
    let rows = table["rows"].as_array().unwrap();
    assert_eq!((rows.len(), &rows[0]["name"]), (9, &"none".into()));
    assert_eq!(&rows[8]["source"], "measured-elsewhere");
    for scene in rows[0]["scenes"].as_array().unwrap() {
        // Without shadows, exactly the shadowed pixels are wrong.
        let (wrong, mean) =
            (scene["wrong_percent"].as_f64().unwrap(), scene["mean_percent"].as_f64().unwrap());
        assert!(wrong > 1.0 && (wrong - mean).abs() < 1e-3, "{scene}");
    }
}

#[test]
fn bench_peers_names_missing_scene() {
    let folder = Folder::new();
    let (scenes, out) = (folder.path(""), folder.path("out"));
    let (code, error) = lab(&["bench", "peers", "--scenes", &scenes, "--truth", &scenes, "-o", &out]);
    assert_eq!(code, 3);
    assert!(error.contains("kaykit_city_21"), "{error}");
}
