//! The tests of voxel.rs on scenes that are not part of the repository, and at a resolution of 16384.

use adumbra::query::FILTER_WIDTHS;
use adumbra_render::voxel::CubesStore;
use adumbra_scene::{LoadOptions, load};
use adumbra_testing::{full, shared};
use adumbra_tree::query::{KERNEL_SIDES, Weights};

use crate::kit;
use crate::voxel_points::{BakedScene, exact_cubes, exact_light, float_cubes, float_light};

const SCENES: [&str; 4] = ["kaykit_city_21.glb", "zdm2.glb", "alpine-2.glb", "auster.obj"];
const COUNT: usize = 100_000;

fn baked(file: &str, resolution: u64, tree_side: u64) -> Option<BakedScene> {
    let scene = load(&shared("scenes")?.join(file), &LoadOptions::default()).unwrap();
    Some(BakedScene::new(scene, [0.5, 0.8, 0.35], resolution, tree_side))
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_voxel_counts_are_the_cpu_s() {
    let gpu = kit::gpu();
    for file in SCENES {
        let Some(baked) = baked(file, 2048, 512) else { return };
        for filter in FILTER_WIDTHS {
            exact_light(&gpu, &baked, filter, COUNT);
        }
        for side in KERNEL_SIDES {
            for weights in [Weights::Mean, Weights::Poisson] {
                exact_cubes(&gpu, &baked, CubesStore::Words, (side, weights), COUNT);
            }
            exact_cubes(&gpu, &baked, CubesStore::Texels, (side, Weights::Mean), COUNT);
        }
        eprintln!("{file}: every count is the same");
    }
}

/// Runs at 16384 for all scenes if full size is requested, else for the first scene only and at 4096 for the others.
/// The tree is at 1024.
#[test]
#[ignore = "slow: real scenes"]
fn shared_voxel_from_f32_positions_differs_only_on_faces() {
    let gpu = kit::gpu();
    for file in SCENES {
        let resolution = if full() || file == SCENES[0] { 16384 } else { 4096 };
        let Some(baked) = baked(file, resolution, 1024) else { return };
        eprintln!("{file} at {resolution}");
        for filter in FILTER_WIDTHS {
            float_light(&gpu, &baked, filter, COUNT);
        }
        for side in KERNEL_SIDES {
            float_cubes(&gpu, &baked, (side, Weights::Mean), COUNT);
        }
    }
}
