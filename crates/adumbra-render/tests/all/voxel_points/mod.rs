//! Scenes baked into light-aligned files, points on and around them, and comparisons with the CPU twins.

use adumbra::query::{FixedReceiver, Receiver, receiver};
use adumbra::{Filter, Placement, Sampler, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_render::Gpu;
use adumbra_render::technique::{Resolver, Technique};
use adumbra_render::voxel::{BakedLight, Voxel, VoxelSettings};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_shaders::layout::{Frame, GpuType, PointQuery};
use adumbra_truth::verify::{Solids, SurfaceSampler};

/// A scene with its baked file.
pub(crate) struct BakedScene {
    pub(crate) scene: Scene,
    pub(crate) light: ShadowFile,
}

impl BakedScene {
    pub(crate) fn new(scene: Scene, sun: [f64; 3], resolution: u64) -> Self {
        Self::in_frame(scene, sun, resolution, FrameChoice::Light)
    }

    fn in_frame(scene: Scene, sun: [f64; 3], resolution: u64, frame: FrameChoice) -> Self {
        let sun = Sun::from_direction(sun).unwrap();
        let options = BakeOptions::new(sun, Size::Resolution(resolution)).with(|o| o.frame = frame);
        let light = Bake::with_options(&scene, &options).in_memory().unwrap();
        Self { scene, light }
    }

    /// Bakes generated scenes under a sun that is half high: one in the light's frame and one in the oblique
    /// frame.
    pub(crate) fn in_each_frame(resolution: u64) -> [Self; 2] {
        let bake = |kind, frame| Self::in_frame(generate(kind, 3), [0.5, 0.8, 0.35], resolution, frame);
        [
            bake(GeneratedKind::Primitives, FrameChoice::Light),
            bake(GeneratedKind::City, FrameChoice::ObliqueAt(0.4)),
        ]
    }

    fn sampler(&self, filter: Filter) -> Sampler {
        self.light.sampler(filter)
    }

    /// Returns random points: half on surfaces, a quarter in the scene's bounding box, a quarter in that box
    /// enlarged to all sides. Of the latter two, a third have a normal.
    pub(crate) fn points(&self, count: usize) -> Vec<([f64; 3], Option<[f64; 3]>)> {
        let solids = Solids::of(&self.scene);
        let sampler = SurfaceSampler::new(&self.scene, &solids, self.light.grid.sun.towards(), false);
        let bounds = self.scene.bounds();
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
    fn float_points(&self, count: usize) -> ([f64; 3], Vec<PointQuery>) {
        let b = self.scene.bounds();
        let anchor: [f64; 3] = std::array::from_fn(|a| f64::from((0.5 * (b.min[a] + b.max[a])) as f32));
        let asked = self.points(count).into_iter().map(|(p, n)| {
            let r: [f32; 3] = std::array::from_fn(|a| (p[a] - anchor[a]) as f32);
            let n = n.unwrap_or_default().map(|c| c as f32);
            PointQuery { p_relative: r, view_depth: 0.0, normal: n, pixel: [0; 2] }
        });
        (anchor, asked.collect())
    }
}

fn as_cpu(anchor: [f64; 3], q: &PointQuery) -> ([f64; 3], Option<[f64; 3]>) {
    let p = std::array::from_fn(|a| anchor[a] + f64::from(q.p_relative[a]));
    let n: [f64; 3] = std::array::from_fn(|a| f64::from(q.normal[a]));
    (p, (n != [0.0; 3]).then_some(n))
}

pub(crate) fn exact_light(gpu: &Gpu, baked: &BakedScene, filter: Filter, count: usize) {
    let (grid, settings) = (&baked.light.grid, &baked.light.settings);
    let light = BakedLight::from_file(gpu, &baked.light, VoxelSettings::taps(filter, settings.bias)).unwrap();
    let sampler = baked.sampler(filter);
    let receivers: Vec<FixedReceiver> = baked
        .points(count)
        .into_iter()
        .map(|(p, n)| FixedReceiver::new(&receiver(grid, &settings.bias, p, n), baked.light.grid.size))
        .collect();
    let counts = light.lit_taps(gpu, &receivers).unwrap();
    let mut partly = 0;
    for (r, found) in receivers.iter().zip(&counts) {
        let expected = sampler.lit_taps(r);
        assert_eq!(*found, expected, "{filter:?}: {r:?}");
        partly += usize::from(expected > 0 && expected < filter.width().pow(2));
    }
    assert!(
        counts.len() == count && (filter == Filter::Nearest || partly * 200 > count),
        "{partly} partly lit"
    );
}

/// Looks up points with a technique whose anchor they are relative to.
pub(crate) fn answer(gpu: &Gpu, technique: &dyn Technique, points: &[PointQuery]) -> Vec<f32> {
    let resolver = Resolver::new(gpu);
    let lookup = resolver.lookup(gpu, technique);
    // Voxel techniques need the frame's binding but not its content: anchor and sun are in their own uniform.
    let frame = gpu.uniform("frame", &vec![0; Frame::SIZE]);
    resolver.answer(gpu, &frame, technique, &lookup, points).unwrap()
}

/// Offsets of 0, 0.02 or -0.02 voxels along each axis.
fn nearby() -> impl Iterator<Item = [f64; 3]> {
    (0..27).map(|i| [i / 9, i / 3 % 3, i % 3].map(|c| 0.02 * (f64::from(c) - 1.0)))
}

/// Asserts that at most 1 in `one_in` answers differs from the CPU's. Each of these must equal the CPU's
/// answer at a point at most 0.02 voxels away along each axis.
fn compare(
    name: &str,
    (found, one_in): (&[f32], usize),
    expected: impl Fn(usize) -> f32,
    within_reach: impl Fn(usize, [f64; 3]) -> f32,
) {
    let same = |a: f32, b: f32| (a - b).abs() < 1e-5;
    let lit = found.iter().filter(|f| **f > 0.5).count();
    assert!(lit * 200 > found.len() && lit * 200 < 199 * found.len(), "{name}: {lit} lit");
    let differing: Vec<usize> = (0..found.len()).filter(|&i| !same(found[i], expected(i))).collect();
    eprintln!("{name}: {} of {} differ", differing.len(), found.len());
    assert!(differing.len() * one_in <= found.len(), "{name}: {} of {} differ", differing.len(), found.len());
    for i in differing {
        let near = nearby().any(|offset| same(found[i], within_reach(i, offset)));
        assert!(near, "{name}: point {i}: {}, not {}, and on no face", found[i], expected(i));
    }
}

pub(crate) fn float_light(gpu: &Gpu, baked: &BakedScene, filter: Filter, count: usize) {
    let bias = baked.light.settings.bias;
    let light = BakedLight::from_file(gpu, &baked.light, VoxelSettings::taps(filter, bias)).unwrap();
    float_light_at(gpu, baked, light, (filter, Placement::BAKED), count);
}

/// Places a light after its file was uploaded.
pub(crate) fn placed_light(gpu: &Gpu, baked: &BakedScene, placement: Placement, count: usize) {
    let (filter, bias) = (Filter::Box5, baked.light.settings.bias);
    let mut light = BakedLight::from_file(gpu, &baked.light, VoxelSettings::taps(filter, bias)).unwrap();
    light.place(placement);
    float_light_at(gpu, baked, light, (filter, placement), count);
}

fn float_light_at(
    gpu: &Gpu,
    baked: &BakedScene,
    mut light: BakedLight,
    (filter, placement): (Filter, Placement),
    count: usize,
) {
    let (grid, bias) = (baked.light.grid.placed(&placement), baked.light.settings.bias);
    let (anchor_file, in_file) = baked.float_points(count);
    let anchor = placement.to_world(anchor_file).map(|c| f64::from(c as f32));
    let points: Vec<PointQuery> = in_file
        .iter()
        .map(|query| {
            let (p, n) = as_cpu(anchor_file, query);
            let p_world = placement.to_world(p);
            let normal = placement.direction_to_world(n.unwrap_or_default()).map(|c| c as f32);
            PointQuery { p_relative: [0, 1, 2].map(|a| (p_world[a] - anchor[a]) as f32), normal, ..*query }
        })
        .collect();
    light.set_anchor(gpu, anchor).unwrap();
    let voxel = Voxel::new(format!("voxel:filter={}", filter.width()), light);
    let found = answer(gpu, &voxel, &points);
    // Rotated normals are rounded, and so are their gradients.
    let one_in = if placement == Placement::BAKED { 10_000 } else { 2000 };
    let sampler = baked.sampler(filter);
    let receiver_of = |i: usize| {
        let (p, n) = as_cpu(anchor, &points[i]);
        receiver(&grid, &bias, p, n)
    };
    compare(
        &voxel.name(),
        (&found, one_in),
        |i| sampler.receiver_visibility(&receiver_of(i)),
        |i, offset| {
            let r = receiver_of(i);
            let p_grid = std::array::from_fn(|a| r.p_grid[a] + offset[a]);
            sampler.receiver_visibility(&Receiver { p_grid, ..r })
        },
    );
}
