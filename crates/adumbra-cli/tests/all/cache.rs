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
    assert_eq!(said["reused_tiles"], 0);
    let said = bake(&second, &["--cache", &cache]);
    assert!(said["reused_tiles"] == said["tiles"] && said["tiles"].as_u64() > Some(0), "{said}");
    let bytes = fs::read(&plain).unwrap();
    assert!(fs::read(&first).unwrap() == bytes && fs::read(&second).unwrap() == bytes);

    let info = json(&["cache", "info", &cache, "--json"]);
    let (objects, all) = (info["objects"].as_u64().unwrap(), info["bytes"].as_u64().unwrap());
    assert!(objects > 1 && all > 0, "{info}");
    let half = (all / 2).to_string();
    let pruned = json(&["cache", "prune", &cache, "--keep", &half, "--json"]);
    let left = pruned["left"]["bytes"].as_u64().unwrap();
    assert!(left <= all / 2 && pruned["removed"]["bytes"].as_u64() == Some(all - left), "{pruned}");
    let said = bake(&second, &["--cache", &cache]);
    assert!(said["reused_tiles"].as_u64() < said["tiles"].as_u64(), "{said}");
    assert!(fs::read(&second).unwrap() == bytes && folder.no_temporary_files());
}

#[test]
fn caches_that_are_not_there_or_cannot_be_written_are_errors_that_name_them() {
    let folder = Folder::new();
    let (code, error) = adumbra(&["cache", "info", &folder.path("none")]);
    assert!(code == 3 && error.contains("none"), "{code}: {error}");
    let (code, error) = adumbra(&["cache", "prune", &folder.path("none")]);
    assert!(code == 2 && error.contains("--keep"), "{code}: {error}");
    let (scene, file) = (folder.generate("city"), folder.write("taken", b"a file"));
    let output = folder.write("city.adumbra", b"earlier");
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "256", "--cache", &file, "-o", &output]);
    assert!(code != 0 && error.contains("taken"), "{code}: {error}");
    assert_eq!(fs::read(&output).unwrap(), b"earlier");
}
