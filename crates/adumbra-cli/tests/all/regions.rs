//! `bake --regions`, and manifests in place of shadow files.

use std::fs;

use adumbra_testing::{Folder, adumbra, json, read_f32};
use serde_json::Value;

const GRID: [&str; 4] = ["--resolution", "2048", "--levels", "2"];

fn runs(words: &[&str]) -> String {
    let (code, said) = adumbra(words);
    assert_eq!(code, 0, "{words:?}: {said}");
    said
}

fn bake(scene: &str, more: &[&str]) -> Value {
    json(&[&["bake", scene, "--json"][..], &GRID, more].concat())
}

#[test]
fn a_world_in_regions_answers_as_one_file_does() {
    let folder = Folder::new();
    let (scene, world, whole) = (folder.generate("city"), folder.path("world.json"), folder.path("whole"));
    let said = bake(&scene, &["--regions=1024", "-o", &world]);
    let regions = said["regions"].as_array().unwrap();
    assert!(regions.len() >= 4 && said["world_regions"] == regions.len(), "{said}");
    let on_disk = |region: &Value| fs::metadata(region["file"].as_str().unwrap()).unwrap().len();
    assert!(regions.iter().all(|region| region["file_bytes"] == on_disk(region)));
    assert!(folder.no_temporary_files());
    bake(&scene, &["-o", &whole]);

    // A manifest does not say how many triangles were baked.
    let verify = |file: &str| {
        let mut said = json(&["verify", file, "--scene", &scene, "--samples", "10000", "--json"]);
        let baked = said["baked_triangles"].take();
        (said, baked.as_u64())
    };
    let [(of_world, none), (of_whole, baked)] = [&world, &whole].map(|file| verify(file));
    assert_eq!(of_world, of_whole);
    assert_eq!((none, baked), (None, Some(148_276)));

    // Points over the whole city and beyond it.
    let points: Vec<f32> = (0..40_000_u32)
        .flat_map(|i| {
            let place = |steps: u32| (i % steps) as f32 / steps as f32;
            [900.0 * (place(211) - 0.5), 30.0 * place(7), 900.0 * (place(199) - 0.5)]
        })
        .collect();
    let points = folder.write_f32("points", &points);
    let query = |file: &str| {
        let out = folder.path("answers");
        runs(&["query", file, "--points", &points, "-o", &out]);
        read_f32(&out)
    };
    let (one, cut) = (query(&whole), query(&world));
    let differ = one.iter().zip(&cut).filter(|(a, b)| a != b).count();
    let dark = one.iter().filter(|&&visibility| visibility == 0.0).count();
    // Inside solids either answer is valid, and depends on the root blocks.
    assert!(differ * 200 < one.len() && dark * 20 > one.len(), "{differ} differ, {dark} are dark");

    let info = json(&["info", &world, "--json"]);
    assert_eq!(info["regions"].as_array().map(Vec::len), Some(regions.len()));
    assert_eq!(info["file_bytes"], said["file_bytes"]);
    let first = regions[0]["file"].as_str().unwrap();
    let info = json(&["info", first, "--json"]);
    assert_eq!(info["settings"]["region"]["x"], regions[0]["x"]);
    runs(&["info", first]);
    runs(&["info", &world]);
}

#[test]
fn shards_of_a_world_write_the_files_of_one_bake() {
    let folder = Folder::new();
    let (scene, all, shared) =
        (folder.generate("primitives"), folder.path("all.json"), folder.path("shared.json"));
    let (cache, of_all) = (folder.path("cache"), folder.path("all.regions"));
    bake(&scene, &["--regions=1024", "-o", &all]);
    let mut regions = 0;
    for shard in ["1/2", "0/2"] {
        let said = bake(&scene, &["--regions=1024", "--shard", shard, "--cache", &cache, "-o", &shared]);
        regions += said["regions"].as_array().unwrap().len();
        assert!(said["world_regions"].as_u64().unwrap() as usize >= regions);
    }
    let text = fs::read_to_string(&all).unwrap();
    assert_eq!(fs::read_to_string(&shared).unwrap(), text.replace("all.regions", "shared.regions"));
    let mut files = 0;
    for file in fs::read_dir(of_all).unwrap() {
        let path = file.unwrap().path();
        let other = path.to_str().unwrap().replace("all.regions", "shared.regions");
        assert!(fs::read(&path).unwrap() == fs::read(&other).unwrap(), "{other}");
        files += 1;
    }
    assert_eq!(files, regions);
    // A second bake of the edited scene takes a region's root blocks from the cache.
    let edit = folder.write("edit.json", br#"{ "removed": [4] }"#);
    let edited = || {
        let words = ["bake", &scene, "--voxel-size", "0.05", "--regions=1024", "--cache", &cache];
        json(&[&words[..], &["--edit", &edit, "--json"]].concat())
    };
    let first = edited();
    let [reused, all] =
        ["reused_root_blocks", "root_blocks"].map(|name| edited()["regions"][0][name].clone());
    assert!(reused == all && first["regions"][0]["root_blocks"] == all, "{reused} of {all}, {first}");
    assert!(folder.exists("primitives.regions.json") && folder.exists("primitives.regions"), "{first}");
}

#[test]
fn wrong_regions_are_refused() {
    let folder = Folder::new();
    let (scene, world) = (folder.generate("primitives"), folder.path("world.json"));
    let bake = |more: &[&str]| {
        adumbra(&[&["bake", &*scene, "--resolution", "2048", "-o", &world][..], more].concat())
    };
    for (more, what) in [
        (&["--regions=1000"][..], "--regions"),
        (&["--regions=262144"], "--regions"),
        (&["--shard", "0/2"], "--regions"),
        (&["--regions", "--bounds=0,0,0,1,1,1"], "--bounds"),
        (&["--regions", "--dry-run"], "--dry-run"),
        (&["--regions", "--voxel-size=0.0000001"], "regions"),
    ] {
        let (code, error) = bake(more);
        assert!(code == 2 && error.contains(what), "{more:?}: {code}: {error}");
        assert!(!folder.exists("world.json") && !folder.exists("world.regions"), "{more:?}");
    }
    let (code, error) = adumbra(&["bake", &scene, "--regions", "-o", &folder.path("world.adumbra")]);
    assert!(code == 2 && error.contains(".json"), "{code}: {error}");

    let (code, error) = bake(&["--regions=1024"]);
    assert_eq!(code, 0, "{error}");
    let (code, error) = adumbra(&["verify", &world, "--scene", &scene, "--level", "1"]);
    assert!(code == 2 && error.contains("--level 1"), "{code}: {error}");
    let (code, error) = adumbra(&["info", &world, "--picture", &folder.path("p.png")]);
    assert!(code == 2 && error.contains("--picture"), "{code}: {error}");
    let files = fs::read_dir(folder.path("world.regions")).unwrap();
    let files: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    let region = files[0].to_str().unwrap();
    let (code, error) = adumbra(&["verify", region, "--scene", &scene]);
    assert!(code == 2 && error.contains("manifest"), "{code}: {error}");
    // The file of one region replaces that of another; then that file is missing.
    let points = folder.write_f32("points", &[0.0; 3]);
    let query = || adumbra(&["query", &world, "--points", &points, "-o", &folder.path("answers")]);
    let own = fs::read(&files[0]).unwrap();
    fs::copy(&files[1], &files[0]).unwrap();
    let (code, error) = query();
    assert!(code == 3 && error.contains("is not the file of region"), "{code}: {error}");
    fs::remove_file(&files[0]).unwrap();
    let (code, error) = query();
    assert!(code == 3 && error.contains(region), "{code}: {error}");
    fs::write(&files[0], own).unwrap();
    assert_eq!(query().0, 0);
    let text = fs::read_to_string(&world).unwrap();
    fs::write(&world, text.replacen("\"x\"", "\"z\"", 1)).unwrap();
    let (code, error) = query();
    assert!(code == 3 && error.contains("world.json"), "{code}: {error}");
}
