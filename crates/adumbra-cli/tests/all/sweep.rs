//! `compare --sun-sweep` as a user calls it.

#![cfg(feature = "render")]

use std::fs;

use adumbra_testing::{Folder, adumbra, json};
use serde_json::Value;

const DAY: &str = "lat=48,lon=11,date=2026-03-20,from=11:00,to=13:00";
const WITHIN: &str = "lat=48,lon=11,date=2026-03-20,from=11:15,to=12:45";

fn share(row: &Value, field: &str) -> f64 {
    row[field].as_f64().unwrap_or_else(|| panic!("{field}: {row}"))
}

fn bake(folder: &Folder, scene: &str, day: &str, more: &[&str]) -> String {
    let file = folder.path("day.adumbra");
    let words = ["bake", scene, "--sun-path", day, "--path-error", "0.3", "-o", &file];
    let (code, said) = adumbra(&[&words[..], more].concat());
    assert_eq!(code, 0, "{said}");
    file
}

/// A sweep, and the limits that its figures must keep.
struct Sweep<'a> {
    /// A generated scene.
    kind: &'a str,
    /// The resolution of its sun path.
    resolution: &'a str,
    camera: &'a str,
    size: &'a str,
    steps: &'a str,
    pixels: u64,
    /// The largest share of pixels that are wrong between keys, the largest share that change more often than
    /// with rays, and the largest error of the share that change.
    most: [f64; 3],
    /// The largest share of pixels that change without shadows, and how many times more pixels are wrong
    /// then.
    without: [f64; 2],
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn path_between_keys_is_accurate_and_changes_like_rays() {
    a_path_is_as_right_as_a_file_and_changes_as_rays_do(&Sweep {
        kind: "city",
        resolution: "2048",
        camera: "street",
        size: "160x90",
        steps: "40",
        pixels: 5000,
        most: [0.03, 0.005, 0.01],
        without: [1e-3, 4.0],
    });
}

#[test]
fn coarse_path_between_keys_is_accurate_and_changes_like_rays() {
    a_path_is_as_right_as_a_file_and_changes_as_rays_do(&Sweep {
        kind: "primitives",
        resolution: "512",
        camera: "overview",
        size: "64x48",
        steps: "6",
        pixels: 500,
        most: [0.05, 0.02, 0.03],
        without: [5e-3, 2.0],
    });
}

#[test]
fn render_draws_a_moment_of_a_path_but_not_of_a_file() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let hour = "lat=48,lon=11,date=2026-03-20,from=11:30,to=12:30,step=300";
    let day = bake(&folder, &scene, hour, &["--resolution", "256"]);
    let picture = folder.path("noon.png");
    let render = ["render", &scene, "--size", "32x18", "--shadow", "voxel:path:filter=1", "-o", &picture];
    let (code, said) = adumbra(&[&render[..], &["--shadow-file", &day, "--sun-time", "12:00"]].concat());
    assert_eq!(code, 0, "{said}");
    let (code, said) = adumbra(&[&render[..], &["--resolution", "256"]].concat());
    assert!(code == 2 && said.contains("it needs a moment of a sun path"), "{said}");
}

fn a_path_is_as_right_as_a_file_and_changes_as_rays_do(asked: &Sweep<'_>) {
    let folder = Folder::new();
    let (scene, out) = (folder.generate(asked.kind), folder.path("out"));
    let day = bake(&folder, &scene, DAY, &["--resolution", asked.resolution]);
    let report = json(&[
        "compare",
        &scene,
        "--shadow-file",
        &day,
        "--sun-sweep",
        WITHIN,
        "--sweep-steps",
        asked.steps,
        "--camera",
        asked.camera,
        "--size",
        asked.size,
        "--frames",
        "1",
        "--shadow",
        "voxel:path:filter=1",
        "--shadow",
        "csm:size=1024",
        "--shadow",
        "none",
        "--json",
        "-o",
        &out,
    ]);
    assert_eq!(report["sun_origin"]["source"], "sun-sweep");
    let sweep = &report["sweep"];
    let rows = sweep["techniques"].as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["voxel:path:filter=1", "csm:size=1024", "none"]);
    let [path, csm, none] = [0, 1, 2].map(|row| &rows[row]);
    let figures = ["wrong", "worst_wrong", "changes", "excess", "more_often"];
    for row in rows {
        eprintln!("{}: {:?}", row["name"], figures.map(|field| share(row, field)));
    }
    let steps: u64 = asked.steps.parse().unwrap();
    assert_eq!((&sweep["steps"], &sweep["nights"]), (&steps.into(), &0.into()));
    assert!(
        sweep["keys"].as_u64().unwrap() >= 2 && sweep["pixels"].as_u64().unwrap() > asked.pixels,
        "{sweep}"
    );
    assert_eq!(sweep["seconds"].as_array().unwrap().len() as u64, steps);

    let rays = share(sweep, "rays_changes");
    let [wrong, excess, apart] = asked.most;
    assert!(rays > 1e-3, "the rays change at {rays} of the pixels");
    assert!(share(path, "wrong") < wrong && share(path, "worst_wrong") >= share(path, "wrong"), "{path}");
    assert!(
        share(path, "excess") < excess && (share(path, "changes") - rays).abs() < apart,
        "{rays} change with rays: {path}"
    );
    // Without shadows hardly any pixel changes, and pixels that are dark according to rays are wrong.
    let [changes, times] = asked.without;
    assert!(["changes", "excess", "more_often"].iter().all(|field| share(none, field) < changes), "{none}");
    let is_far_less = |row: &&Value| share(none, "wrong") > times * share(row, "wrong");
    assert!([path, csm].iter().all(is_far_less), "{none} {path} {csm}");
    // A step's share is that of the pixels that change from the step before.
    let by_step = path["changes_by_step"].as_array().unwrap();
    assert!(by_step[0].is_null() && by_step[1..].iter().all(Value::is_number), "{by_step:?}");

    for file in ["sweep.svg", "voxel_path_filter=1.changes.png", "csm_size=1024.changes.png"] {
        assert!(folder.exists(&format!("out/{file}")), "{file}");
    }
    let text = fs::read_to_string(folder.path("out/report.md")).unwrap();
    assert!(
        text.contains(&format!("{steps} steps from 11:15 to 12:45"))
            && text.contains("\n| `voxel:path:filter=1` |"),
        "{text}"
    );
    assert!(fs::read_to_string(folder.path("out/sweep.svg")).unwrap().contains("Wrong pixels"));
}

#[test]
fn sweep_bakes_its_path_and_skips_the_night() {
    let folder = Folder::new();
    let (scene, out) = (folder.generate("primitives"), folder.path("out"));
    let compare = |day: &str, shadow: &str, steps: &str| {
        json(&[
            "compare",
            &scene,
            "--sun-sweep",
            day,
            "--sweep-steps",
            steps,
            "--shadow",
            shadow,
            "--resolution",
            "256",
            "--size",
            "64x48",
            "--frames",
            "1",
            "--json",
            "-o",
            &out,
        ])
    };
    let baked = compare("lat=48,lon=11,date=2026-03-20,from=12:00,to=12:30,step=300", "voxel:path", "3");
    assert!(baked["sweep"]["keys"].as_u64().unwrap() >= 1, "{baked}");
    assert!(share(&baked["sweep"]["techniques"][0], "wrong") < 0.1, "{baked}");

    // The sun rises at about 6:20.
    let morning = compare("lat=48,lon=11,date=2026-03-20,from=5:00,to=8:00", "none", "13");
    let sweep = &morning["sweep"];
    assert!(sweep["keys"].is_null(), "{sweep}");
    let up = sweep["elevation_degrees"].as_array().unwrap();
    assert!(up.iter().all(|degrees| degrees.as_f64().unwrap() > 0.0), "{up:?}");
    assert_eq!((up.len(), &sweep["nights"]), (7, &6.into()));
}

#[test]
fn rejects_invalid_sweeps() {
    let folder = Folder::new();
    let (scene, out) = (folder.generate("primitives"), folder.path("out"));
    let day = bake(
        &folder,
        &scene,
        "lat=48,lon=11,date=2026-03-20,from=12,to=13,step=300",
        &["--resolution", "256"],
    );
    let one = folder.path("one.adumbra");
    assert_eq!(adumbra(&["bake", &scene, "--resolution", "256", "-o", &one]).0, 0);
    let base = ["compare", &scene, "--shadow", "none", "--size", "32x32", "-o", &out];
    for (more, words) in [
        (vec!["--sun-sweep", DAY, "--path", "orbit"], "cannot be used with"),
        (vec!["--sun-sweep", DAY, "--sun", "1,1,1"], "cannot be used with"),
        (vec!["--sun-sweep", DAY, "--azimuth", "90", "--elevation", "30"], "cannot be used with"),
        (vec!["--sun-sweep", DAY, "--sweep-steps", "1"], "1 is not in 2..="),
        (vec!["--sweep-steps", "9"], "--sun-sweep"),
        (vec!["--sun-sweep"], "give a day, such as lat="),
        (vec!["--sun-sweep", "lat=48,lon=11"], "date"),
        (
            vec!["--sun-sweep", "lat=48,lon=11,date=2026-03-20,from=0,to=3"],
            "in 0 of 600 steps; choose other hours",
        ),
        (vec!["--sun-sweep", "--shadow-file", &one], "is not a sun path; bake one with bake --sun-path"),
        (vec!["--sun-sweep", "--shadow-file", &day, "--shadow-file", &day], "takes one"),
        (vec!["--sun-sweep", DAY, "--shadow-file", &day], "is from 12:00 to 13:00 of its day"),
        (
            vec!["--sun-sweep", "lat=38,lon=11,date=2026-03-20,from=12,to=13", "--shadow-file", &day],
            "has other suns; give the place",
        ),
        (vec!["--shadow-file", &day], "move the sun with compare --sun-sweep"),
    ] {
        let (code, error) = adumbra(&[&base[..], &more].concat());
        assert_eq!(code, 2, "{more:?}: {error}");
        assert!(error.contains(words), "{more:?}: {error}");
    }
    assert!(!folder.exists("out/report.md"));
}
