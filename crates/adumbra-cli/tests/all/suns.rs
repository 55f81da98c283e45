//! The sun of a verb: from `--sun`, from the shadow file, from the scene's first directional light above the
//! horizon, or the default; and the messages of every verb about it.

use std::process::Command;

use adumbra_testing::{Folder, adumbra, json, program, stderr};
use serde_json::{Value, json};

/// A rotation that turns +Z, where a light's node looks away from, by this angle about X towards +Y, in
/// degrees.
fn turned_up(degrees: f64) -> Value {
    let (sin, cos) = (-degrees.to_radians() / 2.0).sin_cos();
    json!([sin, 0.0, 0.0, cos])
}

/// Writes a scene of one triangle with directional lights at these elevations towards +Z.
fn lit_scene(folder: &Folder, name: &str, lights: &[(&str, f64)]) -> String {
    let positions = [0.0_f32, 0.0, 0.0, 0.0, 0.0, 8.0, 8.0, 0.0, 0.0];
    folder.write_f32("triangle.bin", &positions);
    let nodes = lights.iter().map(|(name, degrees)| {
        let light = json!({"KHR_lights_punctual": {"light": 0}});
        json!({"name": name, "rotation": turned_up(*degrees), "extensions": light})
    });
    let nodes: Vec<Value> = [json!({"mesh": 0})].into_iter().chain(nodes).collect();
    let scene = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}},
        "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [8, 0, 8]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "triangle.bin"}],
    });
    folder.write(name, scene.to_string().as_bytes())
}

fn numbers(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| value[i].as_f64().unwrap())
}

fn near(found: &Value, expected: [f64; 3]) -> bool {
    let length = expected.iter().map(|c| c * c).sum::<f64>().sqrt();
    numbers(found).iter().zip(expected).all(|(f, e)| (f - e / length).abs() < 1e-6)
}

const HALF: f64 = 0.5;
/// sin 60°.
const HIGH: f64 = 0.866_025_403_784_438_6;

#[test]
fn light_of_the_scene_is_the_default_sun_of_every_verb() {
    let folder = Folder::new();
    let scene = lit_scene(&folder, "lit.gltf", &[("Sun", 60.0), ("Moon", 30.0)]);
    let (file, picture) = (folder.path("a.adumbra"), folder.path("a.png"));
    let bake = ["bake", &scene, "--resolution", "64", "--progress", "none", "--json", "-o", &file];
    let forecast = [&bake[..], &["--dry-run"]].concat();
    let render =
        ["render", &scene, "--truth", "--size", "16x16", "--device", "cpu", "--json", "-o", &picture];
    let inspect = ["inspect", &scene, "--json"];
    for call in [&bake[..], &forecast, &render, &inspect] {
        let said = json(call);
        assert_eq!(said["sun_origin"], json!({"source": "light", "light": "Sun"}), "{call:?}");
        assert!(near(&said["sun"], [0.0, HIGH, HALF]), "{call:?}: {said}");
    }
    assert_eq!(json(&bake)["sun"], json(&["info", &file, "--json"])["sun"]);
    let lights = &json(&inspect)["lights"];
    assert_eq!((&lights[0]["name"], &lights[1]["name"]), (&json!("Sun"), &json!("Moon")));
    assert!(near(&lights[1]["towards"], [0.0, HALF, HIGH]), "{lights}");
    // Options take precedence over the light, and the shadow file over both.
    for call in [&bake[..], &render] {
        for (option, sun) in [
            (&["--sun", "-1,2,0"][..], [-1.0, 2.0, 0.0]),
            (&["--azimuth", "90", "--elevation", "30"], [HIGH, HALF, 0.0]),
        ] {
            let said = json(&[call, option].concat());
            assert_eq!(said["sun_origin"], json!({"source": "option", "light": null}), "{call:?}");
            assert!(near(&said["sun"], sun), "{call:?} {option:?}: {said}");
        }
    }
    let base = ["render", &scene, "--shadow-file", &file, "--size", "16x16", "--device", "cpu", "--json"];
    assert_eq!(json(&[&bake[..], &["--sun", "-1,2,0"]].concat())["sun_origin"]["source"], "option");
    let said = json(&[&base[..], &["-o", &picture]].concat());
    assert_eq!(said["sun_origin"]["source"], "shadow-file");
    assert!(near(&said["sun"], [-1.0, 2.0, 0.0]), "{said}");
}

#[test]
fn sun_and_its_origin_are_printed() {
    let folder = Folder::new();
    let lit = lit_scene(&folder, "lit.gltf", &[("Sun", 60.0)]);
    let dark = folder.generate("primitives");
    let (file, picture) = (folder.path("a.adumbra"), folder.path("a.png"));
    for (scene, option, said) in [
        (&lit, &[][..], "sun 0,0.866,0.5 (light \"Sun\" of the scene)"),
        (&dark, &[], "sun 0.5,0.8,0.35 (default)"),
        (&lit, &["--sun", "0.5,2,0"], "sun 0.5,2,0 (--sun)"),
    ] {
        let bake = ["bake", scene, "--resolution", "64", "-o", &file];
        let render = ["render", scene, "--truth", "--size", "16x16", "--device", "cpu", "-o", &picture];
        for call in [&bake[..], &render] {
            let output = Command::new(program()).args([call, option].concat()).output().unwrap();
            let text = String::from_utf8(output.stdout.clone()).unwrap();
            assert!(text.contains(said), "{call:?}: {text} {}", stderr(&output));
        }
    }
}

#[test]
fn light_that_cannot_be_the_sun_is_named_and_the_next_one_is_taken() {
    let folder = Folder::new();
    let file = folder.path("a.adumbra");
    for (lights, source, warnings) in [
        (&[("up", -40.0), ("level", 0.0), ("Sun", 60.0)][..], json!("light"), &["\"up\"", "\"level\""][..]),
        (&[("up", -40.0)], json!("default"), &["\"up\""]),
        (&[], json!("default"), &[]),
    ] {
        let scene = lit_scene(&folder, "lit.gltf", lights);
        let bake = ["bake", &scene, "--resolution", "64", "--progress", "none", "-o", &file];
        assert_eq!(json(&[&bake[..], &["--json"]].concat())["sun_origin"]["source"], source);
        let (code, said) = adumbra(&bake);
        assert_eq!(code, 0, "{said}");
        assert_eq!(said.matches("cannot be the sun").count(), warnings.len(), "{said}");
        assert!(warnings.iter().all(|name| said.contains(name)), "{said}");
    }
}

#[test]
fn loader_omissions_are_reported_once_and_rejected_by_strict() {
    let folder = Folder::new();
    let obj = folder.write("lines.obj", b"v 0 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 3\nl 1 2\nl 2 3\nl 1 3\n");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 2\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n0 0 1\n1 0 0\n3 0 1 2\n2 0 1\n";
    let ply = folder.write("small.ply", ply.as_bytes());
    let whole = folder.generate("primitives");
    let file = folder.path("a.adumbra");
    for (scene, what, count) in [(&obj, "lines", 3), (&ply, "faces with fewer than three corners", 1)] {
        let bake = ["bake", scene, "--resolution", "64", "--progress", "none", "-o", &file];
        let expected = json!([{"what": what, "count": count}]);
        assert_eq!(json(&[&bake[..], &["--json"]].concat())["omissions"], expected);
        assert_eq!(json(&["inspect", scene, "--json"])["omissions"], expected);
        let (code, said) = adumbra(&bake);
        assert_eq!(code, 0, "{said}");
        assert_eq!(said.matches(&format!("{count} {what} left out")).count(), 1, "{said}");
        let text = Command::new(program()).args(["inspect", scene]).output().unwrap().stdout;
        let text = String::from_utf8(text).unwrap();
        assert!(text.contains(&format!("left out             {count} {what}")), "{text}");
        for verb in [&bake[..], &["inspect", scene]] {
            let (code, said) = adumbra(&[verb, &["--strict"]].concat());
            assert_eq!(code, 3, "{verb:?}: {said}");
            assert!(said.contains(what) && said.contains("(--strict)"), "{said}");
        }
    }
    let read = &json(&["inspect", &obj, "--json"])["read"];
    assert_eq!(read["faces"], 1, "{read}");
    for verb in [&["bake", &whole, "--resolution", "64", "-o", &file][..], &["inspect", &whole]] {
        let (code, said) = adumbra(&[verb, &["--strict"]].concat());
        assert_eq!(code, 0, "{said}");
    }
}
