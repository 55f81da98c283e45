//! Devices that lack optional features, are lost, or do not exist, and techniques that do not exist.

use adumbra_render::{
    Answer, Features, Gpu, GpuOptions, RenderError, Renderer, SceneOptions, Shot, TechniqueFiles,
    TechniqueSpec, build,
};

use crate::kit;

fn shot() -> Shot {
    Shot { camera: kit::camera(64, 36), towards_sun: kit::sun(), number: 0 }
}

#[test]
fn device_without_features_draws_and_reports_wall_time() {
    let without = Features::all();
    let gpu = Gpu::request(&GpuOptions { without, ..GpuOptions::default() }).unwrap();
    assert_eq!(gpu.missing_features().len(), 3, "{:?}", gpu.missing_features());
    let mut renderer = Renderer::new(gpu, &kit::city(), SceneOptions::default()).unwrap();
    for name in ["none", "csm:size=512", "vsm:size=512"] {
        let technique = build(renderer.gpu(), &name.parse().unwrap(), TechniqueFiles::default()).unwrap();
        let mut technique = renderer.prepare(technique).unwrap();
        let times = renderer.draw(&shot(), &mut technique, Answer::Visibility).unwrap();
        assert!(times.wall_time);
        let picture = renderer.read_picture().unwrap();
        let spread = [0, 1, 2].map(|channel| {
            let values = || picture.iter().skip(channel).step_by(4).copied();
            values().max().unwrap() - values().min().unwrap()
        });
        assert!(spread.iter().all(|&s| s > 40), "{name}: {spread:?}");
    }
}

#[test]
fn lost_device_gives_an_error_instead_of_a_hang() {
    let mut renderer = Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap();
    let none = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut none = renderer.prepare(none).unwrap();
    renderer.gpu().device.destroy();
    let outcome = renderer
        .draw(&shot(), &mut none, Answer::Visibility)
        .and_then(|_| renderer.read_picture().map(|_| ()));
    assert!(matches!(outcome, Err(RenderError::Lost { .. })), "{outcome:?}");
}

#[test]
fn missing_adapter_error_names_the_request() {
    let adapter = Some("no such adapter".to_owned());
    let Err(error) = Gpu::request(&GpuOptions { adapter, ..GpuOptions::default() }) else {
        panic!("there is such an adapter");
    };
    assert!(matches!(error, RenderError::NoAdapter { .. }), "{error}");
    assert!(error.to_string().contains("no such adapter"), "{error}");
}

#[test]
fn unknown_technique_error_lists_the_known_ones() {
    let Err(error) = "cvs".parse::<TechniqueSpec>() else { panic!("it exists") };
    assert!(error.to_string().contains("none"), "{error}");
}
