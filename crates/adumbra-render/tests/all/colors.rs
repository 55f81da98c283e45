//! Textures and vertex colours on the GPU against the CPU renderer, which filters with the same mip levels.

use adumbra_render::{Answer, Renderer, SceneOptions, Shot, TechniqueFiles, build};
use adumbra_scene::{AlphaMode, Camera, Instance, Material, Mesh, Pixels, Projection, Scene, Texture, Wrap};
use adumbra_truth::picture;
use adumbra_truth::picture::Shadows;
use adumbra_truth::trace::{TraceOptions, Tracer};

use crate::kit;

const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Squares of 3 × 3 texels in saturated colours.
fn squares(width: u32, height: u32, wrap: Wrap, nearest: bool) -> Texture {
    let colors = [[250, 30, 20], [30, 200, 60], [20, 40, 230], [255, 255, 255], [0, 0, 0]];
    let texel = |x: u32, y: u32| {
        let [r, g, b] = colors[((x / 3) * 7 + (y / 3) * 3) as usize % colors.len()];
        [r, g, b, 255]
    };
    let pixels = (0..width * height).flat_map(|i| texel(i % width, i / width)).collect();
    let name = "squares".to_owned();
    Texture { name, width, height, pixels: Pixels::Rgba(pixels), wrap: [wrap; 2], nearest }
}

/// A quad whose texture coordinates run from 0 to `repeats`.
fn quad(corners: [[f32; 3]; 4], repeats: f32, colors: Option<[[u8; 4]; 4]>, material: u32) -> Mesh {
    Mesh {
        name: "quad".to_owned(),
        positions: corners.to_vec(),
        uvs: vec![[0.0, 0.0], [repeats, 0.0], [repeats, repeats], [0.0, repeats]],
        colors: colors.map_or_else(Vec::new, |c| c.to_vec()),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![material; 2],
    }
}

/// Ground towards the horizon, two walls, and a leaf that fades out by vertex alpha.
fn scene() -> Scene {
    let textured = |name, texture| Material { texture: Some(texture), ..Material::opaque(name, [1.0; 4]) };
    let wall = |x: f32| [[x, 0.0, 0.0], [x + 3.0, 0.0, 0.0], [x + 3.0, 3.0, 0.0], [x, 3.0, 0.0]];
    let corner_colors = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 0, 255]];
    let faded = [[255, 255, 255, 0], [255; 4], [255; 4], [255, 255, 255, 0]];
    let leaf = [[-1.0, 3.2, 1.0], [3.0, 3.2, 1.0], [3.0, 4.2, 1.0], [-1.0, 4.2, 1.0]];
    let ground = [[-30.0, 0.0, 30.0], [30.0, 0.0, 30.0], [30.0, 0.0, -60.0], [-30.0, 0.0, -60.0]];
    let meshes = vec![
        quad(ground, 20.0, None, 0),
        quad(wall(-4.0), 1.0, None, 1),
        quad(wall(0.5), 0.3, Some(corner_colors), 2),
        quad(leaf, 1.0, Some(faded), 3),
    ];
    let place = |mesh| Instance { name: "place".to_owned(), mesh, world_from_mesh: IDENTITY, casts: true };
    Scene {
        instances: (0..meshes.len() as u32).map(place).collect(),
        meshes,
        materials: vec![
            textured("ground", 0),
            textured("wall", 1),
            Material::opaque("painted", [0.9, 0.8, 0.7, 1.0]),
            Material {
                alpha: AlphaMode::Mask { cutoff: 0.5 },
                ..Material::opaque("leaf", [0.2, 0.6, 0.1, 1.0])
            },
        ],
        textures: vec![squares(129, 65, Wrap::Repeat, false), squares(30, 30, Wrap::Mirror, true)],
        ..Scene::default()
    }
}

#[test]
fn textures_and_vertex_colours_match_the_cpu_renderer() {
    let scene = scene();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    let none = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut none = renderer.prepare(none).unwrap();
    for projection in
        [Projection::Perspective { fov_degrees: 50.0 }, Projection::Orthographic { height_world: 9.0 }]
    {
        let (eye, target) = ([1.0, 2.2, 9.0], [0.2, 1.9, 0.0]);
        let camera = Camera { eye, target, projection, width: 320, height: 200 };
        let shot = Shot { camera, towards_sun: kit::sun(), number: 0 };
        renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
        let gpu = renderer.read_picture().unwrap();
        let cpu = picture::draw(&scene, &tracer, &camera, kit::sun(), &Shadows::File(&kit::AllLit), 1);
        let differing_by = |least: u8| {
            let pixels = gpu.as_chunks::<4>().0.iter().zip(cpu.rgb.as_chunks::<3>().0);
            pixels.filter(|(g, c)| (0..3).any(|a| g[a].abs_diff(c[a]) > least)).count()
        };
        let pixels = cpu.rgb.len() / 3;
        let [slightly, much] = [2, 16].map(differing_by);
        assert!(slightly * 100 < pixels, "{slightly} of {pixels} pixels differ by more than 2/255");
        assert!(much * 1000 < pixels, "{much} of {pixels} pixels differ by more than 16/255");
    }
}

#[test]
fn parts_cut_by_vertex_alpha_cast_no_shadow_on_cpu_or_gpu() {
    let scene = scene();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    // Looks down on the ground beside the leaf, where its shadow falls.
    let projection = Projection::Perspective { fov_degrees: 50.0 };
    let camera =
        Camera { eye: [-1.0, 9.0, 4.0], target: [-1.0, 0.0, -0.5], projection, width: 240, height: 160 };
    let shot = Shot { camera, towards_sun: kit::sun(), number: 0 };
    let cpu = picture::draw(&scene, &tracer, &camera, kit::sun(), &Shadows::Truth, 1);
    let ignoring = Tracer::build(&scene, TraceOptions { ignore_alpha: true });
    let uncut = picture::draw(&scene, &ignoring, &camera, kit::sun(), &Shadows::Truth, 1);
    let pixels = cpu.rgb.len() / 3;
    let off = |a: &[[u8; 3]], b: &[[u8; 3]]| {
        a.iter().zip(b).filter(|(a, b)| (0..3).any(|c| a[c].abs_diff(b[c]) > 16)).count()
    };
    let cpu = cpu.rgb.as_chunks::<3>().0;
    assert!(off(cpu, uncut.rgb.as_chunks::<3>().0) * 50 > pixels, "the cut half is in view, or its shadow");
    // The first technique draws only the casters' depth, the second also their normals.
    for name in ["csm:size=4096:filter=1", "hrsm:2048-512:layout=paper"] {
        let technique = build(renderer.gpu(), &name.parse().unwrap(), TechniqueFiles::default()).unwrap();
        let mut technique = renderer.prepare(technique).unwrap();
        renderer.draw(&shot, &mut technique, Answer::Visibility).unwrap();
        let rgba = renderer.read_picture().unwrap();
        let gpu: Vec<[u8; 3]> = rgba.as_chunks::<4>().0.iter().map(|p| [p[0], p[1], p[2]]).collect();
        let wrong = off(&gpu, cpu);
        assert!(wrong * 100 < pixels, "{name}: {wrong} of {pixels} pixels differ");
    }
}
