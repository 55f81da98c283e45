//! The levels at which look-ups in baked files end, for each pixel of drawn frames: shaders against their CPU
//! twins.

use adumbra::Filter;
use adumbra::query::{FixedReceiver, receiver};
use adumbra_render::maps::twin::Surface;
use adumbra_render::{Answer, Renderer, SceneOptions, Shot, TechniqueFiles, build};
use adumbra_testing::end_level;

use crate::kit;
use crate::kit::surfaces::surfaces;
use crate::voxel_points::BakedScene;

fn shot() -> Shot {
    Shot { camera: kit::camera(240, 160), towards_sun: kit::sun(), number: 0 }
}

/// Returns the levels of a frame and the edge of a voxel in world units.
fn levels(renderer: &mut Renderer, baked: &BakedScene, name: &str) -> (Vec<f32>, f64) {
    let technique = build(renderer.gpu(), &name.parse().unwrap(), TechniqueFiles::of(&baked.light)).unwrap();
    let mut prepared = renderer.prepare(technique).unwrap();
    renderer.draw(&shot(), &mut prepared, Answer::Voxel).unwrap();
    let voxel_world = prepared.technique().voxel_world().unwrap();
    (renderer.read_factor(&prepared).unwrap(), voxel_world)
}

/// Asserts that nearly every pixel equals the twin's answer, and that every other pixel equals the twin's
/// answer at a point at most 0.02 voxels away along each axis. That is as close as f32 and f64 can agree.
fn hold(name: &str, renderer: &Renderer, found: &[f32], twin: impl Fn([f64; 3], [f64; 3]) -> (f32, f64)) {
    let shot = shot();
    let anchor = shot.camera.view().eye.map(|c| f64::from(c as f32));
    let depth = renderer.read_surface(&shot).unwrap().view_depth;
    let (mut checked, mut differing) = (0, 0);
    let mut seen = [0; 16];
    for (at, surface) in surfaces(renderer, &shot).iter().enumerate() {
        assert!(depth[at].is_finite() || found[at] == -1.0, "{name}: {at} of the sky is {}", found[at]);
        let Some(Surface { p_relative, normal, .. }) = surface else { continue };
        let p = std::array::from_fn(|a| anchor[a] + f64::from(p_relative[a]));
        let n = normal.map(f64::from);
        let (expected, voxel_world) = twin(p, n);
        checked += 1;
        seen[(found[at] + 1.0) as usize] += 1;
        if found[at] == expected {
            continue;
        }
        differing += 1;
        let near = (0..27).map(|i| [i / 9, i / 3 % 3, i % 3].map(|c| 0.02 * (f64::from(c) - 1.0)));
        let near = near.map(|offset| std::array::from_fn(|a| p[a] + voxel_world * offset[a]));
        assert!(
            near.into_iter().any(|p| twin(p, n).0 == found[at]),
            "{name}: pixel {at}: {}, not {expected}, and on no face",
            found[at]
        );
    }
    eprintln!("{name}: {differing} of {checked} differ; by level from -1: {seen:?}");
    assert!(checked > 15_000 && differing * 500 < checked, "{name}: {differing} of {checked} differ");
    assert!(seen[1..].iter().filter(|n| **n > 100).count() > 1, "{name}: {seen:?}");
}

#[test]
fn gpu_voxel_levels_match_cpu_with_any_filter() {
    let baked = BakedScene::new(kit::city(), [0.5, 0.8, 0.35], 1024);
    let mut renderer = Renderer::new(kit::gpu(), &baked.scene, SceneOptions::default()).unwrap();
    let (found, voxel_world) = levels(&mut renderer, &baked, "voxel:filter=9");
    let file = &baked.light;
    assert_eq!(voxel_world, file.grid.voxel_size);
    let sampler = file.sampler(Filter::Box9);
    hold("voxel", &renderer, &found, |p, n| {
        let r = FixedReceiver::new(&receiver(&file.grid, &sampler.bias(), p, Some(n)), file.grid.size);
        (end_level(&file.tree, &r).map_or(-1.0, |level| level as f32), voxel_world)
    });
    for name in ["voxel:filter=1", "voxel:soft", "voxel+csm", "blur:base=voxel"] {
        assert_eq!(levels(&mut renderer, &baked, name).0, found, "{name}");
    }
}

#[test]
fn only_baked_files_have_voxel_levels() {
    let gpu = kit::gpu();
    for name in ["none", "pcf:size=256", "csm:size=256", "hrsm:256-128", "blur"] {
        let technique = build(&gpu, &name.parse().unwrap(), TechniqueFiles::default()).unwrap();
        assert!(technique.sources(Answer::Voxel).is_none() && technique.voxel_world().is_none(), "{name}");
    }
}
