//! Baked files against truth: another renderer's images, and rays at random points of real scenes.
//!
//! CI bakes at an eighth of the size; `ADUMBRA_FULL=1` at the whole. The folder is `ADUMBRA_SHARED`, or `shared` beside the
//! checkout; without it the tests say so and pass.

mod shared_folder;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use adumbra::bake::{Baked, Options, Size, bake};
use adumbra::light::Sun;
use adumbra::query::Query;
use adumbra::scene::{Bounds, GeneratedKind, LoadOptions, Scene, generate, load};
use adumbra::settings::Receivers;
use adumbra::trace::{TraceOptions, Tracer};
use adumbra::verify::{
    LightAnswers, Random, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions,
    VolumeSampler,
};
use npyz::npz::NpzArchive;
use shared_folder::{full, shared};

fn bake_quietly(scene: &Scene, options: &Options) -> Baked {
    bake(scene, options, &|_| {}, &AtomicBool::new(false)).unwrap()
}

fn verify(scene: &Scene, baked: &Baked, volume: bool, samples: u64) -> Verification {
    let tracer = Tracer::build(scene, TraceOptions { ignore_alpha: false });
    let solids = Solids::of(scene);
    let sampler = if volume {
        Sampler::Volume(VolumeSampler::new(&baked.grid))
    } else {
        Sampler::Surface(SurfaceSampler::new(scene, &solids, baked.grid.sun.towards(), false))
    };
    let query = Query::new(&baked.grid, &baked.dag, baked.settings.bias, 1).unwrap();
    let answers = LightAnswers::new(&baked.grid, &baked.settings, query);
    Verifier::new(&answers, &tracer, &solids).run(&sampler, &VerifyOptions { samples, seed: 3 })
}

/// Share of sunlit-side pixels on which file and image agree: 99 % at 16384; an eighth of that resolution has eight
/// times as many texels on outlines.
#[test]
fn shared_file_matches_another_renderers_images() {
    let (Some(truth), Some(scenes)) = (shared("truth"), shared("scenes")) else { return };
    let (resolution, needed) = if full() { (16384, 0.99) } else { (2048, 0.95) };
    let options = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
    let mut missed = Vec::new();
    for file in
        ["kaykit_city_21.glb", "box-city-5k.glb", "zdm2.glb", "alpine-2.glb", "auster.obj", "dragon_202k.ply"]
    {
        let view = truth.join(Path::new(file).with_extension("npz"));
        let array = |name: &str| -> Vec<f32> {
            NpzArchive::open(&view).unwrap().by_name(name).unwrap().unwrap().into_vec().unwrap()
        };
        let valid: Vec<bool> =
            NpzArchive::open(&view).unwrap().by_name("valid").unwrap().unwrap().into_vec().unwrap();
        let camera: Vec<String> =
            NpzArchive::open(&view).unwrap().by_name("camera").unwrap().unwrap().into_vec().unwrap();
        let camera: serde_json::Value = serde_json::from_str(camera[0].trim_end_matches('\0')).unwrap();
        let sun = Sun::from_direction([0, 1, 2].map(|a| camera["sun"][a].as_f64().unwrap())).unwrap();
        let [pos, normal, ndotl, truth_sun] = ["pos", "normal", "ndotl", "sun"].map(array);
        let scene = load(&scenes.join(file), &options).unwrap();
        let baked = bake_quietly(&scene, &Options::new(sun, Size::Resolution(resolution)));
        let query = Query::new(&baked.grid, &baked.dag, baked.settings.bias, 1).unwrap();
        let triple = |v: &[f32], i: usize| [0, 1, 2].map(|a| f64::from(v[3 * i + a]));
        let judged: Vec<usize> = (0..valid.len()).filter(|&i| valid[i] && ndotl[i] > 0.1).collect();
        let agreeing = judged
            .iter()
            .filter(|&&i| {
                let answer = query.visibility(triple(&pos, i), Some(triple(&normal, i)));
                (answer > 0.5) == (truth_sun[i] > 0.5)
            })
            .count();
        let agreement = agreeing as f64 / judged.len() as f64;
        eprintln!("{file} at {resolution}: {:.3} % of {} pixels agree", 100.0 * agreement, judged.len());
        if agreement < needed {
            missed.push(file);
        }
    }
    assert!(missed.is_empty(), "too few pixels agree on {missed:?}");
}

/// A share of right answers at an eighth of 8192: points near an outline are eight times as many, and the interior is
/// defined in texels, so what holds at 8192 nearly holds here.
#[test]
fn shared_interior_agrees_with_rays_on_real_scenes() {
    let Some(scenes) = shared("scenes") else { return };
    let (resolution, samples) = if full() { (8192, 1_000_000) } else { (1024, 20_000) };
    let suns = [
        Sun::from_direction([0.5, 0.8, 0.35]).unwrap(),
        Sun::from_angles(55.0, 90.0).unwrap(),
        Sun::from_angles(55.0, 10.0).unwrap(),
        Sun::from_angles(55.0, 3.0).unwrap(),
    ];
    let mut missed = Vec::new();
    let mut files = vec![
        "zdm2.glb",
        "dragon_202k.ply",
        "armadillo.ply",
        "bridge_garden.glb",
        "auster.obj",
        "kaykit_city_21.glb",
    ];
    if full() {
        files.extend(["alpine-2.glb", "street-1.glb", "delft.glb", "box-city-5k.glb", "oak_medium.glb"]);
    }
    for file in files {
        let scene = load(&scenes.join(file), &LoadOptions::default()).unwrap();
        for sun in suns {
            let baked = bake_quietly(&scene, &Options::new(sun, Size::Resolution(resolution)));
            let v = verify(&scene, &baked, false, samples);
            eprintln!(
                "{file}, elevation {:.0}°: interior {:.5}, share {:.3}",
                sun.elevation_degrees(),
                v.interior_agreement,
                v.interior_share
            );
            let needed = if full() { 0.999 } else { 0.995 };
            if v.interior_agreement < needed || (full() && v.interior_share < 0.7) {
                missed.push((file, sun.elevation_degrees().round(), v.interior_agreement));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}

#[test]
fn interior_agrees_with_rays_on_generated_scenes() {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    for kind in
        [GeneratedKind::Spheres, GeneratedKind::Primitives, GeneratedKind::Landscape, GeneratedKind::City]
    {
        let scene = generate(kind, 1);
        let everywhere = Options { assume_ground: false, ..Options::new(sun, Size::Resolution(1024)) };
        let baked = bake_quietly(&scene, &everywhere);
        let surface = verify(&scene, &baked, false, 20_000);
        let volume = verify(&scene, &baked, true, 20_000);
        let on_surfaces =
            bake_quietly(&scene, &Options { receivers: Receivers::Static, ..everywhere.clone() });
        let still = verify(&scene, &on_surfaces, false, 20_000);
        eprintln!(
            "{kind:?}: surface {:.5}, volume {:.5}, static receivers {:.5}",
            surface.interior_agreement, volume.interior_agreement, still.interior_agreement
        );
        assert!(surface.interior_agreement >= 0.998 && surface.interior_share > 0.5, "{kind:?} {surface:?}");
        assert!(volume.interior_agreement >= 0.999, "{kind:?} {volume:?}");
        assert!(still.interior_agreement >= 0.998, "{kind:?} {still:?}");
        assert!(on_surfaces.dag.nodes.len() < baked.dag.nodes.len());
        let difference = mean_filter_difference(&scene, &baked, &on_surfaces);
        assert!(difference < 0.01, "{kind:?}: {difference}");
    }
}

/// Mean difference of two bakes' answers on surfaces under a 9 × 9 filter.
fn mean_filter_difference(scene: &Scene, a: &Baked, b: &Baked) -> f64 {
    let solids = Solids::of(scene);
    let sampler = SurfaceSampler::new(scene, &solids, a.grid.sun.towards(), false);
    let [qa, qb] = [a, b].map(|x| Query::new(&x.grid, &x.dag, x.settings.bias, 9).unwrap());
    let mut random = Random::new(5, 0);
    let samples: Vec<_> = (0..20_000).map(|_| sampler.sample(&mut random)).collect();
    let lit_side = samples.iter().filter(|s| {
        let towards = a.grid.sun.towards();
        s.normal.is_some_and(|n| (0..3).map(|i| n[i] * towards[i]).sum::<f64>() > 0.1)
    });
    let differences: Vec<f64> = lit_side
        .map(|s| f64::from((qa.visibility(s.p_world, s.normal) - qb.visibility(s.p_world, s.normal)).abs()))
        .collect();
    differences.iter().sum::<f64>() / differences.len() as f64
}

#[test]
fn bounds_cover_a_box_that_casters_outside_still_shade() {
    let scene = generate(GeneratedKind::City, 1);
    let sun = Sun::from_angles(70.0, 20.0).unwrap();
    let bounds = Bounds { min: [-60.0, -1.0, -60.0], max: [60.0, 30.0, 60.0] };
    let options = Options { bounds: Some(bounds), ..Options::new(sun, Size::Resolution(2048)) };
    let baked = bake_quietly(&scene, &options);
    let v = verify(&scene, &baked, false, 60_000);
    assert!(v.outside_bounds > 20_000 && v.samples > 1_000, "{v:?}");
    assert!(v.interior_agreement >= 0.998 && v.shadowed_share > 0.2, "{v:?}");
}

#[test]
fn a_wrong_file_is_found_out() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let mut baked = bake_quietly(&scene, &Options::new(sun, Size::Resolution(512)));
    for slab in &mut baked.dag.slabs {
        *slab = !*slab;
    }
    let v = verify(&scene, &baked, false, 20_000);
    assert!(v.agreement < 0.99, "{v:?}");
}
