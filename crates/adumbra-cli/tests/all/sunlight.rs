//! `sun-hours` and `sky`: every format holds the same points, whatever the threads, and wrong calls name the
//! options to give.

use std::process::Command;
#[cfg(unix)]
use std::process::Stdio;

use adumbra_testing::{Folder, adumbra, assert_described, json, program};
use serde_json::Value;

const DAY: [&str; 12] = [
    "--lat",
    "48.14",
    "--lon",
    "11.58",
    "--tz",
    "Europe/Berlin",
    "--date",
    "2026-03-20",
    "--from",
    "8",
    "--to",
    "18",
];

/// Returns the schema of a file that a verb writes. `json` checks printed output against its schema.
fn schema(of: &str) -> Value {
    let output = Command::new(program()).args(["schema", of]).output().unwrap();
    assert!(output.status.success(), "{of}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn read_json(path: &str) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn sun_hours_are_the_same_in_every_format_and_on_any_threads() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let names = ["a.csv", "a.json", "a.ply", "a.png", "a.tif"];
    let of = |threads: &str| {
        let paths = names.map(|name| folder.path(&format!("{threads}-{name}")));
        let outputs = paths.iter().flat_map(|path| ["-o", path]);
        let base = ["sun-hours", &scene, "--grid", "1", "--threads", threads, "--json"];
        let said = json(&base.into_iter().chain(DAY).chain(outputs).collect::<Vec<_>>());
        (said, paths.map(|path| std::fs::read(path).unwrap()))
    };
    let (said, files) = of("1");
    assert!(files == of("3").1, "the files depend on the threads");
    let whole = read_json(&folder.path("1-a.json"));
    assert_described(&schema("sun-hours file"), &whole);
    let points = whole["points"].as_array().unwrap();
    assert_eq!(said["points"], points.len());
    assert!((said["most_hours"].as_f64().unwrap() - 10.0).abs() < 1e-9, "{said}");
    let [csv, _, ply, png, tif] = &files;
    let lines: Vec<&str> = std::str::from_utf8(csv).unwrap().lines().collect();
    assert_eq!(lines.len(), points.len() + 1);
    let mut shadowed = 0;
    for (line, point) in lines[1..].iter().zip(points) {
        let cells: Vec<&str> = line.split(',').collect();
        let hours: f64 = cells[6].parse().unwrap();
        assert!((hours - point["hours"].as_f64().unwrap()).abs() < 1e-3, "{line}: {point}");
        let spans = point["intervals"].as_array().unwrap();
        assert_eq!(cells[7].split_whitespace().count(), spans.len());
        let sum: f64 = spans.iter().map(|s| s[1].as_f64().unwrap() - s[0].as_f64().unwrap()).sum();
        assert!((sum / 3600.0 - hours).abs() < 1e-3);
        shadowed += usize::from(hours < 9.9);
        if hours > 9.99 {
            assert_eq!(cells[7], "08:00-18:00");
        }
    }
    assert!(shadowed > 10 && shadowed < points.len(), "{shadowed} of {}", points.len());
    let head = String::from_utf8_lossy(&ply[..ply.len().min(400)]).into_owned();
    assert!(head.contains(&format!("element vertex {}\n", points.len())), "{head}");
    let body = ply.len() - (head.find("end_header\n").unwrap() + "end_header\n".len());
    assert_eq!(body, points.len() * (3 * 8 + 3 * 4 + 3 + 4));
    assert!(image::load_from_memory(png).unwrap().width() > 600);
    assert_eq!(tif[..4], *b"II*\0");
    assert!(folder.no_temporary_files());
}

#[test]
fn sun_hours_of_a_table_and_of_surfaces() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let table = folder.write("p.csv", b"x,y,z\n0,500,0\n0,500,0,0,-1,0\n");
    let out = folder.path("a.json");
    let call = |more: &[&str]| {
        let base = ["sun-hours", &scene, "-o", &out];
        let (code, error) = adumbra(&[&base[..], &DAY, more].concat());
        assert_eq!(code, 0, "{error}");
        read_json(&out)["points"].as_array().unwrap().clone()
    };
    let points = call(&["--points", &table]);
    // High above everything a point sees the sun all day, and a surface that faces down never does.
    assert_eq!([&points[0]["hours"], &points[1]["hours"]], [10.0, 0.0]);
    assert_eq!([&points[0]["normal"], &points[1]["normal"][1]], [&Value::Null, &Value::from(-1.0)]);
    let walls = call(&["--surfaces", "2"]);
    assert!(walls.iter().any(|point| point["normal"][1].as_f64().unwrap().abs() < 0.1), "no point on a wall");
}

#[test]
fn sun_hours_of_two_designs_are_compared_on_a_page() {
    let folder = Folder::new();
    let (one, two, page) = (folder.generate("primitives"), folder.generate("spheres"), folder.path("a.html"));
    let call = ["sun-hours", &one, "--compare", &two, "--grid", "2", "--json", "-o", &page];
    let said = json(&[&call[..], &DAY].concat());
    assert!(said["other_mean_hours"].is_number(), "{said}");
    let html = std::fs::read_to_string(&page).unwrap();
    for words in ["primitives.glb", "spheres.glb", "spheres.glb less primitives.glb", "at least 2 h", "mean"]
    {
        assert!(html.contains(words), "{words}");
    }
    assert!(!html.contains("src=\"http") && html.matches("data:image/").count() >= 3);
}

#[test]
fn sky_of_a_roof_is_open_and_of_a_street_is_not() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let (table, file) = (folder.path("a.csv"), folder.path("a.json"));
    let call = ["sky", &scene, "--grid", "20", "--patches", "577", "--json", "-o", &table, "-o", &file];
    let said = json(&call);
    let whole = read_json(&file);
    assert_described(&schema("sky file"), &whole);
    assert_eq!(
        [&said["patches"], &Value::from(whole["patch_centers"].as_array().unwrap().len())],
        [577, 577]
    );
    let points = whole["points"].as_array().unwrap();
    let factors: Vec<f64> = points.iter().map(|point| point["sky_view_factor"].as_f64().unwrap()).collect();
    let (least, most) = factors.iter().fold((1.0_f64, 0.0_f64), |(a, b), &f| (a.min(f), b.max(f)));
    assert!(least < 0.7 && most > 0.95 && most <= 1.0 + 1e-9, "{least} to {most}");
    let text = std::fs::read_to_string(&table).unwrap();
    let bits = text.lines().nth(1).unwrap().rsplit(',').next().unwrap();
    assert_eq!(bits.len(), 2 * 577_usize.div_ceil(8));
}

#[test]
fn wrong_calls_of_sun_hours_say_what_to_give() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let (out, picture) = (folder.path("a.csv"), folder.path("a.png"));
    let wrong_table = folder.write("w.csv", b"1,2\n");
    let grid = ["--grid", "2"];
    let call = |more: &[&str]| {
        let base = ["sun-hours", &scene];
        adumbra(&[&base[..], more].concat())
    };
    let day = |change: [&'static str; 2]| {
        let mut day = DAY;
        let at = day.iter().position(|word| *word == change[0]).unwrap();
        day[at + 1] = change[1];
        day
    };
    let written = ["-o", &*out];
    for (words, code, message) in [
        ([&DAY[..], &written].concat(), 2, "--grid"),
        ([&DAY[..], &written, &grid, &["--surfaces", "1"]].concat(), 2, "cannot be used"),
        ([&day(["--lat", "91"])[..], &written, &grid].concat(), 2, "(--lat, --lon)"),
        ([&day(["--date", "2026-02-30"])[..], &written, &grid].concat(), 2, "2026-02-30"),
        ([&day(["--tz", "Mars/Base"])[..], &written, &grid].concat(), 2, "IANA"),
        ([&day(["--to", "8"])[..], &written, &grid].concat(), 2, "24 for the end of the day"),
        ([&DAY[..], &written, &["--grid", "0"]].concat(), 2, "(--grid)"),
        ([&DAY[..], &written, &["--grid", "1e-9"]].concat(), 2, "larger spacing"),
        ([&DAY[..], &["-o", "a.xyz"], &grid].concat(), 2, "give one of .csv"),
        ([&DAY[..], &["-o", &picture, "--surfaces", "2"]].concat(), 2, "needs --grid"),
        ([&DAY[..], &["-o", &out, "-o", &out], &grid].concat(), 2, "one file"),
        ([&DAY[..], &written, &grid, &["--compare", &scene]].concat(), 2, "FILE.html"),
        ([&DAY[..], &written, &["--points", &wrong_table]].concat(), 3, "line 1"),
        ([&DAY[..], &["-o", &wrong_table, "--points", &wrong_table]].concat(), 2, "overwrite the points"),
    ] {
        let (found, error) = call(&words);
        assert_eq!(found, code, "{words:?}: {error}");
        assert!(error.contains(message), "{words:?}: {error}");
    }
    assert!(!folder.exists("a.csv") && !folder.exists("a.png"));
}

#[cfg(unix)]
#[test]
fn sun_hours_end_with_an_interrupt_and_leave_the_earlier_file() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let out = folder.write("a.csv", b"earlier");
    let mut child = Command::new(program())
        .args(["sun-hours", &scene, "--grid", "0.2", "--progress", "json", "-o", &out])
        .args(DAY)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The first progress line shows that rays are under way.
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stderr.take().unwrap()));
    let first: Value = serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap();
    assert_eq!(first["event"], "trace");
    assert!(first["total"].as_u64().unwrap() > 100, "{first}");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let rest: Vec<String> = lines.map_while(Result::ok).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(rest.iter().any(|line| line.contains("interrupted")), "{rest:?}");
    assert_eq!(std::fs::read(&out).unwrap(), b"earlier");
    assert!(folder.no_temporary_files());
}
