//! The tests of answers.rs on scenes that are not part of the repository, and at a resolution of 1024.

use adumbra_papers::techniques::CubesStore;
use adumbra_papers::tree::query::{KERNEL_SIDES, Weights};
use adumbra_scene::{LoadOptions, load};
use adumbra_testing::{full, shared};

use crate::baked_tree::{BakedTree, exact_cubes, float_cubes};
use crate::kit::gpu;

const SCENES: [&str; 4] = ["kaykit_city_21.glb", "zdm2.glb", "alpine-2.glb", "auster.obj"];
const COUNT: usize = 100_000;

fn baked(file: &str, side: u64) -> Option<BakedTree> {
    let scene = load(&shared("scenes")?.join(file), &LoadOptions::default()).unwrap();
    Some(BakedTree::new(scene, side))
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_tree_matches_cpu_tap_counts() {
    let gpu = gpu();
    for file in SCENES {
        let Some(baked) = baked(file, 512) else { return };
        for side in KERNEL_SIDES {
            for weights in [Weights::Mean, Weights::Poisson] {
                exact_cubes(&gpu, &baked, CubesStore::Words, (side, weights), COUNT);
            }
            exact_cubes(&gpu, &baked, CubesStore::Texels, (side, Weights::Mean), COUNT);
        }
        eprintln!("{file}: every count is the same");
    }
}

#[test]
#[ignore = "slow: a real scene; four with ADUMBRA_FULL"]
fn shared_tree_answers_from_f32_positions_differ_only_on_faces() {
    let gpu = gpu();
    for file in SCENES.into_iter().take(if full() { SCENES.len() } else { 1 }) {
        let Some(baked) = baked(file, 1024) else { return };
        eprintln!("{file}");
        for side in KERNEL_SIDES {
            float_cubes(&gpu, &baked, (side, Weights::Mean), COUNT);
        }
    }
}
