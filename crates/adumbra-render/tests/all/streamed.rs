//! Streamed files on the GPU. Where a file is resident, pictures and words read match the whole file.
//! Elsewhere, the answers match the CPU with the same pool.

use std::io::Cursor;
use std::sync::Arc;
use std::time::Duration;

use adumbra::gpu::{LookUp, Penumbra};
use adumbra::query::{FixedReceiver, receiver};
use adumbra::stream::{BytesSource, StreamOptions, Streamer, View};
use adumbra::{Encoding, Filter, LightGrid, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_render::maps::twin::Surface;
use adumbra_render::voxel::{BakedLight, LightFile, StreamedFile, Voxel, VoxelSettings};
use adumbra_render::{Answer, Renderer, SceneOptions, Shot, TechniqueFiles, build};
use adumbra_shaders::layout::PointQuery;
use adumbra_testing::full;

use crate::kit;
use crate::kit::boxes::boxes;
use crate::kit::surfaces::surfaces;
use crate::voxel_points::{BakedScene, answer};

/// Longer than any wait on a busy machine.
const LIMIT: Duration = Duration::from_secs(600);

fn shot() -> Shot {
    Shot { camera: kit::camera(120, 80), towards_sun: kit::sun(), number: 0 }
}

fn city(resolution: u64) -> BakedScene {
    BakedScene::new(kit::city(), [0.5, 0.8, 0.35], resolution)
}

/// Streams a file. The pages for `view` are resident before the first frame.
fn streamed(file: &ShadowFile, budget_bytes: u64, upload_bytes: usize, view: &[View]) -> Arc<StreamedFile> {
    let options = StreamOptions { budget_bytes, ..StreamOptions::default() };
    streamed_with(file, options, upload_bytes, view)
}

fn streamed_with(
    file: &ShadowFile,
    options: StreamOptions,
    upload_bytes: usize,
    view: &[View],
) -> Arc<StreamedFile> {
    let mut bytes = Cursor::new(Vec::new());
    file.write_to(&mut bytes, Encoding::Coded).unwrap();
    let mut streamer = Streamer::new(BytesSource(bytes.into_inner()), options);
    if !view.is_empty() {
        assert!(streamer.settle(view, LIMIT, |_| ()));
    }
    Arc::new(StreamedFile::open(streamer, upload_bytes, LIMIT).unwrap())
}

fn baked(file: &Arc<StreamedFile>) -> TechniqueFiles<'_> {
    TechniqueFiles { light: Some(LightFile::Streamed(file)), other: None }
}

/// Returns a technique's answers for all pixels of a frame.
fn drawn(renderer: &mut Renderer, name: &str, file: TechniqueFiles<'_>, answer: Answer) -> Vec<f32> {
    let technique = build(renderer.gpu(), &name.parse().unwrap(), file).unwrap();
    let mut prepared = renderer.prepare(technique).unwrap();
    renderer.draw(&shot(), &mut prepared, answer).unwrap();
    renderer.read_factor(&prepared).unwrap()
}

#[test]
fn resident_file_draws_the_same_as_the_whole_file() {
    let scene = city(2048);
    let file = streamed(&scene.light, 64 << 20, 1 << 18, &[View::everything()]);
    let mut renderer = Renderer::new(kit::gpu(), &scene.scene, SceneOptions::default()).unwrap();
    for name in ["voxel:filter=1", "voxel", "voxel:filter=17", "voxel:soft:sun-degrees=2", "voxel+csm"] {
        for answer in [Answer::Visibility, Answer::Voxel] {
            let whole = drawn(&mut renderer, name, TechniqueFiles::of(&scene.light), answer);
            let found = drawn(&mut renderer, name, baked(&file), answer);
            let differing = whole.iter().zip(&found).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
            assert_eq!(differing, 0, "{name}, {answer:?}");
            assert!(whole.iter().any(|v| *v != whole[0]), "{name}");
        }
    }
    let levels = drawn(&mut renderer, "voxel", baked(&file), Answer::Resident);
    assert!(levels.iter().all(|level| [-1.0, 0.0].contains(level)) && levels.contains(&0.0));
    assert!(
        build(renderer.gpu(), &"voxel".parse().unwrap(), TechniqueFiles::of(&scene.light))
            .unwrap()
            .sources(Answer::Resident)
            .is_none()
    );
}

/// Points on both sides of the border between two bundles, of which one is absent, below bars that cross it.
#[test]
fn penumbrae_use_one_level_next_to_an_absent_page() {
    const VOXEL: f64 = 1.0 / 64.0;
    // The border is at x = 0, 2048 columns from the ground's beginning.
    let mut corners = vec![([-32.0, -1.0, -1.0], [8.0, 0.0, 1.0])];
    corners.extend([-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|n| {
        let z = 0.125 * n;
        ([-2.0, 1.0, z], [2.0, 1.02, z + 0.05])
    }));
    let frame = FrameChoice::ObliqueAt(0.0);
    let sun = Sun::from_angles(0.0, 90.0).unwrap();
    let options = BakeOptions::new(sun, Size::VoxelSize(VOXEL)).with(|o| o.frame = frame);
    let light = Bake::with_options(&boxes(&corners), &options).in_memory().unwrap();
    let penumbra = Some(Penumbra { sun_degrees: 10.0, max_radius_texels: 4.9 });
    let settings =
        VoxelSettings { look_up: LookUp { penumbra, ..LookUp::default() }, ..VoxelSettings::default() };
    // Four per texel along x, from -12 to 4 texels, and 32 rows.
    let point = |n: u32| {
        let [x, z] = [0.25 * f64::from(n % 64) - 11.875, f64::from(n / 64) - 15.5];
        let p_relative = [x, 0.0, z].map(|c| (VOXEL * c) as f32);
        PointQuery { p_relative, view_depth: 0.0, normal: [0.0, 1.0, 0.0], pixel: [n, 0] }
    };
    let points: Vec<PointQuery> = (0..64 * 32).map(point).collect();
    let gpu = kit::gpu();
    let all = View::everything();
    let near_the_first = View { position_world: [-16.0, 0.0, 0.0], pixel_per_distance: 0.01, ..all.clone() };
    let of_coarse_pixels = View { pixel_world: 8.0 * VOXEL, ..all.clone() };
    let [fine, coarse, found] = [all, of_coarse_pixels, near_the_first].map(|view| {
        let file = streamed(&light, 8 << 20, 1 << 18, &[view]);
        let mut light = BakedLight::new(&gpu, LightFile::Streamed(&file), settings).unwrap();
        light.set_anchor(&gpu, [0.0; 3]).unwrap();
        answer(&gpu, &Voxel::new("voxel:soft".to_owned(), light), &points)
    });
    let mut counts = [0; 2];
    for (n, &found) in found.iter().enumerate() {
        let is_of = [fine[n], coarse[n]].map(|of_level| found == of_level);
        assert!(is_of.contains(&true), "{:?}: {found}, not {} or {}", points[n], fine[n], coarse[n]);
        (0..2).for_each(|level| counts[level] += u32::from(!is_of[1 - level]));
    }
    // For many points, only one of the two levels gives this answer.
    assert!(counts.iter().all(|count| *count > 200), "{counts:?}");
}

#[test]
fn a_small_resident_file_reads_at_most_a_fiftieth_more_words() {
    reads_hardly_more_words(&[2048], 500, &[Filter::Box5]);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn a_resident_file_reads_at_most_a_fiftieth_more_words() {
    let resolutions: &[u64] = if full() { &[8192, 16_384] } else { &[8192] };
    reads_hardly_more_words(resolutions, 3000, &[Filter::Nearest, Filter::Box5, Filter::Box17]);
}

fn reads_hardly_more_words(resolutions: &[u64], points: usize, filters: &[Filter]) {
    let gpu = kit::gpu();
    for &resolution in resolutions {
        let scene = city(resolution);
        let (grid, bias) = (&scene.light.grid, scene.light.settings.bias);
        let fixed = |(p, n)| FixedReceiver::new(&receiver(grid, &bias, p, n), grid.size);
        let receivers: Vec<_> = scene.points(points).into_iter().map(fixed).collect();
        let file = streamed(&scene.light, 64 << 20, 1 << 18, &[View::everything()]);
        for &filter in filters {
            let settings = VoxelSettings::taps(filter, bias);
            let words = |file| {
                let light = BakedLight::new(&gpu, file, settings).unwrap();
                let reads = light.reads(&gpu, &receivers).unwrap();
                let taps: Vec<u32> = reads.iter().map(|reads| reads.lit_taps).collect();
                (taps, reads.iter().map(|reads| reads.words.len()).sum::<usize>())
            };
            let (whole_taps, whole) = words(LightFile::Whole(&scene.light));
            let (taps, found) = words(LightFile::Streamed(&file));
            println!("{filter:?}: {found} words, {whole} of the whole file");
            assert_eq!(taps, whole_taps);
            assert!(found * 50 <= whole * 51, "{filter:?}: {found} words, {whole} of the whole file");
        }
    }
}

/// Compares a frame with the CPU's look-ups in the same words. Returns how many pixels each level answered.
fn hold(
    renderer: &Renderer,
    file: &StreamedFile,
    filter: Filter,
    [factor, levels]: [&[f32]; 2],
) -> Vec<usize> {
    let shot = shot();
    let anchor = shot.camera.view().eye.map(|c| f64::from(c as f32));
    let streamer = file.streamer();
    let sampler = streamer.sampler(filter).unwrap();
    let grids: Vec<LightGrid> = streamer.resident().grids().into_iter().map(|(_, grid)| grid).collect();
    let mut seen = vec![0; grids.len()];
    let (mut checked, mut differing) = (0, 0);
    for (at, surface) in surfaces(renderer, &shot).iter().enumerate() {
        let Some(Surface { p_relative, normal, .. }) = surface else { continue };
        let p: [f64; 3] = std::array::from_fn(|a| anchor[a] + f64::from(p_relative[a]));
        let answer = sampler.look_up(streamer.words(), p, Some(normal.map(f64::from)));
        checked += 1;
        seen[answer.level as usize] += 1;
        let is_level = levels.is_empty() || levels[at] < 0.0 || levels[at] == answer.level as f32;
        // A tap on a face may fall to either side in f32.
        let taps = (filter.width() * filter.width()) as f32;
        let is_near = (answer.visibility - factor[at]).abs() * taps <= 2.0;
        differing += usize::from(!is_level || !is_near);
    }
    assert!(checked > 3_750 && differing * 500 < checked, "{differing} of {checked} differ; {seen:?}");
    seen
}

#[test]
fn streaming_a_small_file_is_never_wrong_and_ends_sharp() {
    frames_are_never_wrong(2048, 1 << 11);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn streaming_is_never_wrong_and_ends_sharp() {
    frames_are_never_wrong(8192, 1 << 13);
}

/// Draws frames that each write less than a page, so that most frames see a half-written page.
fn frames_are_never_wrong(resolution: u64, upload_bytes: usize) {
    let scene = city(resolution);
    let file = streamed(&scene.light, 8 << 20, upload_bytes, &[]);
    let mut renderer = Renderer::new(kit::gpu(), &scene.scene, SceneOptions::default()).unwrap();
    let technique = build(renderer.gpu(), &"voxel".parse().unwrap(), baked(&file)).unwrap();
    let mut prepared = renderer.prepare(technique).unwrap();
    let mut mixed = 0;
    for frame in 0.. {
        renderer.draw(&shot(), &mut prepared, Answer::Visibility).unwrap();
        if frame % 20 == 0 || file.is_settled() {
            let factor = renderer.read_factor(&prepared).unwrap();
            let seen = hold(&renderer, &file, Filter::Box5, [&factor, &[]]);
            mixed += u32::from(seen[0] > 0 && seen[1..].iter().sum::<usize>() > 25);
        }
        if file.is_settled() {
            break;
        }
        assert!(frame < 5000, "{:?}", file.counts());
    }
    assert!(mixed > 0, "no frame was between");
    let levels = drawn(&mut renderer, "voxel", baked(&file), Answer::Resident);
    let factor = drawn(&mut renderer, "voxel", baked(&file), Answer::Visibility);
    hold(&renderer, &file, Filter::Box5, [&factor, &levels]);
    // Once the stream has settled, every pixel has its required level or a finer one.
    let view = adumbra_render::voxel::view_of(&shot().camera);
    let depth = renderer.read_surface(&shot()).unwrap().view_depth;
    let voxel_world = scene.light.grid.voxel_size;
    for (level, depth) in levels.iter().zip(&depth).filter(|(level, _)| **level > 0.0) {
        let texel_world = voxel_world * 4_f64.powf(f64::from(*level));
        assert!(texel_world <= 1.3 * view.pixel_per_distance * f64::from(*depth), "{level} at {depth}");
    }
}

#[test]
fn fading_levels_of_a_small_file_match_cpu() {
    fade(2048, &[("voxel", 12)]);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn fading_levels_match_cpu_and_change_gradually() {
    fade(8192, &[("voxel", 0), ("voxel", 12), ("voxel:soft:sun-degrees=2", 12)]);
}

/// Draws techniques while levels fade over some frames.
fn fade(resolution: u64, techniques: &[(&str, u32)]) {
    let scene = city(resolution);
    let mut renderer = Renderer::new(kit::gpu(), &scene.scene, SceneOptions::default()).unwrap();
    for &(name, fade_frames) in techniques {
        let options = StreamOptions { budget_bytes: 8 << 20, fade_frames, ..StreamOptions::default() };
        let file = streamed_with(&scene.light, options, 1 << 16, &[]);
        let technique = build(renderer.gpu(), &name.parse().unwrap(), baked(&file)).unwrap();
        let mut prepared = renderer.prepare(technique).unwrap();
        let mut before: Vec<f32> = Vec::new();
        let mut largest = 0.0_f32;
        for frame in 0.. {
            renderer.draw(&shot(), &mut prepared, Answer::Visibility).unwrap();
            let factor = renderer.read_factor(&prepared).unwrap();
            if name == "voxel" && frame % 4 == 0 {
                hold(&renderer, &file, Filter::Box5, [&factor, &[]]);
            }
            let changes = before.iter().zip(&factor).map(|(a, b)| (a - b).abs());
            largest = changes.fold(largest, f32::max);
            before = factor;
            if file.is_settled() {
                break;
            }
            assert!(frame < 500, "{:?}", file.counts());
        }
        let levels = file.streamer().resident().grids().len();
        // Each level except the coarsest may fade by one step.
        let by_and_by = (levels - 1) as f32 * 22.0 / 256.0 + 1e-5;
        println!("{name}, {fade_frames} frames, {levels} levels: at most {largest} from frame to frame");
        if fade_frames == 0 {
            assert!(largest > by_and_by, "nothing jumps: {largest}");
        } else {
            assert!(largest > 0.0 && largest <= by_and_by, "{name}: {largest}");
        }
    }
}

#[test]
fn failed_stream_reports_the_reason() {
    let mut streamer = Streamer::new(BytesSource(b"no shadow file".to_vec()), StreamOptions::default());
    // Wait at most ten minutes, even on a busy machine.
    let mut waits = 60_000;
    while !streamer.resident().has_failed() && waits > 0 {
        streamer.settle(&[], Duration::from_millis(10), |_| ());
        waits -= 1;
    }
    let Err(error) = StreamedFile::open(streamer, 1 << 18, Duration::ZERO) else { panic!("it was opened") };
    assert!(error.to_string().contains("not a shadow file"), "{error}");
}
