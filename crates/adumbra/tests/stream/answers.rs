//! Answers equal the file's where its pages are resident, and a coarser level's where they are not.

use std::collections::HashSet;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use adumbra::gpu::LookUp;
use adumbra::layout::depths::{ABSENT, UNIFORM};
use adumbra::stream::{
    BytesSource, FileSource, Request, Resident, ShadowSource, SourceError, StreamError, StreamOptions,
    Streamer, View,
};
use adumbra::{Filter, ShadowFile};
use adumbra_scene::random::Random;
use adumbra_testing::{named_vectors, placements, vectors};

use crate::kit::{LIMIT, camera, city, compare, faults_of, large_city, points, stream};

#[test]
fn resident_file_matches_look_ups_bit_for_bit() {
    for (name, bytes) in named_vectors("valid", 15) {
        let file = ShadowFile::from_bytes(&bytes).unwrap();
        let mut streamer = stream(BytesSource(bytes), 16 << 20);
        assert!(streamer.settle(&[View::everything()], LIMIT, |_| ()), "{name}: {:?}", streamer.counts());
        for filter in Filter::ALL {
            let counts = compare(&streamer, &file, &points(&file, 4000, 1), filter);
            assert_eq!(counts[0], 4000, "{name}: {counts:?}");
        }
        assert!(streamer.take_faults().is_empty());
    }
}

#[test]
fn settled_stream_answers_from_coarsest_sufficient_level() {
    let bytes = std::fs::read(vectors("valid/levels_depths.adumbra")).unwrap();
    let file = ShadowFile::from_bytes(&bytes).unwrap();
    let points = points(&file, 1000, 14);
    let mut streamer = stream(BytesSource(bytes), 16 << 20);
    // The levels' texels are 0.25, 1 and 4 large.
    for (pixel_world, level) in [(5.0, 2_usize), (2.0, 1), (0.5, 0)] {
        let view = View { pixel_world, ..View::everything() };
        assert!(streamer.settle(&[view], LIMIT, |_| ()), "{pixel_world}: {:?}", streamer.counts());
        let counts = compare(&streamer, &file, &points, Filter::Box5);
        // Outside the grid the finest level answers.
        let coarser = counts[level + 1..].iter().sum::<u32>();
        assert!(counts[level] > 500 && coarser == 0, "{pixel_world}: {counts:?}");
    }
}

#[test]
fn resident_city_has_tables_as_fine_as_its_file() {
    let file = ShadowFile::from_bytes(city()).unwrap();
    let mut streamer = stream(BytesSource(city()), 64 << 20);
    assert!(streamer.settle(&[View::everything()], LIMIT, |_| ()));
    assert_eq!(compare(&streamer, &file, &points(&file, 20_000, 2), Filter::Box5)[0], 20_000);
    let counts = streamer.counts();
    // The first request may reach into bundles that are requested later.
    assert!(counts.bytes <= city().len() as u64 + (1 << 16), "{counts:?}");
    // The tables are as fine as the file's, so a look-up reads as many words.
    let levels = streamer.parameters(&LookUp::default(), file.grid.origin()).unwrap();
    for (number, parameters) in (0..).zip(&levels) {
        assert_eq!(parameters.root_level, file.level(number).unwrap().tree.root_level());
    }
    let top = file.tree.top();
    let table = &streamer.words()[levels[0].table_offset as usize..][..2 * top.len()];
    assert!(table.iter().all(|&word| word != ABSENT));
    let is_uniform = |block: &[u32; 2]| block[0] == UNIFORM;
    assert_eq!(
        table.as_chunks().0.iter().filter(|b| is_uniform(b)).count(),
        top.iter().filter(|b| is_uniform(b)).count()
    );
}

#[test]
fn texture_headers_differ_from_the_files_only_in_words_and_levels() {
    let file = ShadowFile::from_bytes(city()).unwrap();
    let options = StreamOptions { reserved_words: 896, ..StreamOptions::default() };
    let mut streamer = Streamer::new(BytesSource(city()), options);
    assert!(streamer.settle(&[], LIMIT, |_| ()));
    let look_up = LookUp::default();
    let headers = streamer.resident().texture_headers(&look_up).unwrap();
    let whole = file.gpu().texture(&look_up, 8192).unwrap();
    assert_eq!(headers.len(), 3 * 512);
    let word = |bytes: &[u8], i: usize| u32::from_le_bytes([0, 1, 2, 3].map(|b| bytes[4 * i + b]));
    let differs: Vec<usize> = (0..128).filter(|&i| word(&headers, i) != word(whole.header(), i)).collect();
    // These words differ: the number of words after the header, the number of coarser levels, and in the
    // parameters the places of table and code, the coarser levels, and whether pages may be absent.
    assert_eq!(differs, [3, 7, 16 + 76, 16 + 77, 16 + 78, 16 + 79]);
    let coarser: Vec<u32> = (0..3).map(|level| word(&headers, 128 * level + 7)).collect();
    assert_eq!(coarser, [2, 1, 0]);
    assert_eq!(word(&headers, 16 + 76), 896);
}

#[test]
fn placed_stream_matches_placed_file() {
    let file = ShadowFile::from_bytes(city()).unwrap();
    let options = StreamOptions { reserved_words: 896, budget_bytes: 64 << 20, ..StreamOptions::default() };
    let mut streamer = Streamer::new(BytesSource(city()), options);
    assert!(streamer.settle(&[View::everything()], LIMIT, |_| ()));
    let sampler = streamer.sampler(Filter::Box5).unwrap();
    let points = points(&file, 500, 3);
    let places = |header: &[u8]| [&header[16..28], &header[32..44], &header[64..64 + 272]].concat();
    for (place, placement) in placements() {
        let placed = sampler.clone().placed(&placement);
        let of_file = file.sampler(Filter::Box5).placed(&placement);
        for (p_file, normal) in &points {
            let p_world = placement.to_world(*p_file);
            let normal = normal.map(|n| placement.direction_to_world(n));
            let found = placed.look_up(streamer.words(), p_world, normal);
            assert_eq!(found.visibility, of_file.visibility(p_world, normal), "{place}: {p_world:?}");
        }
        let twice = placed.placed(&placement);
        let (p_file, normal) = points[0];
        let p_world = placement.to_world(placement.to_world(p_file));
        let normal = normal.map(|n| placement.direction_to_world(placement.direction_to_world(n)));
        let found = twice.look_up(streamer.words(), p_world, normal);
        assert_eq!(found.visibility, file.sampler(Filter::Box5).visibility(p_file, points[0].1), "{place}");
        let look_up = LookUp { placement, ..LookUp::default() };
        let headers = streamer.resident().texture_headers(&look_up).unwrap();
        assert_eq!(places(&headers), places(&file.gpu().texture_header(&look_up).unwrap()), "{place}");
    }
}

#[test]
fn first_answers_take_two_requests_and_little_of_the_file() {
    let mut resident = Resident::new(StreamOptions::default());
    let source = BytesSource(city());
    let mut requests = 0;
    while !resident.is_open() {
        let request = resident.next_request().expect("a request");
        requests += 1;
        resident.deliver(request.run(&source));
    }
    let counts = resident.counts();
    assert!(requests <= 2, "{requests} requests");
    assert!(counts.bytes * 100 <= 3 * counts.file_bytes || counts.bytes <= 1 << 16, "{counts:?}");
}

#[test]
#[ignore = "slow: bakes a large city"]
fn camera_loads_visible_detail_and_little_else() {
    let file = ShadowFile::from_bytes(large_city()).unwrap();
    let view = camera(&file, [0.5, 0.5], 1.7, [1.0, 0.0, 0.2]);
    let mut streamer = stream(BytesSource(large_city()), 64 << 20);
    assert!(streamer.settle(std::slice::from_ref(&view), LIMIT, |_| ()));
    let counts = streamer.counts();
    assert!(counts.bytes < counts.file_bytes / 2, "{counts:?}");
    // No visible point is answered by a level with texels larger than the camera's pixels, unless it is the
    // finest.
    let sampler = streamer.sampler(Filter::Box5).unwrap();
    let (mut seen, mut finest) = (0, 0);
    for (p, normal) in points(&file, 400_000, 3) {
        let rest = |a: usize| p[a] - view.position_world[a];
        let distance = (0..3).map(|a| rest(a) * rest(a)).sum::<f64>().sqrt();
        let is_seen = view.planes.iter().all(|n| n[0] * p[0] + n[1] * p[1] + n[2] * p[2] + n[3] >= 0.0);
        let at = file.grid.to_grid(p);
        let is_inside = (0..3).all(|a| at[a] >= 0.0 && at[a] < f64::from(file.grid.size[a]));
        if !is_seen || !is_inside {
            continue;
        }
        seen += 1;
        let answer = sampler.look_up(streamer.words(), p, normal);
        let texel = file.level(answer.level).unwrap().grid.voxel_size;
        let pixel = view.pixel_per_distance * distance;
        finest += u32::from(answer.level == 0);
        // Before the nearest depth of a bundle everything is lit, at any level.
        assert!(answer.level == 0 || texel <= pixel || answer.visibility == 1.0, "{p:?} {answer:?} {pixel}");
    }
    assert!(seen > 1000 && finest > 100, "{finest} of {seen}");
}

#[test]
#[ignore = "slow: bakes a large city"]
fn small_budgets_answer_from_coarser_levels() {
    let file = ShadowFile::from_bytes(large_city()).unwrap();
    let points = points(&file, 20_000, 4);
    for (budget, filter) in [(1 << 20, Filter::Nearest), (3 << 20, Filter::Box5), (6 << 20, Filter::Box17)] {
        let mut streamer = stream(BytesSource(large_city()), budget);
        let view = camera(&file, [0.4, 0.6], 3.0, [0.3, -0.1, 1.0]);
        assert!(streamer.settle(&[view], LIMIT, |_| ()), "{budget}: {:?}", streamer.counts());
        let counts = compare(&streamer, &file, &points, filter);
        assert!(counts[1..].iter().sum::<u32>() > 0, "{budget}: {counts:?}");
        assert!(streamer.counts().resident_bytes <= budget);
    }
}

#[test]
fn rejects_budget_below_the_coarsest_level() {
    let mut streamer = stream(BytesSource(city()), 4096);
    let faults = faults_of(&mut streamer, &[View::everything()]);
    assert!(
        matches!(faults[..], [ref fault] if matches!(fault.error, StreamError::Budget { budget: 4096, .. }))
    );
    assert!(faults[0].to_string().contains("--levels") && faults[0].retry_in.is_none(), "{}", faults[0]);
}

/// A source that has a fault after some reads.
struct Unreliable {
    bytes: Mutex<Vec<u8>>,
    /// Reads before the fault.
    left: AtomicU64,
    fault: Fault,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    Drop,
    Short,
    /// Bytes of another place.
    WrongRange,
    FlippedBit,
    Changed,
}

impl ShadowSource for Unreliable {
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError> {
        let bytes = self.bytes.lock().unwrap();
        let length = bytes.len() as u64;
        let part = |range: Range<u64>| bytes[range.start as usize..range.end.min(length) as usize].to_vec();
        let is_fine =
            self.left.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |n| n.checked_sub(1)).is_ok();
        if is_fine {
            return Ok(part(range));
        }
        match self.fault {
            Fault::Drop => Err(std::io::Error::other("the connection was closed").into()),
            Fault::Short => Ok(part(range.start..range.start + (range.end - range.start) / 100)),
            Fault::WrongRange => Ok(part(range.start - 1000..range.end - 1000)),
            Fault::FlippedBit => {
                let mut found = part(range);
                let at = found.len() / 64;
                found[at] ^= 16;
                Ok(found)
            }
            Fault::Changed => Err(SourceError::Changed),
        }
    }
}

#[test]
fn faults_are_reported_coarser_level_answers_and_retry_works() {
    let file = ShadowFile::from_bytes(city()).unwrap();
    let points = points(&file, 5000, 5);
    let view = [View::everything()];
    for fault in [Fault::Drop, Fault::Short, Fault::WrongRange, Fault::FlippedBit, Fault::Changed] {
        for good in [1, 2, 4] {
            let source = Arc::new(Unreliable {
                bytes: Mutex::new(city().to_vec()),
                left: AtomicU64::new(good),
                fault,
            });
            let mut streamer = stream(Arc::clone(&source), 64 << 20);
            let faults = faults_of(&mut streamer, &view);
            let answered = compare(&streamer, &file, &points, Filter::Box5);
            assert!(answered[1..].iter().sum::<u32>() > 0, "{fault:?}: {answered:?}");
            let named = faults.iter().all(|f| f.part.contains("level") && f.to_string().contains(&f.part));
            assert!(!faults.is_empty() && named, "{fault:?}: {faults:?}");
            assert_eq!(faults.iter().any(|f| f.retry_in.is_none()), fault == Fault::Changed, "{faults:?}");
            // A retry loads the missing parts.
            source.left.store(u64::MAX, Ordering::SeqCst);
            streamer.retry();
            assert!(streamer.settle(&view, LIMIT, |_| ()), "{fault:?}: {:?}", streamer.counts());
            assert_eq!(compare(&streamer, &file, &points, Filter::Box5)[0], 5000);
        }
    }
}

#[test]
fn failed_parts_are_requested_again_only_after_a_delay() {
    let source = BytesSource(city().to_vec());
    let view = [View::everything()];
    for is_changed in [false, true] {
        let mut resident =
            Resident::new(StreamOptions { budget_bytes: 64 << 20, ..StreamOptions::default() });
        while !resident.is_open() {
            let request = resident.next_request().unwrap();
            resident.deliver(request.run(&source));
        }
        // All requests at second 0 fail, including those that are under way at the same time.
        resident.update(&view, Duration::ZERO);
        let mut count = 0;
        loop {
            let asked: Vec<Request> = std::iter::from_fn(|| resident.next_request()).collect();
            if asked.is_empty() {
                break;
            }
            assert!(count < 1000, "it asks without end");
            for request in asked {
                count += 1;
                let lost = std::io::Error::other("the connection was closed").into();
                resident.deliver(request.answer(Err(if is_changed { SourceError::Changed } else { lost })));
            }
        }
        let faults = resident.take_faults();
        let waits: Vec<_> = faults.iter().map(|fault| fault.retry_in).collect();
        let again = (!is_changed).then_some(Duration::from_secs(1));
        assert!(
            count > 1 && !waits.is_empty() && waits.iter().all(|wait| *wait == again),
            "{count}: {faults:?}"
        );
        assert!(!is_changed || faults.len() == 1, "{faults:?}");
        let mut asks_at = |seconds: f64| {
            resident.update(&view, Duration::from_secs_f64(seconds));
            resident.next_request().is_some()
        };
        assert!(!asks_at(0.9));
        assert_eq!((asks_at(1.0), asks_at(100.0)), (!is_changed, !is_changed));
        resident.retry();
        assert!(!is_changed || resident.next_request().is_some());
    }
}

#[test]
fn damaged_beginning_is_reported_and_retry_works() {
    for (fault, good) in [(Fault::Drop, 0), (Fault::FlippedBit, 0), (Fault::Short, 0)] {
        let bytes = Mutex::new(city().to_vec());
        let source = Arc::new(Unreliable { bytes, left: AtomicU64::new(good), fault });
        let mut streamer = stream(Arc::clone(&source), 64 << 20);
        let faults = faults_of(&mut streamer, &[]);
        assert!(!streamer.is_open() && streamer.sampler(Filter::Box5).is_none());
        assert!(faults.iter().all(|f| f.part == "beginning") && !faults.is_empty(), "{fault:?}: {faults:?}");
        source.left.store(u64::MAX, Ordering::SeqCst);
        streamer.retry();
        assert!(streamer.settle(&[], LIMIT, |_| ()), "{fault:?}");
    }
}

#[test]
fn overwritten_file_is_reported_as_changed() {
    let folder = std::env::temp_dir().join(format!("adumbra-stream-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("city.adumbra");
    std::fs::write(&path, city()).unwrap();
    let file = ShadowFile::read(&path).unwrap();
    let mut streamer = stream(FileSource::open(&path).unwrap(), 64 << 20);
    assert!(streamer.settle(&[], LIMIT, |_| ()));
    std::fs::write(&path, &city()[..city().len() - 1]).unwrap();
    let faults = faults_of(&mut streamer, &[View::everything()]);
    assert!(faults.iter().any(|f| f.to_string().contains("has changed")), "{faults:?}");
    let answered = compare(&streamer, &file, &points(&file, 1000, 6), Filter::Box5);
    // Bundles without bytes are resident from the beginning.
    assert!(answered[1] == 0 && answered[2] > 500, "{answered:?}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Moves the camera to random places, with several budgets.
fn jump(city: &'static [u8], budgets: &[u64]) {
    let file = ShadowFile::from_bytes(city).unwrap();
    let points = points(&file, 200, 8);
    let mut random = Random::new(9, 0);
    for &budget in budgets {
        let mut streamer = stream(BytesSource(city), budget);
        assert!(streamer.settle(&[], LIMIT, |_| ()));
        let own = streamer.counts().resident_bytes;
        for jump in 0..250 {
            let at = [random.unit(), random.unit()];
            let forward = [random.unit() - 0.5, 0.3 * (random.unit() - 0.7), random.unit() - 0.5];
            let views = [camera(&file, at, 1.0 + 60.0 * random.unit(), forward)];
            // Most jumps come before everything is resident.
            if jump % 10 == 9 {
                assert!(streamer.settle(&views, LIMIT, |_| ()), "{budget}: {:?}", streamer.counts());
            } else {
                streamer.update(&views);
                streamer.take_writes(1 << 14);
            }
            let counts = streamer.counts();
            assert!(counts.resident_bytes <= budget, "{counts:?}");
            if jump % 25 == 24 {
                compare(&streamer, &file, &points, Filter::Box5);
                assert_pages_apart(&streamer);
            }
        }
        // Without views, resident bundles stay. Beyond the tables and the coarsest level, only these bundles
        // take words.
        assert!(streamer.settle(&[], LIMIT, |_| ()));
        let counts = streamer.counts();
        assert!(
            counts.resident_bytes >= own && (counts.resident_bundles > 0) == (counts.resident_bytes > own)
        );
        assert!(streamer.take_faults().is_empty());
    }
}

#[test]
fn camera_jumps_leak_no_pool_words() {
    let mut whole = stream(BytesSource(city()), 64 << 20);
    assert!(whole.settle(&[], LIMIT, |_| ()));
    let least = whole.counts().resident_bytes;
    assert!(whole.settle(&[View::everything()], LIMIT, |_| ()));
    let most = whole.counts().resident_bytes;
    jump(city(), &[least + (most - least) / 2, 64 << 20]);
}

#[test]
#[ignore = "slow: bakes a large city"]
fn camera_jumps_in_a_large_city_leak_no_pool_words() {
    jump(large_city(), &[1 << 20, 2 << 20, 5 << 20, 64 << 20]);
}

/// Checks that no two blocks at the level of pages, whose shapes are in pages, have the same address.
fn assert_pages_apart(streamer: &Streamer) {
    let look_up = LookUp::default();
    let mut begun = HashSet::new();
    for parameters in streamer.parameters(&look_up, [0.0; 3]).unwrap() {
        if parameters.root_level != 9 {
            continue;
        }
        let blocks = parameters.root_count[0] * parameters.root_count[1];
        let table = &streamer.words()[parameters.table_offset as usize..][..2 * blocks as usize];
        for &[at, _] in table.as_chunks().0 {
            let word = parameters.code_offset + at / 2;
            let is_in_page = at < ABSENT && word >= streamer.resident().first_page_word().unwrap();
            assert!(!is_in_page || begun.insert(word), "word {word} belongs to two pages");
        }
    }
}
