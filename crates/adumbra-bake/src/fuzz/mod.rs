//! Fuzzes random scenes under every option: both builders are compared with each other, and look-ups with
//! rays.
//!
//! A case depends on its seed alone. `ADUMBRA_FUZZ_SEEDS=100..200` runs those seeds instead of the default
//! ones. `ADUMBRA_FUZZ_SECONDS=600` runs from the first seed on for that many seconds. See CONTRIBUTING.md.

mod baked;
mod dice;
mod found;
mod parts;
mod receivers;
mod scenes;
mod totals;
mod truth;

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use std::{env, thread};

use baked::BakedPair;
use dice::Dice;
use receivers::Checker;
use scenes::Case;
use totals::Totals;
use truth::Truth;

use crate::choose;
use crate::options::BakeOptions;
use adumbra_scene::Scene;

/// Seeds of the quick test.
const QUICK_SEEDS: Range<u64> = 0..60;
/// Seeds of the full test.
const FULL_SEEDS: Range<u64> = 0..2000;
/// Grids with more texels, or more layers, are not checked, because every column is examined.
const MAX_TEXELS: u64 = 1 << 17;
const MAX_LAYERS: u32 = 1 << 14;
/// A run ends after this many failures.
const MAX_FAILURES: usize = 50;

/// Checks one case.
fn check(seed: u64) -> Result<Totals, String> {
    let Case { scene, options } = Case::new(seed);
    check_case(seed, &scene, &options)
}

fn check_case(seed: u64, scene: &Scene, options: &BakeOptions) -> Result<Totals, String> {
    let mut totals = Totals { scenes: 1, ..Totals::default() };
    let mut plan = match choose::plan(scene, options) {
        Ok(plan) if plan.root_blocks.grid.size[2] <= MAX_LAYERS => plan,
        Ok(_) | Err(crate::Error::Range(_) | crate::Error::MemoryLimit { .. }) => {
            totals.refused += 1;
            return Ok(totals);
        }
        Err(error) => return Err(format!("the bake refuses the scene: {error}")),
    };
    let [nx, ny, _] = plan.root_blocks.grid.size;
    if u64::from(nx) * u64::from(ny) > MAX_TEXELS {
        totals.refused += 1;
        return Ok(totals);
    }
    let baked = BakedPair::new(seed, scene, options)?;
    // The builders agree on columns as they are before a limit cuts them.
    plan.root_blocks.limit.within_voxels = 0;
    baked.check_columns(&plan, &mut totals)?;
    let truth = Truth::new(scene, options, &plan);
    let checker = Checker { scene, truth: &truth, baked: &baked, bias: options.bias };
    checker.check(&mut Dice::new(seed, 1), &mut totals)?;
    Ok(totals)
}

/// Checks a case, and treats a panic as a failure too. See [`check`].
fn check_caught(seed: u64) -> Result<Totals, String> {
    catch_unwind(AssertUnwindSafe(|| check(seed))).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        Err(format!("panic: {text}"))
    })
}

/// Checks seeds on all cores until the seeds or the time run out. Returns the totals, and the failures by
/// seed.
fn run(seeds: Range<u64>, time: Option<Duration>) -> (Totals, Vec<(u64, String)>) {
    let start = Instant::now();
    let next = AtomicU64::new(seeds.start);
    let outcome = Mutex::new((Totals::default(), Vec::new()));
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end || time.is_some_and(|time| start.elapsed() >= time) {
                return;
            }
            let result = check_caught(seed);
            let mut outcome = outcome.lock().expect("no check panics while it is locked");
            match result {
                Ok(totals) => outcome.0.add(&totals),
                Err(reason) => {
                    eprintln!("seed {seed}: {reason}");
                    outcome.1.push((seed, reason));
                    if outcome.1.len() >= MAX_FAILURES {
                        next.store(seeds.end, Ordering::Relaxed);
                    }
                }
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                // One pool per worker: in a shared one, a bake that waits for its workers would start the
                // next seed on its stack.
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
                pool.install(work);
            });
        }
    });
    outcome.into_inner().expect("no check panics while it is locked")
}

/// Runs `seeds`, for at most `time` if given, and fails if any of them fails.
fn assert_all(seeds: Range<u64>, time: Option<Duration>) {
    let (totals, mut failures) = run(seeds, time);
    eprintln!("{totals}");
    failures.sort_unstable();
    let list: Vec<String> = failures.iter().map(|(seed, reason)| format!("seed {seed}: {reason}")).collect();
    assert!(list.is_empty(), "{} scenes fail:\n{}", list.len(), list.join("\n"));
    assert!(totals.scenes > 0 && totals.columns > 0, "nothing was checked: {totals}");
    if totals.scenes >= 50 {
        assert!(totals.refused * 10 <= totals.scenes, "few scenes are checked: {totals}");
        assert!(totals.receivers[0] >= 20 * totals.scenes, "few receivers are checked: {totals}");
        let dark = totals.receivers[0] - totals.receivers[1];
        assert!(dark >= 5 * totals.scenes, "few receivers are in shadow: {totals}");
    }
}

#[test]
fn fuzz_scenes_quick() {
    assert_all(QUICK_SEEDS, None);
}

#[test]
#[ignore = "slow: many random scenes; 2,000 with ADUMBRA_FULL"]
fn fuzz_scenes_full_range() {
    let asked = env::var("ADUMBRA_FUZZ_SEEDS").ok().map(|text| {
        let (from, to) = text.split_once("..").expect("ADUMBRA_FUZZ_SEEDS is FROM..TO");
        let number = |text: &str| text.parse().expect("ADUMBRA_FUZZ_SEEDS is FROM..TO, whole numbers");
        number(from)..number(to)
    });
    let time = env::var("ADUMBRA_FUZZ_SECONDS")
        .ok()
        .map(|text| Duration::from_secs(text.parse().expect("ADUMBRA_FUZZ_SECONDS is a whole number")));
    let some = FULL_SEEDS.start..FULL_SEEDS.start + 400;
    let seeds = asked.unwrap_or(if adumbra_testing::full() { FULL_SEEDS } else { some });
    let end = if time.is_some() { u64::MAX } else { seeds.end };
    assert_all(seeds.start..end, time);
}
