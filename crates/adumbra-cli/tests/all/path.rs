//! Sun paths: `bake --sun-path` and `--suns`, and the other verbs on their files.

use std::fs;
use std::process::Command;

use adumbra_testing::{Folder, adumbra, json, program, read_f32};

/// A fast bake of an afternoon.
const SMALL: [&str; 4] = ["--resolution", "512", "--path-error", "1"];
const DAY: &str = "lat=48,lon=11,date=2026-03-20,from=12,to=14:30,step=300";

fn refused(words: &[&str], expected_code: i32, what: &str) {
    let (code, said) = adumbra(words);
    assert_eq!(code, expected_code, "{words:?}: {said}");
    assert!(said.contains(what), "{words:?}: {said}");
}

#[test]
fn half_an_hour_is_baked_and_verified() {
    let folder = Folder::new();
    let (scene, day) = (folder.generate("primitives"), folder.path("day.adumbra"));
    let moments = "lat=48,lon=11,date=2026-03-20,from=12,to=12:30,step=300";
    let said = json(&[
        "bake",
        &scene,
        "--sun-path",
        moments,
        "-o",
        &day,
        "--resolution",
        "256",
        "--path-error",
        "2",
        "--json",
    ]);
    let keys = said["keys"].as_array().unwrap();
    assert!(!keys.is_empty() && said["steps"] == 7, "{said}");
    let verify = ["verify", &day, "--scene", &scene, "--every", "3", "--max-excess", "5", "--json"];
    let verified = json(&verify);
    assert!(
        verified["ok"] == true && verified["moments"].as_array().is_some_and(|all| !all.is_empty()),
        "{verified}"
    );
    let other = folder.generate("city");
    let (code, said) = adumbra(&["verify", &day, "--scene", &other, "--every", "3", "--max-excess", "50"]);
    assert_eq!(code, 1, "{said}");
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn a_day_is_baked_and_verified_and_answers_at_its_moments() {
    let folder = Folder::new();
    let (scene, day) = (folder.generate("city"), folder.path("day.adumbra"));
    let bake = [&["bake", &scene, "--sun-path", DAY, "-o", &day, "--json"][..], &SMALL].concat();
    let said = json(&bake);
    let keys = said["keys"].as_array().unwrap();
    assert!(keys.len() >= 2 && said["steps"] == 31, "{said}");
    assert_eq!(said["file_bytes"], fs::metadata(&day).unwrap().len());
    let written = fs::read(&day).unwrap();
    json(&bake);
    assert_eq!(fs::read(&day).unwrap(), written, "another bake has other bytes");
    assert!(folder.no_temporary_files());

    let info = json(&["info", &day, "--json"]);
    assert_eq!(info["key_seconds"].as_array().unwrap().len(), keys.len());
    assert_eq!((&info["place_degrees"][0], &info["utc_offset_seconds"]), (&48.0.into(), &3600.into()));
    let output = Command::new(program()).args(["info", &day]).output().unwrap();
    let lines = String::from_utf8(output.stdout).unwrap();
    assert!(lines.contains("12:00 to 14:30") && lines.matches("decoded").count() == keys.len(), "{lines}");

    let plot = folder.path("plot.svg");
    let verify = ["verify", &day, "--scene", &scene, "--every", "6", "--max-excess", "2", "--plot", &plot];
    let verified = json(&[&verify[..], &["--json"]].concat());
    let moments = verified["moments"].as_array().unwrap();
    assert!(moments.len() == 6 && verified["ok"] == true, "{verified}");
    assert!(verified["mean_wrong_percent"].as_f64().unwrap() < 6.0, "{verified}");
    assert!(fs::read_to_string(&plot).unwrap().contains("between the keys"));
    // The city of another seed is another city.
    let other = folder.path("other.glb");
    assert_eq!(adumbra(&["generate", "city", "--seed", "99", "-o", &other]).0, 0);
    let (code, said) = adumbra(&["verify", &day, "--scene", &other, "--every", "30", "--max-excess", "50"]);
    assert!(code == 1 && said.contains("the middle key misses"), "{said}");

    let points: Vec<f32> = (0..4000_u32)
        .flat_map(|i| [300.0 * ((i % 61) as f32 / 61.0 - 0.5), 1.5, 300.0 * ((i % 67) as f32 / 67.0 - 0.5)])
        .collect();
    let points = folder.write_f32("points", &points);
    let at = |time: &str| {
        let out = folder.path("out");
        let (code, said) =
            adumbra(&["query", &day, "--time", time, "--points", &points, "--filter", "1", "-o", &out]);
        assert_eq!(code, 0, "{said}");
        read_f32(&out)
    };
    let (early, late) = (at("12:02"), at("14:28:30"));
    let moved = early.iter().zip(&late).filter(|(a, b)| a != b).count();
    assert!(moved * 50 > early.len(), "{moved} points have changed");
    let seconds = info["span_seconds"][0].as_f64().unwrap() + 120.0;
    assert_eq!(at(&seconds.to_string()), early);
}

#[test]
fn suns_from_a_list_are_baked_and_night_is_dark() {
    let folder = Folder::new();
    let (scene, day) = (folder.generate("primitives"), folder.path("list.adumbra"));
    let suns = folder.write("suns.txt", b"# time azimuth elevation\n0 100 40\n60 101 41\n120 250 -5\n");
    let said = json(&[&["bake", &scene, "--suns", &suns, "-o", &day, "--json"][..], &SMALL].concat());
    assert_eq!(said["keys"].as_array().unwrap().len(), 2, "{said}");
    let points = folder.write_f32("points", &[0.0, 100.0, 0.0]);
    let out = folder.path("out");
    for (time, expected) in [("30", 1.0), ("120", 0.0)] {
        let (code, said) = adumbra(&["query", &day, "--time", time, "--points", &points, "-o", &out]);
        assert_eq!((code, read_f32(&out)), (0, vec![expected]), "{said}");
        assert_eq!(said.contains("below the horizon"), expected == 0.0, "{said}");
    }
    refused(&["query", &day, "--points", &points, "-o", &out], 2, "give a moment with --time");
    refused(&["query", &day, "--time", "12:00", "--points", &points, "-o", &out], 2, "give seconds");
    refused(
        &["query", &day, "--time", "500", "--points", &points, "-o", &out],
        2,
        "the path is from 0 s to 120 s",
    );
    refused(&["info", &day, "--picture", &out], 2, "is a sun path");
}

#[test]
fn wrong_paths_are_refused() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let out = folder.path("day.adumbra");
    let bake = |more: &[&str], code, what: &str| {
        refused(&[&["bake", &scene, "-o", &out][..], &SMALL, more].concat(), code, what);
    };
    bake(&["--sun-path", "lat=48,lon=11,date=2026-13-01,from=7,to=19"], 2, "2026-13-01");
    bake(&["--sun-path", "lat=48,lon=11,date=2026-06-21,from=0,to=2"], 3, "never 3° above the horizon");
    bake(&["--sun-path", DAY, "--sun", "1,1,1"], 2, "cannot be used with");
    bake(&["--sun-path", DAY, "--levels", "2"], 2, "cannot be used with");
    bake(&["--sun-path", DAY, "--lowest-sun", "0"], 2, "--lowest-sun 0");
    bake(&["--suns", &folder.write("suns", b"0 10 95\n")], 3, "suns");
    let file = folder.path("one.adumbra");
    assert_eq!(adumbra(&["bake", &scene, "--resolution", "512", "-o", &file]).0, 0);
    let points = folder.write_f32("points", &[0.0; 3]);
    refused(&["query", &file, "--time", "12:00", "--points", &points, "-o", &out], 2, "give a sun path");
    assert!(!folder.exists("day.adumbra"));
}
