//! A comparison on a small generated scene: errors, pictures, the walk, and the report's format. Also checks
//! that baked voxels have smaller errors than cascades, as required.

use adumbra::{ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_compare::compare::{Comparison, Contender, Reference, camera_figures, compare, truth_for, walk};
use adumbra_compare::paths::CameraPath;
use adumbra_compare::report::{BakedFigures, Report, TruthKind};
use adumbra_compare::truth::{
    Cache, StreetOptions, SunShape, TruthTracer, scene_key, street_camera, truth_camera,
};
use adumbra_render::{
    Answer, Given, Gpu, GpuOptions, Renderer, SceneOptions, Shot, TechniqueFiles, TechniqueSpec, build,
};
use adumbra_scene::{Camera, GeneratedKind, LoadOptions, Projection, Scene, generate, load};
use adumbra_testing::{full, scene_file, shared};

const SIZE: [u32; 2] = [96, 64];

fn camera() -> Camera {
    let projection = Projection::Perspective { fov_degrees: 45.0 };
    Camera { eye: [-12.0, 11.0, 17.0], target: [0.0, 0.5, 0.0], projection, width: SIZE[0], height: SIZE[1] }
}

fn renderer(scene: &Scene) -> Renderer {
    let gpu = Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    Renderer::new(gpu, scene, SceneOptions::default()).unwrap()
}

fn contender(renderer: &Renderer, name: &str, truth: TruthKind) -> Contender {
    let spec: TechniqueSpec = name.parse().unwrap();
    let prepared = (name != "truth")
        .then(|| renderer.prepare(build(renderer.gpu(), &spec, TechniqueFiles::default()).unwrap()).unwrap());
    Contender { spec, prepared, truth }
}

struct World {
    scene: Scene,
    sun: Sun,
}

impl World {
    fn new() -> Self {
        let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
        Self { scene: generate(GeneratedKind::Primitives, 1), sun }
    }

    fn with_reference<T>(&self, work: impl FnOnce(&Reference<'_, '_>) -> T) -> T {
        let truth = TruthTracer::build(&self.scene, false);
        let key = scene_key(&self.scene, false);
        let towards_sun = self.sun.towards();
        work(&Reference { truth: &truth, cache: &Cache::none(), scene: &key, towards_sun, disc: (8.0, 16) })
    }
}

#[test]
fn comparison_of_no_shadows_is_wrong_where_the_truth_is_shadowed() {
    let world = World::new();
    let mut renderer = renderer(&world.scene);
    let mut contenders = [
        contender(&renderer, "none", TruthKind::Hard),
        contender(&renderer, "truth", TruthKind::Hard),
        contender(&renderer, "truth", TruthKind::Disc),
    ];
    let Comparison { pixels, truths, compared } = world.with_reference(|reference| {
        compare(&mut renderer, reference, &camera(), &mut contenders, 2).unwrap()
    });
    let all = pixels.compared + pixels.sky + pixels.facing_away + pixels.excluded;
    assert_eq!(all, u64::from(SIZE[0] * SIZE[1]));
    assert!(pixels.compared > 2000 && pixels.excluded * 100 < all, "{pixels:?}");
    assert_eq!(truths.iter().map(|t| t.0).collect::<Vec<_>>(), [TruthKind::Hard, TruthKind::Disc]);
    let none = &compared[0].row;
    let (rmse, wrong_lit) = (none.rmse.unwrap(), none.wrong_lit.unwrap());
    assert!(wrong_lit > 0.02 && none.wrong_shadowed == Some(0.0), "{none:?}");
    // All pixels are lit, so the mean squared difference is the shadowed share.
    assert!((rmse - wrong_lit.sqrt()).abs() < 1e-9);
    assert!(none.ssim.unwrap() < 0.999 && none.flip.unwrap() > 0.0 && none.gpu_ms.is_some());
    let sum: u64 = none.bands.iter().map(|b| b.errors.pixels).sum();
    assert_eq!(sum, pixels.compared);
    for truth in &compared[1..] {
        let row = &truth.row;
        assert_eq!([row.rmse, row.wrong_lit, row.wrong_shadowed], [Some(0.0); 3]);
        // The rasterizer snaps vertices to a fraction of a pixel, and neighbouring small triangles differ in
        // normal.
        assert!(row.ssim.unwrap() > 0.998 && row.flip.unwrap() < 0.005 && row.gpu_ms.is_none(), "{row:?}");
    }
    let soft = compared[2].factors.iter().filter(|f| **f > 0.0 && **f < 1.0).count();
    assert!(soft > 20, "{soft} pixels in penumbra");
    assert_ne!(compared[1].picture.rgb, compared[2].picture.rgb);
}

#[test]
fn camera_at_the_sky_gives_no_figures() {
    let world = World::new();
    let mut renderer = renderer(&world.scene);
    let mut contenders = ["none", "sm", "csm"].map(|name| contender(&renderer, name, TruthKind::Hard));
    let sky = Camera { eye: [0.0, 500.0, 0.0], target: [0.0, 900.0, 1.0], ..camera() };
    let Comparison { pixels, compared, .. } = world
        .with_reference(|reference| compare(&mut renderer, reference, &sky, &mut contenders, 1).unwrap());
    assert_eq!((pixels.compared, pixels.sky), (0, u64::from(SIZE[0] * SIZE[1])));
    for row in compared.iter().map(|c| &c.row) {
        let figures = [row.rmse, row.mean_difference, row.ssim, row.flip, row.wrong_lit, row.wrong_shadowed];
        assert_eq!((figures, row.clear), ([None; 6], None), "{}", row.name);
    }
}

#[test]
fn picture_metrics_detect_other_colours_and_geometry() {
    let world = World::new();
    // The truth's own shadows are used, so that only geometry, normals and colours can differ.
    let figures = |drawn: &Scene| {
        let mut renderer = renderer(drawn);
        let mut contenders = [contender(&renderer, "truth", TruthKind::Hard)];
        let Comparison { compared, .. } = world.with_reference(|reference| {
            compare(&mut renderer, reference, &camera(), &mut contenders, 1).unwrap()
        });
        (compared[0].row.ssim.unwrap(), compared[0].row.flip.unwrap())
    };
    let (ssim, flip) = figures(&world.scene);
    assert!(ssim > 0.998 && flip < 0.005, "as it is: {ssim} {flip}");
    let mut darker = world.scene.clone();
    darker.materials.iter_mut().for_each(|m| m.base_color = m.base_color.map(|c| 0.5 * c));
    let mut turned = world.scene.clone();
    for row in turned.instances.iter_mut().flat_map(|i| &mut i.world_from_mesh) {
        let [x, y, z, _] = *row;
        (row[0], row[2]) = (0.995 * x - 0.1 * z, 0.1 * x + 0.995 * z);
        row[1] = y;
    }
    for (what, scene) in [("darker", &darker), ("turned", &turned)] {
        let (ssim, flip) = figures(scene);
        assert!(ssim < 0.99 && flip > 0.01, "{what}: {ssim} {flip}");
    }
}

#[test]
fn screen_space_noise_shimmers() {
    let world = World::new();
    let mut renderer = renderer(&world.scene);
    let names = ["pcf", "pcf:filter=poisson:radius=6"];
    let mut contenders = names.map(|name| contender(&renderer, name, TruthKind::Hard));
    let path = CameraPath::orbit(&world.scene.bounds(), 720).with_frames(4);
    let report = world
        .with_reference(|reference| walk(&mut renderer, reference, &path, SIZE, &mut contenders).unwrap());
    let [still, noisy] = [0, 1].map(|i: usize| report.techniques[i].shimmer.unwrap().edge_share.unwrap());
    assert!(still < 0.001 && noisy > 0.01, "{still} {noisy}");
}

#[test]
fn given_factors_are_composited_as_they_are() {
    let world = World::new();
    let mut renderer = renderer(&world.scene);
    let shot = Shot { camera: camera(), towards_sun: world.sun.towards(), number: 0 };
    let factors: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| (i % 17) as f32 / 16.0).collect();
    let given = Given::new(renderer.gpu(), "given", SIZE, &factors).unwrap();
    let mut given = renderer.prepare(Box::new(given)).unwrap();
    renderer.draw(&shot, &mut given, Answer::Visibility).unwrap();
    let surface = renderer.read_surface(&shot).unwrap();
    let back = renderer.read_factor(&given).unwrap();
    for (i, (&there, &asked)) in back.iter().zip(&factors).enumerate() {
        let n_dot_l: f64 = (0..3).map(|a| f64::from(surface.normal[i][a]) * shot.towards_sun[a]).sum();
        // With a normal of half precision, the sign of n·l is reliable only if it is clear of zero.
        if surface.view_depth[i].is_finite() && n_dot_l.abs() < 1e-3 {
            continue;
        }
        let expected = match (surface.view_depth[i].is_finite(), n_dot_l > 0.0) {
            (false, _) => 1.0,
            (true, false) => 0.0,
            (true, true) => asked,
        };
        assert_eq!(there, expected, "pixel {i}");
    }
    let larger = Shot { camera: Camera { width: 97, ..camera() }, ..shot };
    assert!(renderer.draw(&larger, &mut given, Answer::Visibility).is_err());
    assert!(Given::new(renderer.gpu(), "given", [5, 5], &factors).is_err());
}

#[test]
fn walk_gives_times_and_shimmer_of_every_technique() {
    let world = World::new();
    let mut renderer = renderer(&world.scene);
    let mut contenders =
        [contender(&renderer, "none", TruthKind::Hard), contender(&renderer, "truth", TruthKind::Hard)];
    let path = CameraPath::orbit(&world.scene.bounds(), 36).with_frames(3);
    let report = world
        .with_reference(|reference| walk(&mut renderer, reference, &path, SIZE, &mut contenders).unwrap());
    assert_eq!((report.frames, report.techniques.len()), (3, 1), "truth draws no frames");
    let row = &report.techniques[0];
    assert_eq!(row.gpu_ms.len(), 3);
    let shimmer = row.shimmer.unwrap();
    assert_eq!((shimmer.edge_share, shimmer.share), (Some(0.0), 0.0));
    assert!(shimmer.edge_points > 50 && shimmer.points > shimmer.edge_points, "{shimmer:?}");
    let csv = report.csv();
    assert_eq!(csv.lines().count(), 4);
    assert!(csv.starts_with("frame,none all ms,none depth ms,none lookup ms\n0,"), "{csv}");
}

#[test]
fn soft_techniques_compare_with_the_disc_and_hard_ones_do_not() {
    let kind = |name: &str| truth_for(&name.parse().unwrap());
    for soft in ["pcss", "pcss:size=1024", "voxel:soft", "blur", "blur-dilate", "blur-bilateral"] {
        assert_eq!(kind(soft), TruthKind::Disc, "{soft}");
    }
    for hard in ["sm", "pcf", "csm", "csm-vsm", "vsm", "evsm", "msm", "voxel", "voxel+csm", "none", "truth"] {
        assert_eq!(kind(hard), TruthKind::Hard, "{hard}");
    }
}

#[test]
fn report_json_keeps_its_fields() {
    let world = World::new();
    let mut renderer = renderer(&world.scene);
    let mut contenders = [contender(&renderer, "none", TruthKind::Hard)];
    let comparison = world.with_reference(|reference| {
        compare(&mut renderer, reference, &camera(), &mut contenders, 1).unwrap()
    });
    let mut report = Report {
        adapter: renderer.gpu().name(),
        software: renderer.gpu().is_software(),
        scene: "primitives".to_owned(),
        camera: camera_figures("given", &camera()),
        sun: world.sun.towards(),
        sun_origin: None,
        sun_degrees: 0.53,
        sun_samples: 64,
        frames: 1,
        pixels: comparison.pixels,
        baked: vec![BakedFigures {
            frame: "light".to_owned(),
            resolution: 1024,
            voxel_size: 0.05,
            file_bytes: 4096,
        }],
        missing_features: Vec::new(),
        techniques: comparison.compared.iter().map(|c| c.row.clone()).collect(),
        path: None,
        sweep: None,
    };
    let value = serde_json::to_value(&report).unwrap();
    let row = value["techniques"][0].as_object().unwrap();
    for field in [
        "name",
        "gpu_ms",
        "depth_ms",
        "lookup_ms",
        "bytes",
        "rmse",
        "ssim",
        "flip",
        "wrong_lit",
        "wrong_shadowed",
    ] {
        assert!(row.contains_key(field), "{field}");
    }
    assert!(row["wall_time"].is_boolean() && row["truth"] == "hard");
    assert_eq!(serde_json::from_value::<Report>(value).unwrap(), report);
    let text = report.markdown();
    assert!(text.contains("| `none` |") && text.contains("excluded") && text.contains("light-aligned, 1024"));
    report.techniques[0].wall_time = true;
    assert!(report.markdown().contains("* |"), "wall times are marked");
}

/// Returns the wrong pixels of cascades and of voxels at one camera, in percent.
fn cascades_and_voxels(
    cascades: &str,
    scene: &Scene,
    truth: &TruthTracer<'_>,
    file: &ShadowFile,
    camera: &Camera,
) -> [f64; 2] {
    let mut renderer = renderer(scene);
    let baked = TechniqueFiles::of(file);
    let mut contenders: Vec<Contender> = [cascades, "voxel:filter=5"]
        .iter()
        .map(|name| {
            let spec: TechniqueSpec = name.parse().unwrap();
            let technique = build(renderer.gpu(), &spec, baked).unwrap();
            Contender { prepared: Some(renderer.prepare(technique).unwrap()), spec, truth: TruthKind::Hard }
        })
        .collect();
    let key = scene_key(scene, false);
    let towards_sun = file.grid.sun.towards();
    let reference = Reference { truth, cache: &Cache::none(), scene: &key, towards_sun, disc: (0.53, 2) };
    let comparison = compare(&mut renderer, &reference, camera, &mut contenders, 1).unwrap();
    [0, 1].map(|i| {
        let row = &comparison.compared[i].row;
        100.0 * row.wrong().unwrap()
    })
}

#[test]
fn voxels_of_a_city_are_wrong_at_fewer_pixels_than_cascades() {
    let scene = generate(GeneratedKind::City, 1);
    let truth = TruthTracer::build(&scene, false);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let file =
        Bake::with_options(&scene, &BakeOptions::new(sun, Size::Resolution(2048))).in_memory().unwrap();
    let camera = Camera { width: SIZE[0], height: SIZE[1], ..Camera::overview(&scene.bounds(), 45.0) };
    // An eighth as many texels along a side, as with 2048 beside a file of 16384.
    let [cascades, voxels] = cascades_and_voxels("csm:filter=5:size=256", &scene, &truth, &file, &camera);
    println!("cascades {cascades:.3} %, voxels {voxels:.3} %");
    assert!(voxels < cascades, "{voxels} and {cascades}");
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_voxels_are_wrong_at_fewer_pixels_than_cascades() {
    let (Some(scenes), Some(truths)) = (shared("scenes"), shared("truth")) else { return };
    let (names, [width, height]): (&[&str], _) = if full() {
        (&["zdm2", "kaykit_city_21", "alpine-2", "auster"], [1280, 720])
    } else {
        (&["zdm2"], [480, 270])
    };
    for name in names {
        let scene = load(&scene_file(&scenes, name), &LoadOptions::default()).unwrap();
        let truth = TruthTracer::build(&scene, false);
        let (given, sun) = truth_camera(&truths.join(format!("{name}.npz"))).unwrap();
        let options = BakeOptions::new(sun, Size::Resolution(16384));
        let file = Bake::with_options(&scene, &options).in_memory().unwrap();
        let options = StreetOptions { width, height, ..StreetOptions::default() };
        let street = street_camera(&truth, sun.towards(), &options).unwrap();
        for (from, camera) in [("truth camera", Camera { width, height, ..given }), ("street", street)] {
            // By default there are 4 cascades of 2048², with a practical split at 0.5, as far as the scene is
            // in view.
            let [cascades, voxels] = cascades_and_voxels("csm:filter=5", &scene, &truth, &file, &camera);
            eprintln!("{name}, {from}: cascades {cascades:.3} %, voxels {voxels:.3} %");
            // At street level the nearest cascade's texels may be finer than the voxels. The tables show
            // where.
            assert!(voxels < cascades || from == "street", "{name}, {from}: {voxels} and {cascades}");
        }
    }
}

#[test]
fn disc_truth_is_softer_for_a_larger_sun() {
    let world = World::new();
    let truth = TruthTracer::build(&world.scene, false);
    let surfaces = truth.surfaces(&camera());
    let soft = |sun_degrees: f64| {
        let shape = SunShape::Disc { sun_degrees, samples: 32 };
        let factors = truth.factors(&surfaces, world.sun.towards(), shape);
        factors.iter().filter(|f| **f > 0.0 && **f < 1.0).count()
    };
    assert!(soft(8.0) > 2 * soft(1.0), "{} {}", soft(8.0), soft(1.0));
}
