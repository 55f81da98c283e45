//! A city with all of its levels, points, and the comparison of a stream with its file.

use std::io::Cursor;
use std::sync::OnceLock;
use std::time::Duration;

use adumbra::stream::{ShadowSource, StreamFault, StreamOptions, Streamer, View};
use adumbra::{Encoding, Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, generate};

/// Longer than any wait on a busy machine.
pub(crate) const LIMIT: Duration = Duration::from_secs(600);

fn coded_city(resolution: u64, levels: u32, frame: FrameChoice) -> Vec<u8> {
    let sun = Sun::from_angles(130.0, 35.0).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(resolution)).with(|o| {
        o.levels = levels;
        o.frame = frame;
    });
    let file = Bake::with_options(&generate(GeneratedKind::City, 7), &options).in_memory().unwrap();
    let mut bytes = Cursor::new(Vec::new());
    file.write_to(&mut bytes, Encoding::Coded).unwrap();
    bytes.into_inner()
}

/// A city of 4 bundles in its finest level, and two coarser levels.
pub(crate) fn city() -> &'static [u8] {
    static CITY: OnceLock<Vec<u8>> = OnceLock::new();
    // Set the frame: trying both takes the baker as long as a small bake.
    CITY.get_or_init(|| coded_city(4096, 3, FrameChoice::Light))
}

/// A city of 64 bundles in its finest level, and three coarser levels.
pub(crate) fn large_city() -> &'static [u8] {
    static CITY: OnceLock<Vec<u8>> = OnceLock::new();
    CITY.get_or_init(|| coded_city(16_384, 4, FrameChoice::Auto))
}

pub(crate) type Point = ([f64; 3], Option<[f64; 3]>);

/// Points in and around a file's grid, half of them on surfaces.
pub(crate) fn points(file: &ShadowFile, count: usize, seed: u64) -> Vec<Point> {
    let mut random = Random::new(seed, 0);
    (0..count)
        .map(|i| {
            let at = file.grid.size.map(|n| (1.1 * random.unit() - 0.05) * f64::from(n));
            let normal = [0; 3].map(|_| random.unit() - 0.5);
            let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
            (file.grid.to_world(at), (i % 2 == 0).then(|| normal.map(|c| c / length)))
        })
        .collect()
}

/// Checks that each answer of a stream equals that of the level that it names. Returns how many answers each
/// level gave.
pub(crate) fn compare(streamer: &Streamer, file: &ShadowFile, points: &[Point], filter: Filter) -> Vec<u32> {
    let levels: Vec<_> = (0..file.level_count()).map(|n| file.level(n).unwrap().sampler(filter)).collect();
    let mut counts = vec![0; levels.len()];
    let sampler = streamer.sampler(filter).expect("an open file");
    for &(p_world, normal) in points {
        let answer = sampler.look_up(streamer.words(), p_world, normal);
        let expected = levels[answer.level as usize].visibility(p_world, normal);
        assert_eq!(answer.visibility.to_bits(), expected.to_bits(), "{p_world:?} {normal:?} {answer:?}");
        counts[answer.level as usize] += 1;
    }
    counts
}

pub(crate) fn stream(source: impl ShadowSource + 'static, budget_bytes: u64) -> Streamer {
    Streamer::new(source, StreamOptions { budget_bytes, ..StreamOptions::default() })
}

/// Waits until a stream that cannot settle has faults, and returns them.
pub(crate) fn faults_of(streamer: &mut Streamer, views: &[View]) -> Vec<StreamFault> {
    loop {
        assert!(!streamer.settle(views, Duration::from_millis(20), |_| ()), "there is no fault");
        let faults = streamer.take_faults();
        if !faults.is_empty() {
            return faults;
        }
    }
}

/// A camera over the middle of a file's grid.
pub(crate) fn camera(file: &ShadowFile, [x, y]: [f64; 2], height: f64, forward: [f64; 3]) -> View {
    let [nx, ny, nz] = file.grid.size.map(f64::from);
    let mut eye = file.grid.to_world([x * nx, y * ny, 0.5 * nz]);
    eye[1] = height;
    View::perspective(eye, forward, [0.0, 1.0, 0.0], 60.0, [640, 360])
}
