//! Tests of the window under a virtual display: its keys, its pictures compared with those of `render`, and
//! its reaction to a broken file.
//!
//! Needs Xvfb and xdotool. Without them the tests print a note and pass, unless
//! `ADUMBRA_REQUIRE_TOOLS` is set, as `cargo xtask test` does.

#![cfg(feature = "view")]

use std::time::{Duration, Instant};

use adumbra_compare::metrics::flip;
use adumbra_truth::picture::Picture;
use serde_json::{Value, json};

use adumbra_testing::{Folder, adumbra};

use crate::display::{TIMEOUT, display, finish};

/// Largest mean FLIP difference between the pictures of the view and of `render`.
const MAX_FLIP: f64 = 0.02;

fn picture(path: &str) -> Picture {
    let image = image::open(path).unwrap_or_else(|e| panic!("{path}: {e}")).into_rgb8();
    let (width, height) = image.dimensions();
    Picture { width, height, rgb: image.into_raw(), difference_share: None }
}

/// Returns the mean FLIP difference of two pictures, and the share of their bytes that differ by more than
/// two steps.
fn apart(a: &str, b: &str) -> (f64, f64) {
    let (a, b) = (picture(a), picture(b));
    let off = a.rgb.iter().zip(&b.rgb).filter(|(x, y)| x.abs_diff(**y) > 2).count();
    (flip(&a, &b).unwrap(), off as f64 / a.rgb.len() as f64)
}

const CAMERA: [&str; 6] = ["--eye", "9,6,12", "--target", "0,1,0", "--size", "480x300"];

#[test]
#[ignore = "slow: draws in a window"]
fn view_shows_what_render_draws() {
    let Some(display) = display() else { return };
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("primitives.adumbra");
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "2048", "-o", &file]);
    assert_eq!(code, 0, "{error}");
    // Layer, technique and ambient occlusion of each view.
    let views = [
        ("color", "voxel:filter=9", "none"),
        ("color", "voxel:filter=9", "issao:radius=1"),
        ("shadow", "csm", "none"),
        ("ao", "none", "gtao:radius=1"),
        ("normal", "none", "none"),
        ("depth", "none", "none"),
        ("cascades", "csm:cascades=3", "none"),
        ("hrsm-levels", "hrsm:1024-256", "none"),
        ("voxel-size", "voxel", "none"),
        ("shadow", "truth", "none"),
    ];
    let shot = |i: usize| folder.path(&format!("view-{i}.png"));
    let mut steps = vec![json!({"wait": "loaded"})];
    for (i, (layer, technique, ao)) in views.iter().enumerate() {
        steps.extend([
            json!({"shadow": {"side": "first", "technique": technique}}),
            json!({"ao": ao}),
            json!({"layer": layer}),
            json!({"wait": {"frames": 1}}),
            json!({"wait": "traced"}),
            json!({"screenshot": shot(i)}),
        ]);
    }
    // Four samples per pixel, the default of render.
    steps.extend([
        json!({"shadow": {"side": "first", "technique": "voxel:filter=9"}}),
        json!({"layer": "color"}),
        json!({"antialias": 2}),
        json!({"screenshot": shot(views.len())}),
        json!("quit"),
    ]);
    let arguments = [&[scene.as_str(), "--shadow-file", &file][..], &CAMERA].concat();
    let (code, said) = display.play(&folder, &arguments, &Value::Array(steps));
    assert_eq!(code, 0, "{said}");
    let more = ("color", "voxel:filter=9", "none");
    for (i, (layer, technique, ao)) in views.iter().chain([&more]).enumerate() {
        let drawn = folder.path("render.png");
        let samples = if i == views.len() { "2" } else { "1" };
        let rest = ["--layer", layer, "--ao", ao, "--antialias", samples, "-o", &drawn];
        let head = ["render", &scene, "--shadow-file", &file, "--shadow", technique];
        let (code, error) = adumbra(&[&head[..], &CAMERA, &rest].concat());
        assert_eq!(code, 0, "{error}");
        let (flip, off) = apart(&shot(i), &drawn);
        assert!(flip <= MAX_FLIP && off <= 0.002, "{layer} of {technique}, {ao}: FLIP {flip}, {off} off");
    }
}

#[test]
#[ignore = "slow: draws in a window"]
fn view_streams_a_file_that_needs_more_than_the_budget() {
    let Some(display) = display() else { return };
    let folder = Folder::new();
    let scene = folder.generate("city");
    let file = folder.path("city.adumbra");
    let bake = ["bake", &scene, "--resolution", "16384", "--levels", "4", "-o", &file];
    let (code, error) = adumbra(&bake);
    assert_eq!(code, 0, "{error}");
    let camera = ["--eye", "-150,38,175", "--target", "-75,4,75", "--size", "480x300"];
    let [streamed, levels, whole, missing] =
        ["streamed.png", "levels.png", "whole.png", "missing.png"].map(|name| folder.path(name));
    let steps = json!([
        {"wait": "streamed"},
        {"screenshot": streamed},
        {"layer": "level"},
        {"wait": {"frames": 1}},
        {"screenshot": levels},
        {"layer": "color"},
        {"budget": 512},
        {"wait": "loaded"},
        {"wait": {"frames": 1}},
        {"screenshot": whole},
        {"layer": "level"},
        {"wait": {"frames": 1}},
        {"screenshot": missing},
        "quit",
    ]);
    let head = [scene.as_str(), "--shadow-file", &file, "--budget", "1", "--fade", "5"];
    let arguments = [&head[..], &camera].concat();
    let (code, said) = display.play(&folder, &arguments, &steps);
    assert_eq!(code, 0, "{said}");
    let drawn = folder.path("render.png");
    let head = ["render", &scene, "--shadow-file", &file, "--antialias", "1", "-o", &drawn];
    let (code, error) = adumbra(&[&head[..], &camera].concat());
    assert_eq!(code, 0, "{error}");
    let (flip, off) = apart(&whole, &drawn);
    assert!(flip <= 0.001 && off <= 0.002, "whole: FLIP {flip}, {off} off");
    // Pixels far away have a coarser level, whose texels are no larger than they are.
    let (flip, _) = apart(&streamed, &drawn);
    assert!(flip > 0.0 && flip <= MAX_FLIP, "streamed: FLIP {flip}");
    // The finest level is red, the next one orange; a whole file has no such layer, and the picture is shown
    // in its place.
    let colors = |path: &str| {
        let Picture { rgb, .. } = picture(path);
        let tinted = |is: &dyn Fn(&[u8]) -> bool| rgb.chunks(3).filter(|p| is(p)).count();
        [tinted(&|p| p[0] > p[1] + 60 && p[0] > p[2] + 60), rgb.len() / 3]
    };
    let [red, pixels] = colors(&levels);
    assert!(red * 20 > pixels, "{red} of {pixels} pixels have the finest levels");
    assert_eq!(apart(&missing, &whole), (0.0, 0.0));
}

#[test]
#[ignore = "slow: opens windows"]
fn view_takes_keys_sizes_and_broken_files_and_closes() {
    let Some(display) = display() else { return };
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let broken = folder.write("broken.glb", b"glTF, but not really");
    let torn = folder.write("torn.adumbra", b"ADUMBRA\nand nothing more");
    let [first, second, third, camera] =
        ["one.png", "two.png", "three.png", "camera.json"].map(|name| folder.path(name));
    let steps = json!([
        {"wait": "loaded"},
        {"wait": "baked"},
        {"screenshot": first},
        // The test presses keys and resizes the window here.
        {"wait": {"size": [640, 400]}},
        {"wait": {"frames": 1}},
        {"screenshot": second},
        {"drop": broken},
        {"wait": {"message": "broken.glb"}},
        {"drop": torn},
        {"wait": {"message": "torn.adumbra"}},
        {"save_camera": camera},
        {"resize": [400, 300]},
        {"wait": {"size": [400, 300]}},
        {"screenshot": third},
    ]);
    let script = folder.write("script.json", steps.to_string().as_bytes());
    let arguments = [&[scene.as_str(), "--resolution", "1024"][..], &CAMERA, &["--script", &script]].concat();
    let mut view = display.begin(&arguments);
    let window = display.window(&mut view);
    let mut wait_for = |path: &str| {
        let start = Instant::now();
        while !std::path::Path::new(path).exists() {
            assert!(start.elapsed() < TIMEOUT, "{path} was not written");
            view.must_run(&format!("{path} was written"));
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    wait_for(&first);
    display.xdotool(&["windowfocus", "--sync", &window]);
    // The next technique is voxel+csm, and the next layer is the shadow factor.
    display.press("t");
    display.press("l");
    display.xdotool(&["windowsize", "--sync", &window, "640", "400"]);
    wait_for(&second);
    wait_for(&third);
    display.press("ctrl+q");
    let (code, said) = finish(view);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("broken.glb") && said.contains("torn.adumbra"), "{said}");
    let sizes = [&first, &second, &third].map(|p| (picture(p).width, picture(p).height));
    assert_eq!(sizes, [(480, 300), (640, 400), (400, 300)]);
    // The bake in the background gives the same picture as a file of `bake`.
    let (file, drawn) = (folder.path("primitives.adumbra"), folder.path("render.png"));
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "1024", "-o", &file]);
    assert_eq!(code, 0, "{error}");
    let from = [&["render", &scene, "--shadow-file", &file, "--antialias", "1"][..], &CAMERA[..4]].concat();
    let to = ["--shadow", "voxel+csm", "--layer", "shadow", "--size", "640x400", "-o", &drawn];
    let (code, error) = adumbra(&[&from[..], &to].concat());
    assert_eq!(code, 0, "{error}");
    let (flip, off) = apart(&second, &drawn);
    assert!(flip <= MAX_FLIP && off <= 0.002, "FLIP {flip}, {off} off");
    let saved: Value = serde_json::from_slice(&std::fs::read(&camera).unwrap()).unwrap();
    assert_eq!((&saved["eye"], &saved["size"]), (&json!([9.0, 6.0, 12.0]), &json!([640, 400])));
    let compared = folder.path("compared");
    let (code, error) = adumbra(&[
        "compare", &scene, "--camera", &camera, "--shadow", "sm", "--size", "64x40", "-o", &compared,
    ]);
    assert_eq!(code, 0, "{error}");
}

#[test]
#[ignore = "slow: bakes in a window"]
fn view_rebakes_for_a_moved_sun_and_keeps_finished_levels() {
    let Some(display) = display() else { return };
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let [before, after, split, kept, difference, soft, ball, window] =
        ["a", "b", "c", "d", "e", "f", "g", "h"].map(|name| folder.path(&format!("{name}.png")));
    let steps = json!([
        {"wait": "ball"},
        {"ball": false},
        {"layer": "shadow"},
        {"wait": "baked"},
        {"screenshot": before},
        {"sun": {"azimuth": 250.0, "elevation": 30.0}},
        {"wait": "baked"},
        {"screenshot": after},
        {"shadow": {"side": "second", "technique": "truth"}},
        {"split": 0.5},
        {"wait": "traced"},
        {"screenshot": split},
        // Stop a finer bake midway: its completed levels stay.
        "single",
        {"bake": 131072},
        {"wait": {"frames": 1}},
        "cancel_bake",
        {"wait": "baked"},
        {"screenshot": kept},
        {"difference": 4.0},
        {"screenshot": difference},
        "single",
        {"bake": 1024},
        // The current file has no penumbrae, so another is baked.
        {"shadow": {"side": "first", "technique": "voxel:soft:sun-degrees=4"}},
        {"wait": "baked"},
        {"screenshot": soft},
        {"ball": true},
        {"wait": "ball"},
        {"time": 2.0},
        {"layer": "color"},
        {"shadow": {"side": "first", "technique": "voxel+csm"}},
        {"box": true},
        {"screenshot": ball},
        {"window_shot": window},
        "quit",
    ]);
    let way = "sphere:from=3,1,6:to=-3,1,6:radius=1";
    let arguments = [&[scene.as_str(), "--resolution", "1024", "--move", way][..], &CAMERA].concat();
    let (code, said) = display.play(&folder, &arguments, &steps);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("the bake was stopped; completed levels are kept"), "{said}");
    let (flip, _) = apart(&before, &after);
    assert!(flip > 0.02, "the shadows followed the sun: {flip}");
    let (flip, _) = apart(&kept, &after);
    assert!(flip < 0.02, "completed levels were kept: {flip}");
    let colored =
        |p: &str| picture(p).rgb.as_chunks::<3>().0.iter().filter(|c| c[0].abs_diff(c[2]) > 60).count();
    assert!(colored(&difference) > 20 && colored(&kept) == 0, "the file differs from rays along edges");
    let (file, drawn) = (folder.path("soft.adumbra"), folder.path("render.png"));
    let sun = ["--azimuth", "250", "--elevation", "30"];
    let baked = ["bake", &scene, "--resolution", "1024", "-o", &file];
    let (code, error) = adumbra(&[&baked[..], &sun].concat());
    assert_eq!(code, 0, "{error}");
    let rendered = ["render", &scene, "--shadow-file", &file, "--shadow", "voxel:soft:sun-degrees=4"];
    let rest = ["--layer", "shadow", "--antialias", "1", "-o", &drawn];
    let (code, error) = adumbra(&[&rendered[..], &CAMERA, &rest].concat());
    assert_eq!(code, 0, "{error}");
    let (flip, off) = apart(&soft, &drawn);
    assert!(flip <= MAX_FLIP && off <= 0.002, "penumbrae: FLIP {flip}, {off} off");
    let (bare, panel) = (picture(&ball), picture(&window));
    assert_eq!((bare.width, bare.height), (panel.width, panel.height));
    let covered = bare.rgb.iter().zip(&panel.rgb).filter(|(a, b)| a.abs_diff(**b) > 30).count();
    assert!(covered > bare.rgb.len() / 20, "the panel is in the window's picture: {covered}");
    // The file is left of the divider, rays are right of it. On the right, the file mostly agrees with rays.
    let (after, split) = (picture(&after), picture(&split));
    let half = |p: &Picture, right: bool| -> Vec<u8> {
        let row = p.width as usize * 3;
        let part = if right { row / 2 + 3..row } else { 0..row / 2 - 3 };
        p.rgb.chunks(row).flat_map(|r| r[part.clone()].to_vec()).collect()
    };
    assert_eq!(half(&after, false), half(&split, false));
    let (file, rays) = (half(&after, true), half(&split, true));
    let wrong = file.iter().zip(&rays).filter(|(a, b)| a.abs_diff(**b) > 127).count();
    assert!(file != rays && wrong * 50 < rays.len(), "{wrong} of {}", rays.len());
    let red = picture(&ball).rgb.as_chunks::<3>().0.iter().filter(|c| c[0] > 2 * c[1].max(40)).count();
    assert!(red > 100, "the ball is seen: {red} pixels of it");
}

#[test]
#[ignore = "slow: opens windows"]
fn view_keeps_camera_and_file_given_before_its_scene_loads() {
    let Some(display) = display() else { return };
    let folder = Folder::new();
    let (scene, other) = (folder.generate("primitives"), folder.generate("spheres"));
    let broken = folder.write("broken.glb", b"glTF, but not really");
    let file = folder.path("primitives.adumbra");
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "512", "-o", &file]);
    assert_eq!(code, 0, "{error}");
    let saved = folder.path("camera.json");
    let steps = json!([
        {"camera": {"eye": [1.0, 2.0, 3.0], "target": [0.0, 0.5, 0.0]}},
        // A scene that cannot be loaded changes nothing.
        {"drop": broken},
        {"drop": file},
        {"wait": "loaded"},
        {"wait": {"message": "broken.glb"}},
        {"save_camera": saved},
        "say_line",
        {"sun": {"azimuth": 10.0, "elevation": 50.0}},
        "say_line",
        // Back to the sun that the view began with. The file was not there at that time, but it is for that
        // sun.
        "reset_sun",
        {"wait": "baked"},
        "say_line",
        {"key": "w"},
        {"drop": other},
        {"wait": "loaded"},
        "say_line",
        "quit",
    ]);
    let begin = [scene.as_str(), "--resolution", "512", "--max-memory", "1GiB", "--time=-2"];
    let (code, said) = display.play(&folder, &begin, &steps);
    assert_eq!(code, 0, "{said}");
    let saved: Value = serde_json::from_slice(&std::fs::read(&saved).unwrap()).unwrap();
    assert_eq!(saved["eye"], json!([1.0, 2.0, 3.0]));
    let lines: Vec<&str> = said.lines().filter_map(|line| line.split("adumbra view ").nth(1)).collect();
    let has_file = lines.iter().map(|line| line.contains(&file)).collect::<Vec<_>>();
    assert_eq!(has_file, [true, false, true, false], "{said}");
    assert!(
        lines.iter().all(|line| line.contains("--max-memory 1073741824 ") || line.ends_with("1073741824"))
    );
    assert!(lines[3].starts_with(&other), "{said}");
    // The printed command line is accepted.
    let again: Vec<&str> = lines[2].split(' ').collect();
    let (code, said) = display.play(&folder, &again, &json!([{"wait": "loaded"}, "quit"]));
    assert_eq!(code, 0, "{said}");
}

#[test]
#[ignore = "slow: draws in a window"]
fn view_follows_its_scene() {
    let Some(display) = display() else { return };
    let folder = Folder::new();
    let (scene, next) = (folder.generate("primitives"), folder.path("next.glb"));
    let (code, error) = adumbra(&["generate", "primitives", "--seed", "9", "-o", &next]);
    assert_eq!(code, 0, "{error}");
    let [first, second, fresh] = ["first.png", "second.png", "fresh.png"].map(|name| folder.path(name));
    let steps = json!([
        {"wait": "baked"}, {"screenshot": first},
        {"wait": {"message": "has changed"}}, {"wait": "loaded"}, {"wait": "baked"}, {"screenshot": second}, "quit"
    ]);
    let script = folder.write("script.json", steps.to_string().as_bytes());
    let arguments =
        [&[&*scene, "--watch", "--resolution", "1024", "--script", &script][..], &CAMERA].concat();
    let view = display.begin(&arguments);
    let begun = Instant::now();
    while !std::path::Path::new(&first).exists() {
        assert!(begun.elapsed() < TIMEOUT, "no first picture");
        std::thread::sleep(Duration::from_millis(100));
    }
    std::fs::rename(&next, &scene).unwrap();
    let (code, said) = finish(view);
    assert_eq!(code, 0, "{said}");
    let steps = json!([{"wait": "baked"}, {"screenshot": fresh}, "quit"]);
    let arguments = [&[&*scene, "--resolution", "1024"][..], &CAMERA].concat();
    let (code, said) = display.play(&folder, &arguments, &steps);
    assert_eq!(code, 0, "{said}");
    assert!(apart(&second, &fresh).1 == 0.0, "{:?}", apart(&second, &fresh));
    assert!(apart(&first, &second).1 > 0.01, "{:?}", apart(&first, &second));
}

#[test]
#[ignore = "slow: draws in a window"]
fn view_plays_a_day_as_render_draws_it() {
    let Some(display) = display() else { return };
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let day = "lat=48,lon=11,date=2026-06-21,from=9,to=15,tz=+02:00";
    let file = folder.path("day.adumbra");
    let bake = ["bake", &scene, "--resolution", "1024", "--sun-path", day, "-o", &file];
    let (code, error) = adumbra(&bake);
    assert_eq!(code, 0, "{error}");
    let shots = ["baked.png", "later.png", "read.png", "render.png"].map(|name| folder.path(name));
    let steps = json!([
        {"wait": "loaded"},
        {"wait": "baked"},
        {"hour": 12.25},
        {"wait": {"seconds": 0.5}},
        {"wait": "baked"},
        {"wait": {"frames": 8}},
        {"screenshot": shots[0]},
        {"play": true},
        {"wait": {"seconds": 2}},
        {"play": false},
        {"wait": {"frames": 2}},
        {"screenshot": shots[1]},
        "say_line",
        "quit"
    ]);
    let length = ["--day-length", "100", "--resolution", "1024"];
    let arguments = [&[scene.as_str(), "--day", day], &length[..], &CAMERA].concat();
    let (code, said) = display.play(&folder, &arguments, &steps);
    assert_eq!(code, 0, "{said}");
    let (_, hour) = said.split_once("--day-length 100 --hour ").expect(&said);
    let hour: f64 = hour.split_whitespace().next().and_then(|hour| hour.parse().ok()).expect(&said);
    // The view plays 0.48 hours in two seconds. How much later it stops depends on the machine.
    assert!((12.7..=15.0).contains(&hour) && !said.contains("--azimuth"), "{said}");
    let steps = json!([
        {"wait": "loaded"},
        {"wait": "baked"},
        {"wait": {"frames": 8}},
        {"screenshot": shots[2]},
        "quit"
    ]);
    let arguments = [&[scene.as_str(), "--shadow-file", &file, "--hour", "12.25"], &CAMERA[..]].concat();
    let (code, said) = display.play(&folder, &arguments, &steps);
    assert_eq!(code, 0, "{said}");
    let of_render = ["--sun-time", "12:15", "--antialias", "1", "-o", &shots[3]];
    let render = ["render", &scene, "--shadow-file", &file];
    let (code, error) = adumbra(&[&render[..], &CAMERA, &of_render].concat());
    assert_eq!(code, 0, "{error}");
    let (flip, off) = apart(&shots[2], &shots[3]);
    assert!(flip <= MAX_FLIP && off <= 0.002, "read: FLIP {flip}, {off} off");
    // Keys that are baked at run time are not those of the file.
    let (flip, off) = apart(&shots[0], &shots[3]);
    assert!(flip <= MAX_FLIP && off <= 0.02, "baked: FLIP {flip}, {off} off");
    let (_, off) = apart(&shots[0], &shots[1]);
    assert!(off > 0.005, "two seconds are half an hour: the sun has moved, {off} off");
}
