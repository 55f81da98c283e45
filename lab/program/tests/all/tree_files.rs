//! No verb of `tree` replaces a file that it reads, and a verb that fails leaves every earlier file
//! unchanged.

use std::fs;
use std::process::Command;

use adumbra_testing::{Folder, lab, lab_json, lab_program, stderr};

/// A board of 4 × 4 m, 2 m above a floor of 20 × 20 m.
const BOARD: &str = "v -10 0 -10\nv 10 0 -10\nv 10 0 10\nv -10 0 10\nv -2 2 -2\nv 2 2 -2\nv 2 2 2\nv -2 2 2\n\
    f 1 4 3\nf 1 3 2\nf 5 8 7\nf 5 7 6\n";

struct BakedBoard {
    folder: Folder,
    scene: String,
    file: String,
}

fn baked() -> BakedBoard {
    let folder = Folder::new();
    let scene = folder.write("board.obj", BOARD.as_bytes());
    let file = folder.path("board.adumtree");
    let (code, error) = bake(&scene, &file, &["--resolution", "64", "--attribute", "penumbra"]);
    assert_eq!(code, 0, "{error}");
    BakedBoard { folder, scene, file }
}

fn bake(scene: &str, output: &str, more: &[&str]) -> (i32, String) {
    let base = ["tree", "bake", scene, "-o", output, "--sun", "0,1,0", "--progress", "none"];
    lab(&[&base[..], more].concat())
}

/// Bakes a city, whose export has several pages of 64 × 64 pixels.
fn city(folder: &Folder) -> String {
    let file = folder.path("city.adumtree");
    let (code, error) = bake(&folder.generate("city"), &file, &["--resolution", "512"]);
    assert_eq!(code, 0, "{error}");
    file
}

/// Returns other names of a file: another spelling, a symbolic link, a hard link.
fn names(folder: &Folder, name: &str) -> Vec<String> {
    let path = folder.path(name);
    let mut all = vec![path.clone(), folder.path(&format!("./{name}"))];
    #[cfg(unix)]
    {
        let link = folder.path(&format!("soft-{name}"));
        std::os::unix::fs::symlink(name, &link).unwrap();
        all.push(link);
    }
    let link = folder.path(&format!("hard-{name}"));
    fs::hard_link(&path, &link).unwrap();
    all.push(link);
    all
}

/// Checks that a command is refused with this exit code and a message, and leaves the file unchanged.
fn is_kept(path: &str, code: i32, command: &[&str]) {
    let before = fs::read(path).unwrap();
    let (found, error) = lab(command);
    assert_eq!(found, code, "{command:?}: {error}");
    assert!(error.contains("give another path"), "{command:?}: {error}");
    assert_eq!(fs::read(path).unwrap(), before, "{command:?}");
}

#[test]
fn tree_bake_does_not_overwrite_its_scene() {
    let BakedBoard { folder, scene, .. } = baked();
    for name in names(&folder, "board.obj") {
        is_kept(&scene, 3, &["tree", "bake", &scene, "-o", &name]);
    }
}

#[test]
fn tree_query_does_not_overwrite_its_inputs() {
    let BakedBoard { folder, file, .. } = baked();
    let points = folder.write_f32("p.f32", &[0.0, 0.0, 0.0]);
    let normals = folder.write_f32("n.f32", &[0.0, 1.0, 0.0]);
    let query = ["tree", "query", &file, "--points", &points, "--normals", &normals];
    let new = folder.path("new.f32");
    for (path, name) in [(&file, "board.adumtree"), (&points, "p.f32"), (&normals, "n.f32")] {
        for other in names(&folder, name) {
            is_kept(path, 2, &[&query[..], &["-o", &other]].concat());
            is_kept(path, 2, &[&query[..], &["-o", &new, "--penumbra", &other]].concat());
        }
    }
}

#[test]
fn tree_export_and_import_do_not_overwrite_inputs() {
    let BakedBoard { folder, file, .. } = baked();
    // Page 1 of an export to page 0 would replace the tree file.
    let second = folder.path("page.1.png");
    fs::rename(city(&folder), &second).unwrap();
    let export = ["tree", "export", &second, "--max-side", "64", "--texture"];
    is_kept(&second, 2, &[&export[..], &[&folder.path("page.png")]].concat());
    for name in names(&folder, "board.adumtree") {
        is_kept(&file, 2, &["tree", "export", &file, "--texture", &name]);
    }
    let page = folder.path("whole.png");
    let (code, error) = lab(&[&export[..], &[&page]].concat());
    assert_eq!(code, 0, "{error}");
    for output in [&page, &folder.path("whole.1.png")] {
        is_kept(output, 2, &["tree", "import", &page, "-o", output]);
    }
}

#[cfg(unix)]
#[test]
fn tree_export_rejects_pages_that_are_one_file() {
    let folder = Folder::new();
    let city = city(&folder);
    let (first, second) = (folder.path("p.png"), folder.path("p.1.png"));
    std::os::unix::fs::symlink("p.png", &second).unwrap();
    for there_already in [false, true] {
        let (code, error) = lab(&["tree", "export", &city, "--max-side", "64", "--texture", &first]);
        assert_eq!((code, error.contains("are one file")), (2, true), "{error}");
        assert_eq!(folder.exists("p.png"), there_already);
        fs::write(&first, "earlier").unwrap();
    }
}

#[test]
fn failed_tree_query_keeps_earlier_widths() {
    let BakedBoard { folder, file, .. } = baked();
    let points = folder.write_f32("p.f32", &[0.0; 3]);
    let widths = folder.write("w.f32", b"earlier");
    let missing = folder.path("missing/v.f32");
    let (code, error) =
        lab(&["tree", "query", &file, "--points", &points, "--penumbra", &widths, "-o", &missing]);
    assert_eq!((code, error.contains("create it first")), (3, true), "{error}");
    assert_eq!(fs::read(&widths).unwrap(), b"earlier");
    assert!(folder.no_temporary_files());
}

#[cfg(target_os = "linux")]
#[test]
fn failed_tree_export_keeps_earlier_pages() {
    let folder = Folder::new();
    let (city, page) = (city(&folder), folder.path("page.png"));
    let export = |side| ["tree", "export", &city, "--texture", &page, "--max-side", side];
    let (code, error) = lab(&export("128"));
    assert_eq!((code, folder.exists("page.1.png")), (0, true), "{error}");
    let pages = ["page.png", "page.1.png"].map(|name| folder.path(name));
    let before = pages.each_ref().map(|page| fs::read(page).unwrap());
    // A limit on file sizes has the effect of a full disk. A page with sides of 128 pixels is smaller than
    // the limit, a page with sides of 256 pixels is larger.
    let limit = before.iter().map(Vec::len).max().unwrap().div_ceil(512);
    let limited = format!("ulimit -f {limit}; exec \"$@\"");
    let mut shell = Command::new("sh");
    shell.args(["-c", &limited, "sh"]).arg(lab_program()).args(export("256"));
    let output = shell.output().unwrap();
    let said = stderr(&output);
    assert_eq!((output.status.code(), said.contains("raise the file size limit")), (Some(4), true), "{said}");
    assert_eq!(pages.each_ref().map(|page| fs::read(page).unwrap()), before);
    assert!(folder.no_temporary_files());
}

#[test]
fn tree_bake_warns_about_empty_bounds() {
    let BakedBoard { folder, scene, .. } = baked();
    let output = folder.path("b.adumtree");
    for (bounds, empty) in [("100,0,100,110,5,110", true), ("-1,-1,-1,1,1,1", false)] {
        let options = ["--resolution", "64", "--bounds", bounds];
        let (code, error) = bake(&scene, &output, &options);
        assert_eq!((code, error.contains("--bounds contain no part of")), (0, empty), "{error}");
        let base = ["tree", "bake", &scene, "-o", &output, "--progress", "none", "--json"];
        assert_eq!(lab_json(&[&base[..], &options].concat())["empty_bounds"], empty, "{bounds}");
    }
}
