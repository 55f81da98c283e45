//! Points on and around a scene, and answers at them compared with a CPU twin's.

use adumbra::Sun;
use adumbra_render::Gpu;
use adumbra_render::technique::{Resolver, Technique};
use adumbra_scene::Scene;
use adumbra_scene::random::Random;
use adumbra_shaders::layout::{Frame, GpuType, PointQuery};
use adumbra_truth::verify::{Solids, SurfaceSampler};

use crate::kit::SUN;

/// Returns random points: half on surfaces, a quarter in the scene's bounding box, a quarter in that box
/// enlarged to all sides. Of the latter two, a third have a normal.
pub(crate) fn points(scene: &Scene, count: usize) -> Vec<([f64; 3], Option<[f64; 3]>)> {
    let solids = Solids::of(scene);
    let sampler = SurfaceSampler::new(scene, &solids, Sun::from_direction(SUN).unwrap().towards(), false);
    let bounds = scene.bounds();
    let mut random = Random::for_batch(17, 0);
    let point = |i: usize| {
        if i.is_multiple_of(2) {
            let s = sampler.sample(&mut random);
            return (s.p_world, s.normal);
        }
        let beyond = if i % 4 == 1 { 0.0 } else { 0.4 };
        let p = std::array::from_fn(|a| {
            let extent = bounds.max[a] - bounds.min[a];
            bounds.min[a] + (random.unit() * (1.0 + 2.0 * beyond) - beyond) * extent
        });
        let n: [f64; 3] = std::array::from_fn(|_| random.unit() * 2.0 - 1.0);
        let length = n.iter().map(|c| c * c).sum::<f64>().sqrt().max(1e-3);
        (p, i.is_multiple_of(3).then_some(n.map(|c| c / length)))
    };
    (0..count).map(point).collect()
}

/// Returns an anchor at the middle of the scene, and the points as a shader receives them: f32 positions
/// relative to it.
pub(crate) fn float_points(scene: &Scene, count: usize) -> ([f64; 3], Vec<PointQuery>) {
    let b = scene.bounds();
    let anchor: [f64; 3] = std::array::from_fn(|a| f64::from((0.5 * (b.min[a] + b.max[a])) as f32));
    let asked = points(scene, count).into_iter().map(|(p, n)| {
        let r: [f32; 3] = std::array::from_fn(|a| (p[a] - anchor[a]) as f32);
        let n = n.unwrap_or_default().map(|c| c as f32);
        PointQuery { p_relative: r, view_depth: 0.0, normal: n, pixel: [0; 2] }
    });
    (anchor, asked.collect())
}

/// Looks up points, given relative to the anchor of the technique.
fn answer(gpu: &Gpu, technique: &dyn Technique, points: &[PointQuery]) -> Vec<f32> {
    let resolver = Resolver::new(gpu);
    let lookup = resolver.lookup(gpu, technique);
    // Voxel techniques need the frame's binding but not its content: anchor and sun are in their own uniform.
    let frame = gpu.uniform("frame", &vec![0; Frame::SIZE]);
    resolver.answer(gpu, &frame, technique, &lookup, points).unwrap()
}

/// Asserts that at most 1 in 10,000 answers differs from the twin's, and that each such answer equals the
/// twin's answer at a point at most 0.02 voxels away along each axis.
pub(crate) fn hold_floats(
    gpu: &Gpu,
    technique: &dyn Technique,
    (anchor, points): ([f64; 3], &[PointQuery]),
    twin: impl Fn([f64; 3], Option<[f64; 3]>) -> f32,
    voxel_world: impl Fn([f64; 3], Option<[f64; 3]>) -> f64,
) {
    let (name, found) = (technique.name(), answer(gpu, technique, points));
    let receiver = |i: usize| {
        let p: [f64; 3] = std::array::from_fn(|a| anchor[a] + f64::from(points[i].p_relative[a]));
        let n: [f64; 3] = points[i].normal.map(f64::from);
        (p, (n != [0.0; 3]).then_some(n))
    };
    let expected = |i: usize| {
        let (p, n) = receiver(i);
        twin(p, n)
    };
    let same = |a: f32, b: f32| (a - b).abs() < 1e-5;
    let lit = found.iter().filter(|f| **f > 0.5).count();
    assert!(lit * 200 > found.len() && lit * 200 < 199 * found.len(), "{name}: {lit} lit");
    let differing: Vec<usize> = (0..found.len()).filter(|&i| !same(found[i], expected(i))).collect();
    eprintln!("{name}: {} of {} differ", differing.len(), found.len());
    assert!(differing.len() * 10_000 <= found.len(), "{name}: {} of {} differ", differing.len(), found.len());
    for i in differing {
        let (p, n) = receiver(i);
        let size = voxel_world(p, n);
        let mut near = nearby().map(|offset| std::array::from_fn(|a| p[a] + size * offset[a]));
        let near = near.any(|p| same(found[i], twin(p, n)));
        assert!(near, "{name}: point {i}: {}, not {}, and on no face", found[i], expected(i));
    }
}

/// Offsets of 0, 0.02 or -0.02 voxels along each axis.
pub(crate) fn nearby() -> impl Iterator<Item = [f64; 3]> {
    (0..27).map(|i| [i / 9, i / 3 % 3, i % 3].map(|c| 0.02 * (f64::from(c) - 1.0)))
}
