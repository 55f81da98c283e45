//! Fading levels: answers change gradually while pages come and go. At rest they equal those of a stream
//! without fading.

use adumbra::stream::{BytesSource, StreamOptions, Streamer, View};
use adumbra::{Filter, ShadowFile};
use adumbra_scene::random::Random;

use crate::kit::{LIMIT, Point, camera, city, compare, large_city, points};

const FRAMES: u32 = 16;

fn fading(city: &'static [u8], budget_bytes: u64, fade_frames: u32) -> Streamer {
    let options = StreamOptions { budget_bytes, fade_frames, ..StreamOptions::default() };
    Streamer::new(BytesSource(city), options)
}

/// Updates the stream by a frame, and returns the visibility of points after it.
fn frame(streamer: &mut Streamer, views: &[View], points: &[Point]) -> Vec<f32> {
    std::thread::sleep(std::time::Duration::from_millis(1));
    streamer.update(views);
    streamer.take_writes(1 << 18);
    let sampler = streamer.sampler(Filter::Box5).expect("an open file");
    points.iter().map(|&(p, normal)| sampler.look_up(streamer.words(), p, normal).visibility).collect()
}

/// Returns the largest change of a point's visibility from one frame to the next, while a camera goes along a
/// street and jumps back.
fn largest_change(city: &'static [u8], budget_bytes: u64, fade_frames: u32) -> f32 {
    let file = ShadowFile::from_bytes(city).unwrap();
    let points = points(&file, 1000, 11);
    let mut streamer = fading(city, budget_bytes, fade_frames);
    assert!(streamer.settle(&[], LIMIT, |_| ()), "{:?}", streamer.take_faults());
    let mut before = frame(&mut streamer, &[], &points);
    let mut largest = 0.0_f32;
    for step in 0..240 {
        let along = f64::from(step % 80) / 80.0;
        let views = [camera(&file, [0.1 + 0.8 * along, 0.3 + 0.2 * along], 3.0, [1.0, -0.1, 0.3])];
        let after = frame(&mut streamer, &views, &points);
        let changes = before.iter().zip(&after).map(|(a, b)| (a - b).abs());
        largest = largest.max(changes.fold(0.0, f32::max));
        before = after;
    }
    assert!(streamer.take_faults().is_empty());
    largest
}

/// Compares fading changes with immediate ones.
fn fades(city: &'static [u8], budget: u64) {
    let levels = ShadowFile::from_bytes(city).unwrap().level_count();
    let at_once = largest_change(city, budget, 0);
    assert!(at_once > 0.5, "a camera that makes nothing jump proves nothing: {at_once}");
    // All levels above the coarsest may fade at the same time, each by one step.
    let most = (levels - 1) as f32 / FRAMES as f32;
    let by_and_by = largest_change(city, budget, FRAMES);
    assert!(by_and_by > 0.0 && by_and_by <= most + 1e-6, "{budget}: {by_and_by}");
}

#[test]
fn visibility_fades_where_pages_come() {
    fades(city(), 64 << 20);
}

#[test]
#[ignore = "slow: bakes a large city"]
fn visibility_fades_where_pages_come_and_go() {
    [1 << 20, 64 << 20].into_iter().for_each(|budget| fades(large_city(), budget));
}

#[test]
fn faded_stream_matches_file_bit_for_bit() {
    let file = ShadowFile::from_bytes(city()).unwrap();
    let points = points(&file, 5000, 12);
    let mut streamer = fading(city(), 64 << 20, FRAMES);
    assert!(streamer.settle(&[View::everything()], LIMIT, |_| ()));
    assert_eq!(compare(&streamer, &file, &points, Filter::Box5)[0], 5000);
}

#[test]
#[ignore = "slow: bakes a large city"]
fn faded_stream_with_small_budget_matches_levels_bit_for_bit() {
    let file = ShadowFile::from_bytes(large_city()).unwrap();
    let points = points(&file, 5000, 12);
    // With little room, bundles fade out gradually, and others wait for room.
    let mut random = Random::new(13, 0);
    for budget in [1 << 20, 2 << 20] {
        let mut streamer = fading(large_city(), budget, 4);
        for jump in 0..60 {
            let forward = [random.unit() - 0.5, -0.2, random.unit() - 0.5];
            let views = [camera(&file, [random.unit(), random.unit()], 1.0 + 40.0 * random.unit(), forward)];
            if jump % 5 == 4 {
                assert!(streamer.settle(&views, LIMIT, |_| ()), "{budget}: {:?}", streamer.counts());
                compare(&streamer, &file, &points, Filter::Box5);
                let counts = streamer.counts();
                assert!(counts.resident_bytes <= budget && counts.queued_bytes == 0, "{counts:?}");
            } else {
                streamer.update(&views);
                streamer.take_writes(1 << 14);
            }
        }
        assert!(streamer.take_faults().is_empty());
    }
}
