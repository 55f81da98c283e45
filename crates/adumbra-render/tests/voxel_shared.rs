//! As tests/voxel.rs, on scenes that are no part of the repository, and at 16384.

mod kit;
#[path = "../../adumbra/tests/shared_folder/mod.rs"]
mod shared_folder;
mod voxel_points;

use adumbra::query::{FILTER_WIDTHS, KERNEL_SIDES, Weights};
use adumbra::scene::{LoadOptions, load};
use adumbra_render::voxel::CubesStore;
use shared_folder::{full, shared};
use voxel_points::{BakedScene, exact_cubes, exact_light, float_cubes, float_light};

const SCENES: [&str; 4] = ["kaykit_city_21.glb", "zdm2.glb", "alpine-2.glb", "auster.obj"];
const COUNT: usize = 100_000;

fn baked(file: &str, resolution: u64, tree_side: u64) -> Option<BakedScene> {
    let scene = load(&shared("scenes")?.join(file), &LoadOptions::default()).unwrap();
    Some(BakedScene::new(scene, [0.5, 0.8, 0.35], resolution, tree_side))
}

#[test]
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

/// At 16384 where the whole size is asked for, else on the smallest scene alone; the tree at 1024.
#[test]
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
