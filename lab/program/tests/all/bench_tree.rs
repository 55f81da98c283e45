//! `bench tree` as users run it, at small depths.

use std::fs;

use adumbra_testing::{Folder, lab};

#[test]
fn bench_tree_writes_tables_plots_and_pictures() {
    let folder = Folder::new();
    let out = folder.path("bench");
    let run = |only: &str| {
        let (code, error) = lab(&[
            "bench",
            "tree",
            "--scenes",
            "none",
            "--names",
            "primitives",
            "--depths",
            "5,6",
            "--runs",
            "2",
            "--samples",
            "2000",
            "--only",
            only,
            "-o",
            &out,
        ]);
        assert_eq!(code, 0, "{error}");
    };
    run("builders");
    run("reductions");
    let text = fs::read_to_string(folder.path("bench/tree.md")).unwrap();
    assert_eq!(text.matches("take turns").count(), 2, "{text}");
    let document: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path("bench/tree.json")).unwrap()).unwrap();
    for section in ["builders", "reductions"] {
        let rows = document[section]["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 2, "{section}");
        assert!(rows.iter().all(|r| r["agree"] == true), "{rows:?}");
    }
    let sizes = &document["reductions"]["rows"][1];
    let bytes = |key: &str| sizes[key].as_f64().unwrap();
    assert!(bytes("complete_bytes") > bytes("merged_bytes") && bytes("merged_bytes") > bytes("graph_bytes"));
    assert!(text.contains("## Builders") && text.contains("## Sort against hash"));
    for plot in ["tree-builders.svg", "tree-merging.svg", "tree-reductions.svg"] {
        let svg = fs::read_to_string(folder.path(&format!("bench/{plot}"))).unwrap();
        assert!(svg.contains("<svg") && svg.contains("depth"), "{plot}");
    }
}

#[test]
fn bench_tree_rejects_invalid_earlier_results() {
    let folder = Folder::new();
    for content in ["[]", "null", "{", ""] {
        let earlier = folder.write("tree.json", content.as_bytes());
        let out = folder.path("");
        let base =
            ["bench", "tree", "--scenes", "none", "--names", "primitives", "--depths", "3", "--runs", "1"];
        let (code, error) = lab(&[&base[..], &["--only", "builders", "-o", &out]].concat());
        assert_eq!(code, 3, "{content:?}: {error}");
        assert!(error.contains("tree.json") && error.contains("remove it"), "{content:?}: {error}");
        assert_eq!(fs::read(&earlier).unwrap(), content.as_bytes());
    }
}
