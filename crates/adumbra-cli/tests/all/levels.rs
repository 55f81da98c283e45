//! Hybrid maps drawn by the program: the levels that answer, and the note about a coarse start.

#![cfg(feature = "render")]

use std::process::Command;

use adumbra_testing::{Folder, adumbra, json, program};
use exr::prelude::read_first_flat_layer_from_file;

const SIZE: [&str; 2] = ["--size", "96x64"];

#[test]
fn render_shows_the_levels_of_a_hybrid_map() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let render = |shadow: &str, extra: &[&str], output: &str| {
        let mut arguments = vec!["render", &scene, "--shadow", shadow, "--layer", "hrsm-levels"];
        arguments.extend(SIZE);
        arguments.extend(extra);
        let output = folder.path(output);
        adumbra(&[&arguments[..], &["-o", &output]].concat())
    };
    // Raw levels, one channel.
    assert_eq!(render("hrsm:1024-256", &[], "levels.exr").0, 0);
    let levels = read_first_flat_layer_from_file(folder.path("levels.exr")).unwrap().layer_data;
    let channels = &levels.channel_data.list;
    assert_eq!((channels.len(), channels[0].name.to_string().as_str()), (1, "Y"));
    let values: Vec<f32> = channels[0].sample_data.values_as_f32().collect();
    assert_eq!(values.len(), 96 * 64);
    assert!(values.iter().all(|v| [-1.0, 0.0, 1.0, 2.0].contains(v)));
    for level in [0.0, 1.0, 2.0] {
        assert!(values.iter().filter(|v| **v == level).count() > 20, "level {level}");
    }
    // A picture: the coarsest of three levels is green, the finest red.
    assert_eq!(render("hrsm:1024-256", &["--antialias", "1"], "levels.png").0, 0);
    let picture = image::open(folder.path("levels.png")).unwrap().into_rgb8();
    for (pixel, level) in picture.pixels().zip(&values) {
        let [r, g, b] = pixel.0;
        assert!(*level != 2.0 || g > r && g > b, "{level}: {pixel:?}");
        assert!(*level != 0.0 || r > g && r > b, "{level}: {pixel:?}");
    }
    // A technique without levels, and drawing without a GPU, are errors.
    let (code, error) = render("pcf:size=256", &[], "none.png");
    assert_eq!(code, 2, "{error}");
    assert!(error.contains("--layer hrsm-levels: pcf:size=256 has no levels"), "{error}");
    let (code, error) = render("hrsm:1024-256", &["--device", "cpu"], "cpu.png");
    assert_eq!(code, 2, "{error}");
    assert!(error.contains("hrsm:1024-256: the CPU draws"), "{error}");
    let (code, error) = render("truth", &["--device", "cpu"], "cpu.png");
    assert_eq!(code, 2, "{error}");
    assert!(error.contains("other layers and EXR need a GPU adapter"), "{error}");
    assert!(!folder.exists("none.png") && !folder.exists("cpu.png"));
}

#[test]
fn warns_of_a_hybrid_map_with_a_coarse_start() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let of = |verb: &[&str], shadow: &str, output: &str| {
        let output = folder.path(output);
        let (code, error) = adumbra(&[verb, &SIZE, &["--shadow", shadow, "-o", &output]].concat());
        assert_eq!(code, 0, "{error}");
        error
    };
    let compare = ["compare", &scene, "--sun-samples", "2", "--frames", "1", "--shadow", "none"];
    for (start, warned) in [("512-256", true), ("1024-512", false)] {
        let shadow = format!("hrsm:{start}");
        let said = [
            of(&["render", &scene], &shadow, &format!("{start}.png")),
            of(&compare, &shadow, &format!("compared-{start}")),
        ];
        for said in said {
            let note = format!("note: {shadow}: the paper advises against a START below 1024, here 512: ");
            assert_eq!(said.contains(&note), warned, "{said}");
        }
        let report = std::fs::read_to_string(folder.path(&format!("compared-{start}/report.md"))).unwrap();
        assert_eq!(report.contains("advises against"), warned, "{report}");
    }
}

#[test]
fn render_reports_the_time_of_the_build() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let milliseconds = |shadow: &str| {
        let output = folder.path("out.png");
        let said =
            json(&[&["render", &scene, "--json"][..], &SIZE, &["--shadow", shadow, "-o", &output]].concat());
        said["build_ms"].as_f64().unwrap()
    };
    // Without a build the stage is still timed, with nothing in it.
    let [none, some] = ["pcf:size=256", "hrsm:1024-512"].map(milliseconds);
    assert!(none >= 0.0 && some > none && some > 0.0, "{none} {some}");
}

#[test]
fn render_shows_the_size_of_the_voxels_that_answer() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("a.adumbra");
    let (code, error) = adumbra(&["bake", &scene, "--frame", "light", "--resolution", "256", "-o", &file]);
    assert_eq!(code, 0, "{error}");
    let raw = folder.path("a.exr");
    let render = ["render", &scene, "--shadow-file", &file, "--layer", "voxel-size"];
    let said = json(&[&render[..], &SIZE, &["--json", "-o", &raw]].concat());
    let levels = read_first_flat_layer_from_file(&raw).unwrap().layer_data;
    let values: Vec<f32> = levels.channel_data.list[0].sample_data.values_as_f32().collect();
    let rows = said["voxel_levels"].as_array().unwrap();
    assert!(rows.len() > 1, "{said}");
    let edge = |row: &serde_json::Value| row["edge_world"].as_f64().unwrap();
    for row in rows {
        let level = row["level"].as_f64().unwrap();
        let share = values.iter().filter(|v| **v == level as f32).count() as f64 / values.len() as f64;
        assert!((row["share"].as_f64().unwrap() - share).abs() < 1e-9 && share > 0.0, "{row}");
        let finer = rows[0]["level"].as_f64().unwrap();
        assert!((edge(row) / edge(&rows[0]) - (level - finer).exp2()).abs() < 1e-9, "{row}");
        assert_eq!(row["color"].as_array().unwrap().len(), 3);
    }
    let shares: f64 = rows.iter().map(|r| r["share"].as_f64().unwrap()).sum();
    let nothing = values.iter().filter(|v| **v == -1.0).count() as f64 / values.len() as f64;
    assert!((shares + nothing - 1.0).abs() < 1e-9, "{said}");
    // As a picture, with its legend printed.
    let picture = folder.path("a.png");
    let arguments = [&render[..], &SIZE, &["-o", &picture]].concat();
    let legend = Command::new(program()).args(arguments).output().unwrap().stdout;
    let legend = String::from_utf8(legend).unwrap();
    assert!(folder.exists("a.png"));
    let line = format!("level {}: {:.4} world units, ", rows[0]["level"], edge(&rows[0]));
    assert!(legend.contains(&line), "{line} is not in {legend}");
    let output = folder.path("none.png");
    let (code, error) =
        adumbra(&["render", &scene, "--shadow", "none", "--layer", "voxel-size", "-o", &output]);
    assert_eq!(code, 2, "{error}");
    assert!(error.contains("--layer voxel-size: none has no voxels"), "{error}");
}
