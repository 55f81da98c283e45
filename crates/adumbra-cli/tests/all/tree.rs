//! World-aligned trees on the command line.

use std::fs;

use adumbra_testing::{Folder, adumbra, json, read_f32};

/// Bakes `scene` as a tree of depth 8 with further options, and returns the printed JSON.
fn bake(scene: &str, output: &str, options: &[&str]) -> serde_json::Value {
    let base = ["bake", scene, "--frame", "world", "--resolution", "256", "--progress", "none", "--json"];
    json(&[&base, options, &["-o", output]].concat())
}

#[test]
fn tree_verbs_work_together() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("tree.adumbra");
    let baked = bake(&scene, &file, &[]);
    assert_eq!(baked["frame"], "world");
    assert_eq!(baked["depth"], 8);
    assert_eq!(baked["file_bytes"].as_u64(), Some(fs::metadata(&file).unwrap().len()));
    assert!(baked["report"]["build_seconds"].as_f64().unwrap() > 0.0);

    let info = json(&["info", &file, "--json"]);
    assert_eq!(info["frame"], "world");
    assert_eq!(info["body"], "words");
    assert_eq!(info["body_bytes"], baked["tree_bytes"]);
    assert_eq!(info["nodes"].as_u64(), info["body_bytes"].as_u64().map(|bytes| (bytes - 4) / 32));
    assert_eq!(info["settings"]["closed_regions"], true);

    for filter in ["1", "3", "5"] {
        let checked =
            json(&["verify", &file, "--scene", &scene, "--samples", "20000", "--filter", filter, "--json"]);
        assert!(checked["interior_agreement"].as_f64().unwrap() >= 0.999, "{checked}");
        assert!(checked["classes"][0]["points"].as_u64().unwrap() > 5_000, "{checked}");
    }
    let volume = json(&["verify", &file, "--scene", &scene, "--samples", "20000", "--volume", "--json"]);
    assert!(volume["interior_agreement"].as_f64().unwrap() >= 0.999, "{volume}");

    let picture = folder.path("tree.png");
    let render = ["render", &scene, "--shadow-file", &file, "--size", "160x90", "-o", &picture];
    let (code, error) = adumbra(&[&render[..], &["--weights", "poisson"]].concat());
    assert_eq!(code, 0, "{error}");
    let difference = json(&[&render[..], &["--filter", "1", "--diff", "--json"]].concat());
    assert!(difference["difference_share"].as_f64().unwrap() < 0.02, "{difference}");
    assert!(folder.no_temporary_files());
}

#[test]
fn tree_is_the_same_file_however_it_is_built() {
    let folder = Folder::new();
    let scene = folder.generate("landscape");
    let first = folder.path("first.adumbra");
    bake(&scene, &first, &[]);
    let bytes = fs::read(&first).unwrap();
    let other = folder.path("other.adumbra");
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
fn tree_options_report_what_they_did() {
    let folder = Folder::new();
    let scene = folder.generate("landscape");
    let plain = folder.path("plain.adumbra");
    let plain_bytes = bake(&scene, &plain, &[])["body_bytes"].as_u64().unwrap();
    let points =
        folder.write_f32("p.f32", &[0.0, 2.0, 0.0, 10.0, 3.0, -20.0, -31.5, 4.0, 12.0, 40.0, 6.0, 9.0]);
    let answers = |file: &str, name: &str| {
        let output = folder.path(name);
        let (code, error) = adumbra(&["query", file, "--points", &points, "--filter", "3", "-o", &output]);
        assert_eq!(code, 0, "{error}");
        read_f32(&output)
    };

    let symmetric = folder.path("symmetric.adumbra");
    let baked = bake(&scene, &symmetric, &["--symmetry"]);
    let bytes = baked["body_bytes"].as_u64().unwrap();
    assert!(bytes * 2 < plain_bytes, "{baked}");
    let both = ["bytes_with_mirrors", "bytes_without_mirrors"].map(|k| baked[k].as_u64().unwrap());
    assert_eq!(bytes, both[0].min(both[1]));
    let info = json(&["info", &symmetric, "--json"]);
    assert_eq!(info["body"], "symmetric");
    // Mirrors merge more nodes. Without them there are as many nodes as in words.
    let plain_nodes = (plain_bytes - 4) / 32;
    let nodes = info["nodes"].as_u64().unwrap();
    assert!(nodes > 0 && nodes <= plain_nodes, "{nodes} of {plain_nodes}");
    assert_eq!(answers(&symmetric, "s.f32"), answers(&plain, "p.out.f32"));

    let lossy = folder.path("lossy.adumbra");
    let baked = bake(&scene, &lossy, &["--lossy", "0.5%"]);
    let changed = baked["changed_voxels"].as_u64().unwrap();
    assert!(changed > 0 && changed as f64 <= 0.005 * baked["leaf_voxels"].as_f64().unwrap(), "{baked}");
    assert!(baked["body_bytes"].as_u64().unwrap() < plain_bytes);
    let info = json(&["info", &lossy, "--json"]);
    assert_eq!(info["settings"]["lossy"]["changed_voxels"], baked["changed_voxels"]);
    assert_eq!(info["settings"]["lossy"]["max_share"], 0.005);

    let penumbra = folder.path("penumbra.adumbra");
    let baked = bake(&scene, &penumbra, &["--attribute", "penumbra"]);
    assert_eq!(baked["body_bytes"], plain_bytes);
    assert!(baked["attribute_bytes"].as_u64().unwrap() > 10_000);
    assert_eq!(json(&["info", &penumbra, "--json"])["attribute"], "penumbra");
    let widths = folder.path("w.f32");
    let query = |file: &str| {
        adumbra(&["query", file, "--points", &points, "--penumbra", &widths, "-o", &folder.path("v.f32")])
    };
    assert_eq!(query(&penumbra).0, 0);
    assert_eq!(read_f32(&widths).len(), 4);
    let (code, error) = query(&plain);
    assert_eq!(code, 3);
    assert!(error.contains("--attribute penumbra"), "{error}");
    // One path for both results: neither is written, whether or not the file exists.
    let new = folder.path("one.f32");
    for path in [&new, &widths] {
        let earlier = fs::read(path).ok();
        let (code, error) =
            adumbra(&["query", &penumbra, "--points", &points, "--penumbra", path, "-o", path]);
        assert_eq!(code, 2, "{error}");
        assert!(error.contains("the same file"), "{error}");
        assert_eq!(fs::read(path).ok(), earlier);
    }
}

/// A thin board 10 m above a floor under a sun overhead, so that the penumbra of its outline is 10 m · 0.0093 wide. Its
/// edge is off the planes of the cube, so that the border crosses single voxels.
#[test]
fn tree_penumbra_is_as_wide_as_the_sun_makes_it() {
    let folder = Folder::new();
    let obj = "v -8 0 -8\nv 8 0 -8\nv 8 0 8\nv -8 0 8\nv -2 10 -2\nv 1.99 10 -2\nv 1.99 10 2\nv -2 10 2\n\
        f 1 4 3\nf 1 3 2\nf 5 8 7\nf 5 7 6\n";
    let scene = folder.write("board.obj", obj.as_bytes());
    let file = folder.path("board.adumbra");
    let options = ["--sun", "0,1,0", "--resolution", "1024", "--attribute", "penumbra"];
    let base = ["bake", &scene, "--frame", "world", "--progress", "none", "-o", &file];
    let (code, error) = adumbra(&[&base[..], &options].concat());
    assert_eq!(code, 0, "{error}");
    // The two voxels on either side of the border, just above the floor.
    let steps: Vec<f32> = (0..28).map(|i| 1.971 + 0.001 * i as f32).collect();
    let points: Vec<f32> = steps.iter().flat_map(|x| [*x, 0.05, 0.3]).collect();
    let points = folder.write_f32("p.f32", &points);
    let widths = folder.path("w.f32");
    let (code, error) =
        adumbra(&["query", &file, "--points", &points, "--penumbra", &widths, "-o", &folder.path("v.f32")]);
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
    let file = folder.path("regions.adumbra");
    let baked = bake(&scene, &file, &["--region", "-4,-4,4,4:10", "--region", "2,2,6,6:9"]);
    assert_eq!(baked["depth"], 10);
    let info = json(&["info", &file, "--json"]);
    assert_eq!(info["regions"]["base_depth"], 8);
    assert_eq!(info["regions"]["list"][1]["depth"], 9);
    let rings = folder.path("rings.adumbra");
    let baked = bake(&scene, &rings, &["--rings", "1,-2:3,6"]);
    assert_eq!(baked["depth"], 8);
    assert_eq!(json(&["info", &rings, "--json"])["regions"]["base_depth"], 6);
    for file in [&file, &rings] {
        let checked = json(&["verify", file, "--scene", &scene, "--samples", "20000", "--json"]);
        assert!(checked["interior_agreement"].as_f64().unwrap() >= 0.999, "{checked}");
    }
}

#[test]
fn tree_texture_gives_the_same_file_back() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let (file, page, back) = (folder.path("t.adumbra"), folder.path("t.png"), folder.path("b.adumbra"));
    for options in [&[][..], &["--attribute", "penumbra"], &["--rings", "0,0:3", "--lossy", "1%"]] {
        bake(&scene, &file, options);
        let exported = json(&["export", &file, "--texture", &page, "--json"]);
        assert_eq!(exported["kind"], "world-aligned");
        assert_eq!(json(&["import", &page, "-o", &back, "--json"])["kind"], "world-aligned");
        assert!(fs::read(&back).unwrap() == fs::read(&file).unwrap(), "{options:?}");
    }
    bake(&scene, &file, &["--symmetry"]);
    let (code, error) = adumbra(&["export", &file, "--texture", &page]);
    assert_eq!(code, 3);
    assert!(error.contains("without --symmetry"), "{error}");
}

#[test]
fn tree_faults_have_their_exit_codes() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let output = folder.write("tree.adumbra", b"earlier");
    let refused = |options: &[&str], code: i32, words: &str| {
        let base = ["bake", &scene, "--progress", "none", "-o", &output];
        let (found, error) = adumbra(&[&base[..], options].concat());
        assert_eq!(found, code, "{options:?}: {error}");
        assert!(error.contains(words), "{options:?}: {error}");
        assert_eq!(fs::read(&output).unwrap(), b"earlier");
    };
    let world = |options: &[&'static str]| [&["--frame", "world"][..], options].concat();
    refused(&["--symmetry"], 2, "--symmetry does not apply to --frame auto");
    refused(&["--yaw", "10"], 2, "--yaw does not apply to --frame auto");
    refused(&["--frame", "oblique", "--yaw", "200"], 2, "yaw");
    refused(&["--lossy", "1%"], 2, "--lossy");
    refused(&["--rings", "0,0:1"], 2, "--rings");
    refused(&["--builder", "pooled"], 2, "--builder does not apply to --frame auto");
    refused(&world(&["--capture-bias-slope", "17"]), 2, "--capture-bias");
    refused(&world(&["--region", "100,100,101,101:9"]), 2, "touch the scene's cube");
    refused(&world(&["--region", "0,0,1,1:8", "--resolution", "256"]), 2, "deeper than the rest");
    refused(&world(&["--rings", "0,0:nan"]), 2, "--rings");
    refused(&world(&["--voxel-size", "0.0001"]), 2, "--voxel-size");
    refused(&world(&["--thickness", "0.1"]), 2, "--thickness does not apply to --frame world");
    refused(&world(&["--receivers", "static"]), 2, "--receivers static");
    refused(&world(&["--no-assume-ground"]), 2, "--no-assume-ground");
    refused(&world(&["--symmetry", "--attribute", "penumbra"]), 2, "cannot be used with");
    refused(&world(&["--lossy", "101%"]), 2, "between 0 and 100 %");
    refused(&world(&["--region", "0,0,1,1"]), 2, "X0,Z0,X1,Z1:DEPTH");
    refused(&world(&["--region", "1,0,0,1:9"]), 2, "--region");
    refused(&world(&["--region", "0,0,1,1:16"]), 2, "depths from 1 to 15");
    refused(&world(&["--rings", "0,0:5,4"]), 2, "--rings");
    refused(&world(&["--dry-run"]), 2, "--dry-run");
    refused(&world(&["--resolution", "1000"]), 2, "not a power of two");
    refused(&world(&["--resolution", "65536"]), 2, "--frame light");
    refused(&world(&["--resolution", "1024", "--max-memory", "1MiB"]), 4, "memory");
    refused(&world(&["--sun", "0,-1,0"]), 2, "above the horizon");

    let tree = folder.path("good.adumbra");
    bake(&scene, &tree, &[]);
    let points = folder.write_f32("p.f32", &[0.0; 3]);
    let (code, error) =
        adumbra(&["query", &tree, "--points", &points, "--filter", "9", "-o", &folder.path("v.f32")]);
    assert_eq!(code, 2);
    assert!(error.contains("1, 3 or 5"), "{error}");
    let light = folder.path("light.adumbra");
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "64", "--progress", "none", "-o", &light]);
    assert_eq!(code, 0, "{error}");
    let (code, error) =
        adumbra(&["query", &light, "--points", &points, "--weights", "poisson", "-o", &folder.path("v.f32")]);
    assert_eq!(code, 2);
    assert!(error.contains("world-aligned"), "{error}");
}
