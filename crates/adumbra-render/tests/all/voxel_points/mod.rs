//! Scenes baked into light-aligned and world-aligned files, points on and around them, and comparisons with the CPU
//! twins.

use adumbra::query::{FixedReceiver, Receiver, receiver};
use adumbra::{Bias, Layout, Query, ShadowFile, Sun};
use adumbra_bake::convert::{body_in, graph_of};
use adumbra_bake::{BakeOptions, FrameChoice, LayoutChoice, Size, Watch};
use adumbra_render::technique::{Resolver, Technique};
use adumbra_render::voxel::{BakedLight, Cubes, CubesOptions, CubesStore, Voxel, VoxelSettings};
use adumbra_render::{Gpu, Result};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_shaders::layout::{Frame, GpuType, PointQuery};
use adumbra_testing::bake_file;
use adumbra_tree::query::{TreeQuery, Weights};
use adumbra_tree::{Detail, TreeBody, TreeFile, TreeOptions, VoxelTree, bake_tree};
use adumbra_truth::verify::{Solids, SurfaceSampler};

/// A scene with its baked files.
pub(crate) struct BakedScene {
    pub(crate) scene: Scene,
    pub(crate) light: ShadowFile,
    pub(crate) tree: TreeFile,
}

impl BakedScene {
    pub(crate) fn new(scene: Scene, sun: [f64; 3], resolution: u64, tree_side: u64) -> Self {
        Self::with_detail(scene, sun, resolution, tree_side, Detail::Uniform)
    }

    /// Bakes generated scenes under a sun that is half high: one in the light's frame and one in the oblique frame.
    pub(crate) fn in_each_frame(resolution: u64, tree_side: u64) -> [Self; 2] {
        let sun = [0.5, 0.8, 0.35];
        let primitives = Self::new(generate(GeneratedKind::Primitives, 3), sun, resolution, tree_side);
        let frame = FrameChoice::ObliqueAt(0.4);
        let mut city = Self::new(generate(GeneratedKind::City, 3), sun, resolution, tree_side);
        city.light = light_file(&city.scene, sun, resolution, frame);
        [primitives, city]
    }

    pub(crate) fn with_detail(
        scene: Scene,
        sun: [f64; 3],
        resolution: u64,
        side: u64,
        detail: Detail,
    ) -> Self {
        let light = light_file(&scene, sun, resolution, FrameChoice::Light);
        let options = TreeOptions { detail, ..TreeOptions::new(light.grid.sun, Size::Resolution(side)) };
        let tree = TreeFile::from(bake_tree(&scene, &options, Watch::none()).unwrap());
        Self { scene, light, tree }
    }

    /// Returns a copy with the light-aligned file in another layout.
    pub(crate) fn in_layout(&self, layout: Layout) -> Self {
        let light = &self.light;
        let body = body_in(layout, graph_of(&light.body).unwrap().into_owned()).unwrap();
        let light = ShadowFile { grid: light.grid, settings: light.settings, body };
        Self { scene: self.scene.clone(), light, tree: self.tree.clone() }
    }

    fn voxels(&self) -> &VoxelTree {
        match &self.tree.body {
            TreeBody::Words(tree) => tree,
            TreeBody::Symmetric(_) => unreachable!("made of words"),
        }
    }

    pub(crate) fn words(&self) -> &[u32] {
        self.voxels().words()
    }

    fn query(&self, filter: u32) -> Query<'_> {
        Query::new(&self.light.grid, self.light.leaf_masks(), self.light.settings.bias, filter).unwrap()
    }

    fn tree_query(&self, (side, weights): (u32, Weights)) -> TreeQuery<'_, VoxelTree> {
        let t = &self.tree;
        TreeQuery::new(&t.space, &t.regions, &t.sun, self.voxels(), t.settings.bias, side, weights).unwrap()
    }

    /// Returns random points: half on surfaces, a quarter in the scene's bounding box, a quarter in that box enlarged
    /// to all sides. Of the latter two, a third have a normal.
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

    /// Returns an anchor at the middle of the scene, and the points as a shader receives them: f32 positions relative
    /// to it.
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

fn light_file(scene: &Scene, sun: [f64; 3], resolution: u64, frame: FrameChoice) -> ShadowFile {
    let sun = Sun::from_direction(sun).unwrap();
    let options = BakeOptions { frame, ..BakeOptions::new(sun, Size::Resolution(resolution)) };
    bake_file(scene, &options, LayoutChoice::Plain).unwrap()
}

fn as_cpu(anchor: [f64; 3], q: &PointQuery) -> ([f64; 3], Option<[f64; 3]>) {
    let p = std::array::from_fn(|a| anchor[a] + f64::from(q.p_relative[a]));
    let n: [f64; 3] = std::array::from_fn(|a| f64::from(q.normal[a]));
    (p, (n != [0.0; 3]).then_some(n))
}

pub(crate) fn exact_light(gpu: &Gpu, baked: &BakedScene, filter: u32, count: usize) {
    let (grid, settings) = (&baked.light.grid, &baked.light.settings);
    let light = BakedLight::from_file(gpu, &baked.light, VoxelSettings::taps(filter, settings.bias)).unwrap();
    let query = baked.query(filter);
    let receivers: Vec<FixedReceiver> = baked
        .points(count)
        .into_iter()
        .map(|(p, n)| FixedReceiver::new(&receiver(grid, &settings.bias, p, n), baked.light.grid.size))
        .collect();
    let counts = light.lit_taps(gpu, &receivers).unwrap();
    let mut partly = 0;
    for (r, found) in receivers.iter().zip(&counts) {
        let expected = query.lit_taps(r);
        assert_eq!(*found, expected, "filter {filter}: {r:?}");
        partly += usize::from(expected > 0 && expected < filter * filter);
    }
    assert!(counts.len() == count && (filter == 1 || partly * 200 > count), "{partly} partly lit");
}

pub(crate) fn try_cubes(
    gpu: &Gpu,
    baked: &BakedScene,
    store: CubesStore,
    (filter, weights): (u32, Weights),
) -> Result<Cubes> {
    let bias: Bias = baked.tree.settings.bias;
    Cubes::new(gpu, &baked.tree, CubesOptions { bias, filter, weights, all_taps: false, store })
}

pub(crate) fn exact_cubes(
    gpu: &Gpu,
    baked: &BakedScene,
    store: CubesStore,
    kernel: (u32, Weights),
    count: usize,
) {
    let cubes = try_cubes(gpu, baked, store, kernel).unwrap();
    let query = baked.tree_query(kernel);
    let receivers: Vec<_> =
        baked.points(count).into_iter().filter_map(|(p, n)| query.receiver(p, n)).collect();
    let found = cubes.lit_weights(gpu, &receivers).unwrap();
    let mut partly = 0;
    for (r, found) in receivers.iter().zip(&found) {
        let expected = query.lit_weights(r);
        // The quotients of whole numbers must be equal.
        assert!(
            found[1] > 0 && found[0] * expected[1] == expected[0] * found[1],
            "{kernel:?}: {r:?} {found:?} {expected:?}"
        );
        partly += usize::from(expected[0] > 0 && expected[0] < expected[1]);
    }
    assert!(found.len() * 2 > count && (kernel.0 == 1 || partly * 200 > count), "{partly} partly lit");
}

/// Looks up points with a technique whose anchor they are relative to.
fn answer(gpu: &Gpu, technique: &dyn Technique, points: &[PointQuery]) -> Vec<f32> {
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

/// Asserts that at most 1 in 10,000 answers differs from the CPU's, and that each of those equals the CPU's answer at
/// most 0.02 voxels away along each axis.
fn compare(
    name: &str,
    found: &[f32],
    expected: impl Fn(usize) -> f32,
    within_reach: impl Fn(usize, [f64; 3]) -> f32,
) {
    let same = |a: f32, b: f32| (a - b).abs() < 1e-5;
    let lit = found.iter().filter(|f| **f > 0.5).count();
    assert!(lit * 200 > found.len() && lit * 200 < 199 * found.len(), "{name}: {lit} lit");
    let differing: Vec<usize> = (0..found.len()).filter(|&i| !same(found[i], expected(i))).collect();
    eprintln!("{name}: {} of {} differ", differing.len(), found.len());
    assert!(differing.len() * 10_000 <= found.len(), "{name}: {} of {} differ", differing.len(), found.len());
    for i in differing {
        let near = nearby().any(|offset| same(found[i], within_reach(i, offset)));
        assert!(near, "{name}: point {i}: {}, not {}, and on no face", found[i], expected(i));
    }
}

pub(crate) fn float_light(gpu: &Gpu, baked: &BakedScene, filter: u32, count: usize) {
    let (grid, bias) = (&baked.light.grid, baked.light.settings.bias);
    let (anchor, points) = baked.float_points(count);
    let mut light = BakedLight::from_file(gpu, &baked.light, VoxelSettings::taps(filter, bias)).unwrap();
    light.set_anchor(gpu, anchor).unwrap();
    let voxel = Voxel::new(format!("voxel:filter={filter}"), light);
    let found = answer(gpu, &voxel, &points);
    let query = baked.query(filter);
    let receiver_of = |i: usize| {
        let (p, n) = as_cpu(anchor, &points[i]);
        receiver(grid, &bias, p, n)
    };
    compare(
        &voxel.name(),
        &found,
        |i| query.receiver_visibility(&receiver_of(i)),
        |i, offset| {
            let r = receiver_of(i);
            let p_grid = std::array::from_fn(|a| r.p_grid[a] + offset[a]);
            query.receiver_visibility(&Receiver { p_grid, ..r })
        },
    );
}

pub(crate) fn float_cubes(gpu: &Gpu, baked: &BakedScene, kernel: (u32, Weights), count: usize) {
    let (anchor, points) = baked.float_points(count);
    let mut cubes = try_cubes(gpu, baked, CubesStore::Words, kernel).unwrap();
    cubes.set_anchor(gpu, anchor).unwrap();
    let found = answer(gpu, &cubes, &points);
    let query = baked.tree_query(kernel);
    compare(
        &cubes.name(),
        &found,
        |i| {
            let (p, n) = as_cpu(anchor, &points[i]);
            query.visibility(p, n)
        },
        |i, offset| {
            let (p, n) = as_cpu(anchor, &points[i]);
            let size = query.voxel_size_at(p, n);
            query.visibility(std::array::from_fn(|a| p[a] + size * offset[a]), n)
        },
    );
}
