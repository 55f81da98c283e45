//! Techniques beside rays, for tests that hold one scene against another.

use adumbra::camera::Camera;
use adumbra::format::ShadowFile;
use adumbra::light::Sun;
use adumbra::scene::Scene;
use adumbra_lab::compare::{Comparison, Contender, Judge, compare, truth_for};
use adumbra_lab::truth::{Cache, TruthTracer, scene_key};
use adumbra_render::{Baked, Renderer, TechniqueSpec, build};

/// What each camera gives of the techniques called `names`, one frame each.
pub(crate) fn comparisons(
    renderer: &mut Renderer,
    scene: &Scene,
    file: Option<&ShadowFile>,
    sun: Sun,
    cameras: &[Camera],
    names: &[&str],
) -> Vec<Comparison> {
    let truth = TruthTracer::build(scene, false);
    let key = scene_key(scene, false);
    let (cache, towards_sun) = (Cache::none(), sun.towards());
    let judge = Judge { truth: &truth, cache: &cache, scene: &key, towards_sun, disc: (0.53, 16) };
    let contender = |name: &&str| {
        let spec: TechniqueSpec = name.parse().unwrap();
        let technique = build(renderer.gpu(), &spec, Baked { light: file, tree: None }).unwrap();
        Contender { prepared: Some(renderer.prepare(technique).unwrap()), truth: truth_for(&spec), spec }
    };
    let mut contenders: Vec<Contender> = names.iter().map(contender).collect();
    cameras.iter().map(|c| compare(renderer, &judge, c, &mut contenders, 1).unwrap()).collect()
}
