//! Ambient occlusion drawn by the program: every name, its layer, its figures, frames, and the messages about
//! mistakes.

#![cfg(feature = "render")]

use adumbra_testing::{Folder, adumbra, json};
use exr::prelude::read_first_flat_layer_from_file;

const SIZE: [&str; 2] = ["--size", "96x64"];
const PIXELS: usize = 96 * 64;

/// Reads the only channel of an EXR.
fn visibility(path: &str) -> Vec<f32> {
    let layer = read_first_flat_layer_from_file(path).unwrap().layer_data;
    let channels = &layer.channel_data.list;
    assert_eq!((channels.len(), channels[0].name.to_string().as_str()), (1, "Y"));
    channels[0].sample_data.values_as_f32().collect()
}

#[test]
fn render_draws_ambient_occlusion_of_every_name() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let draw = |shadow: &str, ao: &str| {
        let output = folder.path("color.png");
        let always = ["render", &scene, "--shadow", shadow, "--ao", ao, "--antialias", "1", "-o", &output];
        let (code, error) = adumbra(&[&always[..], &SIZE].concat());
        assert_eq!(code, 0, "{shadow} {ao}: {error}");
        std::fs::read(output).unwrap()
    };
    let open = draw("none", "none");
    let mut pictures = vec![open.clone()];
    for ao in ["ssao", "hbao", "alchemy", "issao", "gtao", "truth:rays=16"] {
        let picture = draw("none", &format!("{ao}:radius=1"));
        assert!(!pictures.contains(&picture), "{ao} draws what another does");
        pictures.push(picture);
    }
    assert!(draw("none", "issao:radius=0") == open);
    // It combines with any shadows, including traced ones.
    for shadow in ["pcf:size=256", "truth"] {
        assert!(draw(shadow, "gtao:radius=1") != draw(shadow, "none"), "{shadow}");
    }
}

#[test]
fn render_draws_the_layer_of_ambient_visibility_alone() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let draw = |ao: &str, name: &str, more: &[&str]| {
        let output = folder.path(name);
        let layer = ["render", &scene, "--layer", "ao", "--ao", ao, "-o", &output];
        let (code, error) = adumbra(&[&layer[..], &SIZE, more].concat());
        assert_eq!(code, 0, "{ao}: {error}");
        error
    };
    for ao in ["hbao:radius=1.5:strength=1:power=1:bias=0.1:falloff=2", "truth:radius=1.5:rays=64"] {
        let said = draw(ao, "ao.exr", &[]);
        assert!(!said.contains("radius"), "{said}");
        let raw = visibility(&folder.path("ao.exr"));
        assert_eq!(raw.len(), PIXELS);
        assert!(raw.iter().all(|v| (0.0..=1.0).contains(v)));
        let mean = raw.iter().sum::<f32>() / PIXELS as f32;
        assert!(mean > 0.8 && mean < 0.995, "{ao}: {mean}");
        // A picture has the same values, without a tone curve. Shadows and the choice of the device have no
        // influence.
        draw(ao, "ao.png", &["--antialias", "1", "--shadow", "pcf:size=256"]);
        let png = image::open(folder.path("ao.png")).unwrap().into_rgb8();
        for (pixel, v) in png.pixels().zip(&raw) {
            assert_eq!(pixel.0, [(v * 255.0 + 0.5) as u8; 3], "{ao}");
        }
    }
    // More samples per pixel see the same radius, which is in world units.
    let mean = |samples: &str| {
        draw("issao:radius=1.5", "ao.png", &["--antialias", samples]);
        let png = image::open(folder.path("ao.png")).unwrap().into_luma8();
        png.pixels().map(|p| f64::from(p.0[0])).sum::<f64>() / (255 * PIXELS) as f64
    };
    let [one, three] = [mean("1"), mean("3")];
    assert!((one - three).abs() < 0.01, "{one} {three}");
    // Without a radius, a note states the radius that is used: 0.02 of the scene's usual diagonal.
    let said = draw("gtao", "ao.png", &[]);
    assert!(said.contains("note: --ao gtao: the radius is ") && said.contains("2 % of the"), "{said}");
}

#[test]
fn render_reports_the_figures_of_ambient_occlusion() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let output = folder.path("a.png");
    let figures = |ao: &str| {
        let words = ["render", &scene, "--shadow", "none", "--ao", ao, "--json", "-o", &output];
        json(&[&words[..], &SIZE].concat())["ambient"].clone()
    };
    assert!(figures("none").is_null());
    let gtao = figures("gtao:radius=2:reuse=on");
    assert_eq!(gtao["name"], "gtao:radius=2:reuse=on");
    assert_eq!(gtao["radius_world"], 2.0);
    assert!(gtao["bytes"].as_u64().unwrap() > 0);
    let ms = |key: &str| gtao[key].as_f64().unwrap();
    let stages = ["surface_ms", "estimate_ms", "history_ms", "filter_ms"].map(ms);
    assert!(stages.iter().all(|ms| *ms > 0.0), "{gtao}");
    assert!((stages.iter().sum::<f64>() - ms("ms")).abs() < 1e-6, "{gtao}");
    let truth = figures("truth:radius=2:rays=1");
    assert!(truth["ms"].is_null() && truth["radius_world"] == 2.0, "{truth}");
}

#[test]
fn frames_reuse_earlier_frames_of_the_same_call() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let draw = |reuse: &str, shadows: &[&str]| {
        let output = folder.path(&format!("{reuse}.exr"));
        let ao = format!("hbao:radius=1.5:strength=1:filter=none:reuse={reuse}");
        let mut words = vec!["render", &scene, "--layer", "ao", "--ao", &ao, "-o", &output];
        shadows.iter().for_each(|s| words.extend(["--shadow", s]));
        words.extend(["--move", "sphere:from=-3,1,2:to=3,1,2:radius=0.5", "--frames", "3"]);
        words.extend(["--eye", "-12,11,17", "--target", "0,0.5,0"]);
        let (code, error) = adumbra(&[&words[..], &SIZE].concat());
        assert_eq!(code, 0, "{error}");
        |name: &str| visibility(&folder.path(name))
    };
    let read = draw("off", &["none"]);
    let off = [0, 1, 2].map(|i| read(&format!("off.000{i}.exr")));
    let read = draw("on", &["none", "pcf:size=256"]);
    let on = [0, 1, 2].map(|i| read(&format!("on.none.000{i}.exr")));
    let next = [0, 1, 2].map(|i| read(&format!("on.pcf_size=256.000{i}.exr")));
    let apart = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 0.01).count();
    // A first frame has no previous frame, whatever technique was drawn before.
    assert_eq!(apart(&on[0], &off[0]), 0);
    assert!(apart(&on[1], &off[1]) > 200 && apart(&on[2], &off[2]) > 200);
    assert!(on == next, "a technique's frames do not depend on another's");
}

#[test]
fn invalid_ambient_occlusion_is_rejected_without_a_picture() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let output = folder.path("a.png");
    let cases: [(&[&str], &str); 10] = [
        (
            &["--ao", "sao"],
            "--ao sao: unknown ambient occlusion; choose one of: ssao, hbao, alchemy, issao, gtao, truth, none",
        ),
        (
            &["--ao", "issao:taps=3"],
            "--ao issao:taps=3: unknown parameter \"taps\"; choose one of: radius, samples, cap, levels, ",
        ),
        (&["--ao", "issao:samples=65"], "samples=65: give a whole number from 1 to 64"),
        (&["--ao", "gtao:filter=box"], "filter=box: choose one of: bilateral, square, gauss, none"),
        (&["--ao", "gtao:radius=-1"], "radius=-1: give a number from 0"),
        (&["--ao", "truth:rays=0"], "rays=0: give a whole number from 1 to 65536"),
        (&["--ao", "truth:filter=none"], "unknown parameter \"filter\"; choose one of: radius, rays"),
        (&["--ao", "none:radius=1"], "unknown parameter \"radius\"; there are none"),
        (&["--layer", "ao"], "--layer ao: choose the ambient occlusion with --ao NAME"),
        (&["--ao", "gtao", "--device", "cpu"], "--ao gtao: the CPU does not draw ambient occlusion"),
    ];
    for (words, said) in cases {
        let always = ["render", &scene, "--truth", "-o", &output];
        let (code, error) = adumbra(&[&always[..], &SIZE, words].concat());
        assert_eq!(code, 2, "{words:?}: {error}");
        assert!(error.contains(said), "{words:?}: {error}");
        assert!(!folder.exists("a.png"), "{words:?}");
    }
}
