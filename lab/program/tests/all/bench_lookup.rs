//! `bench lookup` as users run it.

use std::fs;

use adumbra_testing::{Folder, lab, shared};
use serde_json::Value;

#[test]
#[ignore = "slow: real scenes"]
fn shared_bench_lookup_counts_reads_of_every_file() {
    let (Some(truth), Some(scenes)) = (shared("truth"), shared("scenes")) else { return };
    let folder = Folder::new();
    let out = folder.path("out");
    let (truth, scenes) = (truth.to_str().unwrap(), scenes.to_str().unwrap());
    let (code, error) = lab(&[
        "bench",
        "lookup",
        "--scenes",
        scenes,
        "--truth",
        truth,
        "--names",
        "zdm2",
        "--resolution",
        "1024",
        "--filter",
        "1,5",
        "--size",
        "320x180",
        "--every",
        "7",
        "--frames",
        "1",
        "-o",
        &out,
    ]);
    assert_eq!(code, 0, "{error}");
    let document: Value = serde_json::from_slice(&fs::read(folder.path("out/lookup.json")).unwrap()).unwrap();
    let rows = document["rows"].as_array().unwrap();
    // Two views, frames, layouts and filters each.
    assert_eq!(rows.len(), 16);
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    for row in rows {
        assert!(number(row, "pixels") > 1000.0, "{row}");
        // A root, a node and a leaf take at least a word each in most pixels.
        assert!((2.0..400.0).contains(&number(row, "words_per_pixel")), "{row}");
        // Neighbours share sectors, but 32 pixels need more than one.
        assert!((1.0..1000.0).contains(&number(row, "sectors_per_group")), "{row}");
        // Root, nodes and a leaf.
        assert!((1.0..40.0).contains(&number(row, "chain_per_group")), "{row}");
        assert!(number(row, "milliseconds") > 0.0, "{row}");
    }
    // No pixel is outside its cascade, and few pixels blend two cascades.
    let cascades = document["cascades"].as_array().unwrap();
    assert_eq!(cascades.len(), 6);
    for row in cascades {
        let gathered = (number(row, "filter") + 1.0).powi(2);
        assert!((0.9 * gathered..1.3 * gathered).contains(&number(row, "words_per_pixel")), "{row}");
        assert!((1.0..32.0 * gathered).contains(&number(row, "sectors_per_group")), "{row}");
        assert!(number(row, "chain_per_group") == 1.0 && number(row, "milliseconds") > 0.0, "{row}");
    }
    assert!(document["adapter"].as_str().is_some_and(|name| !name.is_empty()));
    for view in ["truth camera", "street"] {
        let words = |layout: &str, filter: u32| -> f64 {
            let of_file = |row: &&Value| {
                row["view"] == view
                    && row["frame"] == "light"
                    && row["layout"] == layout
                    && row["filter"] == filter
            };
            number(rows.iter().find(of_file).unwrap(), "words_per_pixel")
        };
        for layout in ["packed", "depths"] {
            assert!(words(layout, 5) > words(layout, 1), "{view}, {layout}");
        }
        // A leaf of depths is read once, however many layers the taps are in.
        assert!(words("depths", 5) < 2.5 * words("depths", 1), "{view}");
    }
}
