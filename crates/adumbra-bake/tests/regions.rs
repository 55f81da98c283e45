//! Worlds in regions: look-ups in their files answer as look-ups in one file of the whole world do.

use std::fs::File;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::Arc;

use adumbra::regions::{RegionSampler, Regions};
use adumbra::{Bounds, Filter, LightGrid, RangeField, Region, ShadowFile, Sun};
use adumbra_bake::{
    Bake, BakeCache, BakeField, BakeOptions, BakePlan, Baker, Error, FrameChoice, MemoryCache, PartBaker,
    RegionPlan, Size, Watch,
};
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_testing::{add_box, add_quad, full, scene_of};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{
    self, ClassResult, LightAnswers, Solids, SurfaceSampler, Verifier, VerifyOptions,
};
use tempfile::TempDir;

const TEXELS: u32 = 1024;

/// The files of a world's regions, in a folder.
struct World {
    folder: TempDir,
    plan: RegionPlan,
}

impl World {
    fn bake(scene: &Scene, options: &BakeOptions) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let plan = RegionPlan::new(scene, options, TEXELS).unwrap();
        let world = Self { folder, plan };
        for region in world.plan.regions() {
            let out = File::create(world.folder.path().join(Self::name(region))).unwrap();
            Bake::with_options(scene, &world.plan.options(region)).write_to(out).unwrap();
        }
        std::fs::write(world.manifest(), world.regions(options.sun).to_json()).unwrap();
        world
    }

    fn name(region: Region) -> String {
        format!("{}_{}.adumbra", region.x, region.y)
    }

    fn manifest(&self) -> PathBuf {
        self.folder.path().join("world.json")
    }

    fn regions(&self, sun: Sun) -> Regions {
        let files = self.plan.regions().map(|region| (region, Self::name(region)));
        Regions::new(sun, self.plan.frame(), self.plan.voxel_size(), TEXELS, files).unwrap()
    }

    fn sampler(&self, filter: Filter) -> RegionSampler {
        Regions::read(self.manifest()).unwrap().sampler(self.manifest(), filter).unwrap()
    }

    /// Bakes the whole world into one file with the same voxels.
    fn whole(&self, scene: &Scene, options: &BakeOptions) -> ShadowFile {
        let region = self.plan.regions().next().unwrap();
        let shared = self.plan.options(region).with(|o| o.region = None);
        assert_eq!(shared.levels, options.levels);
        Bake::with_options(scene, &shared).in_memory().unwrap()
    }
}

/// Verifies a world's regions and its single file with rays, and checks that the results are equal, or nearly
/// equal for filters of 9 texels or more. The world must have at least `least_regions` regions. Returns the
/// share of the points in shadow.
fn assert_answers_are_equal(
    scene: &Scene,
    options: &BakeOptions,
    filters: &[Filter],
    samples: u64,
    least_regions: usize,
) -> f64 {
    let world = World::bake(scene, options);
    assert!(world.plan.regions().len() >= least_regions, "only {} regions", world.plan.regions().len());
    let whole = world.whole(scene, options);
    let solids = Solids::of(scene);
    let tracer = Tracer::build(scene, TraceOptions { ignore_alpha: false });
    let surfaces = SurfaceSampler::new(scene, &solids, whole.sun().towards(), false);
    let surfaces = verify::Sampler::Surface(surfaces);
    let mut shadowed = 0.0;
    for &filter in filters {
        let sampler = world.sampler(filter);
        let settings = *sampler.settings().expect("there are regions");
        let asked = (filter, settings.bias);
        let lattice = LightGrid { corner: whole.grid.corner, size: whole.grid.size, ..*sampler.grid() };
        assert_eq!(lattice, whole.grid, "the voxels are others");
        let regions = LightAnswers::new(*sampler.grid(), settings, sampler, asked);
        let one = LightAnswers::of(&whole, whole.sampler(filter));
        let options = VerifyOptions { samples, seed: 5 };
        let [expected, found] = [
            Verifier::new(&one, &tracer, &solids).run(&surfaces, &options),
            Verifier::new(&regions, &tracer, &solids).run(&surfaces, &options),
        ];
        assert!(expected.is_checked());
        if filter.width() < 9 {
            assert_eq!(found, expected, "{filter:?}");
        }
        // Beside walls, wide filters read voxels for which either answer is valid. These voxels depend on the
        // root blocks, which are larger in the single file.
        for (found, expected) in found.classes.iter().zip(&expected.classes) {
            assert!(
                (found.agreement - expected.agreement).abs() < 2e-4,
                "{filter:?}: {found:?}, {expected:?}"
            );
            let counts = |class: &ClassResult| (class.points, class.acne, class.leak, class.holds);
            assert_eq!(counts(found), counts(expected), "{filter:?}: {found:?}, {expected:?}");
        }
        shadowed = expected.shadowed_share;
    }
    shadowed
}

fn sun() -> Sun {
    Sun::from_direction([0.5, 0.8, 0.35]).unwrap()
}

fn options(frame: FrameChoice, voxels: f64) -> BakeOptions {
    BakeOptions::new(sun(), Size::Resolution(voxels as u64)).with(|o| {
        o.frame = frame;
        o.levels = 2;
    })
}

#[test]
fn regions_of_a_small_scene_answer_as_one_file_does() {
    let options = options(FrameChoice::Auto, 2048.0);
    assert_answers_are_equal(&generate(GeneratedKind::Primitives, 3), &options, &[Filter::Box5], 5000, 4);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn regions_answer_as_one_file_does() {
    let options = options(FrameChoice::Auto, 4096.0);
    let filters = [Filter::Box5, Filter::Box17];
    let shadowed = assert_answers_are_equal(&generate(GeneratedKind::City, 3), &options, &filters, 30_000, 5);
    assert!(shadowed > 0.2, "only {shadowed} of the points are in shadow");
}

#[test]
#[ignore = "slow: three scenes and every filter with ADUMBRA_FULL"]
fn regions_of_other_scenes_and_frames_answer_as_one_file_does() {
    let all = [
        (GeneratedKind::Wires, FrameChoice::Light),
        (GeneratedKind::Landscape, FrameChoice::Oblique),
        (GeneratedKind::City, FrameChoice::Light),
    ];
    for (kind, frame) in all.into_iter().take(if full() { 3 } else { 1 }) {
        let filters: &[Filter] = if full() { &Filter::ALL } else { &[Filter::Nearest, Filter::Box9] };
        let shadowed =
            assert_answers_are_equal(&generate(kind, 3), &options(frame, 4096.0), filters, 30_000, 5);
        assert!(shadowed > 0.03, "{kind:?}: only {shadowed} of the points are in shadow");
    }
}

/// A ground of two triangles, a box of a kilometre and a few small ones, near to and far from the world's
/// origin.
fn wide_world(at: f32) -> Scene {
    let mut mesh = adumbra_scene::Mesh::default();
    let side = 1500.0;
    let ground = [[0.0, 0.0], [0.0, side], [side, side], [side, 0.0]];
    add_quad(&mut mesh, ground.map(|[x, z]| [at + x, 0.0, at + z]));
    add_box(&mut mesh, [at + 100.0, -1.0, at + 700.0], [at + 1100.0, 30.0, at + 710.0]);
    for i in 0..40_u8 {
        let (x, z) = (at + 37.0 * f32::from(i), at + 350.0 + 23.0 * f32::from(i));
        add_box(&mut mesh, [x, 0.0, z], [x + 3.0, 8.0, z + 2.0]);
    }
    scene_of(vec![mesh])
}

#[test]
#[ignore = "slow: wide worlds; two of them and every filter with ADUMBRA_FULL"]
fn regions_far_from_the_origin_answer_as_one_file_does() {
    let filters: &[Filter] = if full() { &Filter::ALL } else { &[Filter::Nearest, Filter::Box9] };
    let worlds = [(60_000.0, [-0.3, 0.9, 0.4]), (-700.0, [0.7, 0.25, 0.2])];
    for (at, direction) in worlds.into_iter().take(if full() { 2 } else { 1 }) {
        let sun = Sun::from_direction(direction).unwrap();
        for frame in [FrameChoice::Light, FrameChoice::ObliqueAt(0.4)] {
            let options = BakeOptions::new(sun, Size::VoxelSize(0.5)).with(|o| {
                o.frame = frame;
                o.levels = 2;
            });
            let shadowed = assert_answers_are_equal(&wide_world(at), &options, filters, 30_000, 5);
            assert!(shadowed > 0.005, "{at} {frame:?}: only {shadowed} of the points are in shadow");
        }
    }
}

#[test]
fn worlds_too_wide_for_a_file_are_cut_into_regions() {
    // 2,000,000 texels across.
    let scene = wide_world(0.0);
    let options = BakeOptions::new(sun(), Size::VoxelSize(0.000_75)).with(|o| o.levels = 2);
    assert!(matches!(Bake::with_options(&scene, &options).in_memory(), Err(Error::Range(_))));
    let plan = RegionPlan::new(&scene, &options, 1 << 17).unwrap();
    assert!(plan.regions().len() > 200, "{}", plan.regions().len());
    let mut all: Vec<Region> = plan.regions().collect();
    let mut shared: Vec<Region> = (0..7).flat_map(|shard| plan.shard(shard, 7)).collect();
    shared.sort();
    all.sort();
    assert_eq!(shared, all);
    let plan = RegionPlan::new(&scene, &options, TEXELS);
    assert!(matches!(plan, Err(Error::Range(e)) if e.field == BakeField::VoxelSize), "a million regions");
}

#[test]
fn parts_of_a_region_link_to_the_bytes_of_its_bake() {
    let scene = generate(GeneratedKind::Primitives, 3);
    let plan = RegionPlan::new(&scene, &options(FrameChoice::Oblique, 2048.0), TEXELS).unwrap();
    let cache: Arc<dyn BakeCache> = Arc::new(MemoryCache::default());
    let mut reused = 0;
    for region in plan.regions().take(3) {
        let options = plan.options(region);
        let mut fresh = Cursor::new(Vec::new());
        Bake::with_options(&scene, &options).write_to(&mut fresh).unwrap();
        let parts = BakePlan::new(&scene, &options).unwrap();
        let parts: BakePlan = serde_json::from_str(&serde_json::to_string(&parts).unwrap()).unwrap();
        let ids: Vec<usize> = (0..parts.parts().len()).collect();
        let baker = PartBaker::new(&scene, &parts, &options).unwrap();
        baker.bake(&ids, &cache, Watch::none()).unwrap();
        let mut linked = Cursor::new(Vec::new());
        parts.link(&cache, &options, Watch::none(), &mut linked).unwrap();
        assert!(linked.get_ref() == fresh.get_ref(), "{region:?}");
        let mut again = Cursor::new(Vec::new());
        let written =
            Bake::with_options(&scene, &options).cache(Arc::clone(&cache)).write_to(&mut again).unwrap();
        reused += written.report.reused_root_blocks;
        assert!(again.get_ref() == fresh.get_ref(), "{region:?}");
        // An edit in memory gives the same file too.
        let mut baker = Baker::new(scene.clone(), &options).unwrap();
        baker.bake(None, Watch::none()).unwrap();
        assert!(baker.in_memory().unwrap() == ShadowFile::from_bytes(fresh.get_ref()).unwrap(), "{region:?}");
        let mut coarse = Cursor::new(Vec::new());
        baker.write_coarser_to(&mut coarse, Watch::none()).unwrap();
        let coarse = ShadowFile::from_bytes(coarse.get_ref()).unwrap();
        assert!(
            Some(coarse.grid) == baker.in_memory().unwrap().level(1).map(|level| level.grid),
            "{region:?}"
        );
    }
    assert!(reused > 0, "nothing was taken from the entries");
}

#[test]
fn wrong_regions_are_refused() {
    let scene = generate(GeneratedKind::Primitives, 3);
    let options = options(FrameChoice::Oblique, 2048.0);
    for texels in [0, 512, 1000, 1 << 18] {
        let error = RegionPlan::new(&scene, &options, texels).unwrap_err();
        let Error::File(adumbra::Error::Range(error)) = error else { panic!("{texels}: {error}") };
        assert_eq!(error.field, RangeField::RegionTexels, "{texels}");
    }
    let bounds = Some(Bounds { min: [-1.0; 3], max: [1.0; 3] });
    let error = RegionPlan::new(&scene, &options.clone().with(|o| o.bounds = bounds), TEXELS).unwrap_err();
    assert!(matches!(error, Error::Range(e) if e.field == BakeField::Bounds));
    let world = World::bake(&scene, &options);
    let regions: Vec<Region> = world.plan.regions().collect();
    let path = |at: usize| world.folder.path().join(World::name(regions[at]));
    // In place of a region's file: a neighbour's, one of another sun, and none.
    let own = std::fs::read(path(0)).unwrap();
    std::fs::copy(path(1), path(0)).unwrap();
    let manifest = Regions::read(world.manifest()).unwrap();
    let sampler = || manifest.sampler(world.manifest(), Filter::Box5).map(drop);
    let error = sampler().unwrap_err();
    assert!(error.to_string().contains("is not the file of region"), "{error}");
    let other = Sun::from_direction([0.5, 0.8, 0.3]).unwrap();
    let other = RegionPlan::new(&scene, &options.with(|o| o.sun = other), TEXELS).unwrap();
    let region = other.regions().next().unwrap();
    Bake::with_options(&scene, &other.options(region)).write_to(File::create(path(0)).unwrap()).unwrap();
    let error = sampler().unwrap_err();
    assert!(error.to_string().contains("is not the file of region"), "{error}");
    std::fs::remove_file(path(0)).unwrap();
    assert!(matches!(sampler(), Err(adumbra::Error::Io(_))));
    std::fs::write(path(0), own).unwrap();
    sampler().unwrap();
}
