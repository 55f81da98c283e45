//! The tuner of ambient occlusion on a small scene, and its record compared with the defaults that users get.

use adumbra_compare::truth::Cache;
use adumbra_lab::occlusion::{Fold, Record, RecordEntry, TuneOptions, TuneScene, TunedOn, scene_named, tune};
use adumbra_render::occlusion::{Estimator, OcclusionSettings, Search};
use adumbra_render::{Gpu, GpuOptions};
use adumbra_scene::{Camera, GeneratedKind, generate};

const OPTIONS: TuneOptions = TuneOptions { budget: 18, size: [96, 54], rays: 16 };

/// Returns the Cornell box from its own camera for one half, and from another camera for the other half.
fn scenes() -> Vec<TuneScene> {
    let gpu = Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let view = scene_named("cornell").unwrap().open(std::path::Path::new("")).unwrap();
    let camera = view.camera(OPTIONS.size);
    let other = Camera { eye: [0.9, 2.2, 4.6], ..camera };
    let scene = generate(GeneratedKind::Cornell, 1);
    let open = |name: &str, fold: Fold, camera: Camera| {
        let gpu = Gpu::sharing(&gpu.device, &gpu.queue);
        TuneScene::new(gpu, (name, fold), &scene, camera, 1.0, OPTIONS.rays, &Cache::none()).unwrap()
    };
    vec![open("one", Fold::A, camera), open("other", Fold::B, other)]
}

#[test]
fn tuner_is_deterministic_and_reduces_error_within_ranges() {
    let scenes = scenes();
    let run = |options: &TuneOptions| {
        tune(&scenes, options, &[OcclusionSettings::new(Estimator::Issao, 1.0)], |_| ()).unwrap()
    };
    let record = run(&OPTIONS);
    assert_eq!(record.json().unwrap(), run(&OPTIONS).json().unwrap());
    assert_eq!(record.entries.len(), 3);
    let first = run(&TuneOptions { budget: 1, ..OPTIONS });
    for on in TunedOn::ALL {
        let entry = record.entry(Estimator::Issao, on).unwrap();
        let start = first.entry(Estimator::Issao, on).unwrap();
        assert!(entry.objective < start.objective && entry.objective < 0.9, "{entry:?} {start:?}");
        assert_eq!(entry.elsewhere.is_some(), on != TunedOn::All);
        assert_eq!(entry.rmse.len(), 2);
        let shape = record.shape(Estimator::Issao, on).unwrap();
        for (value, p) in shape.iter().zip(Estimator::Issao.parameters()) {
            let Some(Search::Even(low, high) | Search::Factors(low, high)) = p.search else {
                assert_eq!(*value, p.default);
                continue;
            };
            assert!((0.999 * low..=1.001 * high).contains(value), "{}: {value}", p.name);
        }
    }
    // A run's result on the half that it was not tuned on matches the entry of the other half.
    let [a, b] = [TunedOn::FoldA, TunedOn::FoldB].map(|on| record.entry(Estimator::Issao, on).unwrap());
    let share = |e: &RecordEntry, i: usize| e.rmse[&record.scenes[i].name] / record.scenes[i].none_rmse;
    assert!((a.elsewhere.unwrap() - share(a, 1)).abs() < 2e-3, "{a:?}");
    assert!((b.objective - share(b, 1)).abs() < 2e-3, "{b:?}");
    let text = record.markdown();
    assert!(text.contains("| `issao` | fold A | lambda "), "{text}");
    assert_eq!(text.lines().filter(|l| l.starts_with('|')).count(), 2 + 1 + 3);
}

#[test]
fn estimator_defaults_match_record_tuned_on_all_scenes() {
    let record = Record::embedded();
    for estimator in Estimator::ALL {
        // A record with other parameters belongs to an older version of the estimator.
        let Some(shape) = record.shape(estimator, TunedOn::All) else { continue };
        for (value, p) in shape.iter().zip(estimator.parameters()) {
            let off = (value - p.default).abs();
            assert!(
                off <= 0.01 * value.abs(),
                "{estimator}: {} is {}, the record's {value}",
                p.name,
                p.default
            );
        }
    }
}
