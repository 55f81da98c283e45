//! `--device` and `--adapter` are obeyed, and the GPU's pictures match the CPU's.

#![cfg(feature = "render")]

use adumbra_testing::{Folder, adumbra, json, scene_file, shared};

/// Draws traced shadows on a device. Returns the picture and the device's name according to `--json`.
fn truth(scene: &str, device: &str, output: &str) -> (image::RgbImage, String) {
    let report = json(&[
        "render",
        scene,
        "--shadow",
        "truth",
        "--device",
        device,
        "--size",
        "320x180",
        "--antialias",
        "1",
        "--json",
        "-o",
        output,
    ]);
    (image::open(output).unwrap().into_rgb8(), report["device"].as_str().unwrap().to_owned())
}

/// Returns the shares of pixels that differ by more than 2/255 and by more than 16/255.
fn differing(a: &image::RgbImage, b: &image::RgbImage) -> [f64; 2] {
    let by = |least: u8| {
        let pixels = a.pixels().zip(b.pixels());
        let off = pixels.filter(|(a, b)| (0..3).any(|c| a.0[c].abs_diff(b.0[c]) > least)).count();
        off as f64 / f64::from(a.width() * a.height())
    };
    [by(2), by(16)]
}

#[test]
fn device_gpu_draws_on_the_gpu() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let (cpu, cpu_name) = truth(&scene, "cpu", &folder.path("cpu.png"));
    let (gpu, gpu_name) = truth(&scene, "gpu", &folder.path("gpu.png"));
    assert_eq!(cpu_name, "cpu");
    assert_ne!(gpu_name, "cpu");
    let [slightly, much] = differing(&cpu, &gpu);
    assert!(slightly < 0.005 && much < 0.003, "{slightly} {much}");
    // By default the CPU draws traced shadows. A named adapter is a GPU.
    assert_eq!(truth(&scene, "auto", &folder.path("auto.png")).1, "cpu");
    let picture = folder.path("none.png");
    let base = ["render", &scene, "--truth", "--size", "32x18", "-o", &picture];
    let (code, error) = adumbra(&[&base[..], &["--adapter", "nosuchadapter"]].concat());
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("no GPU adapter was found"), "{error}");
    let file = folder.path("city.adumbra");
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "256", "-o", &file]);
    assert_eq!(code, 0, "{error}");
    let base = ["render", &scene, "--shadow-file", &file, "--diff", "--size", "32x18", "-o", &picture];
    let (code, error) = adumbra(&[&base[..], &["--device", "gpu"]].concat());
    assert_eq!(code, 2, "{error}");
    assert!(error.contains("--diff: it is drawn on the CPU"), "{error}");
    assert!(!folder.exists("none.png"));
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_textured_scenes_look_alike_on_both_devices() {
    let Some(scenes) = shared("scenes") else { return };
    let folder = Folder::new();
    for name in ["oak_medium", "kaykit_city_21", "bridge_garden"] {
        let scene = scene_file(&scenes, name).display().to_string();
        let (cpu, _) = truth(&scene, "cpu", &folder.path("cpu.png"));
        let (gpu, _) = truth(&scene, "gpu", &folder.path("gpu.png"));
        let [slightly, much] = differing(&cpu, &gpu);
        assert!(slightly < 0.002 && much < 0.001, "{name}: {slightly} {much}");
    }
}
