use std::path::PathBuf;
use std::sync::Arc;

use proptest::prelude::*;

use crate::error::Error;
use crate::store::paged::*;
use adumbra::IoError;

#[derive(Clone, Debug)]
enum Step {
    Extend(Vec<u32>),
    Read(usize, usize),
    Shrink(u64),
}

fn step() -> impl Strategy<Value = Step> {
    let words = || prop::collection::vec(any::<u32>(), 1..40);
    prop_oneof![
        8 => prop::collection::vec(any::<u32>(), 0..6000).prop_map(Step::Extend),
        8 => words().prop_map(Step::Extend),
        8 => (any::<usize>(), 1..40_usize).prop_map(|(at, count)| Step::Read(at, count)),
        1 => (0..40_u64).prop_map(Step::Shrink),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn paged_vectors_hold_what_vectors_hold(steps in prop::collection::vec(step(), 1..120)) {
        let spill = Arc::new(Spill::new(40 * PAGE_BYTES as u64, std::env::temp_dir()));
        // The words, and their low halves, share the room.
        let mut wide = PagedVec::new(Some(&spill));
        let mut narrow = PagedVec::new(Some(&spill));
        let mut model: Vec<u32> = Vec::new();
        for step in steps {
            match step {
                Step::Extend(words) => {
                    wide.extend_from_slice(&words);
                    narrow.extend_from_slice(&words.iter().map(|&w| w as u16).collect::<Vec<_>>());
                    model.extend(words);
                }
                Step::Read(at, count) if count <= model.len() => {
                    let at = at % (model.len() - count + 1);
                    let expected = &model[at..at + count];
                    prop_assert!(wide.with::<40, _>(at, |_| count, |words| words == expected));
                    prop_assert!(narrow.with::<1, _>(at, |_| 1, |halves| halves == [expected[0] as u16]));
                }
                Step::Shrink(pages) => spill.shrink_to(pages * PAGE_BYTES as u64),
                Step::Read(..) => {}
            }
            prop_assert_eq!((wide.len(), narrow.len()), (model.len(), model.len()));
        }
        prop_assert!(spill.resident_bytes() <= 40 * PAGE_BYTES as u64);
        prop_assert_eq!(spill.spilled_bytes() > 0, spill.resident_bytes() < total_bytes(model.len()));
        for (at, &word) in model.iter().enumerate() {
            prop_assert!(narrow.with::<1, _>(at, |_| 1, |found| found == [word as u16]));
            prop_assert!(wide.with::<1, _>(at, |_| 1, |found| found == [word]));
        }
        prop_assert!(spill.check().is_ok());
        drop((narrow, wide));
        prop_assert_eq!(spill.resident_bytes(), 0);
    }
}

fn total_bytes(words: usize) -> u64 {
    ((4 * words).next_multiple_of(PAGE_BYTES) + (2 * words).next_multiple_of(PAGE_BYTES)) as u64
}

#[test]
#[ignore = "slow: real scenes"]
fn paged_vectors_are_shared_by_threads() {
    let spill = Arc::new(Spill::new(0, std::env::temp_dir()));
    let vectors: Vec<PagedVec<u32>> = std::thread::scope(|scope| {
        let fill = |seed: u32| {
            let mut words = PagedVec::new(Some(&spill));
            (0..40_000).for_each(|i| words.extend_from_slice(&[i * seed]));
            words
        };
        let threads: Vec<_> = (1..4).map(|seed| scope.spawn(move || fill(seed))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(spill.resident_bytes() <= Spill::MIN_BYTES && spill.spilled_bytes() > 0);
    for (seed, words) in (1..).zip(vectors) {
        for i in 0..40_000 {
            assert!(words.with::<1, _>(i, |_| 1, |found| found == [i as u32 * seed]), "{seed}");
        }
    }
}

#[test]
fn spill_that_cannot_write_says_so_and_goes_on() {
    let folder = PathBuf::from("/nonexistent/adumbra");
    let spill = Arc::new(Spill::new(0, folder.clone()));
    let mut words = PagedVec::new(Some(&spill));
    words.extend_from_slice(&[7_u32; 100]);
    assert!(spill.check().is_ok());
    (0..100_000).for_each(|i| words.extend_from_slice(&[i]));
    assert_eq!((words.len(), words.with::<1, _>(3, |_| 1, |found| found[0])), (100_100, 0));
    let Err(Error::Spill(IoError { path, source, .. })) = spill.check() else { panic!("no error") };
    assert_eq!((path, source.kind()), (folder, std::io::ErrorKind::NotFound));
    assert!(spill.check().is_err());
}
