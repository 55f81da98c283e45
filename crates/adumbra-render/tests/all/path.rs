//! Sun paths on the GPU: marches and pictures match those of the CPU.

use std::sync::Arc;

use adumbra::query::{FixedReceiver, MarchSlope, Marched, march, receiver};
use adumbra::{Bounds, Filter, PathSampler, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_render::maps::twin::Surface;
use adumbra_render::voxel::{BakedLight, LightFile, MovingLight, PathDiscTwin, SoftTwin, VoxelSettings};
use adumbra_render::{Answer, Renderer, SceneOptions, Shot, TechniqueFiles, build};
use adumbra_scene::Scene;
use adumbra_scene::random::Random;
use adumbra_shaders::layout::PointQuery;
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};

use crate::kit;
use crate::kit::surfaces::surfaces;

/// The suns of two keys, and one between them.
fn suns() -> [Sun; 3] {
    [[120.0, 38.0], [126.0, 41.0], [123.5, 39.7]]
        .map(|[azimuth, elevation]| Sun::from_angles(azimuth, elevation).unwrap())
}

/// Small, so that the shaders guess some rays to be blocked.
const DARK_AFTER_VOXELS: u32 = 3;

fn keys(frame: FrameChoice, voxel_world: f64) -> [ShadowFile; 2] {
    let [first, second, _] = suns();
    [first, second].map(|sun| {
        let options = BakeOptions::new(sun, Size::VoxelSize(voxel_world)).with(|o| {
            o.levels = 1;
            o.frame = frame;
        });
        let mut file = Bake::with_options(&kit::city(), &options).in_memory().unwrap();
        file.settings.dark_after_voxels = DARK_AFTER_VOXELS;
        file
    })
}

fn between(keys: &[ShadowFile; 2]) -> LightFile<'_> {
    LightFile::Between { keys: keys.each_ref(), towards_sun: suns()[2].towards() }
}

#[test]
fn gpu_marches_match_cpu() {
    let gpu = kit::gpu();
    for frame in [FrameChoice::ObliqueAt(0.0), FrameChoice::Light] {
        let keys = keys(frame, 0.3);
        let bias = keys[0].settings.bias;
        let light =
            BakedLight::new(&gpu, between(&keys), VoxelSettings::taps(Filter::Nearest, bias)).unwrap();
        let slopes = keys.each_ref().map(|key| MarchSlope::new(&key.grid, suns()[2].towards()).unwrap());
        let mut random = Random::new(3, 0);
        let starts: Vec<FixedReceiver> = (0..60_000)
            .map(|_| {
                let at = keys[0].grid.size.map(|n| (1.2 * random.unit() - 0.1) * f64::from(n));
                FixedReceiver { p_fixed: at.map(|c| (4096.0 * c) as i64), gradient: [0; 2] }
            })
            .collect();
        let found = light.marched(&gpu, &starts).unwrap();
        let mut counts = [0; 4];
        for (start, found) in starts.iter().zip(&found) {
            let expected =
                [0, 1].map(|key| match march(keys[key].tree.words(), slopes[key], start.p_fixed) {
                    Marched::Blocked => 0,
                    Marched::Clear => 1,
                    Marched::Unknown { hidden_rise } => 2 + hidden_rise,
                });
            assert_eq!(*found, expected, "{start:?}");
            counts[found[0].min(3) as usize] += 1;
        }
        println!("{frame:?}: blocked, clear, unknown, unknown and hidden at first {counts:?}");
        assert!(counts[0] > 500 && counts[1] > 500 && counts[2] + counts[3] > 500, "{counts:?}");
        assert!(counts[3] > 500, "{counts:?}");
    }
}

const WIDTH: u32 = 120;
const HEIGHT: u32 = 80;

/// Visibility of a point with its normal, at a pixel.
type LookUp<'a> = &'a dyn Fn([f64; 3], Option<[f64; 3]>, [u32; 2]) -> f32;

#[test]
fn gpu_sun_path_pictures_match_cpu() {
    let keys = keys(FrameChoice::ObliqueAt(0.0), 0.3);
    let sun = suns()[2].towards();
    let shot = Shot { camera: kit::camera(WIDTH, HEIGHT), towards_sun: sun, number: 0 };
    let mut renderer = Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap();
    let anchor = shot.camera.view().eye.map(|c| f64::from(c as f32));
    let still = keys[0].sampler(Filter::Nearest);
    let [hard, wide] =
        [Filter::Nearest, Filter::Box5].map(|filter| PathSampler::new(keys.each_ref(), sun, filter).unwrap());
    let quick = [hard.clone().quick(), wide.clone().quick()];
    let mut never = keys.clone();
    never[0].settings.dark_after_voxels = 0;
    let never = PathSampler::new(never.each_ref(), sun, Filter::Nearest).unwrap();
    let mut guessed = 0;
    let disc = PathDiscTwin::new(keys.each_ref(), sun, 3.0).unwrap();
    // Two of nine rays, or four of 32, may pass an edge on either side in f32.
    let cases: [(&str, f32, LookUp<'_>); 5] = [
        ("voxel:filter=1", 0.5, &|p, normal, _| hard.look_up(p, normal)),
        ("voxel:filter=5", 0.23, &|p, normal, _| wide.look_up(p, normal)),
        ("voxel:filter=1:march=quick", 0.5, &|p, normal, _| quick[0].look_up(p, normal)),
        ("voxel:filter=5:march=quick", 0.23, &|p, normal, _| quick[1].look_up(p, normal)),
        ("voxel:soft:sun-degrees=3", 0.13, &|p, normal, pixel| disc.visibility(p, normal, pixel)),
    ];
    for (name, most_apart, expected) in cases {
        let baked = TechniqueFiles { light: Some(between(&keys)), other: None };
        let technique = build(renderer.gpu(), &name.parse().unwrap(), baked).unwrap();
        let mut prepared = renderer.prepare(technique).unwrap();
        renderer.draw(&shot, &mut prepared, Answer::Visibility).unwrap();
        let factor = renderer.read_factor(&prepared).unwrap();
        let (mut checked, mut off, mut moved, mut partly) = (0, 0, 0, 0);
        for (at, surface) in surfaces(&renderer, &shot).iter().enumerate() {
            let Some(Surface { p_relative, normal, .. }) = surface else { continue };
            let p = std::array::from_fn(|a| anchor[a] + f64::from(p_relative[a]));
            let normal = Some(normal.map(f64::from));
            let pixel = [at as u32 % WIDTH, at as u32 / WIDTH];
            checked += 1;
            off += u32::from((expected(p, normal, pixel) - factor[at]).abs() > most_apart);
            guessed += u32::from(hard.look_up(p, normal) != never.look_up(p, normal) && factor[at] == 0.0);
            moved += u32::from((still.visibility(p, normal) - factor[at]).abs() > 0.5);
            partly += u32::from(factor[at] > 0.0 && factor[at] < 1.0);
        }
        println!(
            "{name}: {off} of {checked} are off; {moved} are not as with the key's own sun; {partly} are between"
        );
        assert!(checked > 3_750 && off * 300 < checked, "{name}: {off} of {checked}");
        assert!(moved * 200 > checked, "{name}: {moved}");
        assert_eq!(partly > checked / 60, !name.contains("filter=1"), "{name}: {partly}");
    }
    println!("{guessed} pixels are guessed to be dark");
    assert!(guessed > 2, "{guessed}");
    let whole = TechniqueFiles { light: Some(LightFile::Whole(&keys[0])), other: None };
    let of_file = build(renderer.gpu(), &"voxel:march=quick".parse().unwrap(), whole);
    assert!(of_file.is_err_and(|error| error.to_string().contains("march")));
}

#[test]
fn quick_look_ups_in_small_keys_read_fewer_words_than_marches() {
    quick_look_ups_read_fewer_words(0.6, [96, 64]);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn quick_look_ups_read_fewer_words_than_marches() {
    quick_look_ups_read_fewer_words(0.15, [240, 160]);
}

/// Compares the cost of look-ups: words read from the file per visible point.
fn quick_look_ups_read_fewer_words(voxel_world: f64, [width, height]: [u32; 2]) {
    let keys = keys(FrameChoice::ObliqueAt(0.0), voxel_world);
    let sun = suns()[2].towards();
    let shot = Shot { camera: kit::camera(width, height), towards_sun: sun, number: 0 };
    let mut renderer = Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap();
    let none = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut prepared = renderer.prepare(none).unwrap();
    renderer.draw(&shot, &mut prepared, Answer::Visibility).unwrap();
    let anchor = shot.camera.view().eye.map(|c| f64::from(c as f32));
    let points: Vec<PointQuery> = surfaces(&renderer, &shot)
        .iter()
        .flatten()
        .map(|Surface { p_relative, normal, .. }| PointQuery {
            p_relative: *p_relative,
            view_depth: 0.0,
            normal: *normal,
            pixel: [0; 2],
        })
        .collect();
    let gpu = renderer.gpu();
    let bias = keys[0].settings.bias;
    let mean = |filter, quick| {
        let settings = VoxelSettings { quick, ..VoxelSettings::taps(filter, bias) };
        let mut light = BakedLight::new(gpu, between(&keys), settings).unwrap();
        light.set_anchor(gpu, anchor).unwrap();
        let found = light.path_reads(gpu, &points).unwrap();
        found.iter().map(|(_, words)| f64::from(*words)).sum::<f64>() / found.len() as f64
    };
    let own = {
        let light = BakedLight::from_file(gpu, &keys[0], VoxelSettings::taps(Filter::Nearest, bias)).unwrap();
        let receivers: Vec<FixedReceiver> = points
            .iter()
            .map(|point| {
                let p = std::array::from_fn(|a| anchor[a] + f64::from(point.p_relative[a]));
                let r = receiver(&keys[0].grid, &bias, p, Some(point.normal.map(f64::from)));
                FixedReceiver::new(&r, keys[0].grid.size)
            })
            .collect();
        let found = light.reads(gpu, &receivers).unwrap();
        found.iter().map(|reads| reads.words.len() as f64).sum::<f64>() / found.len() as f64
    };
    let [full, quick] = [false, true].map(|quick| mean(Filter::Nearest, quick));
    println!(
        "words: {own:.1} of voxel:filter=1; between keys {full:.1}, quick {quick:.1}, {:.2} times",
        quick / own
    );
    assert!(quick <= 2.5 * own, "{quick} and {own} words");
    assert!(own < quick && quick < full, "{own}, {quick}, {full}");
}

#[test]
#[ignore = "slow: 32 marches and 256 rays for each point"]
fn marches_to_a_disc_are_about_as_accurate_as_penumbrae() {
    marches_to_a_disc_are_near(&[0.53, 2.0, 6.0], 6000, 256, [1.25, 1.1]);
}

#[test]
fn few_marches_to_a_disc_are_about_as_accurate_as_penumbrae() {
    // With so few points and rays, the measured errors are accurate only to a third.
    marches_to_a_disc_are_near(&[2.0], 1000, 64, [1.5, 1.5]);
}

/// Compares root-mean-square errors against rays to the sun's disc. Marches in a file of the same sun may
/// have `times[0]` times the error of `voxel:soft` in that file. Marches between two keys may have `times[1]`
/// times the error of marches in one file.
fn marches_to_a_disc_are_near(angles: &[f64], points: usize, rays: u32, times: [f64; 2]) {
    let scene = kit::city();
    let mut keys = keys(FrameChoice::ObliqueAt(0.0), 0.15);
    // The value measured for a city: 9 m.
    keys.iter_mut().for_each(|key| key.settings.dark_after_voxels = 60);
    let [own, _, between] = suns().map(|sun| sun.towards());
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let points = visible_points(&scene, &tracer, points);
    for &angle in angles {
        let rms = |sun: [f64; 3], visibility: &dyn Fn([f64; 3], [f64; 3], [u32; 2]) -> f32| {
            let mut sum = 0.0;
            let mut count = 0;
            for (i, (p, normal)) in points.iter().enumerate() {
                let facing: f64 = (0..3).map(|a| normal[a] * sun[a]).sum();
                if facing < 0.2 {
                    continue;
                }
                let lifted = std::array::from_fn(|a| p[a] + 1e-3 * normal[a]);
                let truth = tracer.sun_disc_visibility(lifted, sun, angle, rays, i as u64);
                let found = f64::from(visibility(*p, *normal, [i as u32, 0]));
                sum += (found - f64::from(truth)).powi(2);
                count += 1;
            }
            (sum / f64::from(count)).sqrt()
        };
        let twin = SoftTwin::new(&keys[0].grid, &keys[0].tree, angle, 32.0);
        let soft = rms(own, &|p, normal, pixel| {
            let r = receiver(&keys[0].grid, &keys[0].settings.bias, p, Some(normal));
            twin.visibility(&FixedReceiver::new(&r, keys[0].grid.size), pixel)
        });
        let disc = |keys: [&ShadowFile; 2], sun| {
            let twin = PathDiscTwin::new(keys, sun, angle).unwrap();
            rms(sun, &|p, normal, pixel| twin.visibility(p, Some(normal), pixel))
        };
        let marched = disc([&keys[0]; 2], own);
        let moved = disc(keys.each_ref(), between);
        println!("a disc of {angle}°: voxel:soft {soft:.4}, marches {marched:.4}, between keys {moved:.4}");
        // Penumbrae of a file are smooth within a texel. Marches are correct where several casters overlap.
        assert!(marched < times[0] * soft && moved < times[1] * marched, "{angle}: {soft} {marched} {moved}");
        assert!(angle < 4.0 || marched < soft, "{angle}: {soft} {marched}");
    }
}

/// Returns points on the ground and on roofs that rays from above see, with their normals.
fn visible_points(scene: &Scene, tracer: &Tracer<'_>, count: usize) -> Vec<([f64; 3], [f64; 3])> {
    let Bounds { min, max } = scene.bounds();
    let mut random = Random::new(5, 0);
    let mut points = Vec::new();
    while points.len() < count {
        let [x, z] = [0, 2].map(|a| min[a] + random.unit() * (max[a] - min[a]));
        let origin = [x, max[1] + 1.0, z];
        let ray = Ray { origin, direction: [0.0, -1.0, 0.0], t_min: 0.0, t_max: f64::INFINITY };
        let Some(hit) = tracer.nearest_surface(&ray) else { continue };
        let up = if hit.normal[1] < 0.0 { -1.0 } else { 1.0 };
        points.push(([x, origin[1] - hit.t, z], hit.normal.map(|c| up * c)));
    }
    points
}

#[test]
fn moving_sun_switches_keys_without_an_intermediate_frame() {
    let [first, second] = keys(FrameChoice::ObliqueAt(0.0), 0.6);
    let third = Bake::with_options(
        &kit::city(),
        &BakeOptions::new(Sun::from_angles(131.0, 44.0).unwrap(), Size::VoxelSize(0.4)).with(|o| {
            o.levels = 1;
            o.frame = FrameChoice::ObliqueAt(0.0);
        }),
    )
    .in_memory()
    .unwrap();
    let sun = |azimuth, elevation| Sun::from_angles(azimuth, elevation).unwrap().towards();
    let mut renderer = Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap();
    let mut picture = |light: LightFile<'_>, towards_sun, frames: u32| {
        let baked = TechniqueFiles { light: Some(light), other: None };
        let technique = build(renderer.gpu(), &"voxel:filter=1".parse().unwrap(), baked).unwrap();
        let mut prepared = renderer.prepare(technique).unwrap();
        let mut factors = Vec::new();
        for number in 0..frames {
            let shot = Shot { camera: kit::camera(96, 64), towards_sun, number };
            renderer.draw(&shot, &mut prepared, Answer::Visibility).unwrap();
            factors.push(renderer.read_factor(&prepared).unwrap());
            if let LightFile::Moving(light) = light
                && number == 0
            {
                // The finer key does not fit into the existing slots.
                light.set([&third, &second], towards_sun);
            }
        }
        factors
    };
    let towards = sun(126.5, 41.2);
    let still = |keys| LightFile::Between { keys, towards_sun: towards };
    let before = picture(still([&second, &first]), towards, 1).remove(0);
    let after = picture(still([&third, &second]), towards, 1).remove(0);
    assert!(before != after);
    let bytes = third.gpu().words().count() * 4;
    let moving = Arc::new(MovingLight::new([&second, &first], towards, (bytes / 3) as usize));
    let frames = picture(LightFile::Moving(&moving), towards, 8);
    let switch = frames.iter().position(|factor| *factor == after).expect("the new keys");
    assert!(moving.is_settled());
    moving.set([&second, &first], towards);
    assert!(!moving.is_settled(), "other keys are to be written");
    assert!((3..7).contains(&switch), "{switch}: a frame writes a third of a key, and there are two");
    assert!(frames[..switch].iter().all(|factor| *factor == before));
    assert!(frames[switch..].iter().all(|factor| *factor == after));
}
