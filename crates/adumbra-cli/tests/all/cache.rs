//! `bake --cache` and `cache`.

use std::fs;

use adumbra_testing::{Folder, adumbra, json};

#[test]
fn cached_bakes_write_the_same_file_and_say_what_they_reused() {
    let folder = Folder::new();
    let (scene, cache) = (folder.generate("city"), folder.path("cache"));
    let bake = |output: &str, more: &[&str]| {
        let words = ["bake", &scene, "--resolution", "1024", "-o", output, "--json"];
        json(&[&words, more].concat())
    };
    let [plain, first, second] = ["plain", "first", "second"].map(|name| folder.path(name));
    bake(&plain, &[]);
    let said = bake(&first, &["--cache", &cache]);
    assert_eq!(said["reused_root_blocks"], 0);
    let said = bake(&second, &["--cache", &cache]);
    assert!(
        said["reused_root_blocks"] == said["root_blocks"] && said["root_blocks"].as_u64() > Some(0),
        "{said}"
    );
    let bytes = fs::read(&plain).unwrap();
    assert!(fs::read(&first).unwrap() == bytes && fs::read(&second).unwrap() == bytes);

    let info = json(&["cache", "info", &cache, "--json"]);
    let (entries, all) = (info["entries"].as_u64().unwrap(), info["bytes"].as_u64().unwrap());
    assert!(entries > 1 && all > 0, "{info}");
    let half = (all / 2).to_string();
    let pruned = json(&["cache", "prune", &cache, "--keep", &half, "--json"]);
    let left = pruned["left"]["bytes"].as_u64().unwrap();
    assert!(left <= all / 2 && pruned["removed"]["bytes"].as_u64() == Some(all - left), "{pruned}");
    let said = bake(&second, &["--cache", &cache]);
    assert!(said["reused_root_blocks"].as_u64() < said["root_blocks"].as_u64(), "{said}");
    assert!(fs::read(&second).unwrap() == bytes && folder.no_temporary_files());
}

#[test]
fn missing_or_unwritable_caches_are_errors_that_name_the_path() {
    let folder = Folder::new();
    let (code, error) = adumbra(&["cache", "info", &folder.path("none")]);
    assert!(code == 3 && error.contains("none"), "{code}: {error}");
    let (code, error) = adumbra(&["cache", "prune", &folder.path("none")]);
    assert!(code == 2 && error.contains("--keep"), "{code}: {error}");
    let (scene, file) = (folder.generate("city"), folder.write("taken", b"a file"));
    let output = folder.write("city.adumbra", b"earlier");
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "256", "--cache", &file, "-o", &output]);
    assert!(code != 0 && error.contains("--cache") && error.contains("taken"), "{code}: {error}");
    assert_eq!(fs::read(&output).unwrap(), b"earlier");
    // The error comes before the scene is loaded, which may take long.
    let broken = folder.write("broken.glb", b"no scene");
    for verb in [&["bake", &broken][..], &["bake", &broken, "--watch"], &["bake", &broken, "--regions=1024"]]
    {
        let (code, error) = adumbra(&[verb, &["--cache", &file]].concat());
        assert!(code != 0 && error.contains("--cache") && error.contains("taken"), "{code}: {error}");
    }
}

#[test]
fn bake_warns_of_an_unusable_cache_and_continues() {
    let folder = Folder::new();
    let (scene, cache) = (folder.generate("primitives"), folder.path("cache"));
    let bake = |output: &str| {
        adumbra(&["bake", &scene, "--resolution", "256", "--levels", "1", "--cache", &cache, "-o", output])
    };
    let [first, second] = ["first", "second"].map(|name| folder.path(name));
    let (code, said) = bake(&first);
    assert!(code == 0 && !said.contains("warning"), "{code}: {said}");
    let in_cache = |path: &str| fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    let entries: Vec<_> = in_cache(&cache)
        .filter(|path| !path.ends_with("new"))
        .flat_map(|path| in_cache(path.to_str().unwrap()))
        .collect();
    for entry in &entries {
        fs::remove_file(entry).unwrap();
        fs::create_dir(entry).unwrap();
    }
    let (code, said) = bake(&second);
    assert!(code == 0 && said.matches("warning: --cache").count() == 1, "{code}: {said}");
    assert!(fs::read(&first).unwrap() == fs::read(&second).unwrap());
    // A folder in place of an entry is not removed.
    assert_eq!(json(&["cache", "prune", &cache, "--keep", "0", "--json"])["removed"]["entries"], 0);
}

/// The light that `--link-in` writes leads to the same sun.
#[test]
fn scene_with_a_linked_file_is_baked_from_the_cache() {
    let folder = Folder::new();
    let (scene, cache, output) =
        (folder.generate("primitives"), folder.path("cache"), folder.path("a.adumbra"));
    let bake = || {
        json(&[
            "bake",
            &scene,
            "--resolution",
            "512",
            "--link-in",
            &scene,
            "--cache",
            &cache,
            "-o",
            &output,
            "--json",
        ])
    };
    assert_eq!(bake()["reused_root_blocks"], 0);
    let first = fs::read(&output).unwrap();
    for _ in 0..2 {
        let said = bake();
        assert!(
            said["reused_root_blocks"] == said["root_blocks"] && said["sun_origin"]["source"] == "light",
            "{said}"
        );
        assert!(fs::read(&output).unwrap() == first);
    }
}
