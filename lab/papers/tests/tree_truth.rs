//! World-aligned trees compared with truth: rays at random points, and builders and reductions compared with
//! each other.
//!
//! Where noted, CI builds trees two levels shallower; `ADUMBRA_FULL=1` builds them at full depth. The shared
//! folder is `ADUMBRA_SHARED`, or `shared` beside the checkout. Without it the tests that need it print a
//! message and pass.

use std::sync::atomic::AtomicBool;

use adumbra::Sun;
use adumbra_bake::{Size, Watch};
use adumbra_papers::tree::query::{TreeQuery, Weights};
use adumbra_papers::tree::{
    BakedTree, PreparedTree, Reduction, TreeAnswers, TreeBuilder, TreeOptions, bake_tree, volume_of,
};
use adumbra_scene::{GeneratedKind, LoadOptions, Scene, generate, load};
use adumbra_testing::{full, shared};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions};

fn options(sun: [f64; 3], depth: u32) -> TreeOptions {
    TreeOptions::new(Sun::from_direction(sun).unwrap(), Size::Resolution(1 << depth))
}

fn bake_quietly(scene: &Scene, options: &TreeOptions) -> BakedTree {
    bake_tree(scene, options, Watch::none()).unwrap()
}

fn verify(scene: &Scene, baked: &BakedTree, sun: Sun, volume: bool, samples: u64) -> Verification {
    let tracer = Tracer::build(scene, TraceOptions { ignore_alpha: false });
    let solids = Solids::of(scene);
    let sampler = if volume {
        Sampler::Volume(volume_of(&baked.space))
    } else {
        Sampler::Surface(SurfaceSampler::new(scene, &solids, sun.towards(), false))
    };
    let settings = &baked.settings;
    let query =
        TreeQuery::new(&baked.space, &baked.regions, &sun, &baked.tree, settings.bias, 1, Weights::Mean)
            .unwrap();
    let answers = TreeAnswers::new(settings, sun, query);
    Verifier::new(&answers, &tracer, &solids).run(&sampler, &VerifyOptions { samples, seed: 3 })
}

const SUNS: [[f64; 3]; 3] = [[0.5, 0.8, 0.35], [0.0, 1.0, 0.0], [0.8, 0.3, -0.5]];

fn holds_under_every_sun(name: &str, scene: &Scene) {
    for towards in SUNS {
        let baked = bake_quietly(scene, &options(towards, 10));
        let sun = Sun::from_direction(towards).unwrap();
        for volume in [false, true] {
            let v = verify(scene, &baked, sun, volume, 100_000);
            println!(
                "{name} {towards:?} volume {volume}: interior {:.5} of {}, agreement {:.5}",
                v.interior_agreement, v.interior_share, v.agreement
            );
            assert!(v.interior_agreement >= 0.999, "{name} {towards:?} volume {volume}: {v:?}");
            assert!(v.interior_share >= 0.5, "{name} {towards:?} volume {volume}: {v:?}");
        }
    }
}

#[test]
#[ignore = "slow: traces many rays; of two scenes with ADUMBRA_FULL"]
fn tree_answers_agree_with_rays_on_generated_scenes() {
    holds_under_every_sun("landscape", &generate(GeneratedKind::Landscape, 1));
    if full() {
        holds_under_every_sun("primitives", &generate(GeneratedKind::Primitives, 1));
    }
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_tree_answers_agree_with_rays_on_zdm2() {
    let Some(scenes) = shared("scenes") else { return };
    holds_under_every_sun("zdm2", &load(&scenes.join("zdm2.glb"), &LoadOptions::default()).unwrap());
}

/// Every builder and every reduction is compared, at depth 9, on every scene with fewer instanced triangles
/// than this.
const MAX_TRIANGLES: u64 = 500_000;

#[test]
#[ignore = "slow: real scenes"]
fn shared_tree_builders_and_reductions_agree_on_every_scene() {
    let Some(scenes) = shared("scenes") else { return };
    let depth = if full() { 9 } else { 7 };
    let mut names: Vec<_> = std::fs::read_dir(scenes)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e != "md"))
        .collect();
    names.sort();
    let mut compared = 0;
    for path in names {
        let scene = load(&path, &LoadOptions::default()).unwrap();
        if scene.instanced_triangles() >= MAX_TRIANGLES {
            continue;
        }
        let base = options(SUNS[0], depth);
        let prepared = PreparedTree::new(&scene, &base, &AtomicBool::new(false)).unwrap();
        let build = |builder, reduction, prune| {
            let options = TreeOptions { builder, reduction, prune, ..base.clone() };
            prepared.build(&options, Watch::none()).unwrap().tree
        };
        let first = build(TreeBuilder::Recursive, Reduction::Hash, false);
        for (builder, reduction, prune) in [
            (TreeBuilder::Iterative, Reduction::Hash, false),
            (TreeBuilder::Pooled, Reduction::Sort, false),
            (TreeBuilder::Recursive, Reduction::Sort, true),
            (TreeBuilder::Pooled, Reduction::TreeHash, true),
        ] {
            let other = build(builder, reduction, prune);
            assert!(other == first, "{}: {builder:?} {reduction:?} {prune}", path.display());
        }
        compared += 1;
        println!("{}: {} bytes", path.display(), first.bytes());
    }
    assert!(compared >= 10, "only {compared} scenes were small enough");
}
