//! The tests of voxel.rs on scenes that are not part of the repository, and at a resolution of 16384.

use adumbra::Filter;
use adumbra_scene::{LoadOptions, load};
use adumbra_testing::{full, shared};

use crate::kit;
use crate::voxel_points::{BakedScene, exact_light, float_light};

const SCENES: [&str; 4] = ["kaykit_city_21.glb", "zdm2.glb", "alpine-2.glb", "auster.obj"];
const COUNT: usize = 100_000;

fn baked(file: &str, resolution: u64) -> Option<BakedScene> {
    let scene = load(&shared("scenes")?.join(file), &LoadOptions::default()).unwrap();
    Some(BakedScene::new(scene, [0.5, 0.8, 0.35], resolution))
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_voxel_taps_match_cpu() {
    let gpu = kit::gpu();
    for file in SCENES {
        let Some(baked) = baked(file, 2048) else { return };
        for filter in Filter::ALL {
            exact_light(&gpu, &baked, filter, COUNT);
        }
        eprintln!("{file}: every count is the same");
    }
}

/// Runs at 16384 for all scenes if full size is requested, else for the first scene only and at 4096 for the
/// others.
#[test]
#[ignore = "slow: real scenes"]
fn shared_voxel_from_f32_positions_differs_only_on_faces() {
    let gpu = kit::gpu();
    for file in SCENES {
        let resolution = if full() || file == SCENES[0] { 16384 } else { 4096 };
        let Some(baked) = baked(file, resolution) else { return };
        eprintln!("{file} at {resolution}");
        for filter in Filter::ALL {
            float_light(&gpu, &baked, filter, COUNT);
        }
    }
}
