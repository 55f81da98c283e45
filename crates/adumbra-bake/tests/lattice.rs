//! Grids are aligned to a lattice anchored at the world's origin, so a scene that grows keeps its texels.

use adumbra::query::receiver;
use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::{AssumeGround, Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::random::Random;
use adumbra_scene::{Mesh, Scene};
use adumbra_testing::{add_box, scene_of};

const UP: [f64; 3] = [0.0, 1.0, 0.0];
const VOXEL: f64 = 0.1;

/// A few boxes on a ground, and one more far away if the scene has grown.
fn scene(has_grown: bool) -> Scene {
    let mut mesh = Mesh::default();
    add_box(&mut mesh, [-12.0, -1.0, -12.0], [12.0, 0.0, 12.0]);
    for i in 0..12_u8 {
        let at = f32::from(i);
        let [x, z] = [(at * 1.7).sin() * 8.0, (at * 2.3).cos() * 8.0];
        add_box(&mut mesh, [x, 0.0, z], [x + 1.3, 0.8 + 0.3 * at, z + 0.9]);
    }
    if has_grown {
        add_box(&mut mesh, [-97.0, -30.0, 60.0], [-90.0, 5.0, 71.0]);
    }
    scene_of(vec![mesh])
}

fn bake(has_grown: bool, frame: FrameChoice, voxel: f64) -> ShadowFile {
    let sun = Sun::from_direction([0.6, 0.7, 0.2]).unwrap();
    // Both scenes need the same decision on the ground.
    let assume_ground = AssumeGround::Yes;
    let options = BakeOptions::new(sun, Size::VoxelSize(voxel)).with(|o| {
        o.frame = frame;
        o.assume_ground = assume_ground;
    });
    Bake::with_options(&scene(has_grown), &options).in_memory().unwrap()
}

/// Returns the answers at points on the ground.
fn answers(file: &ShadowFile, points: &[[f64; 3]]) -> Vec<bool> {
    let sampler = file.sampler(Filter::Nearest);
    points.iter().map(|&p| sampler.visibility(p, Some(UP)) > 0.5).collect()
}

#[test]
fn scene_that_grows_keeps_its_texels() {
    let mut random = Random::for_batch(5, 0);
    let mut any = || 22.0 * random.unit() - 11.0;
    let points: Vec<[f64; 3]> = (0..40_000).map(|_| [any(), 0.0, any()]).collect();
    for frame in [FrameChoice::Light, FrameChoice::ObliqueAt(0.3)] {
        let (small, large) = (bake(false, frame, VOXEL), bake(true, frame, VOXEL));
        assert_ne!(
            small.grid.corner, large.grid.corner,
            "{frame:?}: the grid has grown towards the origin's far side"
        );
        // The same point is at the same place in its texel.
        for &p in &points[..100] {
            let [a, b] =
                [&small, &large].map(|file| receiver(&file.grid, &file.settings.bias, p, Some(UP)).p_grid);
            for axis in 0..3 {
                let apart = (a[axis] - b[axis]) - (a[axis] - b[axis]).round();
                assert!(apart.abs() < 1e-9, "{frame:?}: {a:?}, {b:?}");
            }
        }
        let [of_small, of_large] = [&small, &large].map(|file| answers(file, &points));
        let differ = |a: &[bool], b: &[bool]| a.iter().zip(b).filter(|(a, b)| a != b).count();
        assert_eq!(differ(&of_small, &of_large), 0, "{frame:?}");
        // Texels of another size would show at the edges.
        let other = answers(&bake(false, frame, 1.01 * VOXEL), &points);
        assert!(differ(&of_small, &other) > 100, "{frame:?}: {}", differ(&of_small, &other));
    }
}
