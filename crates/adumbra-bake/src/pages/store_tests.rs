//! Pages that are kept, in memory or on disk.

use std::path::PathBuf;
use std::sync::Arc;

use adumbra::IoError;
use proptest::prelude::*;

use super::{PageStore, Spill};
use crate::error::Error;

/// Room for pages in bytes.
const ROOM: u64 = 20_000;

#[derive(Clone, Debug)]
enum Operation {
    Add(u32, Vec<u32>),
    Get(prop::sample::Index),
    Forget(prop::sample::Index),
    Limit(u64),
}

fn step() -> impl Strategy<Value = Operation> {
    prop_oneof![
        8 => (any::<u32>(), prop::collection::vec(any::<u32>(), 1..2000)).prop_map(|(root, w)| Operation::Add(root, w)),
        8 => any::<prop::sample::Index>().prop_map(Operation::Get),
        2 => any::<prop::sample::Index>().prop_map(Operation::Forget),
        1 => (0..ROOM).prop_map(Operation::Limit),
    ]
}

fn bytes(pages: &[Option<(u32, Vec<u32>)>]) -> u64 {
    pages.iter().flatten().map(|(_, words)| 4 * words.len() as u64).sum()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn stores_hold_the_pages_that_were_added(steps in prop::collection::vec(step(), 1..80)) {
        let spill = Arc::new(Spill::new(ROOM, std::env::temp_dir()));
        // Both share the room.
        let stores = [(); 2].map(|()| PageStore::new(Arc::clone(&spill)));
        let mut models = [const { Vec::<Option<(u32, Vec<u32>)>>::new() }; 2];
        let (mut room, mut added, mut which) = (ROOM, [0; 2], 0);
        for step in steps {
            which = 1 - which;
            let (store, model) = (&stores[which], &mut models[which]);
            match step {
                Operation::Add(root, words) => {
                    added[which] += 2 * words.len() as u64;
                    prop_assert_eq!(store.add(root, words.clone()) as usize, model.len());
                    model.push(Some((root, words)));
                }
                Operation::Get(at) if !model.is_empty() => {
                    let at = at.index(model.len());
                    let found = store.get(at as u32).map(|(words, root)| (root, words.to_vec()));
                    prop_assert_eq!(&found, &model[at]);
                }
                Operation::Forget(at) if !model.is_empty() => {
                    let at = at.index(model.len());
                    store.forget(at as u32);
                    model[at] = None;
                }
                Operation::Limit(bytes) => {
                    room = room.min(bytes);
                    spill.limit_to(bytes);
                    stores.iter().for_each(PageStore::shrink);
                }
                Operation::Get(_) | Operation::Forget(_) => {}
            }
            prop_assert_eq!(store.halves(), added[which]);
            prop_assert!(spill.resident_bytes() <= room);
        }
        let held: u64 = models.iter().map(|model| bytes(model)).sum();
        prop_assert!(spill.resident_bytes() <= held && held <= spill.resident_bytes() + spill.spilled_bytes());
        for (store, model) in stores.iter().zip(&models) {
            for (number, page) in (0..).zip(model) {
                prop_assert_eq!(&store.get(number).map(|(words, root)| (root, words.to_vec())), page);
                store.forget(number);
                prop_assert!(store.get(number).is_none());
            }
        }
        prop_assert!(spill.check().is_ok());
        prop_assert_eq!(spill.resident_bytes(), 0);
    }
}

#[test]
fn stores_are_shared_by_threads() {
    let store = PageStore::new(Arc::new(Spill::new(1_000, std::env::temp_dir())));
    let page = |seed: u32, i: u32| (0..100).map(|word| word * seed + i).collect::<Vec<u32>>();
    let numbers: Vec<Vec<u32>> = std::thread::scope(|scope| {
        let fill = |seed: u32| (0..200).map(|i| store.add(seed, page(seed, i))).collect::<Vec<u32>>();
        let threads: Vec<_> = (1..4).map(|seed| scope.spawn(move || fill(seed))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert_eq!(store.spill().resident_bytes() + store.spill().spilled_bytes(), 3 * 200 * 400);
    assert!(store.spill().resident_bytes() <= 1_000);
    for (seed, numbers) in (1..).zip(numbers) {
        for (i, number) in (0..).zip(numbers) {
            let (words, root) = store.get(number).unwrap();
            assert_eq!((&*words, root), (&page(seed, i)[..], seed));
        }
    }
}

#[test]
fn spill_reports_failed_writes_and_continues() {
    let folder = PathBuf::from("/nonexistent/adumbra");
    let store = PageStore::new(Arc::new(Spill::new(1_000, folder.clone())));
    let kept = store.add(3, vec![7; 100]);
    assert!(store.spill().check().is_ok());
    let lost = store.add(4, vec![8; 1000]);
    assert!(store.get(kept).is_some() && store.get(lost).is_none());
    assert_eq!(store.halves(), 2200);
    let Err(Error::Spill(IoError { path, source, .. })) = store.spill().check() else { panic!("no error") };
    assert_eq!((path, source.kind()), (folder, std::io::ErrorKind::NotFound));
    assert!(store.spill().check().is_err());
}
