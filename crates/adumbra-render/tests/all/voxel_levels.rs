//! The levels at which look-ups in baked files end, for each pixel of drawn frames: shaders against their CPU twins,
//! and layouts against each other.

use adumbra::query::{FixedReceiver, receiver};
use adumbra::{Layout, Query};
use adumbra_render::maps::twin::Surface;
use adumbra_render::{Answer, Baked, Renderer, SceneOptions, Shot, build};
use adumbra_tree::query::{TreeQuery, Weights};
use adumbra_tree::{Detail, VoxelTree};

use crate::kit;
use crate::kit::surfaces::surfaces;
use crate::voxel_points::BakedScene;

const SUN: [f64; 3] = [0.5, 0.8, 0.35];

fn baked(detail: Detail) -> BakedScene {
    BakedScene::with_detail(kit::city(), SUN, 1024, 256, detail)
}

fn renderer(baked: &BakedScene) -> Renderer {
    Renderer::new(kit::gpu(), &baked.scene, SceneOptions::default()).unwrap()
}

fn shot() -> Shot {
    Shot { camera: kit::camera(240, 160), towards_sun: kit::sun(), number: 0 }
}

/// Returns the levels of a frame and the edge of a voxel in world units.
fn levels(renderer: &mut Renderer, baked: &BakedScene, name: &str) -> (Vec<f32>, f64) {
    let files = Baked { light: Some(&baked.light), tree: Some(&baked.tree) };
    let technique = build(renderer.gpu(), &name.parse().unwrap(), files).unwrap();
    let mut prepared = renderer.prepare(technique).unwrap();
    renderer.draw(&shot(), &mut prepared, Answer::Voxel).unwrap();
    let voxel_world = prepared.technique().voxel_world().unwrap();
    (renderer.read_factor(&prepared).unwrap(), voxel_world)
}

/// Asserts that nearly every pixel equals the twin's answer, and every other one equals its answer at most 0.02 voxels
/// away along each axis. That is as close as f32 and f64 can agree.
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
fn voxel_levels_are_those_of_the_cpu_in_every_layout() {
    let plain = baked(Detail::Uniform);
    let mut renderer = renderer(&plain);
    let mut frames = Vec::new();
    for layout in [Layout::Plain, Layout::Packed, Layout::Depths] {
        let baked = plain.in_layout(layout);
        let (found, voxel_world) = levels(&mut renderer, &baked, "voxel:filter=9");
        let file = &baked.light;
        assert_eq!(voxel_world, file.grid.voxel_size);
        let bias = file.settings.bias;
        let query = Query::new(&file.grid, file.leaf_masks(), bias, 9).unwrap();
        hold(&format!("{layout:?}"), &renderer, &found, |p, n| {
            let r = FixedReceiver::new(&receiver(&file.grid, &bias, p, Some(n)), file.grid.size);
            (query.end_level(&r).map_or(-1.0, |level| level as f32), voxel_world)
        });
        if layout == Layout::Depths {
            assert_eq!(levels(&mut renderer, &baked, "voxel:soft").0, found);
        }
        frames.push(found);
    }
    // Both graphs give equal levels at every pixel, with every filter. Adding cascades or a blur does not change them.
    assert_eq!(frames[0], frames[1]);
    for name in ["voxel:filter=1", "voxel+csm", "blur:base=voxel"] {
        assert_eq!(levels(&mut renderer, &plain, name).0, frames[0], "{name}");
    }
}

#[test]
fn voxel_levels_of_trees_are_those_of_the_cpu_from_every_store() {
    let rings = Detail::Rings { center_xz: [-75.0, 75.0], radii: vec![20.0, 60.0] };
    for detail in [Detail::Uniform, rings] {
        let baked = baked(detail);
        let mut renderer = renderer(&baked);
        let (found, voxel_world) = levels(&mut renderer, &baked, "voxel-cubes");
        let file = &baked.tree;
        assert_eq!(voxel_world, file.space.voxel_size);
        let tree = VoxelTree::from_words(file.space.depth, baked.words().to_vec()).unwrap();
        let bias = file.settings.bias;
        let query =
            TreeQuery::new(&file.space, &file.regions, &file.sun, &tree, bias, 3, Weights::Mean).unwrap();
        hold("tree", &renderer, &found, |p, n| {
            let level = query.receiver(p, Some(n)).map_or(-1.0, |r| query.end_level(&r) as f32);
            (level, query.voxel_size_at(p, Some(n)))
        });
        for name in ["voxel-texture", "voxel-texture:read=buffer"] {
            assert_eq!(levels(&mut renderer, &baked, name).0, found, "{name}");
        }
    }
}

#[test]
fn voxel_levels_are_of_baked_files_alone() {
    let gpu = kit::gpu();
    for name in ["none", "pcf:size=256", "csm:size=256", "hrsm:256-128", "blur"] {
        let technique = build(&gpu, &name.parse().unwrap(), Baked::default()).unwrap();
        assert!(technique.sources(Answer::Voxel).is_none() && technique.voxel_world().is_none(), "{name}");
    }
}
