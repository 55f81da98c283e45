//! `export`: the file for a web page.

use std::fs;
use std::process::Command;

use adumbra_testing::{Folder, adumbra, json, program, stderr};

/// Bakes a small city and returns the file's path.
fn bake(folder: &Folder) -> String {
    let scene = folder.generate("city");
    let file = folder.path("city.adumbra");
    let bake = ["bake", &scene, "--resolution", "256", "--progress", "none", "-o", &file];
    let (code, error) = adumbra(&bake);
    assert_eq!(code, 0, "{error}");
    file
}

#[test]
fn export_for_a_web_page_writes_the_coded_file() {
    let folder = Folder::new();
    let file = bake(&folder);
    let raw = folder.path("raw.adumbra");
    json(&["unpack", &file, "-o", &raw, "--json"]);
    let web = folder.path("web.adumbra");
    // Whether the file is raw or coded, the copy is coded.
    for input in [&*raw, &*file] {
        let exported = json(&["export", input, "--web", &web, "--json"]);
        assert!(fs::read(&web).unwrap() == fs::read(&file).unwrap());
        assert_eq!(exported["web_bytes"].as_u64(), Some(fs::metadata(&file).unwrap().len()));
    }
    // The file itself may be the copy.
    let printed = Command::new(program()).args(["export", &raw, "--web", &raw]).output().unwrap();
    let text = String::from_utf8_lossy(&printed.stdout);
    assert!(printed.status.success(), "{}", stderr(&printed));
    assert!(text.contains("loadAsync('raw.adumbra')"), "{text}");
    assert!(fs::read(&raw).unwrap() == fs::read(&file).unwrap());
    assert!(folder.no_temporary_files());
}

#[test]
fn export_for_a_web_page_refuses_what_it_cannot_write() {
    let folder = Folder::new();
    let file = bake(&folder);
    let (code, error) = adumbra(&["export", &file]);
    assert!(code == 2 && error.contains("--web"), "{error}");
    let (code, error) = adumbra(&["export", &file, "--web", &folder.path("no/such/web.adumbra")]);
    assert!(code != 0 && error.contains("no/such"), "{error}");
    let broken = folder.write("broken.adumbra", &fs::read(&file).unwrap()[..1000]);
    for (input, words) in [(&*broken, "cut off"), (&folder.path("city.glb"), "not a shadow file")] {
        let (code, error) = adumbra(&["export", input, "--web", &folder.path("web.adumbra")]);
        assert_eq!((code, error.contains(words)), (3, true), "{error}");
    }
    assert!(!folder.exists("web.adumbra"));
}
