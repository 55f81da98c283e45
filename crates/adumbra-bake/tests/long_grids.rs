//! Grids that are far longer than the resolution: an oblique frame under a low sun.

use adumbra::Sun;
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::Mesh;
use adumbra_testing::{add_quad, scene_of};

/// A wall of 100 m on a square.
fn wall() -> adumbra_scene::Scene {
    let mut mesh = Mesh::default();
    add_quad(&mut mesh, [[-50.0, 0.0, -50.0], [-50.0, 0.0, 50.0], [50.0, 0.0, 50.0], [50.0, 0.0, -50.0]]);
    add_quad(&mut mesh, [[0.0, 0.0, -50.0], [0.0, 100.0, -50.0], [0.0, 100.0, 50.0], [0.0, 0.0, 50.0]]);
    scene_of(vec![mesh])
}

#[test]
fn root_block_count_does_not_grow_with_shadow_length() {
    let mut all = Vec::new();
    for elevation_degrees in [60.0, 5.0, 1.0, 0.5] {
        let sun = Sun::from_angles(100.0, elevation_degrees).unwrap();
        let options = BakeOptions::new(sun, Size::Resolution(512)).with(|o| {
            o.frame = FrameChoice::ObliqueAt(0.3);
            o.levels = 1;
        });
        all.push(Bake::with_options(&wall(), &options).estimate().unwrap().root_blocks);
    }
    // A shadow of 11 km has 120 times the texels of one of 60 m.
    assert!(all.iter().all(|&root_blocks| root_blocks <= 20 * all[0]), "{all:?}");
}

#[test]
fn long_grid_answers_like_a_short_one() {
    let sun = Sun::from_angles(100.0, 2.0).unwrap();
    let baked = |frame| {
        let options = BakeOptions::new(sun, Size::Resolution(256)).with(|o| {
            o.frame = frame;
            o.levels = 1;
        });
        Bake::with_options(&wall(), &options).in_memory().unwrap()
    };
    let [long, short] = [FrameChoice::ObliqueAt(0.3), FrameChoice::Light]
        .map(|frame| baked(frame).sampler(adumbra::Filter::Nearest));
    let points = (0..40_u8).map(|i| [2.5 * f64::from(i) - 49.0, 5.0, 3.0]);
    let disagree = points.filter(|&p| long.visibility(p, None) != short.visibility(p, None)).count();
    assert!(disagree <= 2, "{disagree} of 40");
}
