//! `export`: the file for a web page, and its compressed copy.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Command;

use adumbra::{AtRest, ShadowFile};
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
fn export_for_a_web_page_writes_the_file_and_its_compressed_copy() {
    let folder = Folder::new();
    let file = bake(&folder);
    let web = folder.path("web.adumbra");
    let exported = json(&["export", &file, "--web", &web, "--json"]);
    // The copy is raw, because Brotli compresses it.
    let bytes = ShadowFile::read(&file).unwrap().to_bytes(AtRest::Raw).unwrap();
    assert!(fs::read(&web).unwrap() == bytes);
    assert!(fs::read(&file).unwrap().len() < bytes.len());
    assert_eq!(exported["web_bytes"].as_u64(), Some(bytes.len() as u64));
    let compressed = fs::read(format!("{web}.br")).unwrap();
    assert_eq!(exported["compressed_bytes"].as_u64(), Some(compressed.len() as u64));
    assert!(compressed.len() < bytes.len(), "{} {}", compressed.len(), bytes.len());
    let mut back = Vec::new();
    brotli::Decompressor::new(&*compressed, 4096).read_to_end(&mut back).unwrap();
    assert!(back == bytes);
    // Again: the same bytes, and the file itself may be the copy.
    let printed = Command::new(program()).args(["export", &web, "--web", &web]).output().unwrap();
    let text = String::from_utf8_lossy(&printed.stdout);
    assert!(printed.status.success(), "{}", stderr(&printed));
    assert!(text.contains("loadAsync('web.adumbra')"), "{text}");
    assert!(fs::read(format!("{web}.br")).unwrap() == compressed);
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
    assert!(!folder.exists("web.adumbra") && !Path::new(&folder.path("web.adumbra.br")).exists());
}

#[cfg(unix)]
#[test]
fn two_outputs_are_not_one_file() {
    let folder = Folder::new();
    let file = bake(&folder);
    let web = folder.write("web.adumbra", b"earlier");
    std::os::unix::fs::symlink("web.adumbra", folder.path("web.adumbra.br")).unwrap();
    let (code, error) = adumbra(&["export", &file, "--web", &web]);
    assert_eq!((code, error.contains("are one file")), (2, true), "{error}");
    assert_eq!(fs::read(&web).unwrap(), b"earlier");
}
