//! Compares pictures with those stored in `golden/`, with a mean FLIP of at most [`TOLERANCE`].
//!
//! There is one picture per technique of a generated scene with a moving ball, and one per ambient occlusion
//! variant of the scene.
//!
//! `ADUMBRA_BLESS=1` rewrites the stored pictures. Inspect them before committing. Adapters round
//! differently, so pictures are compared perceptually, not by bytes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use adumbra::{ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size, Watch};
use adumbra_compare::metrics::flip;
use adumbra_lab::TECHNIQUES;
use adumbra_lab::occlusion::grey_picture;
use adumbra_papers::dag::DagLayout;
use adumbra_papers::dag::build::{DagOptions, bake as bake_graph};
use adumbra_papers::techniques::PaperFiles;
use adumbra_papers::tree::{TreeOptions, bake_tree};
use adumbra_render::occlusion::{OcclusionPasses, OcclusionSettings};
use adumbra_render::voxel::LightFile;
use adumbra_render::{Answer, Gpu, GpuOptions, Renderer, SceneOptions, Shot, TechniqueFiles, build};
use adumbra_scene::{Camera, GeneratedKind, Projection, Scene, generate};
use adumbra_truth::picture::Picture;
use image::{ExtendedColorType, ImageEncoder};

/// Largest mean FLIP.
const TOLERANCE: f64 = 0.02;
const SIZE: [u32; 2] = [192, 108];
/// Variants of techniques that names with default parameters do not cover.
const VARIANTS: &[&str] = &[
    "csm:far=24:filter=5",
    "csm-vsm:far=24",
    "csm-evsm:far=24",
    "pcf:filter=poisson",
    "pcf:filter=2",
    "voxel:filter=17",
    "voxel-cubes:filter=5:weights=poisson",
    "hrsm:test=paper",
];
/// Techniques whose golden pictures were made with an earlier default filter width, each with the equivalent
/// name.
const DRAWN_AS: [(&str, &str); 3] =
    [("voxel", "voxel:filter=9"), ("voxel+csm", "voxel+csm:filter=9"), ("voxel-dag", "voxel-dag:filter=9")];
/// Pairs of pictures that must differ, as otherwise the feature that distinguishes the first is not visible.
const DIFFERENT: &[[&str; 2]] = &[
    ["csm:far=24:filter=5", "pcf"],
    ["csm-vsm:far=24", "vsm"],
    ["csm-evsm:far=24", "evsm"],
    ["voxel+csm", "voxel"],
    ["hrsm:test=paper", "hrsm"],
];
/// Every estimator of ambient occlusion, and variants that names with default parameters do not cover.
const OCCLUSIONS: &[&str] = &[
    "ssao",
    "hbao",
    "alchemy",
    "issao",
    "gtao",
    "issao:attenuation=off",
    "issao:preset=fig4",
    "gtao:half=on:normals=depth",
];
/// Radius of ambient occlusion in world units.
const RADIUS_WORLD: f64 = 2.0;
/// Linear RGBA colour of the ball.
const BALL_COLOR: [f32; 4] = [0.80, 0.10, 0.06, 1.0];

fn camera() -> Camera {
    let projection = Projection::Perspective { fov_degrees: 45.0 };
    Camera { eye: [-12.0, 11.0, 17.0], target: [0.0, 0.5, 0.0], projection, width: SIZE[0], height: SIZE[1] }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

fn read(path: &Path) -> Picture {
    let png =
        image::open(path).unwrap_or_else(|e| panic!("{}: {e}; ADUMBRA_BLESS=1 writes it", path.display()));
    let png = png.into_rgb8();
    Picture { width: png.width(), height: png.height(), rgb: png.into_raw(), difference_share: None }
}

fn write(path: &Path, picture: &Picture) {
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&picture.rgb, picture.width, picture.height, ExtendedColorType::Rgb8)
        .unwrap();
    fs::write(path, bytes).unwrap();
}

/// Compares a picture with the stored one, or stores it.
fn compare(name: &str, picture: &Picture, wrong: &mut Vec<String>) {
    let path = folder().join(format!("{}.png", name.replace([':', '='], "_")));
    if std::env::var_os("ADUMBRA_BLESS").is_some() {
        fs::create_dir_all(folder()).unwrap();
        write(&path, picture);
        return;
    }
    let error = flip(&read(&path), picture).unwrap();
    if error > TOLERANCE {
        wrong.push(format!("{name}: FLIP {error:.4}"));
    }
}

/// Returns the number of bytes that differ by more than 16.
fn apart(a: &Picture, b: &Picture) -> usize {
    a.rgb.iter().zip(&b.rgb).filter(|(x, y)| x.abs_diff(**y) > 16).count()
}

fn color(renderer: &Renderer) -> Picture {
    let rgba = renderer.read_picture().unwrap();
    let rgb = rgba.as_chunks::<4>().0.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
    Picture { width: SIZE[0], height: SIZE[1], rgb, difference_share: None }
}

#[test]
fn every_occlusion_variant_matches_golden_picture() {
    let gpu = Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let scene = generate(GeneratedKind::Primitives, 1);
    let mut renderer = Renderer::new(gpu, &scene, SceneOptions::default()).unwrap();
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let shot = Shot { camera: camera(), towards_sun: sun.towards(), number: 0 };
    let pcf = build(renderer.gpu(), &"pcf".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut pcf = renderer.prepare(pcf).unwrap();
    let mut wrong = Vec::new();
    let mut pictures: Vec<(&str, Picture)> = Vec::new();
    for text in OCCLUSIONS {
        let settings = OcclusionSettings::from_spec(&text.parse().unwrap(), RADIUS_WORLD).unwrap();
        let passes = OcclusionPasses::new(renderer.gpu(), settings);
        renderer.set_ambient(Some(passes.into()));
        renderer.draw(&shot, &mut pcf, Answer::Visibility).unwrap();
        // Its visibility alone, and for one estimator also the composited picture.
        let picture = grey_picture(SIZE, &renderer.read_ambient().unwrap()).unwrap();
        compare(&format!("ao-{text}"), &picture, &mut wrong);
        if *text == "issao" {
            compare("pcf-ao-issao", &color(&renderer), &mut wrong);
        }
        let none = grey_picture(SIZE, &vec![1.0; (SIZE[0] * SIZE[1]) as usize]).unwrap();
        let darkened = flip(&none, &picture).unwrap();
        println!("{text}: FLIP {darkened:.4} from none");
        if darkened < 2.0 * TOLERANCE {
            wrong.push(format!("{text} is like none: FLIP {darkened:.4}"));
        }
        for (other, before) in &pictures {
            let apart = apart(before, &picture);
            println!("{text} and {other}: {apart} bytes differ");
            if apart < 60 {
                wrong.push(format!("{text} and {other}: {apart} bytes differ"));
            }
        }
        pictures.push((text, picture));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Draws with techniques that need no file of a paper, and compares them with their golden pictures.
#[test]
fn five_techniques_match_golden_pictures() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let light = light_of(&scene);
    let baked = TechniqueFiles { light: Some(LightFile::Whole(&light)), ..TechniqueFiles::default() };
    let mut renderer = renderer(&scene);
    let mut wrong = Vec::new();
    for name in ["sm", "pcf", "csm", "voxel", "hrsm"] {
        compare(name, &drawn(&mut renderer, name, baked), &mut wrong);
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn towards_sun() -> Sun {
    Sun::from_direction([0.5, 0.8, 0.35]).unwrap()
}

fn light_of(scene: &Scene) -> ShadowFile {
    Bake::with_options(scene, &BakeOptions::new(towards_sun(), Size::Resolution(1024))).in_memory().unwrap()
}

/// Returns a renderer of a scene with a ball that moves above its free middle.
fn renderer(scene: &Scene) -> Renderer {
    let mut moving = scene.clone();
    moving.add_ball(1.3, BALL_COLOR, &[(0.0, [-1.5, 2.2, 1.5]), (1.0, [-1.5, 3.2, 1.5])]).unwrap();
    let gpu = Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut renderer = Renderer::new(gpu, scene, SceneOptions::default()).unwrap();
    renderer.set_movers(&moving.take_movers(), SceneOptions::default()).unwrap();
    renderer
}

/// Returns the picture of a technique.
fn drawn(renderer: &mut Renderer, name: &str, baked: TechniqueFiles<'_>) -> Picture {
    let drawn = DRAWN_AS.iter().find(|(of, _)| *of == name).map_or(name, |(_, drawn)| *drawn);
    let technique = build(renderer.gpu(), &TECHNIQUES.parse(drawn).unwrap(), baked).unwrap();
    let mut technique = renderer.prepare(technique).unwrap();
    let shot = Shot { camera: camera(), towards_sun: towards_sun().towards(), number: 0 };
    renderer.draw(&shot, &mut technique, Answer::Visibility).unwrap();
    color(renderer)
}

#[test]
#[ignore = "slow: draws with every technique"]
fn every_technique_matches_golden_picture() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let (sun, light) = (towards_sun(), light_of(&scene));
    let options = BakeOptions::new(sun, Size::Resolution(1024));
    let options = DagOptions { bake: options, layout: DagLayout::Plain };
    let graph = bake_graph(&scene, &options, Watch::none()).unwrap().file;
    let tree = bake_tree(&scene, &TreeOptions::new(sun, Size::Resolution(512)), Watch::none()).unwrap();
    let papers = PaperFiles { graph: Some(graph), tree: Some(tree.into()), ..PaperFiles::default() };
    let baked = TechniqueFiles { light: Some(LightFile::Whole(&light)), ..papers.baked() };
    let mut renderer = renderer(&scene);
    let mut wrong = Vec::new();
    let mut pictures = BTreeMap::new();
    for name in TECHNIQUES.iter().filter(|t| !t.is_traced()).map(|t| t.name).chain(VARIANTS.iter().copied()) {
        let picture = drawn(&mut renderer, name, baked);
        compare(name, &picture, &mut wrong);
        pictures.insert(name, picture);
    }
    for [a, b] in DIFFERENT {
        let apart = apart(&pictures[a], &pictures[b]);
        println!("{a} and {b}: {apart} bytes differ");
        if apart < 60 {
            wrong.push(format!("{a} and {b}: {apart} bytes differ"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
