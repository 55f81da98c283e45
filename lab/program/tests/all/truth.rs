//! Ray-traced truth: compared with another renderer, through the cache, near edges, and from the street.

use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use adumbra::Sun;
use adumbra_compare::truth::{
    Cache, EdgeProbe, StreetOptions, SunShape, Surfaces, TruthTracer, TruthView, scene_key, standard_error,
    street_camera,
};
use adumbra_lab::occlusion::{SCENES, occlusion_errors};
use adumbra_scene::{Camera, GeneratedKind, LoadOptions, Projection, Scene, generate, load};
use adumbra_testing::{add_quad, cuboid, full, scene_file, scene_of, shared};

/// Minimum share of sun-facing pixels that agree with the other renderer.
const SUN_AGREEMENT: f64 = 0.995;

#[test]
#[ignore = "slow: real scenes"]
fn shared_truth_matches_another_renderer_through_its_cameras() {
    let (Some(truth), Some(scenes)) = (shared("truth"), shared("scenes")) else { return };
    for name in ["zdm2", "kaykit_city_21", "box-city-5k", "alpine-2", "auster", "dragon_202k"] {
        let view = TruthView::read(&truth.join(format!("{name}.npz"))).unwrap();
        let options = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
        let scene = load(&scene_file(&scenes, name), &options).unwrap();
        let tracer = TruthTracer::build(&scene, true);
        let towards = view.sun.towards();
        let surfaces = tracer.surfaces(&view.camera);
        let factors = tracer.factors(&surfaces, towards, SunShape::Hard);
        let (mut compared, mut agreeing, mut apart) = (0_u32, 0_u32, 0_u32);
        for (i, factor) in factors.iter().enumerate() {
            let far = (0..3).any(|a| {
                (surfaces.position[i][a] - f64::from(view.position[i][a])).abs()
                    > 1e-4 * tracer.bounds().diagonal()
            });
            if view.valid[i] != surfaces.is_valid(i) || (view.valid[i] && far) {
                apart += 1;
            } else if view.valid[i] && view.n_dot_l[i] > 0.1 {
                compared += 1;
                agreeing += u32::from((*factor > 0.5) == (view.visibility[i] > 0.5));
            }
        }
        let share = f64::from(agreeing) / f64::from(compared);
        eprintln!("{name}: {share:.5} of {compared} pixels agree; {apart} see other surfaces");
        assert!(share >= SUN_AGREEMENT, "{name}: {share}");
        assert!(f64::from(apart) < 0.01 * factors.len() as f64, "{name}: {apart}");
    }
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_ambient_agrees_with_another_renderer_at_its_positions() {
    let (Some(truth), Some(scenes)) = (shared("truth"), shared("scenes")) else { return };
    for name in ["kaykit_city_21", "dragon_202k"] {
        let view = TruthView::read(&truth.join(format!("{name}.npz"))).unwrap();
        let options = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
        let scene = load(&scene_file(&scenes, name), &options).unwrap();
        let tracer = TruthTracer::build(&scene, true);
        // The file's own surfaces are used, every third row, so that only occlusion is compared.
        let rows = (0..view.camera.height as usize).step_by(3);
        let pixels: Vec<usize> = rows.flat_map(|y| (0..320).map(move |x| y * 320 + x)).collect();
        let surfaces = Surfaces {
            width: 320,
            height: pixels.len() as u32 / 320,
            position: pixels.iter().map(|&i| view.position[i].map(f64::from)).collect(),
            normal: pixels.iter().map(|&i| view.normal[i]).collect(),
            view_depth: pixels.iter().map(|&i| if view.valid[i] { 1.0 } else { f64::INFINITY }).collect(),
            // Positions in the file have single precision.
            lift_world: vec![1e-5 * scene.bounds().diagonal(); pixels.len()],
        };
        let ambient = tracer.ambient(&surfaces, view.ambient_radius_world, 64);
        let theirs: Vec<f32> = pixels.iter().map(|&i| view.ambient[i]).collect();
        let errors = occlusion_errors(&ambient, &theirs, |i| surfaces.is_valid(i)).unwrap();
        eprintln!("{name}: {errors:?}");
        assert!(errors.mean_signed.abs() < 0.003 && errors.mean_absolute < 0.03, "{name}: {errors:?}");
        assert!(ambient.iter().enumerate().all(|(i, v)| surfaces.is_valid(i) || *v == 1.0));
    }
}

/// Returns a square ground with a box on it.
fn plane_and_box() -> Scene {
    let mut mesh = cuboid([-1.0, 0.0, -1.0], [1.0, 4.0, 1.0]);
    add_quad(&mut mesh, [[-20.0, 0.0, 20.0], [20.0, 0.0, 20.0], [20.0, 0.0, -20.0], [-20.0, 0.0, -20.0]]);
    scene_of(vec![mesh])
}

fn above(width: u32, height: u32) -> Camera {
    let projection = Projection::Orthographic { height_world: 18.0 };
    Camera { eye: [0.0, 30.0, 0.0], target: [0.0; 3], projection, width, height }
}

#[test]
fn truth_of_box_matches_analytic_shadow() {
    let scene = plane_and_box();
    let truth = TruthTracer::build(&scene, false);
    let sun = Sun::from_direction([1.0, 1.0, 0.0]).unwrap();
    let surfaces = truth.surfaces(&above(96, 48));
    let factors = truth.factors(&surfaces, sun.towards(), SunShape::Hard);
    for (i, factor) in factors.iter().enumerate() {
        let [x, y, z] = surfaces.position[i];
        assert_eq!(surfaces.normal[i], [0.0, 1.0, 0.0]);
        assert!((surfaces.view_depth[i] - (30.0 - y)).abs() < 1e-9);
        // The box casts a shadow four metres long towards -x.
        let shadowed = y < 1.0 && z.abs() < 1.0 && (-5.0..-1.0).contains(&x);
        assert_eq!(*factor, f32::from(u8::from(!shadowed)), "{x} {y} {z}");
    }
    // At the far edge of the hard shadow, half of the disc is visible.
    let soft = truth.factors(&surfaces, sun.towards(), SunShape::Disc { sun_degrees: 10.0, samples: 64 });
    let partly = soft.iter().filter(|f| **f > 0.0 && **f < 1.0).count();
    assert!(partly > 20, "{partly}");
    let away = truth.factors(&surfaces, [0.6, -0.8, 0.0], SunShape::Hard);
    assert!(away.iter().all(|f| *f == 0.0));
}

#[test]
fn ambient_beside_wall_matches_integral() {
    let scene = plane_and_box();
    let truth = TruthTracer::build(&scene, false);
    // Points next to the middle of a side of the box, with a radius that reaches neither its top nor its
    // corners.
    let at = |x: f64| ([x, 0.0, 0.0], [0.0, 1.0, 0.0_f32]);
    let places = [at(1.25), at(1.5), at(5.0)];
    let surfaces = Surfaces {
        width: 4,
        height: 1,
        position: places.iter().map(|p| p.0).chain([[0.0; 3]]).collect(),
        normal: places.iter().map(|p| p.1).chain([[0.0; 3]]).collect(),
        view_depth: vec![1.0, 1.0, 1.0, f64::INFINITY],
        lift_world: vec![1e-6; 4],
    };
    let radius = 0.75;
    let ambient = truth.ambient(&surfaces, radius, 4096);
    // A ray hits a plane at distance `d` within the radius if its direction's component towards the plane is
    // at least d / radius. Seen from above, cosine-weighted directions fill the unit disc evenly, so the rays
    // that hit are the segment beyond that chord.
    let wall = |d: f64| {
        let chord: f64 = d / radius;
        (chord.acos() - chord * (1.0 - chord * chord).sqrt()) / std::f64::consts::PI
    };
    for (i, d) in [(0, 0.25), (1, 0.5)] {
        assert!((f64::from(ambient[i]) - (1.0 - wall(d))).abs() < 0.004, "{d}: {} {}", ambient[i], wall(d));
    }
    assert_eq!(ambient[2..], [1.0, 1.0]);
    for none in [0.0, -1.0, f64::NAN] {
        assert!(truth.ambient(&surfaces, none, 16).iter().all(|v| *v == 1.0), "{none}");
    }
    assert!(truth.ambient(&surfaces, radius, 0).iter().all(|v| *v == 1.0));
}

#[test]
fn ambient_error_is_below_its_bound_and_falls_with_the_rays() {
    let scene = plane_and_box();
    let truth = TruthTracer::build(&scene, false);
    let projection = Projection::Orthographic { height_world: 6.0 };
    let camera = Camera { eye: [0.0, 30.0, 0.0], target: [0.0; 3], projection, width: 64, height: 64 };
    let surfaces = truth.surfaces(&camera);
    let errors = [16, 256].map(|rays| {
        let ambient = truth.ambient(&surfaces, 2.0, rays);
        let bound = standard_error(&ambient, rays, |i| surfaces.is_valid(i));
        let measured = truth.measured_error(&surfaces, &ambient, 2.0, rays, 3).unwrap();
        assert!(measured > 0.0 && measured < bound, "{rays}: {measured} {bound}");
        measured
    });
    assert!(errors[1] < errors[0] / 3.0, "{errors:?}");
    assert_eq!(standard_error(&[0.5, 0.5], 25, |_| true), 0.1);
    assert_eq!(standard_error(&[0.5], 25, |_| false), 0.0);
    assert_eq!(standard_error(&[0.0, 1.0], 25, |_| true), 0.0);
    let sky = Surfaces { view_depth: vec![f64::INFINITY; surfaces.pixels()], ..surfaces };
    assert_eq!(truth.measured_error(&sky, &vec![1.0; sky.pixels()], 2.0, 16, 1), None);
}

#[test]
fn ambient_cache_key_includes_radius_and_rays() {
    let folder = tempfile::tempdir().unwrap();
    let scene = plane_and_box();
    let truth = TruthTracer::build(&scene, false);
    let (cache, key, camera) =
        (Cache::in_folder(folder.path().to_owned(), u64::MAX), scene_key(&scene, false), above(24, 12));
    let surfaces = truth.surfaces(&camera);
    let ask = |radius: f64, rays: u32| cache.ambient(&truth, &key, &camera, &surfaces, radius, rays);
    let entries = || std::fs::read_dir(folder.path()).unwrap().count();
    let first = ask(2.0, 16);
    assert_eq!(first, truth.ambient(&surfaces, 2.0, 16));
    assert_eq!((ask(2.0, 16), entries()), (first, 1));
    ask(2.5, 16);
    ask(2.0, 17);
    assert_eq!(entries(), 3);
    let threads = |n: usize| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    let by = |n: usize| threads(n).install(|| truth.ambient(&surfaces, 2.0, 16));
    assert_eq!(by(1), by(3));
}

#[test]
fn edge_probe_finds_distance_to_edges_of_box_shadow() {
    let scene = plane_and_box();
    let truth = TruthTracer::build(&scene, false);
    let sun = Sun::from_direction([1.0, 1.0, 0.0]).unwrap();
    let probe = EdgeProbe::new(&truth, sun.towards());
    let clear = |p: [f64; 3], radius: f64| probe.is_clear([p[0], p[1] + 1e-6, p[2]], [0.0, 1.0, 0.0], radius);
    // Projected into the light's plane, a metre on the ground is √½ m along x and 1 m along z.
    for (p, distance) in [
        ([-3.0, 0.0, 0.6], 0.4),
        ([-3.0, 0.0, 1.5], 0.5),
        ([-4.4, 0.0, 0.0], 0.6 * 0.5_f64.sqrt()),
        ([-5.6, 0.0, 0.0], 0.6 * 0.5_f64.sqrt()),
    ] {
        assert!(clear(p, 0.95 * distance), "{p:?} is clear of an edge {distance} away");
        assert!(!clear(p, 1.1 * distance), "{p:?} is not clear of an edge {distance} away");
    }
    assert!(!probe.is_clear([-3.0, 0.0, 9.0], [0.0, -1.0, 0.0], 0.1), "turned away");
    let surfaces = truth.surfaces(&above(96, 48));
    let mask = probe.clear_pixels(&surfaces, |_| 0.2);
    let alone: Vec<bool> = (0..surfaces.pixels())
        .map(|i| probe.is_clear(surfaces.lifted(i), surfaces.normal[i].map(f64::from), 0.2))
        .collect();
    assert_eq!(mask, alone);
    assert!(mask.iter().any(|c| *c) && mask.iter().any(|c| !*c));
}

#[test]
fn cache_returns_traced_results_and_retraces_damaged_entries() {
    let folder = tempfile::tempdir().unwrap();
    let scene = plane_and_box();
    let truth = TruthTracer::build(&scene, false);
    let entries = folder.path().join("cache");
    let cache = Cache::in_folder(entries.clone(), u64::MAX);
    let key = scene_key(&scene, false);
    let (camera, towards) = (above(24, 12), Sun::from_direction([1.0, 1.0, 0.3]).unwrap().towards());
    let soft = SunShape::Disc { sun_degrees: 5.0, samples: 8 };
    let ask = |cache: &Cache| -> (Surfaces, Vec<f32>) {
        let surfaces = cache.surfaces(&truth, &key, &camera);
        let factors = cache.factors(&truth, &key, &camera, &surfaces, towards, soft);
        (surfaces, factors)
    };
    let plain = ask(&Cache::none());
    let first = ask(&cache);
    assert_eq!(first, plain);
    assert_eq!(ask(&cache), first);
    let files = || {
        let mut files: Vec<_> = std::fs::read_dir(&entries).unwrap().map(|e| e.unwrap().path()).collect();
        files.sort();
        files
    };
    assert_eq!(files().len(), 2);
    for file in files() {
        let whole = std::fs::read(&file).unwrap();
        let mut changed = whole.clone();
        *changed.last_mut().unwrap() ^= 1;
        let longer = [whole.as_slice(), &[0]].concat();
        for damaged in [&whole[..whole.len() - 1], &whole[..20], &[], &changed, &longer] {
            std::fs::write(&file, damaged).unwrap();
            assert_eq!(ask(&cache), first);
            assert_eq!(std::fs::read(&file).unwrap(), whole, "it is traced anew and kept");
        }
    }
    // An intact entry is trusted only under its own name and key, so swapped entries are traced again.
    let [a, b] = &files()[..] else { panic!() };
    let (bytes_a, bytes_b) = (std::fs::read(a).unwrap(), std::fs::read(b).unwrap());
    std::fs::write(a, &bytes_b).unwrap();
    std::fs::write(b, &bytes_a).unwrap();
    assert_eq!(ask(&cache), first);
    // A change to any input of the result leads to another entry.
    let before = files().len();
    let surfaces = &first.0;
    cache.factors(&truth, &key, &camera, surfaces, towards, SunShape::Hard);
    cache.factors(&truth, &scene_key(&scene, true), &camera, surfaces, towards, soft);
    cache.surfaces(&truth, &key, &above(24, 13));
    let mut moved = scene.clone();
    moved.instances[0].world_from_mesh[1][3] = 0.5;
    cache.surfaces(&truth, &scene_key(&moved, false), &camera);
    assert_eq!(files().len(), before + 4);
    // Colour is not an input.
    let mut red = scene.clone();
    red.materials[0].base_color = [1.0, 0.0, 0.0, 1.0];
    cache.surfaces(&truth, &scene_key(&red, false), &camera);
    assert_eq!(files().len(), before + 4);
}

#[test]
fn cache_stays_within_limit_and_evicts_least_recently_used() {
    let folder = tempfile::tempdir().unwrap();
    let entries = folder.path().join("cache");
    let scene = plane_and_box();
    let truth = TruthTracer::build(&scene, false);
    let key = scene_key(&scene, false);
    let unlimited = Cache::in_folder(entries.clone(), u64::MAX);
    let sizes = || -> Vec<u64> {
        std::fs::read_dir(&entries).unwrap().map(|e| e.unwrap().metadata().unwrap().len()).collect()
    };
    let cameras = [8, 9, 10, 11].map(|width| above(width, 12));
    let names = || -> Vec<PathBuf> {
        std::fs::read_dir(&entries).into_iter().flatten().map(|e| e.unwrap().path()).collect()
    };
    for (age_hours, camera) in [3, 2, 1].into_iter().zip(&cameras) {
        let before = names();
        unlimited.surfaces(&truth, &key, camera);
        let made = names().into_iter().find(|name| !before.contains(name)).unwrap();
        let time = SystemTime::now() - Duration::from_secs(3600 * age_hours);
        std::fs::File::options().write(true).open(made).unwrap().set_modified(time).unwrap();
    }
    let other = entries.join("notes.txt");
    std::fs::write(&other, "not an entry").unwrap();
    let limit = sizes().into_iter().max().unwrap() * 3;
    let cache = Cache::in_folder(entries.clone(), limit);
    // The first entry is used again, so the second entry becomes the least recently used.
    cache.surfaces(&truth, &key, &cameras[0]);
    cache.surfaces(&truth, &key, &cameras[3]);
    let kept = cameras.map(|camera| {
        let before = sizes().len();
        unlimited.surfaces(&truth, &key, &camera);
        sizes().len() == before
    });
    assert_eq!(kept, [true, false, true, true]);
    assert!(other.exists());
    let tiny = Cache::in_folder(folder.path().join("tiny"), 100);
    assert_eq!(tiny.surfaces(&truth, &key, &cameras[0]), truth.surfaces(&cameras[0]));
    assert!(!folder.path().join("tiny").exists());
}

#[test]
fn cache_without_folder_still_traces() {
    let folder = tempfile::tempdir().unwrap();
    let scene = plane_and_box();
    let truth = TruthTracer::build(&scene, false);
    // There is a file at the path of the folder.
    let file = folder.path().join("a file");
    std::fs::write(&file, "").unwrap();
    let cache = Cache::in_folder(file, u64::MAX);
    let key = scene_key(&scene, false);
    assert_eq!(cache.surfaces(&truth, &key, &above(8, 8)), truth.surfaces(&above(8, 8)));
}

/// Checks a street-level camera with the test's own rays.
fn check_street(name: &str, scene: &Scene, sun: Sun) {
    let truth = TruthTracer::build(scene, false);
    let options = StreetOptions { width: 160, height: 90, ..StreetOptions::default() };
    let camera = street_camera(&truth, sun.towards(), &options).unwrap();
    assert_eq!(camera, street_camera(&truth, sun.towards(), &options).unwrap());
    let down = adumbra_truth::trace::Ray {
        origin: camera.eye,
        direction: [0.0, -1.0, 0.0],
        t_min: 0.0,
        t_max: f64::INFINITY,
    };
    let below = truth.tracer().nearest_surface(&down).unwrap().t;
    assert!((below - 1.7).abs() < 1e-6, "{name}: {below} m above the ground");
    assert!(truth.tracer().sun_visible(camera.eye, [0.0, 1.0, 0.0]), "{name}: open sky above");
    let surfaces = truth.surfaces(&camera);
    let factors = truth.factors(&surfaces, sun.towards(), SunShape::Hard);
    let facing: Vec<usize> =
        (0..factors.len()).filter(|&i| surfaces.n_dot_l(i, sun.towards()) > 0.1).collect();
    let shadowed = facing.iter().filter(|&&i| factors[i] < 0.5).count() as f64 / facing.len() as f64;
    let walls = surfaces.normal.iter().filter(|n| n[1].abs() < 0.5 && **n != [0.0; 3]).count();
    let near = (0..factors.len()).filter(|&i| surfaces.view_depth[i] < 2.0 && surfaces.normal[i][1] < 0.8);
    let (walls, near) = (walls as f64 / factors.len() as f64, near.count() as f64 / factors.len() as f64);
    eprintln!(
        "{name}: eye {:?}, {shadowed:.2} of what faces the sun shadowed, walls {walls:.2}, near {near:.2}",
        camera.eye
    );
    assert!((0.05..0.95).contains(&shadowed), "{name}: shadows in view");
    assert!(near < 0.1, "{name}: nothing before the eye");
}

#[test]
fn street_camera_is_at_street_level_in_generated_scenes() {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    check_street("city", &generate(GeneratedKind::City, 1), sun);
    check_street("landscape", &generate(GeneratedKind::Landscape, 1), sun);
}

#[test]
fn street_camera_fails_without_street() {
    let mut scene = plane_and_box();
    scene.meshes[0].positions.iter_mut().flatten().for_each(|c| *c *= 0.01);
    let truth = TruthTracer::build(&scene, false);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let refused = street_camera(&truth, sun.towards(), &StreetOptions::default());
    assert!(matches!(refused, Err(adumbra_compare::Error::NoStreet)), "{refused:?}");
}

#[test]
#[ignore = "slow: two real scenes; four with ADUMBRA_FULL"]
fn shared_street_camera_is_at_street_level_in_table_scenes() {
    let Some(scenes) = shared("scenes") else { return };
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let all = ["kaykit_city_21", "auster", "zdm2", "alpine-2"];
    for name in &all[..if full() { 4 } else { 2 }] {
        let scene = load(&scene_file(&scenes, name), &LoadOptions::default()).unwrap();
        eprintln!("{name}: {:?}", scene.bounds());
        check_street(name, &scene, sun);
    }
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_occlusion_scenes_show_contact_and_open_space() {
    let Some(scenes) = shared("scenes") else { return };
    for scene in &SCENES {
        let view = scene.open(&scenes).unwrap();
        let tracer = TruthTracer::build(&view.scene, false);
        let size = [96, 54];
        for camera in [view.camera(size), *view.path(size).last().unwrap()] {
            let surfaces = tracer.surfaces(&camera);
            let ambient = tracer.ambient(&surfaces, view.radius_world, 16);
            let share = |of: &dyn Fn(usize) -> bool| {
                (0..surfaces.pixels()).filter(|&i| of(i)).count() as f64 / surfaces.pixels() as f64
            };
            let seen = share(&|i| surfaces.is_valid(i));
            let open = share(&|i| surfaces.is_valid(i) && ambient[i] > 0.95);
            let occluded = share(&|i| ambient[i] < 0.8);
            eprintln!("{}: seen {seen:.3}, open {open:.3}, occluded {occluded:.3}", scene.name);
            assert!(seen > 0.65, "{}: not mostly sky: {seen}", scene.name);
            assert!(open > 0.1 && occluded > 0.03, "{}: {open} {occluded}", scene.name);
        }
    }
}
