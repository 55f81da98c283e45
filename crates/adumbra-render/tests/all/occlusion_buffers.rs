//! Estimators of ambient occlusion on synthetic depth: GPU against CPU.

use adumbra::Bounds;
use adumbra_render::frame::frame;
use adumbra_render::occlusion::twin::{Surfaces, ambient};
use adumbra_render::occlusion::{Estimator, OcclusionPasses, OcclusionSettings};
use adumbra_scene::{Camera, Projection};
use adumbra_shaders::layout::Frame;

use crate::kit;
use crate::kit::ambient::{VARIANTS, stored_depth};
use crate::kit::buffers::Buffers;

const PERSPECTIVE: Projection = Projection::Perspective { fov_degrees: 50.0 };
const ORTHOGRAPHIC: Projection = Projection::Orthographic { height_world: 6.0 };
const BOUNDS: Bounds = Bounds { min: [-5.0; 3], max: [5.0; 3] };

fn frame_of(projection: Projection, [width, height]: [u32; 2]) -> Frame {
    let camera = Camera { eye: [3.0, 4.0, 5.0], target: [0.5, 0.0, -0.5], projection, width, height };
    frame(&camera, &BOUNDS, kit::sun(), 0)
}

/// A reproducible generator of numbers from 0 to 1: splitmix64 (Steele, Lea, Flood, *Fast Splittable
/// Pseudorandom Number Generators*, 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }
}

/// Random stored depths for view depths from `near` to `far`, a tenth of them sky, and random normals, most
/// of them towards the eye.
fn random(frame: &Frame, [near, far]: [f32; 2], seed: u64) -> (Vec<f32>, Vec<[f32; 3]>) {
    let mut random = Random(seed);
    (0..frame.size[0] * frame.size[1])
        .map(|_| {
            let z = near + (far - near) * random.next();
            let depth = stored_depth(frame.depth_to_z, z);
            let depth = if random.next() < 0.1 { 0.0 } else { depth };
            let n: [f32; 3] = std::array::from_fn(|a| 2.0 * random.next() - 1.0 - frame.forward[a]);
            let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
            (depth, n.map(|c| c / length))
        })
        .unzip()
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn gpu_occlusion_matches_cpu_on_random_depth() {
    let gpu = kit::gpu();
    let (mut compared, mut off, mut darkened) = (0, 0, 0);
    for text in
        Estimator::ALL.map(Estimator::name).iter().chain(&VARIANTS).chain(&["gtao:thin=0.5:falloff=0.1"])
    {
        let mut worst = 0.0_f32;
        for samples in [1, 12, 64] {
            let text = format!("{text}:samples={samples}:filter=none");
            let mut settings = OcclusionSettings::from_spec(&text.parse().unwrap(), 1.0).unwrap();
            let mut passes = OcclusionPasses::new(&gpu, settings);
            for (projection, size) in [PERSPECTIVE, ORTHOGRAPHIC]
                .into_iter()
                .flat_map(|p| [[1, 1], [1, 7], [33, 17], [64, 40]].map(|size| (p, size)))
            {
                let frame = frame_of(projection, size);
                for (seed, range) in [(1, [2.0, 9.0]), (2, [6.0, 6.3])] {
                    let (depth, normal) = random(&frame, range, seed);
                    let buffers = Buffers::new(&gpu, size, &depth, &normal);
                    // Radii on the screen: zero, a few texels, more than the picture has, more than the cap
                    // allows.
                    for radius_world in [0.0, 0.7, 5.0, 1e4] {
                        settings.radius_world = radius_world;
                        assert!(passes.reshape(&gpu, &settings));
                        let found = buffers.occlude(&gpu, &frame, &mut passes).unwrap();
                        let expected =
                            ambient(&settings, &Surfaces { frame, depth: &depth, normal: &normal });
                        for (at, (a, b)) in found.iter().zip(&expected).enumerate() {
                            assert!((0.0..=1.0).contains(a), "{text} {settings:?} {at}: {a}");
                            let difference = (a - b[0]).abs();
                            off += u32::from(difference > 2e-3);
                            worst = worst.max(difference);
                            darkened += u32::from(b[0] < 0.9);
                            compared += 1;
                        }
                        if radius_world == 0.0 {
                            assert!(found.iter().all(|v| *v == 1.0));
                        }
                    }
                }
            }
        }
        println!("{text}: {worst}");
    }
    println!("{off} of {compared}, {darkened} dark");
    assert!(darkened > compared / 10);
    // On a GPU, samples at edges may fall on their other side.
    let allowed = if gpu.is_software() { 0 } else { compared / 100_000 };
    assert!(off <= allowed, "{off} of {compared}");
}

#[test]
fn empty_sky_and_a_far_plane_are_unoccluded() {
    let gpu = kit::gpu();
    for estimator in Estimator::ALL {
        for (projection, size) in [(PERSPECTIVE, [33, 17]), (ORTHOGRAPHIC, [33, 17]), (PERSPECTIVE, [1, 1])] {
            let frame = frame_of(projection, size);
            let count = (size[0] * size[1]) as usize;
            let backwards = frame.forward.map(|c| -c);
            let mut passes = OcclusionPasses::new(&gpu, OcclusionSettings::new(estimator, 2.0));
            for (depth, normal) in [(0.0, [0.0; 3]), (1e-6, backwards)] {
                let buffers = Buffers::new(&gpu, size, &vec![depth; count], &vec![normal; count]);
                let found = buffers.occlude(&gpu, &frame, &mut passes).unwrap();
                assert!(found.iter().all(|v| (*v - 1.0).abs() < 1e-3), "{estimator} {projection:?} {depth}");
            }
        }
    }
}
