//! Ambient occlusion on the truth cameras, compared with current engines.

use adumbra_compare::truth::TruthView;
use adumbra_lab::occlusion::{OcclusionStage, TunedOn, with_tuned};
use adumbra_lab::peers::occlusion::{SCENES, engines, figures};
use adumbra_render::occlusion::{Estimator, OcclusionPasses, OcclusionSettings};
use adumbra_render::{Gpu, GpuOptions, SceneOptions};
use adumbra_scene::{LoadOptions, load};
use adumbra_testing::{scene_file, shared};

#[test]
#[ignore = "slow: real scenes"]
fn shared_issao_has_lower_error_than_every_engine() {
    let (Some(truth), Some(scenes)) = (shared("truth"), shared("scenes")) else { return };
    let mut behind = Vec::new();
    for (i, name) in SCENES.into_iter().enumerate() {
        let best = engines().iter().filter_map(|r| r.scenes[i]).map(|f| f.rmse).fold(f64::INFINITY, f64::min);
        let view = TruthView::read(&truth.join(format!("{name}.npz"))).unwrap();
        let options = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
        let scene = load(&scene_file(&scenes, name), &options).unwrap();
        let gpu = Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let stage =
            OcclusionStage::new(gpu, &scene, SceneOptions { ignore_alpha: true }, view.camera).unwrap();
        let settings = OcclusionSettings::new(Estimator::Issao, view.ambient_radius_world);
        let settings = with_tuned(settings, TunedOn::without(name));
        let visibility = stage.visibility(&mut OcclusionPasses::new(stage.gpu(), settings)).unwrap();
        let found = figures(&visibility, &view).unwrap();
        println!("{name}: {found:?}, the best engine {best}");
        if found.rmse >= best {
            behind.push(format!("{name}: {:.4} beside {best}", found.rmse));
        }
    }
    assert!(behind.is_empty(), "{behind:?}");
}
