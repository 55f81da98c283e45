//! A frame drawn again with another technique reuses G-buffer and ambient occlusion and gives the same
//! picture as a frame drawn from scratch.

use adumbra_render::occlusion::OcclusionPasses;
use adumbra_render::{
    Answer, FrameTimes, Prepared, Renderer, SceneOptions, Shot, Stage, TechniqueFiles, build,
};
use adumbra_scene::Scene;
use adumbra_truth::movers::MoveSpec;
use adumbra_truth::trace::{TraceOptions, Tracer};

use crate::kit;
use crate::kit::ambient::settings;

const TEXT: &str = "issao:reuse=on";

fn renderer(scene: &Scene) -> Renderer {
    let mut renderer = Renderer::new(kit::gpu(), scene, SceneOptions::default()).unwrap();
    let passes = OcclusionPasses::new(renderer.gpu(), settings(TEXT, 8.0));
    renderer.set_ambient(Some(passes.into()));
    renderer
}

fn prepared(renderer: &Renderer, name: &str) -> Prepared {
    let technique = build(renderer.gpu(), &name.parse().unwrap(), TechniqueFiles::default()).unwrap();
    renderer.prepare(technique).unwrap()
}

fn shot(number: u32) -> Shot {
    let mut camera = kit::camera(96, 64);
    camera.eye[0] += f64::from(number);
    Shot { camera, towards_sun: kit::sun(), number }
}

fn shared(times: &FrameTimes) -> [f64; 4] {
    use Stage::{AmbientEstimate, AmbientFilter, AmbientHistory, GBuffer};
    [GBuffer, AmbientEstimate, AmbientHistory, AmbientFilter].map(|stage| times.of(stage))
}

#[test]
fn a_second_technique_shares_the_frame_and_its_history() {
    let scene = kit::city();
    let [mut both, mut alone] = [renderer(&scene), renderer(&scene)];
    let [mut maps, mut cascades] = ["sm", "csm"].map(|name| prepared(&both, name));
    let mut alone_cascades = prepared(&alone, "csm");
    for number in 0..3 {
        let shot = shot(number);
        let first = both.draw_again(&shot, &mut maps, Answer::Visibility).unwrap();
        let ambient = both.read_ambient().unwrap();
        let second = both.draw_again(&shot, &mut cascades, Answer::Visibility).unwrap();
        assert_eq!(shared(&first), shared(&second), "these are the first's");
        assert!(shared(&first).iter().all(|ms| *ms > 0.0), "{first:?}");
        assert!(both.read_ambient().unwrap() == ambient, "a history advances once per frame");
        let drawn = alone.draw(&shot, &mut alone_cascades, Answer::Visibility).unwrap();
        assert!(drawn.of(Stage::GBuffer) > 0.0);
        assert!(both.read_picture().unwrap() == alone.read_picture().unwrap(), "frame {number}");
    }
}

#[test]
fn draw_again_adds_ambient_occlusion_that_was_skipped() {
    let scene = kit::city();
    let [mut again, mut alone] = [renderer(&scene), renderer(&scene)];
    let [mut cascades, mut alone_cascades] = [prepared(&again, "csm"), prepared(&alone, "csm")];
    again.draw_again(&shot(0), &mut cascades, Answer::Cascade).unwrap();
    let times = again.draw_again(&shot(0), &mut cascades, Answer::Visibility).unwrap();
    assert!(times.ambient() > 0.0);
    alone.draw(&shot(0), &mut alone_cascades, Answer::Visibility).unwrap();
    assert!(again.read_picture().unwrap() == alone.read_picture().unwrap());
}

#[test]
fn draw_again_redraws_after_movement_or_in_a_new_shot() {
    let scene = kit::city();
    // Place the ball close to the camera, so that nothing hides it.
    let camera = shot(0).camera;
    let [x, y, z] = [0, 1, 2].map(|a| 0.8 * camera.eye[a] + 0.2 * camera.target[a]);
    let spec = format!("sphere:radius=2:from={x},{y},{z}:to={x},{},{z}:seconds=1", y + 3.0);
    let spec: MoveSpec = spec.parse().unwrap();
    let ball = spec.path(&Tracer::build(&scene, TraceOptions::default()), kit::sun()).unwrap();
    let mut renderer = renderer(&scene);
    let mut movers = Scene::default();
    ball.add_to(&mut movers);
    renderer.set_movers(&movers, SceneOptions::default()).unwrap();
    let mut none = prepared(&renderer, "none");
    let mut depth = |renderer: &mut Renderer, shot: &Shot| {
        renderer.draw_again(shot, &mut none, Answer::Visibility).unwrap();
        renderer.read_surface(shot).unwrap().view_depth
    };
    movers.pose(0.0);
    renderer.move_movers(&movers);
    let at_first = depth(&mut renderer, &shot(0));
    assert!(depth(&mut renderer, &shot(0)) == at_first);
    movers.pose(1.0);
    renderer.move_movers(&movers);
    let moved = depth(&mut renderer, &shot(0));
    assert!(moved != at_first);
    renderer.remove_movers();
    let without = depth(&mut renderer, &shot(0));
    assert!(without != at_first && without != moved);
    assert!(depth(&mut renderer, &shot(5)) != without);
}
