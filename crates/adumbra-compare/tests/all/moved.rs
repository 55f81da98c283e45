//! Every shared scene gives the same results at map coordinates as at the origin.
//!
//! Each scene is compared from two cameras, with techniques of every kind.

use std::path::Path;

use adumbra::{ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_compare::compare::{Compared, Comparison};
use adumbra_compare::paths::CameraPath;
use adumbra_compare::truth::{StreetOptions, TruthTracer, street_camera};
use adumbra_render::{Gpu, GpuOptions, Renderer, SceneOptions};
use adumbra_scene::{Camera, LoadOptions, Scene, load};
use adumbra_testing::{scene_file, shared};

use crate::compared;

const SIZE: [u32; 2] = [192, 120];
/// As far away as any map coordinate: 10,000 km along both axes.
const PLACE: [f64; 3] = [10_000_000.0, 0.0, 10_000_000.0];
/// Number of pixels that may differ, as some are on an edge to within rounding.
const PIXELS: u64 = 1;
const TECHNIQUES: [&str; 6] =
    ["none", "voxel", "voxel:filter=5", "sm:size=2048", "csm:size=1024", "hrsm:1024-256"];

/// Returns a camera beside the scene and one in a street, or two around it if there is no street.
fn cameras(scene: &Scene, sun: Sun) -> Vec<Camera> {
    let truth = TruthTracer::build(scene, false);
    let [width, height] = SIZE;
    let options = StreetOptions { width, height, ..StreetOptions::default() };
    let street = street_camera(&truth, sun.towards(), &options).ok();
    let orbit = CameraPath::orbit(&scene.bounds(), if street.is_some() { 1 } else { 2 });
    (0..orbit.frames()).map(|i| orbit.camera(i, width, height)).chain(street).collect()
}

fn moved(scene: &Scene, place: [f64; 3]) -> Scene {
    let mut scene = scene.clone();
    for instance in &mut scene.instances {
        (0..3).for_each(|a| instance.world_from_mesh[a][3] += place[a]);
    }
    scene
}

fn compare_at(scene: &Scene, file: &ShadowFile, place: [f64; 3], cameras: &[Camera]) -> Vec<Comparison> {
    let sun = file.grid.sun;
    let file = compared::moved(file.clone(), place);
    let scene = moved(scene, place);
    let gpu = Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut renderer = Renderer::new(gpu, &scene, SceneOptions::default()).unwrap();
    let at = |p: [f64; 3]| std::array::from_fn(|a| p[a] + place[a]);
    let cameras: Vec<_> =
        cameras.iter().map(|c| Camera { eye: at(c.eye), target: at(c.target), ..*c }).collect();
    compared::comparisons(&mut renderer, &scene, Some(&file), sun, &cameras, &TECHNIQUES)
}

/// Returns every error of a comparison with its name.
fn figures(comparison: &Comparison) -> Vec<(String, f64)> {
    let of = |c: &Compared| {
        let row = &c.row;
        let figures = [
            ("RMSE", row.rmse),
            ("mean", row.mean_difference),
            ("lit", row.wrong_lit),
            ("shadowed", row.wrong_shadowed),
            ("SSIM", row.ssim),
            ("FLIP", row.flip),
        ];
        figures.map(|(what, value)| (format!("{} {what}", row.name), value.unwrap_or(f64::NAN)))
    };
    comparison.compared.iter().flat_map(of).collect()
}

/// Compares a scene's results elsewhere with those at the origin.
///
/// They may differ by 1 % of their value, or by the share that `PIXELS` are of the compared pixels.
fn check(scenes: &Path, name: &str) {
    let options = LoadOptions { color_textures: true, ..LoadOptions::default() };
    let scene = load(&scene_file(scenes, name), &options).unwrap();
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let cameras = cameras(&scene, sun);
    assert_eq!(cameras.len(), 2, "{name}");
    let file =
        Bake::with_options(&scene, &BakeOptions::new(sun, Size::Resolution(2048))).in_memory().unwrap();
    let plain = compare_at(&scene, &file, [0.0; 3], &cameras);
    let mut largest = (0.0_f64, String::new());
    for (number, (a, b)) in plain.iter().zip(compare_at(&scene, &file, PLACE, &cameras)).enumerate() {
        let what = format!("{name}, camera {number}");
        assert!(a.pixels.compared > 0, "{what}: {:?}", a.pixels);
        let excluded = a.pixels.excluded.abs_diff(b.pixels.excluded);
        assert!(excluded <= PIXELS, "{what}: {:?} {:?}", a.pixels, b.pixels);
        let pixels = PIXELS as f64 / a.pixels.compared as f64;
        for ((figure, a), (_, b)) in figures(a).into_iter().zip(figures(&b)) {
            let apart = (a - b).abs();
            assert!(apart <= pixels.max(0.01 * a.abs()), "{what}, {figure}: {a} {b}");
            if apart > largest.0 {
                largest = (apart, format!("{what}, {figure}: {a} {b}"));
            }
        }
    }
    println!("{name}: at most {:.2e} apart: {}", largest.0, largest.1);
}

fn check_all(names: &[&str]) {
    let Some(scenes) = shared("scenes") else { return };
    names.iter().for_each(|name| check(&scenes, name));
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_towns_give_the_same_figures_anywhere() {
    check_all(&["box-city-51k", "box-city-5k", "delft", "jacksboro", "kaykit_city_121", "kaykit_city_21"]);
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_places_give_the_same_figures_anywhere() {
    check_all(&["alpine-2", "auster", "bridge_garden", "dream_apartment", "street-1", "zdm2"]);
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_things_give_the_same_figures_anywhere() {
    check_all(&["armadillo", "bunny_69k", "dragon_202k", "oak_medium", "pine_medium", "teapot"]);
}
