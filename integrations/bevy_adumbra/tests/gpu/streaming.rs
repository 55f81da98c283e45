//! Streamed files: pictures when everything is resident, within a small budget, and after faults.

use std::io::Cursor;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use adumbra::stream::{BytesSource, ShadowSource, SourceError, StreamCounts, StreamError};
use adumbra::{Encoding, Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, generate};
use adumbra_testing::full;
use bevy::diagnostic::{DiagnosticPath, DiagnosticsStore};
use bevy::prelude::*;
use bevy_adumbra::StreamDiagnostics;
use bevy_adumbra::prelude::*;

use crate::stage::{MIDDLE, Stage, assert_alike, baked, expected, towards_sun};

/// Bytes of a city of 64 bundles in its finest level, and three coarser levels.
fn city() -> &'static [u8] {
    static CITY: OnceLock<Vec<u8>> = OnceLock::new();
    CITY.get_or_init(|| {
        let sun = Sun::from_direction(towards_sun()).unwrap();
        let options = BakeOptions::new(sun, Size::Resolution(16_384)).with(|o| {
            o.levels = 4;
            o.frame = FrameChoice::Oblique;
        });
        let file = Bake::with_options(&generate(GeneratedKind::City, 1), &options).in_memory().unwrap();
        let mut bytes = Cursor::new(Vec::new());
        file.write_to(&mut bytes, Encoding::Coded).unwrap();
        bytes.into_inner()
    })
}

fn in_memory() -> StreamSource {
    StreamSource::ranges(BytesSource(city()))
}

impl Stage {
    fn stream(&mut self, source: impl Into<StreamSource>) {
        let light = self.light;
        self.app.world_mut().entity_mut(light).insert(BakedShadow::streamed(source));
    }

    fn budget(&mut self) -> Mut<'_, StreamBudget> {
        self.app.world_mut().resource_mut()
    }

    /// Waits until all needed data is resident. At least one frame passes, in which changed lights and
    /// budgets are seen.
    fn settle(&mut self) {
        self.update();
        self.wait_for(|stage| stage.app.world().resource::<ShadowStreams>().is_settled());
    }

    fn counts(&self, source: &StreamSource) -> StreamCounts {
        self.app.world().resource::<ShadowStreams>().counts(source).expect("a source that a light names")
    }

    fn shadow(&mut self) -> Mut<'_, BakedShadow> {
        let light = self.light;
        self.app.world_mut().get_mut(light).expect("a light with files")
    }

    fn measured(&self, path: &DiagnosticPath) -> f64 {
        let store = self.app.world().resource::<DiagnosticsStore>();
        store.get_measurement(path).map_or(0.0, |measurement| measurement.value)
    }

    fn drawn(&mut self) -> Vec<u8> {
        let picture = self.picture.clone();
        self.draw(&picture)
    }

    fn put_glass(&mut self) -> Entity {
        let world = self.app.world_mut();
        let ball = world.resource_mut::<Assets<Mesh>>().add(Sphere::new(0.2));
        let glass = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial { specular_transmission: 0.9, ..default() });
        let at = Transform::from_translation(MIDDLE + 3.0 * Vec3::Y);
        world.spawn((Mesh3d(ball), MeshMaterial3d(glass), bevy::light::NotShadowCaster, at)).id()
    }
}

/// Ways in which a light's files are looked up.
const LOOKS: [fn(&mut BakedShadow); 3] =
    [|_| (), |shadow| shadow.filter = ShadowFilter::Nearest, |shadow| shadow.sun_degrees = Some(1.5)];

/// Returns a picture for each of the looks, and one beside glass, where words are below a picture.
fn pictures(stage: &mut Stage, looks: &[fn(&mut BakedShadow)]) -> Vec<Vec<u8>> {
    let before = stage.shadow().clone();
    let mut all = Vec::new();
    for look in looks {
        look(&mut stage.shadow());
        all.push(stage.drawn());
        *stage.shadow() = before.clone();
    }
    let glass = stage.put_glass();
    all.push(stage.drawn());
    stage.app.world_mut().despawn(glass);
    all
}

#[test]
#[ignore = "slow: draws many frames"]
fn a_resident_stream_draws_bit_for_bit_what_its_file_draws() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.adumbra");
    std::fs::write(&path, city()).unwrap();
    let mut stage = Stage::with_assets(&folder.path().to_string_lossy());
    stage.budget().detail_pixels = 0.0;
    let file = ShadowFile::from_bytes(city()).unwrap();
    stage.give(file.clone(), |_| {});
    let mut whole = pictures(&mut stage, &LOOKS);
    let sources = [in_memory(), StreamSource::from("city.adumbra"), StreamSource::from(path.as_path())];
    for (source, looks) in sources.into_iter().zip([&LOOKS[..], &[], &[]]) {
        stage.stream(source.clone());
        stage.settle();
        assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 }, "{source}");
        let counts = stage.counts(&source);
        assert!(counts.missing_bundles == 0 && counts.bytes >= counts.file_bytes * 9 / 10, "{counts:?}");
        assert!(counts.bytes <= counts.file_bytes + (1 << 16), "{counts:?}");
        let found = pictures(&mut stage, looks);
        // The last picture is that beside glass.
        for (n, (found, whole)) in found.iter().rev().zip(whole.iter().rev()).enumerate() {
            let differs = found.chunks(8).zip(whole.chunks(8)).filter(|(a, b)| a != b).count();
            assert_eq!(differs, 0, "pixels of picture {n} from the end, {source}");
        }
        whole.drain(..whole.len() - 1);
    }
    assert_alike(&stage.visibility(), &expected(&file, Filter::Box5), Filter::Box5);
}

/// Pages that arrive are also written to the texture of views with glass.
#[test]
#[ignore = "slow: draws many frames"]
fn pages_that_arrive_beside_glass_are_drawn() {
    let mut stage = Stage::new(|_| {});
    stage.put_glass();
    stage.budget().detail_pixels = 1e6;
    stage.stream(in_memory());
    stage.settle();
    let coarse = stage.drawn();
    // The files in use do not change, so the existing texture is written page by page.
    let away = Transform::from_translation(MIDDLE + 1e5 * Vec3::X).looking_at(MIDDLE, Vec3::Y);
    let here = *stage.app.world().get::<Transform>(stage.camera).unwrap();
    let camera = stage.camera;
    *stage.app.world_mut().get_mut::<Transform>(camera).unwrap() = away;
    stage.budget().detail_pixels = 0.1;
    stage.settle();
    *stage.app.world_mut().get_mut::<Transform>(camera).unwrap() = here;
    stage.settle();
    let fine = stage.drawn();
    stage.give(ShadowFile::from_bytes(city()).unwrap(), |_| {});
    let whole = stage.drawn();
    assert!(coarse != whole);
    assert!(fine == whole);
}

#[test]
#[ignore = "slow: draws many frames"]
fn budgets_hold_while_cameras_jump() {
    let file = ShadowFile::from_bytes(city()).unwrap();
    let mut stage = Stage::new(|_| {});
    let upload = 16 << 10;
    *stage.budget() =
        StreamBudget { bytes: 2 << 20, upload_bytes_per_frame: upload, detail_pixels: 0.25, fade_frames: 3 };
    let source = in_memory();
    stage.stream(source.clone());
    let camera = stage.camera;
    let home = *stage.app.world().get::<Transform>(camera).unwrap();
    // A second camera, which looks elsewhere.
    let picture = crate::stage::picture(
        stage.app.world_mut(),
        UVec2::splat(32),
        bevy::render::render_resource::TextureFormat::Rgba8UnormSrgb,
    );
    let projection = Projection::from(PerspectiveProjection::default());
    let target = bevy::camera::RenderTarget::from(picture);
    let other = stage
        .app
        .world_mut()
        .spawn((Camera3d::default(), Camera { order: 1, ..default() }, target, projection, Msaa::Off))
        .id();
    let mut random = Random::new(4, 0);
    let (mut most, mut written) = (0.0_f64, 0.0);
    let frames = if full() { 300 } else { 100 };
    for jump in 0..frames {
        if jump % 5 == 0 {
            for entity in [camera, other] {
                let mut at = |side: f32| side * (random.unit() as f32 - 0.5);
                let [x, y, z] = [at(300.0), 40.0 + at(60.0), at(300.0)];
                let forward = Vec3::new(at(1.0), -0.6 + at(1.0), at(1.0));
                let transform = Transform::from_xyz(x, y, z).looking_to(forward, Vec3::Y);
                *stage.app.world_mut().get_mut::<Transform>(entity).unwrap() = transform;
            }
        }
        stage.update();
        let counts = stage.counts(&source);
        assert!(counts.resident_bytes <= 2 << 20, "{counts:?}");
        let bytes = stage.measured(&StreamDiagnostics::UPLOAD_BYTES);
        assert!(bytes <= upload as f64, "{bytes}");
        most = most.max(bytes);
        written += bytes;
    }
    println!(
        "{written} bytes written in {frames} frames, {most} in one at most; {:?}",
        stage.counts(&source)
    );
    assert!(most > 0.0 && stage.measured(&StreamDiagnostics::READ_BYTES) > 0.0);
    stage.app.world_mut().despawn(other);
    *stage.app.world_mut().get_mut::<Transform>(camera).unwrap() = home;
    stage.settle();
    let levels: Vec<_> = (0..4).map(|n| expected_of_level(&file, n)).collect();
    assert_from_levels(&stage.visibility(), &levels);
}

#[test]
#[ignore = "slow: draws many frames"]
fn levels_fade_until_the_picture_equals_the_whole_files() {
    let file = ShadowFile::from_bytes(city()).unwrap();
    let levels: Vec<_> = (0..4).map(|n| expected_of_level(&file, n)).collect();
    let mut stage = Stage::new(|_| {});
    stage.budget().detail_pixels = 0.0;
    stage.give(file, |_| {});
    let whole = stage.drawn();
    stage.budget().fade_frames = 48;
    let source = in_memory();
    stage.stream(source.clone());
    stage.update();
    stage.wait_for(|stage| {
        let counts = stage.counts(&source);
        counts.resident_bundles > 0 && counts.missing_bundles == 0
    });
    let found = stage.visibility();
    let is_between = |i: usize| levels.iter().all(|level| (found[i] - level[i]).abs() > 0.02);
    let between = (0..found.len()).filter(|&i| is_between(i)).count();
    assert!(between * 100 > found.len(), "{between} of {} pixels are mixed", found.len());
    stage.settle();
    assert_eq!(stage.drawn(), whole);
}

fn expected_of_level(file: &ShadowFile, level: u32) -> Vec<f32> {
    let level = file.level(level).unwrap();
    let shadow = level.sampler(Filter::Box5);
    crate::stage::expected_by(|p, normal| shadow.visibility(p, normal))
}

/// Checks that pixels have the visibility of some level.
#[track_caller]
fn assert_from_levels(found: &[f32], levels: &[Vec<f32>]) {
    let is_of = |i: usize| levels.iter().any(|level| (found[i] - level[i]).abs() < 0.01);
    let off = (0..found.len()).filter(|&i| !is_of(i)).count();
    assert!(off * 500 <= found.len(), "{off} of {} pixels are of no level", found.len());
}

/// A source that fails after a number of reads.
struct Unreliable {
    left: AtomicU64,
    error: fn() -> SourceError,
}

impl Unreliable {
    fn after(left: u64) -> Arc<Self> {
        let error = || SourceError::Failed("the connection was closed".into());
        Arc::new(Self { left: left.into(), error })
    }
}

impl ShadowSource for Unreliable {
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError> {
        let is_fine =
            self.left.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |n| n.checked_sub(1)).is_ok();
        if is_fine { BytesSource(city()).read(range) } else { Err((self.error)()) }
    }
}

#[test]
#[ignore = "slow: draws many frames"]
fn reports_faults_uses_a_coarser_level_and_recovers_by_retry() {
    let file = ShadowFile::from_bytes(city()).unwrap();
    let levels: Vec<_> = (0..4).map(|n| expected_of_level(&file, n)).collect();
    let mut stage = Stage::new(|_| {});
    stage.budget().detail_pixels = 0.0;
    let changes = Arc::new(AtomicU64::new(0));
    let seen = Arc::clone(&changes);
    stage.app.add_observer(move |change: On<BakedShadowChanged>| {
        if matches!(change.status, BakedShadowStatus::Incomplete { .. }) {
            seen.fetch_add(1, Ordering::SeqCst);
        }
    });
    // The first two reads are the file's beginning.
    let source = Unreliable::after(2);
    stage.stream(source.clone() as Arc<dyn ShadowSource>);
    stage.wait_for(|stage| matches!(stage.status(), BakedShadowStatus::Incomplete { .. }));
    let BakedShadowStatus::Incomplete { files: 1, missing: 0, fault: BakedShadowError::Stream { fault, .. } } =
        stage.status()
    else {
        panic!("{:?}", stage.status());
    };
    assert!(fault.part.contains("level") && fault.retry_in.is_some(), "{fault:?}");
    let text = stage.status().to_string();
    assert!(text.contains(&fault.part) && text.contains("connection was closed"), "{text}");
    assert!(changes.load(Ordering::SeqCst) > 0);
    assert_from_levels(&stage.visibility(), &levels[1..]);
    source.left.store(u64::MAX, Ordering::SeqCst);
    stage.app.world_mut().resource_mut::<ShadowStreams>().retry();
    stage.settle();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
    assert_alike(&stage.visibility(), &levels[0], Filter::Box5);
}

#[test]
#[ignore = "slow: draws many frames"]
fn reports_a_file_that_does_not_open_and_retries_it() {
    let mut stage = Stage::new(|_| {});
    let source = Unreliable::after(0);
    stage.stream(source.clone() as Arc<dyn ShadowSource>);
    stage.wait_for(|stage| matches!(stage.status(), BakedShadowStatus::Unusable(_)));
    let text = stage.status().to_string();
    assert!(text.contains("the beginning is missing"), "{text}");
    source.left.store(u64::MAX, Ordering::SeqCst);
    // The stream requests the file again after a second.
    stage.wait_for(|stage| stage.status() == BakedShadowStatus::Active { files: 1 });
    stage.stream("none.adumbra");
    stage.wait_for(|stage| matches!(stage.status(), BakedShadowStatus::Unusable(_)));
    assert!(stage.status().to_string().contains("none.adumbra"), "{}", stage.status());
    stage.stream(Path::new("/none.adumbra"));
    stage.wait_for(|stage| stage.status().to_string().contains("/none.adumbra"));
}

#[test]
#[ignore = "slow: draws many frames"]
fn retry_reopens_a_file_that_has_changed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.adumbra");
    let half = baked(FrameChoice::Light);
    std::fs::write(&path, city()).unwrap();
    let mut stage = Stage::new(|_| {});
    // The coarsest level is all that is needed.
    stage.budget().detail_pixels = 1e6;
    stage.stream(path.as_path());
    stage.settle();
    std::fs::write(&path, half.to_bytes(Encoding::default()).unwrap()).unwrap();
    // A changed budget reopens the stream. The file on the disk has changed, and replaces the resident data.
    stage.budget().detail_pixels = 0.0;
    stage.settle();
    assert_alike(&stage.visibility(), &expected(&half, Filter::Box5), Filter::Box5);
    let source = Arc::new(Unreliable { left: 2.into(), error: || SourceError::Changed });
    stage.stream(source.clone() as Arc<dyn ShadowSource>);
    let has_changed = |status: &BakedShadowStatus| match status {
        BakedShadowStatus::Incomplete { fault: BakedShadowError::Stream { fault, .. }, .. } => {
            matches!(fault.error, StreamError::Source(SourceError::Changed))
        }
        _ => false,
    };
    stage.wait_for(|stage| has_changed(&stage.status()));
    source.left.store(u64::MAX, Ordering::SeqCst);
    stage.app.world_mut().resource_mut::<ShadowStreams>().retry();
    stage.settle();
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 1 });
}

#[test]
#[ignore = "slow: draws many frames"]
fn reports_too_small_a_budget_and_opens_with_a_larger_one() {
    let mut stage = Stage::new(|_| {});
    stage.budget().bytes = 8192;
    stage.stream(in_memory());
    stage.wait_for(|stage| matches!(stage.status(), BakedShadowStatus::Unusable(_)));
    let text = stage.status().to_string();
    assert!(text.contains("the budget is"), "{text}");
    stage.budget().bytes = 1 << 20;
    stage.wait_for(|stage| stage.status() == BakedShadowStatus::Active { files: 1 });
    let before = stage.drawn();
    // Resident data answers until the file is open with the new budget.
    stage.budget().bytes = 4 << 20;
    for _ in 0..50 {
        stage.update();
        assert!(stage.status().is_active(), "{}", stage.status());
    }
    stage.settle();
    assert_eq!(before.len(), stage.drawn().len());
}

#[test]
fn streamed_and_whole_files_are_in_use_side_by_side() {
    let file = ShadowFile::from_bytes(city()).unwrap();
    let whole = baked(FrameChoice::Oblique);
    let mut stage = Stage::new(|_| {});
    stage.budget().detail_pixels = 0.0;
    stage.give(whole.clone(), |_| {});
    stage.update();
    stage.shadow().streams.push(in_memory());
    stage.settle();
    stage.update();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 2 });
    // Both files contain the point, and the first one is looked up.
    let found = stage.visibility();
    let levels = [expected(&whole, Filter::Box5), expected_of_level(&file, 0)];
    assert_from_levels(&found, &levels);
    // The whole file is removed, and the texture is recreated from memory.
    stage.shadow().files.clear();
    assert_alike(&stage.visibility(), &levels[1], Filter::Box5);
    stage.shadow().streams.clear();
    stage.update();
    assert!(matches!(stage.status(), BakedShadowStatus::Unusable(BakedShadowError::NoFiles)));
}

/// Prints the median and the largest time of the system in the main world over 500 frames of a flight, and
/// the bytes that a frame writes. `ADUMBRA_STREAM_FILE` names another file to use.
#[test]
#[ignore = "slow: draws many frames"]
fn frames_of_a_flight_write_within_the_budget() {
    let mut stage = Stage::new(|_| {});
    let other = std::env::var("ADUMBRA_STREAM_FILE").ok();
    match &other {
        Some(path) => stage.stream(Path::new(path)),
        None => stage.stream(in_memory()),
    }
    let camera = stage.camera;
    let world = stage.app.world_mut();
    world.entity_mut(camera).insert(Projection::from(PerspectiveProjection { far: 5000.0, ..default() }));
    let (mut times, mut most) = (Vec::new(), 0.0_f64);
    let frames = if full() { 500 } else { 150 };
    for frame in 0..frames {
        let at = Vec3::new(0.8 * frame as f32 - 200.0, 12.0, 40.0);
        let transform = Transform::from_translation(at).looking_to(Vec3::new(1.0, -0.2, 0.3), Vec3::Y);
        *stage.app.world_mut().get_mut::<Transform>(camera).unwrap() = transform;
        stage.update();
        times.push(stage.measured(&StreamDiagnostics::MAIN_TIME));
        most = most.max(stage.measured(&StreamDiagnostics::UPLOAD_BYTES));
    }
    let slow: Vec<_> = times.iter().enumerate().filter(|(_, time)| **time > 1.0).collect();
    println!("frames of more than a millisecond: {slow:?}");
    times.sort_by(f64::total_cmp);
    let [median, late, longest] = [frames / 2, frames * 19 / 20, frames - 1].map(|i| times[i]);
    println!(
        "{median:.3} ms in the median, {late:.3} in 95 % of frames, {longest:.3} at most; {most} bytes written at most"
    );
    assert!(most <= (256 << 10) as f64, "{most}");
}
