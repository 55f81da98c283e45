//! Packed graphs of real bakes: always monotone, equal answers, a lossless round trip to the plain graph, at
//! about a third of the bytes.

use adumbra::{Receivers, Sun};
use adumbra_bake::{BakeOptions, Size, Watch};
use adumbra_papers::dag::build::convert::{graph_of, unpack};
use adumbra_papers::dag::build::{DagOptions, bake, pack};
use adumbra_papers::dag::plain::Dag;
use adumbra_papers::dag::{DagLayout, LeafMasks};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, LoadOptions, Scene, generate, load};

fn baked(scene: &Scene, sun: [f64; 3], change: impl FnOnce(&mut BakeOptions)) -> Dag {
    let sun = Sun::from_direction(sun).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(1024)).with(change);
    let options = DagOptions { bake: options, layout: DagLayout::Plain };
    graph_of(&bake(scene, &options, Watch::none()).unwrap().file.body).unwrap().into_owned()
}

/// Packs a graph, checks it, and returns its size relative to the plain graph's.
fn share_of_packed(dag: &Dag, look_ups: u32) -> f64 {
    let packed = pack(dag).unwrap();
    packed.validate().unwrap();
    assert!(unpack(&packed).unwrap() == *dag);
    let mut random = Random::for_batch(3, 0);
    for _ in 0..look_ups {
        let [i, j, k] = dag.size.map(|n| (random.unit() * f64::from(n)) as u32);
        assert_eq!(packed.look_up(i, j, k), dag.look_up(i, j, k), "{i} {j} {k}");
    }
    let plain = dag.top.len() * 4 + dag.nodes.len() * 4 + dag.leaf_masks.len() * 8;
    (packed.top.len() * 4 + packed.units.len() * 2 + packed.leaf_masks.len() * 8) as f64 / plain as f64
}

#[test]
fn packed_bake_matches_plain() {
    let dag = baked(&generate(GeneratedKind::Primitives, 1), [0.5, 0.8, 0.35], |_| {});
    let share = share_of_packed(&dag, 20_000);
    assert!(share < 0.5, "{share}");
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn packed_bakes_match_plain_with_various_options() {
    for kind in [GeneratedKind::City, GeneratedKind::Primitives] {
        let scene = generate(kind, 1);
        for (sun, receivers, ground, closed) in [
            ([0.5, 0.8, 0.35], Receivers::All, true, true),
            ([0.0, 1.0, 0.0], Receivers::Static, true, true),
            ([-0.9, 0.1, 0.2], Receivers::All, false, false),
        ] {
            let change = |o: &mut BakeOptions| {
                o.receivers = receivers;
                o.assume_ground = ground.into();
                o.closed_regions = closed;
            };
            let share = share_of_packed(&baked(&scene, sun, change), 200_000);
            assert!(share < 0.5, "{kind:?} {sun:?}: {share}");
        }
    }
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_scenes_pack_to_two_fifths_and_match_plain() {
    let Some(scenes) = adumbra_testing::shared("scenes") else { return };
    for name in [
        "kaykit_city_21",
        "alpine-2",
        "street-1",
        "zdm2",
        "delft",
        "bridge_garden",
        "jacksboro",
        "box-city-5k",
    ] {
        let scene = load(&adumbra_testing::scene_file(&scenes, name), &LoadOptions::default()).unwrap();
        let share = share_of_packed(&baked(&scene, [0.5, 0.8, 0.35], |o| o.thickness_world = 0.1), 200_000);
        eprintln!("{name}: {share:.3}");
        assert!(share < 0.45, "{name}: {share}");
    }
}
