//! Levels of detail: each is what a bake of its voxel size gives, and files that are written while they are
//! baked are those of a bake in memory.

use std::io::{Cursor, Seek, SeekFrom, Write};

use adumbra::layout::depths::DepthTree;
use adumbra::{Bounds, Encoding, Filter, ShadowFile, Sun};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, Scene, generate};

use super::{Bake, BakeSummary, Choice};
use crate::error::Error;
use crate::options::{BakeOptions, FrameChoice, Size};
use crate::progress::NEVER;

const UP: [f64; 3] = [0.0, 1.0, 0.0];

fn baked(scene: &Scene, options: &BakeOptions) -> ShadowFile {
    Bake::with_options(scene, options).in_memory().expect("a good bake")
}

/// Options for a sun in the south-east, and voxels of this size.
fn options(voxel_size: f64, levels: u32) -> BakeOptions {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    BakeOptions { levels, frame: FrameChoice::Light, ..BakeOptions::new(sun, Size::VoxelSize(voxel_size)) }
}

#[test]
fn level_whose_grid_is_that_of_its_own_bake_has_the_same_bytes() {
    let scene = generate(GeneratedKind::City, 1);
    // 1024 voxels across, and 256 at the second level: in both, the grid ends at multiples of every page.
    // Along the light there is a margin of one voxel of the second level.
    let half = [64.0, 63.5, 64.0];
    let bounds = Some(Bounds { min: half.map(|c| -c), max: half });
    let sun = Sun::from_angles(0.0, 90.0).unwrap();
    let both = baked(&scene, &BakeOptions { sun, bounds, ..options(0.125, 2) });
    let own = baked(&scene, &BakeOptions { sun, bounds, ..options(0.5, 1) });
    assert_eq!((both.level_count(), own.level_count()), (2, 1));
    assert_eq!(own.grid.size, [256; 3]);
    let level = both.level(1).unwrap();
    assert_eq!((level.grid, level.settings), (own.grid, own.settings));
    assert!(level == own && !own.tree.code().is_empty());
    for encoding in [Encoding::Raw, Encoding::Coded] {
        assert_eq!(level.to_bytes(encoding).unwrap(), own.to_bytes(encoding).unwrap());
    }
}

/// Returns the answers at points on the ground of a city.
fn answers(file: &ShadowFile) -> Vec<bool> {
    let mut random = Random::for_batch(5, 0);
    let sampler = file.sampler(Filter::Nearest);
    let mut any = || 160.0 * random.unit() - 80.0;
    (0..40_000).map(|_| sampler.visibility([any(), 0.0, any()], Some(UP)) > 0.5).collect()
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn levels_answer_as_bakes_of_their_voxel_size() {
    let scene = generate(GeneratedKind::City, 1);
    for frame in [FrameChoice::Light, FrameChoice::ObliqueAt(0.3)] {
        let size = 0.25;
        let file = baked(&scene, &BakeOptions { frame, ..options(size, 3) });
        assert_eq!(file.level_count(), 3, "{frame:?}");
        for level in 0..3 {
            let voxel_size = size * f64::from(4_u32.pow(level));
            let own = baked(&scene, &BakeOptions { frame, ..options(voxel_size, 1) });
            let of_file = file.level(level).unwrap();
            assert_eq!(of_file.grid.voxel_size, own.grid.voxel_size);
            let apart = [0, 1, 2].map(|a| of_file.grid.corner[a] - own.grid.corner[a]);
            assert!(apart.iter().all(|c| c.fract() == 0.0), "{frame:?} {level}: {apart:?}");
            let [a, b] = [&of_file, &own].map(answers);
            assert!(a == b && a.contains(&true) && a.contains(&false), "{frame:?} {level}");
        }
    }
}

#[test]
fn levels_of_too_few_texels_are_left_out() {
    let scene = generate(GeneratedKind::Primitives, 1);
    for (resolution, levels, expected) in
        [(512, 3, 1), (1024, 8, 2), (4096, 3, 3), (1024, 2, 2), (1024, 1, 1)]
    {
        let size = Size::Resolution(resolution);
        let file = baked(&scene, &BakeOptions { size, ..options(1.0, levels) });
        assert_eq!(file.level_count(), expected, "{resolution}, {levels}");
        let resolutions: Vec<u32> =
            (0..expected).map(|level| file.level(level).unwrap().settings.resolution).collect();
        let quartered: Vec<u32> = (0..expected).map(|level| resolution as u32 >> (2 * level)).collect();
        assert_eq!(resolutions, quartered);
        assert!(file.level(expected).is_none());
    }
    for levels in [0, 9] {
        let refused = Bake::with_options(&scene, &options(1.0, levels)).in_memory();
        assert!(matches!(refused, Err(Error::Range(_))), "{levels}");
    }
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// Whether a tree has more than one page, so that there is something to link.
fn has_pages(tree: &DepthTree) -> bool {
    tree.page_dims().iter().any(|&n| n > 1) && !tree.common().is_empty()
}

/// Bakes to memory, behind some other bytes.
fn written(scene: &Scene, options: &BakeOptions, threads: usize) -> (BakeSummary, Vec<u8>) {
    let before = b"other bytes";
    let mut out = Cursor::new(Vec::new());
    out.write_all(before).unwrap();
    let written = on_threads(threads, || Bake::with_options(scene, options).write_to(&mut out)).unwrap();
    assert_eq!(out.position(), before.len() as u64 + written.bytes);
    let bytes = out.into_inner();
    assert_eq!(&bytes[..before.len()], before);
    (written, bytes[before.len()..].to_vec())
}

/// Returns the largest memory limit of a few for which a bake keeps pages on disk.
fn limit_that_spills(scene: &Scene, options: &BakeOptions) -> u64 {
    let bake = |max_memory_bytes| {
        let options = BakeOptions { max_memory_bytes, ..options.clone() };
        on_threads(1, || Bake::with_options(scene, &options).in_memory_with_report()).unwrap()
    };
    let (file, report) = bake(None);
    let step = file.tree.code().len() as u64;
    let mut limits = (1..).map(|steps| report.accounted_bytes - steps * step);
    limits.find(|&limit| bake(Some(limit)).1.spilled_bytes > 0).unwrap()
}

#[test]
fn streamed_bake_writes_the_bytes_of_a_bake_in_memory() {
    let scene = generate(GeneratedKind::Landscape, 3);
    // A strip of pages, each a root block of its own, so that many are done before the last.
    let bounds = Some(Bounds { min: [-4.0, -64.0, -64.0], max: [4.0, 64.0, 64.0] });
    let sun = Sun::from_angles(0.0, 90.0).unwrap();
    let options = BakeOptions { sun, bounds, size: Size::Resolution(16_384), ..options(1.0, 2) };
    let limit = limit_that_spills(&scene, &options);
    for encoding in [Encoding::Raw, Encoding::Coded] {
        let options = BakeOptions { encoding, ..options.clone() };
        let file = baked(&scene, &options);
        assert!(file.level_count() == 2 && has_pages(&file.tree));
        let expected = file.to_bytes(encoding).unwrap();
        assert!(ShadowFile::from_bytes(&expected).unwrap() == file);
        for (max_memory_bytes, threads) in [(None, 1), (None, 3), (Some(limit), 1), (Some(limit), 3)] {
            let options = BakeOptions { max_memory_bytes, ..options.clone() };
            let (written, bytes) = written(&scene, &options, threads);
            assert!(
                bytes == expected,
                "{encoding:?}, {max_memory_bytes:?}, {threads}: {} bytes",
                bytes.len()
            );
            assert_eq!((written.grid, written.settings, written.levels), (file.grid, file.settings, 2));
            assert_eq!(written.bytes, expected.len() as u64);
            let report = written.report;
            assert_eq!(report.spilled_bytes > 0, max_memory_bytes.is_some(), "{report:?}");
            assert!(report.accounted_bytes <= max_memory_bytes.unwrap_or(u64::MAX), "{report:?}");
        }
    }
}

/// An output that is full after this many bytes.
struct Full(Cursor<Vec<u8>>, usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if self.0.position() as usize + bytes.len() > self.1 {
            return Err(std::io::ErrorKind::StorageFull.into());
        }
        self.0.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Full {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.0.seek(to)
    }
}

#[test]
fn output_that_is_full_is_an_error() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let options = BakeOptions { size: Size::Resolution(1024), ..options(1.0, 2) };
    let bytes = baked(&scene, &options).to_bytes(options.encoding).unwrap().len();
    for (room, fits) in [(0, false), (300, false), (bytes / 2, false), (bytes - 1, false), (bytes, true)] {
        let mut out = Full(Cursor::new(Vec::new()), room);
        match Bake::with_options(&scene, &options).write_to(&mut out) {
            Ok(written) => assert!(fits && written.bytes == bytes as u64, "{room}"),
            Err(Error::Output(error)) => {
                assert!(!fits && error.kind() == std::io::ErrorKind::StorageFull, "{room}: {error}");
            }
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn settings_differ_between_levels_only_in_the_resolution() {
    let scene = generate(GeneratedKind::City, 1);
    let options = BakeOptions { size: Size::Resolution(4096), ..options(1.0, 3) };
    let choice = Choice::new(&scene, &options, &NEVER).unwrap();
    let all = [0, 1, 2].map(|level| choice.settings(&choice.plan(&scene, level).unwrap()));
    assert!(choice.levels.len() == 3 && all.iter().all(|settings| *settings == all[0]), "{all:?}");
    assert_eq!(all[0], choice.plan(&scene, 0).unwrap().settings);
}

#[test]
fn progress_counts_the_blocks_of_all_levels() {
    use std::sync::Mutex;
    use std::sync::atomic::AtomicBool;

    let scene = generate(GeneratedKind::Primitives, 1);
    let options = BakeOptions { size: Size::Resolution(1024), ..options(1.0, 3) };
    let seen = Mutex::new(Vec::new());
    let cancel = AtomicBool::new(false);
    let progress = |p: crate::Progress| seen.lock().unwrap().push((p.done, p.total));
    let bake = Bake::with_options(&scene, &options).on_progress(progress).cancel(&cancel);
    let (_, report) = on_threads(1, || bake.in_memory_with_report()).unwrap();
    drop(bake);
    let seen = seen.into_inner().unwrap();
    let expected: Vec<(usize, usize)> =
        (1..=report.root_blocks).map(|done| (done, report.root_blocks)).collect();
    assert_eq!(seen, expected);
}
