//! Techniques compared with ray-traced truth, for tests that compare one scene with another.

use adumbra::grid::vec3::dot;
use adumbra::{ShadowFile, Sun};
use adumbra_compare::compare::{Comparison, Contender, Reference, compare, truth_for};
use adumbra_compare::truth::{Cache, TruthTracer, scene_key};
use adumbra_render::{Renderer, TechniqueFiles, TechniqueSpec, build};
use adumbra_scene::{Camera, Scene};

/// Moves a file's grid. A new bake at `place` would not do: the lattice of texels is anchored at the world's
/// origin, so the texels would be at other points of the surfaces.
pub(crate) fn moved(mut file: ShadowFile, place: [f64; 3]) -> ShadowFile {
    for (corner, axis) in file.grid.corner.iter_mut().zip(file.grid.axes) {
        *corner += dot(axis, place) / file.grid.voxel_size;
    }
    file
}

/// Compares the techniques called `names` with rays at each camera, one frame each.
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
    let reference = Reference { truth: &truth, cache: &cache, scene: &key, towards_sun, disc: (0.53, 16) };
    let contender = |name: &&str| {
        let spec: TechniqueSpec = name.parse().unwrap();
        let technique =
            build(renderer.gpu(), &spec, file.map(TechniqueFiles::of).unwrap_or_default()).unwrap();
        Contender { prepared: Some(renderer.prepare(technique).unwrap()), truth: truth_for(&spec), spec }
    };
    let mut contenders: Vec<Contender> = names.iter().map(contender).collect();
    cameras.iter().map(|c| compare(renderer, &reference, c, &mut contenders, 1).unwrap()).collect()
}
