//! `tree` as a user calls it.

use std::fs;
use std::process::Command;

use adumbra_testing::{Folder, adumbra, lab, lab_json, lab_program, read_f32};

/// Bakes `scene` as a tree of depth 8 with further options, and returns the printed JSON.
fn bake(scene: &str, output: &str, options: &[&str]) -> serde_json::Value {
    let base = ["tree", "bake", scene, "--resolution", "256", "--progress", "none", "--json"];
    lab_json(&[&base, options, &["-o", output]].concat())
}

#[test]
fn tree_verbs_work_together() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("tree.adumtree");
    let baked = bake(&scene, &file, &[]);
    assert_eq!(baked["frame"], "world");
    assert_eq!(baked["depth"], 8);
    assert_eq!(baked["file_bytes"].as_u64(), Some(fs::metadata(&file).unwrap().len()));
    assert!(baked["report"]["build_seconds"].as_f64().unwrap() > 0.0);

    let info = lab_json(&["tree", "info", &file, "--json"]);
    assert_eq!(info["frame"], "world");
    assert_eq!(info["body"], "words");
    assert_eq!(info["body_bytes"], baked["tree_bytes"]);
    assert_eq!(info["nodes"].as_u64(), info["body_bytes"].as_u64().map(|bytes| (bytes - 4) / 32));
    assert_eq!(info["settings"]["closed_regions"], true);

    let verify = ["tree", "verify", &file, "--scene", &scene, "--samples", "20000"];
    for filter in ["1", "3", "5"] {
        let checked = lab_json(&[&verify[..], &["--filter", filter, "--json"]].concat());
        assert!(checked["interior_agreement"].as_f64().unwrap() >= 0.999, "{checked}");
        assert!(checked["classes"][0]["points"].as_u64().unwrap() > 5_000, "{checked}");
    }
    let poisson = lab_json(&[&verify[..], &["--filter", "5", "--weights", "poisson", "--json"]].concat());
    assert!(poisson["interior_agreement"].as_f64().unwrap() >= 0.999, "{poisson}");
    let volume = lab_json(&[&verify[..], &["--volume", "--json"]].concat());
    assert!(volume["interior_agreement"].as_f64().unwrap() >= 0.999, "{volume}");

    let picture = folder.path("tree.png");
    let render = ["render", &scene, "--shadow-file", &file, "--size", "160x90", "-o", &picture];
    for shadow in [&[][..], &["--shadow", "voxel-cubes:weights=poisson"]] {
        let (code, error) = lab(&[&render[..], shadow].concat());
        assert_eq!(code, 0, "{error}");
    }
    let difference = lab_json(&[&render[..], &["--filter", "1", "--diff", "--json"]].concat());
    assert!(difference["difference_share"].as_f64().unwrap() < 0.02, "{difference}");
    assert!(folder.no_temporary_files());
}

#[test]
fn tree_file_does_not_depend_on_builder_or_reduction() {
    let folder = Folder::new();
    let scene = folder.generate("landscape");
    let first = folder.path("first.adumtree");
    bake(&scene, &first, &[]);
    let bytes = fs::read(&first).unwrap();
    let other = folder.path("other.adumtree");
    for options in [
        &["--builder", "iterative", "--threads", "1"][..],
        &["--builder", "pooled", "--reduction", "sort"],
        &["--reduction", "tree-hash", "--exhaustive"],
        &["--max-memory", "1GiB"],
    ] {
        let baked = bake(&scene, &other, options);
        assert!(fs::read(&other).unwrap() == bytes, "{options:?}");
        assert_eq!(baked["collisions"].is_u64(), options.contains(&"tree-hash"));
    }
}

#[test]
fn tree_options_report_their_effect() {
    let folder = Folder::new();
    let scene = folder.generate("landscape");
    let plain = folder.path("plain.adumtree");
    let plain_bytes = bake(&scene, &plain, &[])["body_bytes"].as_u64().unwrap();
    let points =
        folder.write_f32("p.f32", &[0.0, 2.0, 0.0, 10.0, 3.0, -20.0, -31.5, 4.0, 12.0, 40.0, 6.0, 9.0]);
    let answers = |file: &str, name: &str| {
        let output = folder.path(name);
        let query = ["tree", "query", file, "--points", &points, "--filter", "3", "-o", &output];
        let (code, error) = lab(&query);
        assert_eq!(code, 0, "{error}");
        read_f32(&output)
    };

    let symmetric = folder.path("symmetric.adumtree");
    let baked = bake(&scene, &symmetric, &["--symmetry"]);
    let bytes = baked["body_bytes"].as_u64().unwrap();
    assert!(bytes * 2 < plain_bytes, "{baked}");
    let both = ["bytes_with_mirrors", "bytes_without_mirrors"].map(|k| baked[k].as_u64().unwrap());
    assert_eq!(bytes, both[0].min(both[1]));
    let info = lab_json(&["tree", "info", &symmetric, "--json"]);
    assert_eq!(info["body"], "symmetric");
    // Mirrors merge more nodes. Without them there are as many nodes as in words.
    let plain_nodes = (plain_bytes - 4) / 32;
    let nodes = info["nodes"].as_u64().unwrap();
    assert!(nodes > 0 && nodes <= plain_nodes, "{nodes} of {plain_nodes}");
    assert_eq!(answers(&symmetric, "s.f32"), answers(&plain, "p.out.f32"));

    let lossy = folder.path("lossy.adumtree");
    let baked = bake(&scene, &lossy, &["--lossy", "0.5%"]);
    let changed = baked["changed_voxels"].as_u64().unwrap();
    assert!(changed > 0 && changed as f64 <= 0.005 * baked["leaf_voxels"].as_f64().unwrap(), "{baked}");
    assert!(baked["body_bytes"].as_u64().unwrap() < plain_bytes);
    let info = lab_json(&["tree", "info", &lossy, "--json"]);
    assert_eq!(info["settings"]["lossy"]["changed_voxels"], baked["changed_voxels"]);
    assert_eq!(info["settings"]["lossy"]["max_share"], 0.005);

    let penumbra = folder.path("penumbra.adumtree");
    let baked = bake(&scene, &penumbra, &["--attribute", "penumbra"]);
    assert_eq!(baked["body_bytes"], plain_bytes);
    assert!(baked["attribute_bytes"].as_u64().unwrap() > 10_000);
    assert_eq!(lab_json(&["tree", "info", &penumbra, "--json"])["attribute"], "penumbra");
    let widths = folder.path("w.f32");
    let query = |file: &str| {
        let output = folder.path("v.f32");
        lab(&["tree", "query", file, "--points", &points, "--penumbra", &widths, "-o", &output])
    };
    assert_eq!(query(&penumbra).0, 0);
    assert_eq!(read_f32(&widths).len(), 4);
    let (code, error) = query(&plain);
    assert_eq!(code, 3);
    assert!(error.contains("--attribute penumbra"), "{error}");
    // If both results have the same path, neither is written, whether or not the file exists.
    let new = folder.path("one.f32");
    for path in [&new, &widths] {
        let earlier = fs::read(path).ok();
        let (code, error) =
            lab(&["tree", "query", &penumbra, "--points", &points, "--penumbra", path, "-o", path]);
        assert_eq!(code, 2, "{error}");
        assert!(error.contains("the same file"), "{error}");
        assert_eq!(fs::read(path).ok(), earlier);
    }
}

/// A thin board 10 m above a floor under a sun overhead, so that the penumbra of its outline is 10 m · 0.0093
/// wide. Its edge is off the planes of the cube, so that the border crosses single voxels.
#[test]
fn tree_penumbra_width_matches_sun_size() {
    let folder = Folder::new();
    let obj = "v -8 0 -8\nv 8 0 -8\nv 8 0 8\nv -8 0 8\nv -2 10 -2\nv 1.99 10 -2\nv 1.99 10 2\nv -2 10 2\n\
        f 1 4 3\nf 1 3 2\nf 5 8 7\nf 5 7 6\n";
    let scene = folder.write("board.obj", obj.as_bytes());
    let file = folder.path("board.adumtree");
    let options = ["--sun", "0,1,0", "--resolution", "1024", "--attribute", "penumbra"];
    let base = ["tree", "bake", &scene, "--progress", "none", "-o", &file];
    let (code, error) = lab(&[&base[..], &options].concat());
    assert_eq!(code, 0, "{error}");
    // The two voxels on either side of the border, just above the floor.
    let steps: Vec<f32> = (0..28).map(|i| 1.971 + 0.001 * i as f32).collect();
    let points: Vec<f32> = steps.iter().flat_map(|x| [*x, 0.05, 0.3]).collect();
    let points = folder.write_f32("p.f32", &points);
    let widths = folder.path("w.f32");
    let output = folder.path("v.f32");
    let (code, error) =
        lab(&["tree", "query", &file, "--points", &points, "--penumbra", &widths, "-o", &output]);
    assert_eq!(code, 0, "{error}");
    let found: Vec<f32> = read_f32(&widths).into_iter().filter(|w| !w.is_nan() && *w > 0.0).collect();
    assert_eq!(found.len(), steps.len());
    for width in found {
        // Widths are quantized to eighths of a voxel of 1.6 cm.
        assert!((width - 0.0924).abs() < 0.001, "{width}");
    }
}

#[test]
fn tree_regions_are_baked_and_shown() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("regions.adumtree");
    let baked = bake(&scene, &file, &["--region", "-4,-4,4,4:10", "--region", "2,2,6,6:9"]);
    assert_eq!(baked["depth"], 10);
    let info = lab_json(&["tree", "info", &file, "--json"]);
    assert_eq!(info["regions"]["base_depth"], 8);
    assert_eq!(info["regions"]["list"][1]["depth"], 9);
    let rings = folder.path("rings.adumtree");
    let baked = bake(&scene, &rings, &["--rings", "1,-2:3,6"]);
    assert_eq!(baked["depth"], 8);
    assert_eq!(lab_json(&["tree", "info", &rings, "--json"])["regions"]["base_depth"], 6);
    for file in [&file, &rings] {
        let checked = lab_json(&["tree", "verify", file, "--scene", &scene, "--samples", "20000", "--json"]);
        assert!(checked["interior_agreement"].as_f64().unwrap() >= 0.999, "{checked}");
    }
}

#[test]
fn tree_texture_round_trip_restores_file() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let (file, page, back) = (folder.path("t.adumtree"), folder.path("t.png"), folder.path("b.adumtree"));
    for options in [&[][..], &["--attribute", "penumbra"], &["--rings", "0,0:3", "--lossy", "1%"]] {
        bake(&scene, &file, options);
        let exported = lab_json(&["tree", "export", &file, "--texture", &page, "--json"]);
        let imported = lab_json(&["tree", "import", &page, "-o", &back, "--json"]);
        assert_eq!((&exported["depth"], &imported["words"]), (&8.into(), &exported["words"]));
        assert!(fs::read(&back).unwrap() == fs::read(&file).unwrap(), "{options:?}");
    }
    bake(&scene, &file, &["--symmetry"]);
    let (code, error) = lab(&["tree", "export", &file, "--texture", &page]);
    assert_eq!(code, 3);
    assert!(error.contains("without --symmetry"), "{error}");
}

#[test]
fn tree_errors_have_expected_exit_codes() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let output = folder.write("tree.adumtree", b"earlier");
    let refused = |options: &[&str], code: i32, words: &str| {
        let base = ["tree", "bake", &scene, "--progress", "none", "-o", &output];
        let (found, error) = lab(&[&base[..], options].concat());
        assert_eq!(found, code, "{options:?}: {error}");
        assert!(error.contains(words), "{options:?}: {error}");
        assert_eq!(fs::read(&output).unwrap(), b"earlier");
    };
    refused(&["--capture-bias-slope", "17"], 2, "--capture-bias");
    refused(&["--region", "100,100,101,101:9"], 2, "touch the scene's cube");
    refused(&["--region", "0,0,1,1:8", "--resolution", "256"], 2, "deeper than the rest");
    refused(&["--rings", "0,0:nan"], 2, "--rings");
    refused(&["--voxel-size", "0.0001"], 2, "--voxel-size");
    refused(&["--symmetry", "--attribute", "penumbra"], 2, "cannot be used with");
    refused(&["--lossy", "101%"], 2, "between 0 and 100 %");
    refused(&["--region", "0,0,1,1"], 2, "X0,Z0,X1,Z1:DEPTH");
    refused(&["--region", "1,0,0,1:9"], 2, "--region");
    refused(&["--region", "0,0,1,1:16"], 2, "depths from 1 to 15");
    refused(&["--rings", "0,0:5,4"], 2, "--rings");
    refused(&["--resolution", "1000"], 2, "not a power of two");
    refused(&["--resolution", "65536"], 2, "bake a light-aligned file");
    refused(&["--resolution", "1024", "--max-memory", "1MiB"], 4, "memory");
    refused(&["--sun", "0,-1,0"], 2, "above the horizon");
    refused(&["--sun", "0,0,0"], 2, "direction");
    refused(&["--bounds", "nan,0,0,1,1,1"], 2, "six finite numbers");
    // Options that apply to light-aligned files only.
    for option in ["--thickness=0.1", "--receivers=static", "--assume-ground=no", "--dry-run", "--yaw=10"] {
        refused(&[option], 2, "unexpected argument");
    }

    let (tree, light) = (folder.path("good.adumtree"), folder.path("light.adumbra"));
    bake(&scene, &tree, &[]);
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "64", "--progress", "none", "-o", &light]);
    assert_eq!(code, 0, "{error}");
    let points = folder.write_f32("p.f32", &[0.0; 3]);
    let answers = folder.path("v.f32");
    let query = |file: &str, filter: &str| {
        lab(&["tree", "query", file, "--points", &points, "--filter", filter, "-o", &answers])
    };
    let (code, error) = query(&tree, "9");
    assert_eq!((code, error.contains("1, 3 or 5")), (2, true), "{error}");
    let (code, error) = query(&light, "3");
    assert_eq!((code, error.contains("a tree file is needed")), (3, true), "{error}");
    let (code, error) = adumbra(&["query", &tree, "--points", &points, "-o", &answers]);
    assert_eq!((code, error.contains("not a shadow file")), (3, true), "{error}");
    let (code, error) = adumbra(&["convert", &tree, "--encoding", "raw", "-o", &folder.path("raw.adumbra")]);
    assert_eq!((code, error.contains("not a shadow file")), (3, true), "{error}");
    assert!(!folder.exists("raw.adumbra"));
}

#[test]
fn every_tree_verb_shows_an_example() {
    for verb in ["bake", "info", "verify", "query", "export", "import"] {
        let output = Command::new(lab_program()).args(["tree", verb, "--help"]).output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.contains(&format!("Example: adumbra-lab tree {verb}")), "{verb}: {text}");
    }
}
