//! A plan, its parts in any order, and the file that is linked from them.

use std::io::Cursor;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use adumbra::{Bounds, Encoding, Receivers, Sun};
use adumbra_bake::{Bake, BakeCache, BakeOptions, BakePlan, Error, PartBaker, Size, Watch};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, Scene, generate};

mod store;

use store::InMemory;

fn options(resolution: u64) -> BakeOptions {
    BakeOptions::new(Sun::from_direction([0.5, 0.8, 0.35]).unwrap(), Size::Resolution(resolution))
}

fn fresh(scene: &Scene, options: &BakeOptions) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    Bake::with_options(scene, options).write_to(&mut out).expect("a good bake");
    out.into_inner()
}

fn linked(plan: &BakePlan, cache: &Arc<dyn BakeCache>, limits: &BakeOptions) -> Result<Vec<u8>, Error> {
    let mut out = Cursor::new(Vec::new());
    plan.link(cache, limits, Watch::none(), &mut out)?;
    Ok(out.into_inner())
}

/// Writes a plan and reads it again.
fn through_text(plan: &BakePlan) -> BakePlan {
    serde_json::from_str(&serde_json::to_string(plan).unwrap()).expect("a plan that was written can be read")
}

fn store() -> Arc<dyn BakeCache> {
    Arc::new(InMemory::default())
}

/// Bakes the parts of a scene in a random order, and links them.
fn link_in_any_order(kind: GeneratedKind, options: &BakeOptions, random: &mut Random) {
    let scene = generate(kind, 3);
    let plan = BakePlan::new(&scene, options).unwrap();
    let plan = {
        assert_eq!(plan, BakePlan::new(&scene, options).unwrap());
        let read = through_text(&plan);
        assert_eq!(read, plan);
        read
    };
    let cache = store();
    let mut ids: Vec<usize> = (0..plan.parts().len()).collect();
    for last in (1..ids.len()).rev() {
        ids.swap(last, (random.unit() * (last + 1) as f64) as usize);
    }
    let mut baked = 0;
    for some in ids.chunks(5) {
        // Each baker stands for a separate machine.
        let baker = PartBaker::new(&scene, &plan, options).unwrap();
        let done = baker.bake(some, &cache, Watch::none()).unwrap();
        assert_eq!((done.baked, done.reused), (some.len(), 0));
        baked += done.baked;
        let again = baker.bake(some, &cache, Watch::none()).unwrap();
        assert_eq!((again.baked, again.reused), (0, some.len()));
    }
    assert_eq!(baked, plan.parts().len());
    let bytes = fresh(&scene, options);
    assert!(linked(&plan, &cache, options).unwrap() == bytes, "{kind:?}");
    // The options of the plan make the same file in one go, and find the same entries.
    let mut out = Cursor::new(Vec::new());
    let written =
        Bake::with_options(&scene, &plan.options()).cache(Arc::clone(&cache)).write_to(&mut out).unwrap();
    assert!(out.into_inner() == bytes, "{kind:?}");
    assert_eq!(written.report.reused_root_blocks, written.report.root_blocks);
}

#[test]
fn parts_of_a_small_scene_in_any_order_link_to_the_bytes_of_one_bake() {
    link_in_any_order(GeneratedKind::Primitives, &options(512), &mut Random::for_batch(1, 1));
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn parts_in_any_order_link_to_the_bytes_of_one_bake() {
    let bounds = Some(Bounds { min: [-90.0, -1.0, -80.0], max: [70.0, 60.0, 90.0] });
    let cases = [
        (GeneratedKind::City, options(2048)),
        (
            GeneratedKind::Primitives,
            options(1024).with(|o| {
                o.encoding = Encoding::Raw;
                o.levels = 1;
            }),
        ),
        (
            GeneratedKind::City,
            options(1024).with(|o| {
                o.bounds = bounds;
                o.thickness_world = 0.3;
            }),
        ),
        (
            GeneratedKind::Wires,
            options(1024).with(|o| {
                o.receivers = Receivers::Static;
                o.switch_within_voxels = 8;
            }),
        ),
    ];
    let mut random = Random::for_batch(1, 1);
    for (kind, options) in cases {
        link_in_any_order(kind, &options, &mut random);
    }
}

#[test]
fn shards_cover_each_part_once_at_about_equal_cost() {
    let plan = BakePlan::new(&generate(GeneratedKind::City, 3), &options(4096)).unwrap();
    let parts = plan.parts();
    assert!(parts.windows(2).all(|two| two[0].cost() >= two[1].cost()));
    assert!(parts.iter().any(|part| part.level() == 0) && parts.iter().any(|part| part.level() == 2));
    let shards: Vec<Vec<usize>> = (0..3).map(|shard| plan.shard(shard, 3)).collect();
    let mut all = shards.concat();
    all.sort_unstable();
    assert_eq!(all, (0..parts.len()).collect::<Vec<_>>());
    let cost = |ids: &Vec<usize>| ids.iter().map(|&id| parts[id].cost()).sum::<u64>();
    let costs: Vec<u64> = shards.iter().map(cost).collect();
    let [least, most] = [costs.iter().min().unwrap(), costs.iter().max().unwrap()];
    assert!(*most < *least * 3 / 2, "{costs:?}");
    assert!(plan.shard(parts.len(), parts.len() + 1).is_empty());
}

#[test]
fn missing_damaged_and_foreign_entries_are_errors() {
    let (scene, options) = (generate(GeneratedKind::City, 3), options(1024));
    let plan = BakePlan::new(&scene, &options).unwrap();
    let memory = Arc::new(InMemory::default());
    let cache: Arc<dyn BakeCache> = memory.clone();
    let error = linked(&plan, &cache, &options).unwrap_err();
    assert!(matches!(error, Error::MissingParts { .. }), "{error}");
    let all: Vec<usize> = (0..plan.parts().len()).collect();
    let baker = PartBaker::new(&scene, &plan, &options).unwrap();
    baker.bake(&all, &cache, Watch::none()).unwrap();
    let bytes = linked(&plan, &cache, &options).unwrap();
    // One entry is lost, one has a wrong bit, and one is the entry of another part.
    let keys: Vec<_> = [0, 1, 2].map(|id| *plan.parts()[id].key()).into();
    {
        let mut held = memory.0.lock().unwrap();
        held.remove(&keys[0]);
        let other = held[&keys[2]].clone();
        held.insert(keys[1], other);
        held.get_mut(&keys[2]).unwrap()[60] ^= 4;
    }
    let error = linked(&plan, &cache, &options).unwrap_err();
    assert!(matches!(error, Error::MissingParts { .. }), "{error}");
    let done = baker.bake(&all, &cache, Watch::none()).unwrap();
    assert_eq!((done.baked, done.reused), (3, all.len() - 3));
    assert!(linked(&plan, &cache, &options).unwrap() == bytes);
    let error = baker.bake(&[0, all.len()], &cache, Watch::none()).unwrap_err();
    assert!(matches!(error, Error::NoPart { id, last } if id == all.len() && last == id - 1), "{error}");
}

#[test]
fn scene_that_changed_since_it_was_planned_is_refused() {
    let (mut scene, options) = (generate(GeneratedKind::City, 3), options(1024));
    let plan = BakePlan::new(&scene, &options).unwrap();
    scene.instances[0].name.push('!');
    assert!(PartBaker::new(&scene, &plan, &options).is_ok(), "names do not matter");
    scene.instances[0].world_from_mesh[0][3] += 0.25;
    let error = PartBaker::new(&scene, &plan, &options).map(|_| ()).unwrap_err();
    assert!(matches!(error, Error::SceneChanged(_)), "{error}");
}

#[test]
fn plans_that_were_changed_are_refused() {
    let plan = BakePlan::new(&generate(GeneratedKind::City, 3), &options(1024)).unwrap();
    let text = serde_json::to_string(&plan).unwrap();
    let refused = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
        change(&mut value);
        let error = serde_json::from_value::<BakePlan>(value).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("plan") || error.contains("field"), "{error}");
        error
    };
    assert!(refused(&|plan| plan["format"] = "adumbra plan 0".into()).contains("adumbra plan 0"));
    assert!(refused(&|plan| plan["settings"]["thickness_world"] = 0.5.into()).contains("changed"));
    assert!(refused(&|plan| plan["sun"]["towards"][0] = 0.1.into()).contains("changed"));
    assert!(refused(&|plan| plan["parts"][3]["key"] = "12".into()).contains("not a hash"));
    assert!(refused(&|plan| plan["parts"][3]["cost"] = 1.into()).contains("changed"));
    assert!(refused(&|plan| plan["parts"][3]["number"] = 99_999.into()).contains("parts"));
    assert!(refused(&|plan| plan["levels"] = serde_json::json!([])).contains("0 levels"));
    assert!(refused(&|plan| plan["levels"][0]["root_level"] = 40.into()).contains("2^40"));
    assert!(refused(&|plan| plan["levels"][0]["size"][0] = 4_000_000_000_u32.into()).contains("4000000000"));
    refused(&|plan| plan["levels"][0]["size"][2] = 0.into());
    refused(&|plan| plan["more"] = 1.into());
    refused(&|plan| {
        let keys = [0, 1].map(|id: usize| plan["parts"][id]["key"].clone());
        plan["parts"][0]["key"] = keys[1].clone();
        plan["parts"][1]["key"] = keys[0].clone();
    });
}

#[test]
fn cancelled_bake_of_parts_keeps_finished_parts() {
    let (scene, options) = (generate(GeneratedKind::City, 3), options(1024));
    let plan = BakePlan::new(&scene, &options).unwrap();
    let memory = Arc::new(InMemory::default());
    let cache: Arc<dyn BakeCache> = memory.clone();
    let all: Vec<usize> = (0..plan.parts().len()).collect();
    let baker = PartBaker::new(&scene, &plan, &options).unwrap();
    let (cancel, seen) = (AtomicBool::new(false), AtomicUsize::new(0));
    let progress = |p: adumbra_bake::Progress| {
        if seen.fetch_max(p.done, Ordering::Relaxed) > p.total / 3 {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    // A single thread notices the cancellation at once.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let error = pool.install(|| baker.bake(&all, &cache, Watch::new(&progress, &cancel)).unwrap_err());
    assert!(matches!(error, Error::Interrupted), "{error}");
    let kept = memory.len();
    assert!(kept > 0 && kept < all.len(), "{kept}");
    let done = baker.bake(&all, &cache, Watch::none()).unwrap();
    assert_eq!((done.baked, done.reused), (all.len() - kept, kept));
    assert!(linked(&plan, &cache, &options).unwrap() == fresh(&scene, &options));
}

#[test]
fn linking_within_a_memory_limit_spills_and_keeps_the_bytes() {
    let (scene, options) = (generate(GeneratedKind::City, 3), options(2048));
    let plan = BakePlan::new(&scene, &options).unwrap();
    let cache = store();
    let all: Vec<usize> = (0..plan.parts().len()).collect();
    PartBaker::new(&scene, &plan, &options).unwrap().bake(&all, &cache, Watch::none()).unwrap();
    let limits = |bytes| options.clone().with(|o| o.max_memory_bytes = bytes);
    let within = |bytes: Option<u64>| {
        let mut out = Cursor::new(Vec::new());
        let written = plan.link(&cache, &limits(bytes), Watch::none(), &mut out).unwrap();
        (out.into_inner(), written.report)
    };
    let (plain, report) = within(None);
    assert_eq!(report.spilled_bytes, 0);
    let (bytes, report) = within(Some(report.accounted_bytes - (64 << 10)));
    assert!(bytes == plain && report.spilled_bytes > 0, "{report:?}");
    let error = linked(&plan, &cache, &limits(Some(1 << 10))).unwrap_err();
    assert!(matches!(error, Error::MemoryLimit { .. }), "{error}");
}
