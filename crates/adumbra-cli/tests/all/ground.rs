//! Whether a bake assumes a ground: its messages, and the consequences.

use std::process::Command;

use adumbra_testing::{Folder, adumbra, json, program, stderr};
use serde_json::Value;

fn bake(folder: &Folder, scene: &str, words: &[&str]) -> (String, Value) {
    let file = folder.path("file.adumbra");
    let rest = ["--resolution", "512", "--progress", "none", "--json", "-o", &file];
    let said = json(&[&["bake", scene], words, &rest].concat());
    (file, said)
}

fn ground(file: &str, scene: &str, words: &[&str]) -> Value {
    let said = json(&[&["verify", file, "--scene", scene, "--samples", "20000", "--json"], words].concat());
    let classes = said["classes"].as_array().unwrap();
    classes.iter().find(|class| class["class"] == "ground").unwrap().clone()
}

#[test]
fn bake_reports_a_ground_and_verify_checks_it() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let alone = ["--exclude", "ground*"];

    let (file, said) = bake(&folder, &scene, &[]);
    assert_eq!(said["assumes_ground"], true);
    assert_eq!(ground(&file, &scene, &[])["points"], 0);

    let (file, said) = bake(&folder, &scene, &alone);
    assert_eq!(said["assumes_ground"], false);
    let kept = ground(&file, &scene, &alone);
    assert_eq!((&kept["checked"], &kept["holds"]), (&true.into(), &true.into()), "{kept}");

    for (words, is_assumed) in [("yes", true), ("no", false)] {
        let (_, said) = bake(&folder, &scene, &[&alone[..], &["--assume-ground", words]].concat());
        assert_eq!(said["assumes_ground"], is_assumed);
        let (_, said) = bake(&folder, &scene, &["--assume-ground", words, "--dry-run"]);
        assert_eq!(said["assumes_ground"], is_assumed);
    }
}

#[test]
fn every_bake_reports_whether_it_assumes_a_ground() {
    let folder = Folder::new();
    let scene = folder.generate("ball");
    let path = |name: &str| folder.path(name);
    let suns = folder.write("suns.txt", b"# time azimuth elevation\n0 100 40\n60 101 41\n");
    let common = ["--resolution", "256", "--progress", "none"];
    for (words, output) in [
        (&["bake"][..], "a.adumbra"),
        (&["bake", "--dry-run"], "b.adumbra"),
        (&["bake", "--voxel-size", "0.01", "--regions=1024"], "c.json"),
        (&["bake", "--suns", &suns], "d.adumbra"),
        (&["plan"], "e.json"),
    ] {
        let has_size = words.contains(&"--voxel-size");
        let common = if has_size { &common[2..] } else { &common[..] };
        let common = if words[0] == "plan" { &common[..2] } else { common };
        let output = path(output);
        let all = [&words[..1], &[scene.as_str()], &words[1..], common, &["-o", &output]].concat();
        let run = Command::new(program()).args(&all).output().unwrap();
        let said = String::from_utf8_lossy(&run.stdout);
        let kept = "shadows below the last surface are kept: the scene has no ground";
        assert!(said.contains(kept), "{all:?}: {said}{}", stderr(&run));
    }
    let (code, error) = adumbra(&["bake", &scene, "--assume-ground", "maybe"]);
    assert_eq!(code, 2, "{error}");
}
