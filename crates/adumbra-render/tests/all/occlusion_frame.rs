//! Ambient occlusion in finished frames: which light it reduces, visibility given from outside, and answers
//! that must not affect its history.

use adumbra_render::occlusion::{GivenAmbient, OcclusionPasses};
use adumbra_render::{Answer, RenderError, Renderer, SceneOptions, Shot, Stage, TechniqueFiles, build};

use crate::kit;
use crate::kit::ambient::settings;

const SIZE: [u32; 2] = [64, 48];
const TEXT: &str = "hbao:strength=1:power=1:bias=0.1:falloff=2:reuse=on";

fn city() -> Renderer {
    Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap()
}

fn shot(number: u32) -> Shot {
    Shot { camera: kit::camera(SIZE[0], SIZE[1]), towards_sun: kit::sun(), number }
}

fn passes(renderer: &Renderer) -> OcclusionPasses {
    OcclusionPasses::new(renderer.gpu(), settings(TEXT, 8.0))
}

fn given(renderer: &Renderer, visibility: &[f32]) -> GivenAmbient {
    GivenAmbient::new(renderer.gpu(), SIZE, visibility).unwrap()
}

/// Draws a frame with a technique and returns its picture.
fn picture(renderer: &mut Renderer, technique: &str) -> Vec<u8> {
    let technique = build(renderer.gpu(), &technique.parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut technique = renderer.prepare(technique).unwrap();
    renderer.draw(&shot(0), &mut technique, Answer::Visibility).unwrap();
    renderer.read_picture().unwrap()
}

#[test]
fn given_ambient_is_composited_like_the_passes() {
    let mut renderer = city();
    let open = picture(&mut renderer, "pcf:size=256");
    assert_eq!(renderer.read_ambient().unwrap(), vec![1.0; (SIZE[0] * SIZE[1]) as usize]);
    let own = passes(&renderer);
    renderer.set_ambient(Some(own.into()));
    let estimated = picture(&mut renderer, "pcf:size=256");
    let visibility = renderer.read_ambient().unwrap();
    assert!(visibility.iter().any(|v| *v < 0.7) && estimated != open);
    assert!(renderer.ambient().unwrap().bytes() > 0);
    let ones = vec![1.0; visibility.len()];
    for (values, expected) in [(&visibility, &estimated), (&ones, &open)] {
        let given = given(&renderer, values);
        renderer.set_ambient(Some(given.into()));
        assert!(picture(&mut renderer, "pcf:size=256") == *expected);
        assert_eq!(&renderer.read_ambient().unwrap(), values);
    }
    renderer.set_ambient(None);
    assert!(picture(&mut renderer, "pcf:size=256") == open);
}

#[test]
fn ambient_occlusion_does_not_dim_sunlight() {
    let mut renderer = city();
    let technique = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut technique = renderer.prepare(technique).unwrap();
    renderer.draw(&shot(0), &mut technique, Answer::Visibility).unwrap();
    let surface = renderer.read_surface(&shot(0)).unwrap();
    let dark = given(&renderer, &vec![0.0; (SIZE[0] * SIZE[1]) as usize]);
    renderer.set_ambient(Some(dark.into()));
    let rgba = picture(&mut renderer, "none");
    let (mut lit, mut unlit) = (0, 0);
    for ((pixel, n), z) in rgba.as_chunks::<4>().0.iter().zip(&surface.normal).zip(&surface.view_depth) {
        let towards: f64 = (0..3).map(|a| f64::from(n[a]) * kit::sun()[a]).sum();
        let is_black = pixel[..3] == [0; 3];
        if z.is_finite() && towards <= 0.0 {
            assert!(is_black, "only the sky lights it: {pixel:?}");
            unlit += 1;
        } else {
            assert!(!is_black, "the sun, or the sky itself: {towards}");
            lit += 1;
        }
    }
    assert!(lit > 100 && unlit > 100, "{lit} {unlit}");
}

#[test]
fn given_ambient_of_another_size_is_an_error() {
    let mut renderer = city();
    let gpu = renderer.gpu();
    for values in [0, 1, 64 * 48 - 1, 64 * 48 + 1] {
        let error = GivenAmbient::new(gpu, SIZE, &vec![1.0; values]).map(|_| ()).unwrap_err();
        assert!(matches!(error, RenderError::Ambient { .. }), "{error}");
        assert!(error.to_string().contains(&format!("{values} visibilities for 64 x 48")), "{error}");
    }
    assert!(matches!(GivenAmbient::new(gpu, [0, 5], &[]), Err(RenderError::Ambient { .. })));
    // The same number of values in another shape.
    let turned = GivenAmbient::new(gpu, [48, 64], &vec![0.5; 64 * 48]).unwrap();
    renderer.set_ambient(Some(turned.into()));
    let technique = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut technique = renderer.prepare(technique).unwrap();
    let error = renderer.draw(&shot(0), &mut technique, Answer::Visibility).unwrap_err();
    assert!(matches!(error, RenderError::Ambient { .. }), "{error}");
    assert!(error.to_string().contains("[48, 64] pixels, not [64, 48]"), "{error}");
    renderer.set_ambient(None);
    renderer.draw(&shot(0), &mut technique, Answer::Visibility).unwrap();
}

#[test]
fn frames_that_answer_cascades_keep_the_history() {
    let ambient = |with_cascades: bool| {
        let mut renderer = city();
        let own = passes(&renderer);
        renderer.set_ambient(Some(own.into()));
        let csm = build(renderer.gpu(), &"csm:size=256".parse().unwrap(), TechniqueFiles::default()).unwrap();
        let mut csm = renderer.prepare(csm).unwrap();
        for number in 0..2 {
            if with_cascades {
                let times = renderer.draw(&shot(number), &mut csm, Answer::Cascade).unwrap();
                assert_eq!(times.of(Stage::AmbientEstimate), 0.0);
            }
            renderer.draw(&shot(number), &mut csm, Answer::Visibility).unwrap();
        }
        renderer.read_ambient().unwrap()
    };
    assert_eq!(ambient(false), ambient(true));
}
