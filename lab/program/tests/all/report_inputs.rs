//! `report` preserves files that it did not write.

use std::fs;

use adumbra_testing::{Folder, lab};

#[test]
fn report_keeps_scenes_that_it_did_not_make() {
    let folder = Folder::new();
    let (out, scenes) = (folder.path("r"), folder.path("r/scenes"));
    fs::create_dir_all(&scenes).unwrap();
    for kind in ["city", "cornell"] {
        let mine = folder.write(&format!("r/scenes/{kind}.glb"), b"mine");
        for given in [&[][..], &["--scenes", &scenes]] {
            let (code, error) = lab(&[&["report", "-o", &out, "--only", "blur"][..], given].concat());
            assert_eq!((code, error.contains("generates a scene of this name")), (2, true), "{error}");
            assert_eq!(fs::read(&mine).unwrap(), b"mine");
        }
        fs::remove_file(&mine).unwrap();
    }
    // A section's data folder is cleared before a new measurement, so scenes in that folder are refused.
    let measured = folder.path("r/data/blur");
    fs::create_dir_all(&measured).unwrap();
    let (code, error) = lab(&["report", "-o", &out, "--only", "blur", "--scenes", &measured]);
    assert_eq!((code, error.contains("clears")), (2, true), "{error}");
}

#[cfg(unix)]
#[test]
fn report_rejects_outputs_that_are_one_file() {
    let folder = Folder::new();
    let mine = folder.write("report.html", b"earlier");
    std::os::unix::fs::symlink("report.html", folder.path("report.json")).unwrap();
    let (code, error) = lab(&["report", "-o", &folder.path("")]);
    assert_eq!(fs::read(&mine).unwrap(), b"earlier");
    assert_eq!((code, error.contains("are one file")), (2, true), "{error}");
}
