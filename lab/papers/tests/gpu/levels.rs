//! The levels at which look-ups end, for each pixel of drawn frames: shaders against their CPU twins.

use adumbra_papers::techniques::{PaperFiles, TECHNIQUES};
use adumbra_papers::tree::Detail;
use adumbra_papers::tree::query::Weights;
use adumbra_render::{Answer, Renderer, SceneOptions, Techniques, build};

use crate::baked_tree::BakedTree;
use crate::kit;
use crate::points::nearby;

/// Returns the levels of a frame and the edge of a voxel in world units.
pub(crate) fn levels(renderer: &mut Renderer, files: &PaperFiles, name: &str) -> (Vec<f32>, f64) {
    let spec = Techniques::product().with(TECHNIQUES).parse(name).unwrap();
    let technique = build(renderer.gpu(), &spec, files.baked()).unwrap();
    let mut prepared = renderer.prepare(technique).unwrap();
    renderer.draw(&kit::shot(), &mut prepared, Answer::Voxel).unwrap();
    let voxel_world = prepared.technique().voxel_world().unwrap();
    (renderer.read_factor(&prepared).unwrap(), voxel_world)
}

/// Asserts that nearly every pixel equals the twin's answer, and that every other pixel equals the twin's
/// answer at a point at most 0.02 voxels away along each axis. f32 and f64 cannot agree more closely.
pub(crate) fn hold(renderer: &Renderer, found: &[f32], twin: impl Fn([f64; 3], [f64; 3]) -> (f32, f64)) {
    let shot = kit::shot();
    let anchor = shot.camera.view().eye.map(|c| f64::from(c as f32));
    let depth = renderer.read_surface(&shot).unwrap().view_depth;
    let (mut checked, mut differing) = (0, 0);
    let mut seen = [0; 16];
    for (at, surface) in kit::surfaces(renderer, &shot).iter().enumerate() {
        assert!(depth[at].is_finite() || found[at] == -1.0, "{at} of the sky is {}", found[at]);
        let Some((p_relative, normal)) = surface else { continue };
        let p: [f64; 3] = std::array::from_fn(|a| anchor[a] + f64::from(p_relative[a]));
        let n = normal.map(f64::from);
        let (expected, voxel_world) = twin(p, n);
        checked += 1;
        seen[(found[at] + 1.0) as usize] += 1;
        if found[at] == expected {
            continue;
        }
        differing += 1;
        let mut near = nearby().map(|offset| std::array::from_fn(|a| p[a] + voxel_world * offset[a]));
        assert!(
            near.any(|p| twin(p, n).0 == found[at]),
            "pixel {at}: {}, not {expected}, and on no face",
            found[at]
        );
    }
    eprintln!("{differing} of {checked} differ; by level from -1: {seen:?}");
    assert!(checked > 15_000 && differing * 500 < checked, "{differing} of {checked} differ");
    assert!(seen[1..].iter().filter(|n| **n > 100).count() > 1, "{seen:?}");
}

#[test]
fn tree_end_levels_match_cpu_in_every_store() {
    let rings = Detail::Rings { center_xz: [-75.0, 75.0], radii: vec![20.0, 60.0] };
    for detail in [Detail::Uniform, rings] {
        let baked = BakedTree::with_detail(kit::city(), 256, detail);
        let mut renderer = Renderer::new(kit::gpu(), &baked.scene, SceneOptions::default()).unwrap();
        let (found, voxel_world) = levels(&mut renderer, &baked.files(), "voxel-cubes");
        assert_eq!(voxel_world, baked.tree.space.voxel_size);
        let query = baked.query((3, Weights::Mean));
        hold(&renderer, &found, |p, n| {
            let level = query.receiver(p, Some(n)).map_or(-1.0, |r| query.end_level(&r) as f32);
            (level, query.voxel_size_at(p, Some(n)))
        });
        for name in ["voxel-texture", "voxel-texture:read=buffer"] {
            assert_eq!(levels(&mut renderer, &baked.files(), name).0, found, "{name}");
        }
    }
}
